//! The simple policies.

use std::sync::Arc;

use beltsort_core::{InformationGain, Policy, SortingModel, Threshold};
use pyo3::prelude::*;

use crate::actions;
use crate::belief::PyBelief;
use crate::convert::index;
use crate::errors::to_python;
use crate::model::PySortingModel;
use crate::planner::same_model;

/// Look from one viewpoint until a class is likely enough.
#[pyclass(frozen, name = "Threshold", module = "beltsort")]
pub struct PyThreshold {
    pub policy: Threshold,
    pub model: Arc<SortingModel>,
}

#[pymethods]
impl PyThreshold {
    #[new]
    #[pyo3(signature = (model, threshold, viewpoint=None))]
    fn new(model: &PySortingModel, threshold: f64, viewpoint: Option<i64>) -> PyResult<Self> {
        let viewpoint = viewpoint.map(|v| index("viewpoint", v)).transpose()?;
        let policy = Threshold::new(&model.0, threshold, viewpoint).map_err(to_python)?;
        Ok(Self { policy, model: Arc::clone(&model.0) })
    }

    fn act(&self, py: Python<'_>, belief: PyBelief, viewpoint: i64) -> PyResult<Py<PyAny>> {
        act(py, &self.policy, &self.model, &belief, viewpoint)
    }

    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }
}

/// Look from where most is learnt until a class is likely enough.
#[pyclass(frozen, name = "InformationGain", module = "beltsort")]
pub struct PyInformationGain {
    pub policy: InformationGain,
    pub model: Arc<SortingModel>,
}

#[pymethods]
impl PyInformationGain {
    #[new]
    #[pyo3(signature = (model, threshold, positions=1))]
    fn new(model: &PySortingModel, threshold: f64, positions: i64) -> PyResult<Self> {
        let positions = index("positions", positions)?;
        let policy = InformationGain::new(&model.0, threshold, positions).map_err(to_python)?;
        Ok(Self { policy, model: Arc::clone(&model.0) })
    }

    fn act(&self, py: Python<'_>, belief: PyBelief, viewpoint: i64) -> PyResult<Py<PyAny>> {
        act(py, &self.policy, &self.model, &belief, viewpoint)
    }

    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }
}

fn act(
    py: Python<'_>,
    policy: &dyn Policy,
    model: &Arc<SortingModel>,
    belief: &PyBelief,
    viewpoint: i64,
) -> PyResult<Py<PyAny>> {
    same_model(belief, model)?;
    let action = policy.act(&belief.belief, index("viewpoint", viewpoint)?).map_err(to_python)?;
    actions::to_python(py, action)
}
