//! `MovingPlan`.

use beltsort_core::MovingPlan;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::moving_actions;

/// What a search for a moving belt found. Values are expected rewards, discounted per tick.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
/// >>> plan = beltsort.MovingPlanner(belt, trials=50).plan(belt.belief())
/// >>> plan.lower < plan.values[plan.action] < plan.upper
/// True
#[pyclass(frozen, name = "MovingPlan", module = "beltsort")]
pub struct PyMovingPlan {
    pub plan: MovingPlan,
}

#[pymethods]
impl PyMovingPlan {
    /// The action to take: `Move`, `Wait` or `DecideAt`.
    #[getter]
    fn action(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        moving_actions::to_python(py, self.plan.action)
    }

    /// Estimated value of each action that was compared: dict of action to float.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = PyDict::new(py);
        for (action, value) in &self.plan.values {
            values.set_item(moving_actions::to_python(py, *action)?, value)?;
        }
        Ok(values)
    }

    /// Lower bound of the optimal value: what a policy that can be executed earns.
    #[getter]
    fn lower(&self) -> f64 {
        self.plan.lower
    }

    /// Upper bound of the optimal value.
    #[getter]
    fn upper(&self) -> f64 {
        self.plan.upper
    }

    /// Trials done; fewer than allowed if nothing was left to find.
    #[getter]
    fn trials(&self) -> u64 {
        self.plan.trials
    }

    /// Wall-clock time spent, in seconds.
    #[getter]
    fn seconds(&self) -> f64 {
        self.plan.elapsed.as_secs_f64()
    }

    /// Belief nodes whose actions were all generated.
    #[getter]
    fn expansions(&self) -> u64 {
        self.plan.expansions
    }

    /// Belief nodes created.
    #[getter]
    fn nodes(&self) -> u64 {
        self.plan.nodes
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let action = self.action(py)?.bind(py).repr()?.to_string();
        let MovingPlan { lower, upper, trials, .. } = self.plan;
        Ok(format!("MovingPlan({action}, optimum from {lower:.2} to {upper:.2}, {trials} trials)"))
    }
}
