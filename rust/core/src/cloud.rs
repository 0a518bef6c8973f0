//! Kernels of perception: descriptors and clusters of point clouds, and the compression of their files. They have
//! nothing to do with planning.

mod clusters;
mod lzf;
mod vfh;

pub use clusters::clusters;
pub use lzf::lzf_decompress;
pub use vfh::{Distances, VFH_BINS, VfhOptions, vfh};
