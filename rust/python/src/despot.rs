//! `Despot`.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use beltsort_core::{Belief, Budget, BudgetedDespot, Despot, DespotConfig, Plan, SortingModel, Viewpoint};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::ThreadPool;

use crate::actions;
use crate::belief::PyBelief;
use crate::budget::{self, budget, outside_pools, thread_pool};
use crate::convert::{self, Whole, count};
use crate::errors::to_python;
use crate::interrupt::interruptible;
use crate::model::PySortingModel;
use crate::plan::PyPlan;
use crate::solution::PySolution;

/// The DESPOT planner: an anytime search in a tree of beliefs, determinised by scenarios.
///
/// A scenario fixes the classes of the objects and a stream of observation randoms; only labels that some
/// scenario gives get a branch. Each branch weighs its exact probability and holds its exact belief; the mass
/// of the other labels follows the default policy, the best conditional plan for one object after the other.
/// Solving for those plans is what makes the constructor take a moment.
///
/// A trial expands one leaf of the tree. Leaves are chosen in batches of 8 to 256, more as the search goes on,
/// and those of a large batch are expanded at the same time by all threads. So with a budget of trials a plan
/// is a pure function of model, belief, viewpoint, seed and settings, bit by bit the same for any number of
/// `threads`; with a budget of time it depends on the machine too.
///
/// Repeated labels, scans after decisions and a bonus for information are planned for where the model has them.
///
/// Parameters
/// ----------
/// model : SortingModel
///     The problem. A scan has L^H outcomes: each further position multiplies the tree by up to L.
/// scenarios : int
///     Number of scenarios. Each expansion takes time in proportion, so under a budget of time too many leave
///     the tree shallow; too few leave likely labels without a branch.
/// seed : int
///     Seed of the scenarios.
/// threads : int, optional
///     Threads that share the work of a plan. All cores if missing; more than there are cores gain nothing.
///     Plans of less than 2 ms, or of at most 256 trials, are made on the calling thread: others would wake up
///     too late.
/// seconds : float, optional
///     Wall-clock budget of a plan in seconds, 0.01 if neither budget is given.
/// trials : int, optional
///     Budget of a plan in trials, in place of `seconds`. Memory grows with it.
/// regularization : float, optional
///     `lambda` of the DESPOT paper: cost of a policy node, in the unit of `r_max`; 0 if missing. Too large,
///     and nothing but the default policy is worth its nodes.
/// depth : int, optional
///     Planner steps to look ahead; if missing, as many as the discount leaves 1 % of a reward after.
/// solution : Solution, optional
///     A solution of the model: the planner is ready at once and gives the same plans, with a
///     `certified_upper` as tight as the solution's own.
///
/// Raises
/// ------
/// ArgumentError
///     For a count or budget of 0 or below, both budgets, a negative regularisation, an L^H above 2^64, or
///     the solution of another model.
///
/// References
/// ----------
/// Ye, Somani, Hsu & Lee, "DESPOT: Online POMDP planning with regularization", JAIR 58, 2017.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> planner = beltsort.Despot(model, trials=100)
/// >>> planner.plan(beltsort.Belief(model)).action
/// Move(viewpoint=0)
/// >>> planner.plan(beltsort.Belief(model, [[0.01, 0.99]])).action
/// Decide(label=1)
#[pyclass(frozen, name = "Despot", module = "beltsort")]
pub struct PyDespot {
    pub planner: BudgetedDespot,
    pub model: Arc<SortingModel>,
    threads: Threads,
}

/// The threads that work on a plan.
enum Threads {
    /// The one that asks for the plan.
    Caller,
    Own(ThreadPool),
    /// Those of all cores, shared by all planners.
    Shared,
}

impl Threads {
    fn new(threads: Option<Whole>) -> PyResult<Self> {
        Ok(match threads.map(thread_pool).transpose()? {
            Some(pool) if pool.current_num_threads() == 1 => Self::Caller,
            Some(pool) => Self::Own(pool),
            None => Self::Shared,
        })
    }
}

impl PyDespot {
    /// Plan with the GIL released.
    fn search(
        &self,
        py: Python<'_>,
        belief: &Belief,
        viewpoint: Viewpoint,
        budget: Budget,
    ) -> PyResult<Plan> {
        let (despot, stop) = (&self.planner.despot, AtomicBool::new(false));
        let plan = |parallel| despot.plan_until(belief, viewpoint, budget, parallel, &stop);
        let plan_in_pool = || match &self.threads {
            Threads::Own(pool) => pool.install(|| plan(true)),
            Threads::Shared if rayon::current_num_threads() > 1 => rayon::scope(|_| plan(true)),
            Threads::Shared | Threads::Caller => plan(false),
        };
        let plan = if budget::is_brief(budget) {
            py.detach(|| plan(false))
        } else if budget::is_long(budget) {
            interruptible(py, &stop, plan_in_pool)?
        } else {
            py.detach(|| outside_pools(plan_in_pool))
        };
        plan.map_err(to_python)
    }
}

#[pymethods]
impl PyDespot {
    #[new]
    #[pyo3(signature = (model, *, scenarios=500, seed=0, threads=None, seconds=None, trials=None,
                        regularization=None, depth=None, solution=None))]
    #[allow(clippy::too_many_arguments)] // the public contract
    fn new(
        py: Python<'_>,
        model: &PySortingModel,
        scenarios: Whole,
        seed: Whole,
        threads: Option<Whole>,
        seconds: Option<f64>,
        trials: Option<Whole>,
        regularization: Option<f64>,
        depth: Option<Whole>,
        solution: Option<&PySolution>,
    ) -> PyResult<Self> {
        let config = DespotConfig {
            scenarios: count("scenarios", scenarios)?,
            seed: convert::seed(seed)?,
            regularization: regularization.unwrap_or(0.0),
            depth: depth.map(|d| count("depth", d)).transpose()?,
        };
        let budget = budget(seconds, trials)?.unwrap_or(budget::DEFAULT);
        let prepare = || match solution {
            Some(solution) => Despot::with_solution(&model.0, &solution.solution, config),
            None => Despot::new(&model.0, config),
        };
        let despot = py.detach(prepare).map_err(to_python)?;
        Ok(Self {
            planner: BudgetedDespot { despot, budget },
            model: Arc::clone(&model.0),
            threads: Threads::new(threads)?,
        })
    }

    /// Plan the next action.
    ///
    /// Parameters
    /// ----------
    /// belief : Belief
    ///     What is known of the objects; made for the planner's model, or an equal one.
    /// viewpoint : int
    ///     Where the camera stands.
    /// seconds, trials : optional
    ///     In place of the planner's own budget; at most one of them.
    ///
    /// Returns
    /// -------
    /// Plan
    ///     The action, the value of every legal one, and bounds.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a belief of another model, an unknown viewpoint, both budgets, or one of 0 or below.
    #[pyo3(signature = (belief, viewpoint=0, *, seconds=None, trials=None))]
    fn plan(
        &self,
        py: Python<'_>,
        belief: PyBelief,
        viewpoint: Whole,
        seconds: Option<f64>,
        trials: Option<Whole>,
    ) -> PyResult<PyPlan> {
        belief.check_is_of(&self.model)?;
        let budget = budget(seconds, trials)?.unwrap_or(self.planner.budget);
        let plan = self.search(py, &belief.belief, convert::viewpoint(viewpoint)?, budget)?;
        Ok(PyPlan(plan))
    }

    /// The action of a plan with the planner's own budget: a planner is a policy.
    ///
    /// Parameters
    /// ----------
    /// belief : Belief
    ///     What is known of the objects.
    /// viewpoint : int
    ///     Where the camera stands.
    ///
    /// Returns
    /// -------
    /// Move or Decide
    ///     `plan(belief, viewpoint).action`.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a belief of another model or an unknown viewpoint.
    fn act(&self, py: Python<'_>, belief: PyBelief, viewpoint: Whole) -> PyResult<Py<PyAny>> {
        let plan = self.plan(py, belief, viewpoint, None, None)?;
        actions::to_python(py, plan.0.action)
    }

    /// What plans depend on, as keywords of the constructor: scenarios, seed, seconds, trials, regularization, depth.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let DespotConfig { scenarios, seed, regularization, depth } = *self.planner.despot.config();
        let (seconds, trials) = match self.planner.budget {
            Budget::Time(time) => (Some(time.as_secs_f64()), None),
            Budget::Trials(trials) => (None, Some(trials)),
        };
        let settings = PyDict::new(py);
        settings.set_item("scenarios", scenarios)?;
        settings.set_item("seed", seed)?;
        settings.set_item("seconds", seconds)?;
        settings.set_item("trials", trials)?;
        settings.set_item("regularization", regularization)?;
        settings.set_item("depth", depth)?;
        Ok(settings)
    }

    /// The model planned for.
    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }
}
