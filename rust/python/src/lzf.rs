//! The decompression of PCD files.

use beltsort_core as core;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Return the `size` bytes that `data` holds compressed by LZF, or None if it does not hold just those.
#[pyfunction]
pub fn lzf_decompress<'py>(py: Python<'py>, data: &[u8], size: usize) -> Option<Bound<'py, PyBytes>> {
    core::lzf_decompress(data, size).map(|bytes| PyBytes::new(py, &bytes))
}
