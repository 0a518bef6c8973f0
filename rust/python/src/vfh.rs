//! The kernel of `beltsort.perception.vfh`, which checks what it is given.

use beltsort_core::{self as core, Distances, VfhOptions};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::errors::ArgumentError;

/// Return the viewpoint feature histogram, or None where the viewpoint is the centroid.
///
/// Parameters
/// ----------
/// points, normals : ndarray
///     Contiguous, finite, shape (n, 3) both.
/// viewpoint : ndarray
///     Shape (3,).
/// size_component, normalize_distance, raw_counts, pcl_compatible : bool
///     As in `beltsort.perception.vfh`.
#[pyfunction]
#[pyo3(signature = (points, normals, viewpoint, *, size_component, normalize_distance, raw_counts, pcl_compatible))]
#[allow(clippy::too_many_arguments, clippy::fn_params_excessive_bools)] // the public contract
pub fn vfh<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    viewpoint: PyReadonlyArray1<'py, f64>,
    size_component: bool,
    normalize_distance: bool,
    raw_counts: bool,
    pcl_compatible: bool,
) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
    let unit = if normalize_distance { Distances::Shares } else { Distances::Centimetres };
    let options = VfhOptions { distances: size_component.then_some(unit), raw_counts, pcl_compatible };
    let (points, normals) = (points.as_slice()?.as_chunks(), normals.as_slice()?.as_chunks());
    let &[viewpoint] = viewpoint.as_slice()?.as_chunks().0 else {
        return Err(ArgumentError::new_err("viewpoint has no three coordinates; give shape (3,)"));
    };
    let histogram = py.detach(|| core::vfh(points.0, normals.0, viewpoint, options));
    Ok(histogram.map(|bins| PyArray1::from_slice(py, &bins)))
}
