//! `Plan`.

use beltsort_core::Plan;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::actions;

/// What a search found. Values are expected discounted rewards, in the unit of `r_max` and `r_min`.
#[pyclass(frozen, name = "Plan", module = "beltsort")]
pub struct PyPlan(pub Plan);

#[pymethods]
impl PyPlan {
    /// The action to take, `Move` or `Decide`.
    #[getter]
    fn action(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        actions::to_python(py, self.0.action)
    }

    /// Estimated value of every legal action: dict of `Move` or `Decide` to float.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = PyDict::new(py);
        for (action, value) in &self.0.values {
            values.set_item(actions::to_python(py, *action)?, value)?;
        }
        Ok(values)
    }

    /// Lower bound of the optimum of the search's own (sampled, regularised) problem.
    #[getter]
    fn lower(&self) -> f64 {
        self.0.lower
    }

    /// Upper bound of the same optimum.
    #[getter]
    fn upper(&self) -> f64 {
        self.0.upper
    }

    /// Lower bound of V*, the optimal value of the model itself: what a policy that can be executed earns
    /// from here; None if the model repeats looks.
    #[getter]
    fn certified_lower(&self) -> Option<f64> {
        self.0.certified_lower
    }

    /// Upper bound of V*.
    #[getter]
    fn certified_upper(&self) -> f64 {
        self.0.certified_upper
    }

    /// Trials done; fewer than allowed if the sampled problem was solved before.
    #[getter]
    fn trials(&self) -> u64 {
        self.0.trials
    }

    /// Wall-clock time spent, in seconds.
    #[getter]
    fn seconds(&self) -> f64 {
        self.0.elapsed.as_secs_f64()
    }

    /// (scenario, move) pairs simulated at expanded nodes.
    #[getter]
    fn scenario_steps(&self) -> u64 {
        self.0.scenario_steps
    }

    /// Belief nodes whose actions were all generated.
    #[getter]
    fn expansions(&self) -> u64 {
        self.0.expansions
    }

    /// Belief nodes created.
    #[getter]
    fn nodes(&self) -> u64 {
        self.0.nodes
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let action = self.action(py)?;
        let action = action.bind(py).repr()?;
        Ok(format!(
            "Plan(action={action}, lower={:.3}, upper={:.3}, trials={})",
            self.0.lower, self.0.upper, self.0.trials
        ))
    }
}
