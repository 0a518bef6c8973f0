//! `Wait` and `DecideAt`: what a moving belt adds to `Move`.

use beltsort_core::{Action, Bin, MovingAction, Position, Viewpoint};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::actions::{self, Move};
use crate::convert::{Whole, index};
use crate::errors::PolicyError;

/// Let a tick pass on a moving belt.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> beltsort.Wait() == beltsort.Wait()
/// True
#[pyclass(frozen, eq, hash, module = "beltsort", from_py_object)]
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Wait {}

#[pymethods]
impl Wait {
    #[classattr]
    fn __match_args__(py: Python<'_>) -> Bound<'_, PyTuple> {
        PyTuple::empty(py)
    }

    #[new]
    fn new() -> Self {
        Self {}
    }

    fn __repr__(_slf: &Bound<'_, Self>) -> &'static str {
        "Wait()"
    }

    fn __getnewargs__<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyTuple> {
        PyTuple::empty(slf.py())
    }
}

/// Sort the object at a place of a moving belt into a bin.
///
/// Parameters
/// ----------
/// position : int
///     Index of the place, 0 nearest to the exit.
/// label : int
///     Index of the bin: that of the class, unless the model has `bins`.
///
/// Raises
/// ------
/// ArgumentError
///     If an index is negative.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> beltsort.DecideAt(1, 2)
/// DecideAt(position=1, label=2)
#[pyclass(frozen, eq, hash, get_all, module = "beltsort", from_py_object)]
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct DecideAt {
    /// Index of the place, 0 nearest to the exit.
    position: usize,
    /// Index of the bin.
    label: usize,
}

#[pymethods]
impl DecideAt {
    #[classattr]
    fn __match_args__() -> (&'static str, &'static str) {
        ("position", "label")
    }

    #[new]
    fn new(position: Whole, label: Whole) -> PyResult<Self> {
        Ok(Self { position: index("position", position)?, label: index("label", label)? })
    }

    fn __repr__(&self) -> String {
        format!("DecideAt(position={}, label={})", self.position, self.label)
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, [self.position, self.label])
    }
}

/// An action as Python's object.
pub fn to_python(py: Python<'_>, action: MovingAction) -> PyResult<Py<PyAny>> {
    match action {
        MovingAction::Look(viewpoint) => actions::to_python(py, Action::Move(viewpoint)),
        MovingAction::Wait => Ok(Wait {}.into_pyobject(py)?.into_any().unbind()),
        MovingAction::Decide { position, bin } => {
            Ok(DecideAt { position: position.0, label: bin.0 }.into_pyobject(py)?.into_any().unbind())
        }
    }
}

/// The action behind a Python object.
pub fn from_python(object: &Bound<'_, PyAny>) -> PyResult<MovingAction> {
    if let Ok(to) = object.extract::<Move>() {
        return Ok(MovingAction::Look(Viewpoint(to.viewpoint)));
    }
    if object.extract::<Wait>().is_ok() {
        return Ok(MovingAction::Wait);
    }
    if let Ok(DecideAt { position, label }) = object.extract() {
        return Ok(MovingAction::Decide { position: Position(position), bin: Bin(label) });
    }
    Err(PolicyError::new_err(format!(
        "a policy returned {}; return beltsort.Move(viewpoint), beltsort.Wait() or beltsort.DecideAt(position, label)",
        object.repr()?
    )))
}
