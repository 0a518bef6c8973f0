//! From Python's numbers and arrays to those of the core.

use beltsort_core::{ScalarOrMatrix, Tables};
use numpy::{AllowTypeChange, Element, PyArrayLikeDyn};
use pyo3::conversion::FromPyObjectOwned;
use pyo3::prelude::*;
use pyo3::types::PyAny;

use crate::errors::{ArgumentError, ModelError};

/// A viewpoint or label as Python gives it; a negative one is out of range, not an overflow.
pub fn index(name: &str, value: i64) -> PyResult<usize> {
    usize::try_from(value)
        .map_err(|_| ArgumentError::new_err(format!("{name} {value} is out of range: indices start at 0")))
}

/// Observation tables or counts from anything that numpy makes an array of shape (H, K, L, L) of.
pub fn tables<'py, T>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Tables<T>>
where
    T: Element + Copy + FromPyObjectOwned<'py> + 'py,
{
    let array = array::<T>(name, value)?;
    let view = array.as_array();
    let shape = view.shape().to_vec();
    if shape.len() != 4 {
        return Err(ModelError::new_err(format!(
            "{name} has shape {shape:?}; expected (H, K, L, L): positions, viewpoints, true classes, observed classes"
        )));
    }
    let flat: Vec<T> = view.iter().copied().collect();
    let mut entries = flat.into_iter();
    let mut row = || entries.by_ref().take(shape[3]).collect::<Vec<T>>();
    let tables = (0..shape[0])
        .map(|_| (0..shape[1]).map(|_| (0..shape[2]).map(|_| row()).collect()).collect())
        .collect();
    Ok(tables)
}

/// A number, or a matrix as anything that numpy makes an array of two axes of.
pub fn scalar_or_matrix(name: &str, value: &Bound<'_, PyAny>) -> PyResult<ScalarOrMatrix> {
    if let Ok(number) = value.extract::<f64>() {
        return Ok(ScalarOrMatrix::Scalar(number));
    }
    Ok(ScalarOrMatrix::Matrix(rows(name, value)?))
}

/// The rows of a matrix.
pub fn rows(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Vec<f64>>> {
    let array = array::<f64>(name, value)?;
    let view = array.as_array();
    let shape = view.shape();
    if shape.len() != 2 {
        return Err(ModelError::new_err(format!("{name} has shape {shape:?}; expected two axes")));
    }
    Ok(view.rows().into_iter().map(|row| row.iter().copied().collect()).collect())
}

fn array<'py, T: Element + FromPyObjectOwned<'py> + 'py>(
    name: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<PyArrayLikeDyn<'py, T, AllowTypeChange>> {
    value.extract().map_err(|_| {
        ModelError::new_err(format!(
            "{name} is not an array of {}; give nested lists of equal lengths, or a numpy array",
            std::any::type_name::<T>()
        ))
    })
}
