//! `OneObject`.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use beltsort_core::{OneObject, SortingModel};
use pyo3::prelude::*;

use crate::belief::PyBelief;
use crate::display::{displayed, immutable};
use crate::interrupt::interruptible;
use crate::model::PySortingModel;
use crate::names::Named;
use crate::policies::act;

/// Follow the best conditional plan for the object at the belt end, chosen anew at each step.
///
/// The default policy of `Despot`. Each plan looks at one object until it pays to decide; what its looks tell
/// about the objects behind is used once their turn comes. Labels are taken as independent, and a bonus for
/// information is left aside.
///
/// Parameters
/// ----------
/// model : SortingModel
///     The problem; its one-object plans are found here, which takes a moment.
///
/// References
/// ----------
/// Point-based value iteration: Pineau, Gordon & Thrun, IJCAI 2003.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> beltsort.OneObject(model).act(beltsort.Belief(model), 0)
/// Move(viewpoint=0)
#[pyclass(frozen, name = "OneObject", module = "beltsort")]
pub struct PyOneObject {
    pub policy: OneObject,
    pub model: Arc<SortingModel>,
}

#[pymethods]
impl PyOneObject {
    #[new]
    fn new(py: Python<'_>, model: &PySortingModel) -> PyResult<Self> {
        let stop = AtomicBool::new(false);
        let policy = interruptible(py, &stop, || OneObject::new_until(&model.0, &stop))?;
        Ok(Self { policy, model: Arc::clone(&model.0) })
    }

    /// Return the first action of the best plan.
    ///
    /// Parameters
    /// ----------
    /// belief : Belief
    ///     What is known of the objects; made for the policy's model, or an equal one.
    /// viewpoint : int or str
    ///     Where the camera stands: index or name.
    ///
    /// Returns
    /// -------
    /// Move or Decide
    ///     The action.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a belief of another model or an unknown viewpoint.
    fn act(&self, py: Python<'_>, belief: PyBelief, viewpoint: Named) -> PyResult<Py<PyAny>> {
        act(py, &self.policy, &self.model, &belief, viewpoint)
    }

    /// The model that the policy was made for.
    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }

    fn __getnewargs__(&self) -> (PySortingModel,) {
        (self.model(),)
    }
}

displayed!(PyOneObject);
immutable!(PyOneObject);
