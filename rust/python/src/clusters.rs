//! Clusters of points.

use beltsort_core as core;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// Return the number of each point's cluster, from 0; steps no longer than `gap` join its points.
///
/// Parameters
/// ----------
/// points : ndarray
///     Contiguous, finite, shape (n, 3).
/// gap : float
///     In the unit of the points.
#[pyfunction]
pub fn clusters<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    gap: f64,
) -> PyResult<Bound<'py, PyArray1<usize>>> {
    let points = points.as_slice()?.as_chunks().0;
    Ok(py.detach(|| core::clusters(points, gap)).into_pyarray(py))
}
