//! `Move` and `Decide`.

use beltsort_core::{Action, Bin, Viewpoint};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::convert::{Whole, index};
use crate::errors::PolicyError;

/// `m_k`: move the camera to a viewpoint and scan once.
///
/// Parameters
/// ----------
/// viewpoint : int
///     Index of the viewpoint. Whether the model has it, and whether a move may reach it, is checked where
///     the action is used.
///
/// Raises
/// ------
/// ArgumentError
///     If the index is negative.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> beltsort.Move(2)
/// Move(viewpoint=2)
/// >>> match beltsort.Move(2):
/// ...     case beltsort.Move(viewpoint):
/// ...         viewpoint
/// 2
#[pyclass(frozen, eq, hash, get_all, module = "beltsort", from_py_object)]
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Move {
    /// Index of the viewpoint.
    pub viewpoint: usize,
}

#[pymethods]
impl Move {
    #[classattr]
    fn __match_args__() -> (&'static str,) {
        ("viewpoint",)
    }

    #[new]
    fn new(viewpoint: Whole) -> PyResult<Self> {
        Ok(Self { viewpoint: index("viewpoint", viewpoint)? })
    }

    fn __repr__(&self) -> String {
        format!("Move(viewpoint={})", self.viewpoint)
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, [self.viewpoint])
    }
}

/// `d_i`: sort the object at the belt end into a bin; the belt advances by one position.
///
/// Parameters
/// ----------
/// label : int
///     Index of the bin: that of the class, unless the model has `bins`. Whether the model has it is checked
///     where the action is used.
///
/// Raises
/// ------
/// ArgumentError
///     If the index is negative.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> beltsort.Decide(1) == beltsort.Decide(label=1)
/// True
#[pyclass(frozen, eq, hash, get_all, module = "beltsort", from_py_object)]
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Decide {
    /// Index of the bin.
    label: usize,
}

#[pymethods]
impl Decide {
    #[classattr]
    fn __match_args__() -> (&'static str,) {
        ("label",)
    }

    #[new]
    fn new(label: Whole) -> PyResult<Self> {
        Ok(Self { label: index("label", label)? })
    }

    /// Index of the bin, the same as `label`.
    #[getter]
    fn bin(&self) -> usize {
        self.label
    }

    fn __repr__(&self) -> String {
        format!("Decide(label={})", self.label)
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, [self.label])
    }
}

/// The Python object for an action.
pub fn to_python(py: Python<'_>, action: Action) -> PyResult<Py<PyAny>> {
    match action {
        Action::Move(Viewpoint(viewpoint)) => Ok(Py::new(py, Move { viewpoint })?.into_any()),
        Action::Decide(Bin(label)) => Ok(Py::new(py, Decide { label })?.into_any()),
    }
}

/// The action behind a Python object.
pub fn from_python(object: &Bound<'_, PyAny>) -> PyResult<Action> {
    if let Ok(Move { viewpoint }) = object.extract() {
        return Ok(Action::Move(Viewpoint(viewpoint)));
    }
    if let Ok(Decide { label }) = object.extract() {
        return Ok(Action::Decide(Bin(label)));
    }
    Err(PolicyError::new_err(format!(
        "a policy returned {}; return beltsort.Move(viewpoint) or beltsort.Decide(label)",
        object.repr()?
    )))
}
