//! `MovingPlanner`.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use beltsort_core::{
    Budget, BudgetedMovingSearch, Class, DEFAULT_MOVING_DEPTH, DEFAULT_MOVING_SCENARIOS, DEFAULT_OPTIMISM,
    MovingBelt, MovingConfig, MovingSearch, Viewpoint,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::budget::{self, budget};
use crate::convert::{self, Whole, count, index};
use crate::display::immutable;
use crate::errors::to_python;
use crate::interrupt::interruptible;
use crate::keywords;
use crate::moving_actions;
use crate::moving_belief::PyMovingBelief;
use crate::moving_belt::PyMovingBelt;
use crate::moving_plan::PyMovingPlan;
use crate::names::Named;

/// Plan for a belt of constant speed: a search over exact beliefs with a clock.
///
/// Preparing solves the problem of one object with a deadline, which takes seconds for models of many
/// classes.
///
/// Parameters
/// ----------
/// belt : MovingBelt
///     Model, durations and prices; of constant speed.
/// seconds : float, optional
///     Wall-clock budget of a plan in seconds, 0.01 if neither budget is given.
/// trials : int, optional
///     Budget of a plan in trials, in place of `seconds`.
/// scenarios : int
///     Scenarios that choose which label vectors get a branch.
/// seed : int
///     Seed of the scenarios.
/// depth : int
///     Actions to look ahead.
/// optimism : float
///     How far an estimate at a leaf lies from the default policy's value, 0, to the upper bound, 1.
///
/// Raises
/// ------
/// ArgumentError
///     For a belt that advances on decisions, or counts or budgets that make no sense.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
/// >>> planner = beltsort.MovingPlanner(belt, trials=50)
/// >>> planner.plan(belt.belief()).action
/// Move(viewpoint=0)
/// >>> planner.act(beltsort.MovingBelief(belt, kinds=[[0.001, 0.999]]), 0)
/// DecideAt(position=0, label=1)
#[pyclass(frozen, name = "MovingPlanner", module = "beltsort")]
pub struct PyMovingPlanner {
    pub policy: BudgetedMovingSearch,
    belt: Arc<MovingBelt>,
}

#[pymethods]
impl PyMovingPlanner {
    #[new]
    #[pyo3(signature = (belt, *, seconds=None, trials=None, scenarios=DEFAULT_MOVING_SCENARIOS as Whole, seed=0,
                        depth=DEFAULT_MOVING_DEPTH as Whole, optimism=DEFAULT_OPTIMISM, **unknown),
           text_signature = "(belt, *, seconds=None, trials=None, scenarios=..., seed=0, depth=..., optimism=...)")]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn new(
        py: Python<'_>,
        belt: &PyMovingBelt,
        seconds: Option<f64>,
        trials: Option<Whole>,
        scenarios: Whole,
        seed: Whole,
        depth: Whole,
        optimism: f64,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        keywords::refuse(unknown, "MovingPlanner")?;
        let config = MovingConfig {
            scenarios: count("scenarios", scenarios)?,
            seed: convert::seed(seed)?,
            depth: count("depth", depth)?,
            optimism,
        };
        let budget = budget(seconds, trials)?.unwrap_or(budget::DEFAULT);
        let stop = AtomicBool::new(false);
        let prepare = || MovingSearch::new_until(&belt.0, config, &stop);
        let search = interruptible(py, &stop, prepare)?.map_err(to_python)?;
        Ok(Self { policy: BudgetedMovingSearch { search, budget }, belt: Arc::clone(&belt.0) })
    }

    /// Plan the next action.
    ///
    /// Parameters
    /// ----------
    /// belief : MovingBelief
    ///     What is known of the objects; made for the planner's belt, or an equal one.
    /// viewpoint : int or str
    ///     Where the camera stands: index or name.
    /// seconds, trials : optional
    ///     In place of the planner's own budget; at most one of them.
    ///
    /// Returns
    /// -------
    /// MovingPlan
    ///     The action, the values it was compared by, and bounds.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a belief of another belt, an unknown viewpoint, or nothing left to decide.
    #[pyo3(signature = (belief, viewpoint=Named::Index(0), *, seconds=None, trials=None, **unknown),
           text_signature = "($self, belief, viewpoint=0, *, seconds=None, trials=None)")]
    fn plan(
        &self,
        py: Python<'_>,
        belief: PyMovingBelief,
        viewpoint: Named,
        seconds: Option<f64>,
        trials: Option<Whole>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyMovingPlan> {
        keywords::refuse(unknown, "MovingPlanner.plan")?;
        belief.check_is_of(&self.belt)?;
        let budget = budget(seconds, trials)?.unwrap_or(self.policy.budget);
        let viewpoint = viewpoint.viewpoint(self.belt.model())?;
        let stop = AtomicBool::new(false);
        let plan = || self.policy.search.plan_until(&belief.belief, viewpoint, budget, &stop);
        let plan = if budget::is_long(budget) { interruptible(py, &stop, plan)? } else { py.detach(plan) };
        Ok(PyMovingPlan { plan: plan.map_err(to_python)? })
    }

    /// Return the action of a plan.
    ///
    /// Parameters
    /// ----------
    /// belief : MovingBelief
    ///     As for `plan`.
    /// viewpoint : int or str
    ///     Where the camera stands: index or name.
    ///
    /// Returns
    /// -------
    /// Move, Wait or DecideAt
    ///     The action.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     As `plan`.
    fn act(&self, py: Python<'_>, belief: PyMovingBelief, viewpoint: Named) -> PyResult<Py<PyAny>> {
        let found = self.plan(py, belief, viewpoint, None, None, None)?;
        moving_actions::to_python(py, found.plan.action)
    }

    /// Return the thresholds at which one object alone is best decided at once.
    ///
    /// Parameters
    /// ----------
    /// label : int
    ///     Index of a class.
    /// viewpoint : int or str
    ///     Where the camera stands: index or name.
    ///
    /// Returns
    /// -------
    /// list of float or None
    ///     By ticks left until the exit, from 1 to H `ticks_per_place`: the least probability of the class
    ///     from which on deciding is optimal (within the accuracy of a belief grid), the other classes in
    ///     their proportions at arrival; None out of reach, or where it never is.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For an unknown class or viewpoint.
    #[pyo3(signature = (label, viewpoint=Named::Index(0)))]
    fn thresholds(&self, label: Whole, viewpoint: Named) -> PyResult<Vec<Option<f64>>> {
        let (class, viewpoint): (Class, Viewpoint) =
            (Class(index("label", label)?), viewpoint.viewpoint(self.belt.model())?);
        self.policy.search.thresholds(class, viewpoint).map_err(to_python)
    }

    /// The share of a look's cost that each object pays in the upper bound, by ticks left from 1.
    #[getter]
    fn shares(&self) -> Vec<f64> {
        self.policy.search.shares().to_vec()
    }

    /// The belt planned for.
    #[getter]
    fn belt(&self) -> PyMovingBelt {
        PyMovingBelt(Arc::clone(&self.belt))
    }

    /// What plans depend on besides the belt, as keywords of the constructor.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let MovingConfig { scenarios, seed, depth, optimism } = self.policy.search.config();
        let (seconds, trials) = match self.policy.budget {
            Budget::Time(time) => (Some(time.as_secs_f64()), None),
            Budget::Trials(trials) => (None, Some(trials)),
        };
        let settings = PyDict::new(py);
        settings.set_item("seconds", seconds)?;
        settings.set_item("trials", trials)?;
        settings.set_item("scenarios", scenarios)?;
        settings.set_item("seed", seed)?;
        settings.set_item("depth", depth)?;
        settings.set_item("optimism", optimism)?;
        Ok(settings)
    }

    fn __repr__(&self) -> String {
        match self.policy.budget {
            Budget::Time(time) => format!("MovingPlanner(seconds={})", time.as_secs_f64()),
            Budget::Trials(trials) => format!("MovingPlanner(trials={trials})"),
        }
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((PyMovingBelt,), Bound<'py, PyDict>)> {
        Ok(((self.belt(),), self.settings(py)?))
    }
}

immutable!(PyMovingPlanner);
