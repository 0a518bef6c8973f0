//! `Despot` and `Plan`.

use std::sync::Arc;
use std::time::Duration;

use beltsort_core::{Belief, Budget, BudgetedDespot, Despot, DespotConfig, Plan, SortingModel};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::ThreadPool;

use crate::actions;
use crate::belief::PyBelief;
use crate::convert::index;
use crate::errors::{ArgumentError, to_python};
use crate::model::PySortingModel;

const DEFAULT_SECONDS: f64 = 0.01;

/// The DESPOT planner.
#[pyclass(frozen, name = "Despot", module = "beltsort")]
pub struct PyDespot {
    pub planner: BudgetedDespot,
    pub model: Arc<SortingModel>,
    pool: Option<ThreadPool>,
}

impl PyDespot {
    /// Plan with the GIL released, in this planner's own threads if it has any.
    fn search(&self, py: Python<'_>, belief: &Belief, viewpoint: usize, budget: Budget) -> PyResult<Plan> {
        let plan = || self.planner.despot.plan(belief, viewpoint, budget);
        py.detach(|| match &self.pool {
            Some(pool) => pool.install(plan),
            None => plan(),
        })
        .map_err(to_python)
    }
}

#[pymethods]
impl PyDespot {
    #[new]
    #[pyo3(signature = (model, *, scenarios=500, seed=0, threads=None, seconds=None, trials=None,
                        regularization=None, depth=None))]
    #[allow(clippy::too_many_arguments)] // the public contract
    fn new(
        py: Python<'_>,
        model: &PySortingModel,
        scenarios: i64,
        seed: u64,
        threads: Option<i64>,
        seconds: Option<f64>,
        trials: Option<i64>,
        regularization: Option<f64>,
        depth: Option<i64>,
    ) -> PyResult<Self> {
        let config = DespotConfig {
            scenarios: index("scenarios", scenarios)?,
            seed,
            regularization: regularization.unwrap_or(0.0),
            depth: depth.map(|d| index("depth", d)).transpose()?,
        };
        let budget = budget(seconds, trials)?.map_or_else(|| budget_of_time(DEFAULT_SECONDS), Ok)?;
        let despot = py.detach(|| Despot::new(&model.0, config)).map_err(to_python)?;
        Ok(Self {
            planner: BudgetedDespot { despot, budget },
            model: Arc::clone(&model.0),
            pool: threads.map(thread_pool).transpose()?,
        })
    }

    #[pyo3(signature = (belief, viewpoint=0, *, seconds=None, trials=None))]
    fn plan(
        &self,
        py: Python<'_>,
        belief: PyBelief,
        viewpoint: i64,
        seconds: Option<f64>,
        trials: Option<i64>,
    ) -> PyResult<PyPlan> {
        same_model(&belief, &self.model)?;
        let budget = budget(seconds, trials)?.unwrap_or(self.planner.budget);
        let plan = self.search(py, &belief.belief, index("viewpoint", viewpoint)?, budget)?;
        Ok(PyPlan(plan))
    }

    fn act(&self, py: Python<'_>, belief: PyBelief, viewpoint: i64) -> PyResult<Py<PyAny>> {
        let plan = self.plan(py, belief, viewpoint, None, None)?;
        actions::to_python(py, plan.0.action)
    }

    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }
}

/// What a search found.
#[pyclass(frozen, name = "Plan", module = "beltsort")]
pub struct PyPlan(Plan);

#[pymethods]
impl PyPlan {
    #[getter]
    fn action(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        actions::to_python(py, self.0.action)
    }

    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = PyDict::new(py);
        for (action, value) in &self.0.values {
            values.set_item(actions::to_python(py, *action)?, value)?;
        }
        Ok(values)
    }

    #[getter]
    fn lower(&self) -> f64 {
        self.0.lower
    }

    #[getter]
    fn upper(&self) -> f64 {
        self.0.upper
    }

    #[getter]
    fn certified_lower(&self) -> f64 {
        self.0.certified_lower
    }

    #[getter]
    fn certified_upper(&self) -> f64 {
        self.0.certified_upper
    }

    #[getter]
    fn trials(&self) -> u64 {
        self.0.trials
    }

    #[getter]
    fn seconds(&self) -> f64 {
        self.0.elapsed.as_secs_f64()
    }

    #[getter]
    fn scenario_steps(&self) -> u64 {
        self.0.scenario_steps
    }

    #[getter]
    fn expansions(&self) -> u64 {
        self.0.expansions
    }

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

/// The budget that the arguments name, if any.
fn budget(seconds: Option<f64>, trials: Option<i64>) -> PyResult<Option<Budget>> {
    match (seconds, trials) {
        (None, None) => Ok(None),
        (Some(seconds), None) => budget_of_time(seconds).map(Some),
        (None, Some(trials)) => match u64::try_from(trials) {
            Ok(trials) if trials > 0 => Ok(Some(Budget::Trials(trials))),
            _ => Err(ArgumentError::new_err(format!("trials = {trials}; give at least 1, 100 for example"))),
        },
        (Some(_), Some(_)) => Err(ArgumentError::new_err(
            "both seconds and trials are given; give one: seconds for an anytime plan, trials for a reproducible one",
        )),
    }
}

fn budget_of_time(seconds: f64) -> PyResult<Budget> {
    match Duration::try_from_secs_f64(seconds) {
        Ok(time) if !time.is_zero() => Ok(Budget::Time(time)),
        _ => Err(ArgumentError::new_err(format!(
            "seconds = {seconds}; give a finite time above 0, 0.01 for example"
        ))),
    }
}

/// A pool of `threads` threads.
pub fn thread_pool(threads: i64) -> PyResult<ThreadPool> {
    let count = usize::try_from(threads).ok().filter(|n| *n > 0).ok_or_else(|| {
        ArgumentError::new_err(format!("threads = {threads}; give at least 1, or leave it out for all cores"))
    })?;
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build()
        .map_err(|e| ArgumentError::new_err(format!("threads = {threads}: the pool cannot be made: {e}")))
}

/// Refuse a belief that was made for another model.
pub fn same_model(belief: &PyBelief, model: &Arc<SortingModel>) -> PyResult<()> {
    if Arc::ptr_eq(&belief.model, model) || belief.model == *model {
        return Ok(());
    }
    Err(ArgumentError::new_err(
        "the belief is of another model than the policy; make it with Belief(policy.model)",
    ))
}
