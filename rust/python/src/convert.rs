//! From Python's numbers and arrays to those of the core.

use beltsort_core::{Class, Label, ModelSpec, ScalarOrMatrix, Smoothing, Tables};
use numpy::ndarray::Array4;
use numpy::{AllowTypeChange, Element, IntoPyArray, PyArray4, PyArrayLikeDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyAny, PyDict};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::errors::{ArgumentError, ModelError};

/// Whole numbers up to here are exact as f64.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// An argument of the right type, or what was given instead: so that the error can name the argument.
pub enum Given<T> {
    Right(T),
    Wrong(String),
}

impl<'a, 'py, T: FromPyObject<'a, 'py>> FromPyObject<'a, 'py> for Given<T> {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        value.extract().map(Self::Right).or_else(|_| Ok(Self::Wrong(value.repr()?.extract()?)))
    }
}

impl<T> Given<T> {
    /// The argument as the key of a model.
    pub fn of(self, key: &str) -> PyResult<T> {
        match self {
            Self::Right(value) => Ok(value),
            Self::Wrong(value) => Err(ModelError::new_err(ModelSpec::wrong_type(key, key, &value))),
        }
    }
}

/// A whole number as Python gives it: wide enough that what is out of range gets the core's own answer.
pub type Whole = i128;

/// An index as Python gives it; a negative one is out of range, not an overflow.
pub fn index(name: &str, value: Whole) -> PyResult<usize> {
    usize::try_from(value)
        .map_err(|_| ArgumentError::new_err(format!("{name} {value} is out of range: indices start at 0")))
}

/// A number of things; the core says what it thinks of 0.
pub fn count(name: &str, value: Whole) -> PyResult<usize> {
    usize::try_from(value).map_err(|_| {
        ArgumentError::new_err(format!(
            "{name} = {value}; give at least 1, and no more than a machine can count"
        ))
    })
}

/// A seed as Python gives it.
pub fn seed(value: Whole) -> PyResult<u64> {
    u64::try_from(value).map_err(|_| {
        ArgumentError::new_err(format!("seed = {value}; give a whole number from 0 to {}", u64::MAX))
    })
}

/// Observation tables from anything that numpy makes an array of four axes of.
pub fn tables(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Tables<f64>> {
    let array = match array(name, value) {
        Ok(array) => array,
        // Rows of unequal lengths: the core says which.
        Err(reason) => return value.extract().map_err(|_| ModelError::new_err(reason)),
    };
    let view = array.as_array();
    let shape = view.shape().to_vec();
    if shape.len() != 4 {
        return Err(ModelError::new_err(format!(
            "{name} has shape {shape:?}; expected (H, K, L, L): positions, viewpoints, true classes (or their modes), observed \
             classes (or labels); give four axes"
        )));
    }
    let mut entries = view.iter().copied();
    let mut row = || entries.by_ref().take(shape[3]).collect::<Vec<f64>>();
    let tables = (0..shape[0])
        .map(|_| (0..shape[1]).map(|_| (0..shape[2]).map(|_| row()).collect()).collect())
        .collect();
    Ok(tables)
}

/// Label counts from anything that numpy makes an array of four axes of.
pub fn counts(value: &Bound<'_, PyAny>) -> PyResult<Tables<u64>> {
    let row = |row: Vec<f64>| row.into_iter().map(|entry| whole("counts", entry)).collect();
    let table = |rows: Vec<Vec<f64>>| rows.into_iter().map(row).collect();
    let position = |viewpoints: Vec<Vec<Vec<f64>>>| viewpoints.into_iter().map(table).collect();
    let counts: Result<_, _> = tables("counts", value)?.into_iter().map(position).collect();
    counts.map_err(ModelError::new_err)
}

/// Pseudo-counts: a number, or anything that numpy makes an array of four axes of.
pub fn smoothing(value: &Bound<'_, PyAny>) -> PyResult<Smoothing> {
    match value.extract::<f64>() {
        Ok(number) => Ok(Smoothing::Scalar(number)),
        Err(_) => tables("smoothing", value).map(Smoothing::Tables),
    }
}

/// A number, or a matrix as anything that numpy makes an array of two axes of.
pub fn scalar_or_matrix(name: &str, value: &Bound<'_, PyAny>) -> PyResult<ScalarOrMatrix> {
    if let Ok(number) = value.extract::<f64>() {
        return Ok(ScalarOrMatrix::Scalar(number));
    }
    Ok(ScalarOrMatrix::Matrix(rows(name, value).map_err(ModelError::new_err)?))
}

/// The rows of a matrix, or what is wrong with it.
pub fn rows(name: &str, value: &Bound<'_, PyAny>) -> Result<Vec<Vec<f64>>, String> {
    let array = array(name, value)?;
    let view = array.as_array();
    let shape = view.shape();
    if shape.len() != 2 {
        return Err(format!("{name} has shape {shape:?}; expected two axes, so give a list of rows"));
    }
    Ok(view.rows().into_iter().map(|row| row.iter().copied().collect()).collect())
}

/// Rows of labels, -1 for none, or what is wrong with them.
pub fn labels_or_none(name: &str, value: &Bound<'_, PyAny>) -> Result<Vec<Vec<Option<Label>>>, String> {
    let label = |entry: f64| match entry {
        -1.0 => Ok(None),
        _ => whole_index(name, entry).map(Label).map(Some),
    };
    rows(name, value)?.into_iter().map(|row| row.into_iter().map(label).collect()).collect()
}

/// Rows of classes, or what is wrong with them.
pub fn classes(name: &str, value: &Bound<'_, PyAny>) -> Result<Vec<Vec<Class>>, String> {
    let class = |entry: f64| whole_index(name, entry).map(Class);
    rows(name, value)?.into_iter().map(|row| row.into_iter().map(class).collect()).collect()
}

/// An index that numpy turned into a float on its way, or what is wrong with it.
fn whole_index(name: &str, value: f64) -> Result<usize, String> {
    usize::try_from(whole(name, value)?).map_err(|_| format!("{name} holds {value}, which is out of range"))
}

/// A number that numpy turned into a float on its way, or what is wrong with it.
pub fn whole(name: &str, value: f64) -> Result<u64, String> {
    if value.fract() == 0.0 && (0.0..=LARGEST_WHOLE).contains(&value) {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked above
        return Ok(value as u64);
    }
    Err(format!("{name} holds {value}; expected whole numbers, not negative"))
}

/// A dict as a JSON object.
pub fn json(value: &Bound<'_, PyDict>) -> PyResult<serde_json::Value> {
    let text: String = value.py().import("json")?.call_method1("dumps", (value,))?.extract()?;
    serde_json::from_str(&text)
        .map_err(|e| ModelError::new_err(format!("label_rule holds what JSON cannot hold: {e}")))
}

/// Lists of viewpoints.
pub fn travel(lists: Vec<Vec<Whole>>) -> PyResult<Vec<Vec<usize>>> {
    let index = |to: Whole| {
        usize::try_from(to).map_err(|_| {
            ModelError::new_err(format!("travel lists viewpoint {to}; viewpoints are numbered from 0"))
        })
    };
    lists.into_iter().map(|reached| reached.into_iter().map(index).collect()).collect()
}

/// Tables as a read-only array.
pub fn read_only<'py, T: Element + Copy>(
    py: Python<'py>,
    tables: &Tables<T>,
) -> PyResult<Bound<'py, PyArray4<T>>> {
    let shape = (tables.len(), tables[0].len(), tables[0][0].len(), tables[0][0][0].len());
    let array = Array4::from_shape_fn(shape, |(j, v, c, z)| tables[j][v][c][z]).into_pyarray(py);
    array.call_method1("setflags", (false,))?;
    Ok(array)
}

fn array<'py>(
    name: &str,
    value: &Bound<'py, PyAny>,
) -> Result<PyArrayLikeDyn<'py, f64, AllowTypeChange>, String> {
    value.extract().map_err(|reason: PyErr| {
        format!(
            "{name} is not an array of numbers ({reason}); give nested lists of equal lengths, or a numpy array"
        )
    })
}

/// Numbers of the core as text, from which `from_json` restores them to the last bit: what pickle keeps.
pub fn to_json(numbers: &impl Serialize) -> PyResult<String> {
    serde_json::to_string(numbers).map_err(|e| PyValueError::new_err(e.to_string()))
}

/// The numbers that `to_json` wrote.
pub fn from_json<T: DeserializeOwned>(text: &str) -> PyResult<T> {
    serde_json::from_str(text).map_err(|e| PyValueError::new_err(e.to_string()))
}
