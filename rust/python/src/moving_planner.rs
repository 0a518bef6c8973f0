//! `MovingPlanner`.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use beltsort_core::{
    Budget, Class, DEFAULT_MOVING_DEPTH, DEFAULT_MOVING_SCENARIOS, DEFAULT_OPTIMISM, MovingConfig,
    MovingSearch, MovingSituation, MovingTimes, ScalarOrMatrix, SortingModel, Viewpoint,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::belief::PyBelief;
use crate::budget::{self, budget};
use crate::convert::{self, Whole, count, index, scalar_or_matrix};
use crate::errors::{ArgumentError, to_python};
use crate::interrupt::interruptible;
use crate::keywords;
use crate::model::PySortingModel;
use crate::moving_plan::PyMovingPlan;
use crate::names::Named;

/// Plan for a belt that never stops: a search over exact beliefs with a clock.
///
/// Time runs in ticks. The belt carries every object one place further every `ticks_per_place`, whatever is
/// decided. A look moves the camera and scans at the end of its ticks. An object is decided while it is in
/// reach; one that passes the exit undecided costs `missed`. The model's discount is per tick.
///
/// Preparing solves the problem of one object with a deadline, which takes seconds for models of many
/// classes.
///
/// Parameters
/// ----------
/// model : SortingModel
///     Classes, tables and rewards. `repeat`, `observe_after_decision` and `information_gain` are refused.
/// ticks_per_place : int
///     Ticks between two advances of the belt.
/// reach : int, default 1
///     Places, from the exit, at which objects can be decided.
/// move_ticks : int or array of shape (K, K), default 1
///     Ticks of the camera's moves. A look takes at least one tick.
/// scan_ticks : int, default 0
///     Ticks of a scan.
/// sort_ticks : int, default 0
///     Ticks of a decision, in which the camera waits.
/// missed : sequence of L floats, optional
///     Price of an object that passes the exit undecided, per class, not negative; if missing, 0 for the
///     model's `empty` class, and the largest reward for the others.
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
///     For times, prices, counts or budgets that make no sense.
/// ModelError
///     For a model with keys that are not supported.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> planner = beltsort.MovingPlanner(model, ticks_per_place=4, trials=50)
/// >>> planner.plan(beltsort.Belief(model)).action
/// Move(viewpoint=0)
/// >>> planner.plan(beltsort.Belief(model, [[0.001, 0.999]])).action
/// DecideAt(position=0, label=1)
#[pyclass(frozen, name = "MovingPlanner", module = "beltsort")]
pub struct PyMovingPlanner {
    search: MovingSearch,
    model: Arc<SortingModel>,
    times: MovingTimes,
    missed: Vec<f64>,
    budget: Budget,
}

#[pymethods]
impl PyMovingPlanner {
    #[new]
    #[pyo3(signature = (model, *, ticks_per_place, reach=1, move_ticks=None, scan_ticks=0, sort_ticks=0, missed=None,
                        seconds=None, trials=None, scenarios=DEFAULT_MOVING_SCENARIOS as Whole, seed=0,
                        depth=DEFAULT_MOVING_DEPTH as Whole, optimism=DEFAULT_OPTIMISM, **unknown),
           text_signature = "(model, *, ticks_per_place, reach=1, move_ticks=None, scan_ticks=0, sort_ticks=0, missed=None, seconds=None, trials=None, scenarios=..., seed=0, depth=..., optimism=...)")]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn new(
        py: Python<'_>,
        model: &PySortingModel,
        ticks_per_place: Whole,
        reach: Whole,
        move_ticks: Option<&Bound<'_, PyAny>>,
        scan_ticks: Whole,
        sort_ticks: Whole,
        missed: Option<Vec<f64>>,
        seconds: Option<f64>,
        trials: Option<Whole>,
        scenarios: Whole,
        seed: Whole,
        depth: Whole,
        optimism: f64,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        keywords::refuse(unknown, "MovingPlanner")?;
        let model = Arc::clone(&model.0);
        let times = MovingTimes {
            ticks_per_place: count("ticks_per_place", ticks_per_place)?,
            reach: count("reach", reach)?,
            move_ticks: ticks(&model, move_ticks)?,
            scan_ticks: index("scan_ticks", scan_ticks)?,
            sort_ticks: index("sort_ticks", sort_ticks)?,
        };
        let missed = missed.unwrap_or_else(|| MovingTimes::default_missed(&model));
        let config = MovingConfig {
            scenarios: count("scenarios", scenarios)?,
            seed: convert::seed(seed)?,
            depth: count("depth", depth)?,
            optimism,
        };
        let budget = budget(seconds, trials)?.unwrap_or(budget::DEFAULT);
        let stop = AtomicBool::new(false);
        let prepare = || MovingSearch::new_until(&model, &times, &missed, config, &stop);
        let search = interruptible(py, &stop, prepare)?.map_err(to_python)?;
        Ok(Self { search, model, times, missed, budget })
    }

    /// Plan the next action.
    ///
    /// Parameters
    /// ----------
    /// belief : Belief
    ///     What is known of the objects at the H places, the one nearest to the exit first.
    /// viewpoint : int or str
    ///     Where the camera stands: index or name.
    /// decided : sequence of int
    ///     Places whose object is decided already, or that are empty.
    /// offset : int
    ///     Ticks since the belt last advanced, below `ticks_per_place`.
    /// to_come : int, optional
    ///     Objects that have not come to a place yet; if missing, the belt never ends.
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
    ///     For a belief of another model, places or times that do not exist, or nothing left to decide.
    #[pyo3(signature = (belief, viewpoint=Named::Index(0), *, decided=vec![], offset=0, to_come=None, seconds=None,
                        trials=None, **unknown),
           text_signature = "($self, belief, viewpoint=0, *, decided=(), offset=0, to_come=None, seconds=None, trials=None)")]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn plan(
        &self,
        py: Python<'_>,
        belief: PyBelief,
        viewpoint: Named,
        decided: Vec<Whole>,
        offset: Whole,
        to_come: Option<Whole>,
        seconds: Option<f64>,
        trials: Option<Whole>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyMovingPlan> {
        keywords::refuse(unknown, "MovingPlanner.plan")?;
        belief.check_is_of(&self.model)?;
        let situation = MovingSituation {
            decided: decided.into_iter().map(|place| index("position", place)).collect::<PyResult<_>>()?,
            offset: index("offset", offset)?,
            to_come: to_come.map(|objects| index("to_come", objects)).transpose()?,
        };
        let budget = budget(seconds, trials)?.unwrap_or(self.budget);
        let viewpoint = viewpoint.viewpoint(&self.model)?;
        let stop = AtomicBool::new(false);
        let plan = || self.search.plan_until(&belief.belief, &situation, viewpoint, budget, &stop);
        let plan = if budget::is_long(budget) { interruptible(py, &stop, plan)? } else { py.detach(plan) };
        Ok(PyMovingPlan { plan: plan.map_err(to_python)? })
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
            (Class(index("label", label)?), viewpoint.viewpoint(&self.model)?);
        self.search.thresholds(class, viewpoint).map_err(to_python)
    }

    /// The share of a look's cost that each object pays in the upper bound, by ticks left from 1.
    #[getter]
    fn shares(&self) -> Vec<f64> {
        self.search.shares().to_vec()
    }

    /// The model planned for.
    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }

    /// What plans depend on, as keywords of the constructor.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let MovingConfig { scenarios, seed, depth, optimism } = self.search.config();
        let (seconds, trials) = match self.budget {
            Budget::Time(time) => (Some(time.as_secs_f64()), None),
            Budget::Trials(trials) => (None, Some(trials)),
        };
        let settings = PyDict::new(py);
        settings.set_item("ticks_per_place", self.times.ticks_per_place)?;
        settings.set_item("reach", self.times.reach)?;
        settings.set_item("move_ticks", self.times.move_ticks.clone())?;
        settings.set_item("scan_ticks", self.times.scan_ticks)?;
        settings.set_item("sort_ticks", self.times.sort_ticks)?;
        settings.set_item("missed", self.missed.clone())?;
        settings.set_item("seconds", seconds)?;
        settings.set_item("trials", trials)?;
        settings.set_item("scenarios", scenarios)?;
        settings.set_item("seed", seed)?;
        settings.set_item("depth", depth)?;
        settings.set_item("optimism", optimism)?;
        Ok(settings)
    }

    fn __repr__(&self) -> String {
        let MovingTimes { ticks_per_place, reach, .. } = self.times;
        let budget = match self.budget {
            Budget::Time(time) => format!("seconds={}", time.as_secs_f64()),
            Budget::Trials(trials) => format!("trials={trials}"),
        };
        format!("MovingPlanner(ticks_per_place={ticks_per_place}, reach={reach}, {budget})")
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((PySortingModel,), Bound<'py, PyDict>)> {
        Ok(((self.model(),), self.settings(py)?))
    }
}

/// The ticks of each move, a number standing for all.
fn ticks(model: &SortingModel, given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Vec<usize>>> {
    let k = model.viewpoint_count();
    let rows = match given.map(|given| scalar_or_matrix("move_ticks", given)).transpose()? {
        None => vec![vec![1.0; k]; k],
        Some(ScalarOrMatrix::Scalar(ticks)) => vec![vec![ticks; k]; k],
        Some(ScalarOrMatrix::Matrix(rows)) => rows,
    };
    let whole = |ticks: f64| {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        // a whole number of at most six digits
        if ticks >= 0.0 && ticks.fract() == 0.0 && ticks < 1e6 { Some(ticks as usize) } else { None }
    };
    let entry = |ticks: f64| {
        whole(ticks).ok_or_else(|| {
            ArgumentError::new_err(format!(
                "move_ticks has the entry {ticks}; give whole numbers of ticks, 0 or more"
            ))
        })
    };
    rows.into_iter().map(|row| row.into_iter().map(entry).collect()).collect()
}
