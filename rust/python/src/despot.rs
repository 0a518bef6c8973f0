//! `Despot`.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use beltsort_core::{
    Action, Belief, BeliefSearch, Budget, BudgetedDespot, BudgetedSearch, DEFAULT_SCENARIOS, Despot,
    DespotConfig, Plan, Policy, Result, Solution, SortingModel, Viewpoint,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::ThreadPool;

use crate::actions;
use crate::belief::PyBelief;
use crate::budget::{self, budget, outside_pools, thread_pool};
use crate::convert::{self, Whole, count};
use crate::display::{displayed, immutable};
use crate::errors::{ArgumentError, to_python};
use crate::interrupt::interruptible;
use crate::keywords;
use crate::model::PySortingModel;
use crate::names::Named;
use crate::plan::PyPlan;
use crate::solution::PySolution;

/// Plan online by an anytime search in a tree of beliefs, determinised by sampled scenarios.
///
/// A scenario fixes the classes of the objects and a stream of observation randoms. There are two variants:
///
/// * "beliefs", the recommended one: the belief at each node is exact, and scenarios only choose which label
///   vectors get a branch. A branch weighs its exact probability; the labels that no scenario gives follow
///   the default policy, the best conditional plan for one object after the other. Solving for those plans is
///   what makes the constructor take a moment.
/// * "scenarios": DESPOT as published, to compare with. The search knows nothing but its scenarios: rewards
///   and probabilities are averages over those that come to a node.
///
/// A trial expands one leaf of the tree, or as many as the published algorithm says. With a budget of trials
/// a plan is a pure function of model, belief, viewpoint, seed and settings, bit by bit the same for any
/// number of `threads`; with a budget of time it depends on the machine too.
///
/// Repeated labels and scans after decisions are planned for where the model has them; so is a bonus for
/// information, by the variant "beliefs".
///
/// Parameters
/// ----------
/// model : SortingModel
///     The problem. A scan has L^H outcomes: each further position multiplies the tree by up to L.
/// scenarios : int, default 500
///     Number of scenarios. Too few leave likely labels without a branch, or, of the variant "scenarios", are
///     overfitted; too many leave the tree shallow under a budget of time.
/// seed : int
///     Seed of the scenarios.
/// threads : int, optional
///     Threads that share the work of a plan of the variant "scenarios"; all cores if missing. Plans of less
///     than 2 ms, or of at most 256 trials, are made on the calling thread, as are all of the variant
///     "beliefs".
/// seconds : float, optional
///     Wall-clock budget of a plan in seconds, 0.01 if neither budget is given.
/// trials : int, optional
///     Budget of a plan in trials, in place of `seconds`. Memory grows with it.
/// regularization : float, optional
///     `lambda` of the DESPOT paper: cost of a policy node, in the unit of `r_max`; 0 if missing. Only the
///     variant "scenarios" has one: too small, and it overfits its scenarios; too large, and nothing but the
///     default policy is worth its nodes.
/// depth : int, optional
///     Planner steps to look ahead; if missing, as many as the discount leaves 1 % of a reward after.
/// solution : Solution, optional
///     A solution of the model, for the variant "beliefs": the planner is ready at once and gives the same
///     plans, with a `certified_upper` as tight as the solution's own.
/// variant : {"beliefs", "scenarios"}
///     Which planner.
///
/// Raises
/// ------
/// ArgumentError
///     For a count or budget of 0 or below, both budgets, a negative regularisation, an unknown variant, an
///     argument that the variant does not take, the solution of another model, or, of the variant
///     "scenarios", an L^H above 2^64.
/// ModelError
///     For a model with `information_gain` and the variant "scenarios".
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
    pub planner: Planner,
    budget: Budget,
    pub model: Arc<SortingModel>,
    threads: Threads,
    solution: Option<Arc<Solution>>,
}

/// A variant, with the budget of the constructor.
pub enum Planner {
    Beliefs(BudgetedSearch),
    Scenarios(BudgetedDespot),
}

impl Planner {
    fn beliefs(budget: Budget) -> impl FnOnce(BeliefSearch) -> Self {
        move |search| Self::Beliefs(BudgetedSearch { search, budget })
    }

    fn config(&self) -> (&DespotConfig, &'static str) {
        match self {
            Self::Beliefs(planner) => (planner.search.config(), "beliefs"),
            Self::Scenarios(planner) => (planner.despot.config(), "scenarios"),
        }
    }
}

impl Policy for Planner {
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        match self {
            Self::Beliefs(planner) => planner.act(belief, viewpoint),
            Self::Scenarios(planner) => planner.act(belief, viewpoint),
        }
    }
}

/// The threads that work on a plan of the variant "scenarios".
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

impl Threads {
    /// The argument of the constructor.
    fn number(&self) -> Option<usize> {
        match self {
            Self::Caller => Some(1),
            Self::Own(pool) => Some(pool.current_num_threads()),
            Self::Shared => None,
        }
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
        let stop = AtomicBool::new(false);
        let plan = |parallel| match &self.planner {
            Planner::Beliefs(planner) => planner.search.plan_until(belief, viewpoint, budget, &stop),
            Planner::Scenarios(planner) => {
                planner.despot.plan_until(belief, viewpoint, budget, parallel, &stop)
            }
        };
        let plan_in_pool = || match &self.threads {
            Threads::Own(pool) => pool.install(|| plan(true)),
            Threads::Shared if rayon::current_num_threads() > 1 => rayon::scope(|_| plan(true)),
            Threads::Shared | Threads::Caller => plan(false),
        };
        let alone = matches!(self.planner, Planner::Beliefs(_)) || budget::is_brief(budget);
        let plan = match (alone, budget::is_long(budget)) {
            (true, false) => py.detach(|| plan(false)),
            (true, true) => interruptible(py, &stop, || plan(false))?,
            (false, true) => interruptible(py, &stop, plan_in_pool)?,
            (false, false) => py.detach(|| outside_pools(plan_in_pool)),
        };
        plan.map_err(to_python)
    }
}

#[pymethods]
impl PyDespot {
    #[new]
    #[pyo3(signature = (model, *, scenarios=DEFAULT_SCENARIOS as Whole, seed=0, threads=None, seconds=None, trials=None,
                        regularization=None, depth=None, solution=None, variant="beliefs", **unknown),
           text_signature = "(model, *, scenarios=..., seed=0, threads=None, seconds=None, trials=None, \
                             regularization=None, depth=None, solution=None, variant='beliefs')")]
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
        variant: &str,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        keywords::refuse(unknown, "Despot")?;
        let config = DespotConfig {
            scenarios: count("scenarios", scenarios)?,
            seed: convert::seed(seed)?,
            regularization: regularization.unwrap_or(DespotConfig::default().regularization),
            depth: depth.map(|d| count("depth", d)).transpose()?,
        };
        let budget = budget(seconds, trials)?.unwrap_or(budget::DEFAULT);
        let (model, stop) = (&model.0, AtomicBool::new(false));
        let planner = match (variant, solution) {
            ("beliefs", solution) => {
                let solution = solution.map(|solution| &*solution.solution);
                interruptible(py, &stop, || BeliefSearch::new_until(model, solution, config, &stop))?
                    .map(Planner::beliefs(budget))
            }
            ("scenarios", None) => interruptible(py, &stop, || Despot::new_until(model, config, &stop))?
                .map(|despot| Planner::Scenarios(BudgetedDespot { despot, budget })),
            ("scenarios", Some(_)) => {
                return Err(ArgumentError::new_err(
                    "solution is given, which variant=\"scenarios\" makes no use of; leave one of them out",
                ));
            }
            _ => {
                return Err(ArgumentError::new_err(format!(
                    "variant = {variant:?}; give \"beliefs\", the recommended one, or \"scenarios\", DESPOT as published"
                )));
            }
        };
        let planner = planner.map_err(to_python)?;
        let solution = solution.map(|solution| Arc::clone(&solution.solution));
        Ok(Self { planner, budget, model: Arc::clone(model), threads: Threads::new(threads)?, solution })
    }

    /// Plan the next action.
    ///
    /// Parameters
    /// ----------
    /// belief : Belief
    ///     What is known of the objects; made for the planner's model, or an equal one.
    /// viewpoint : int or str
    ///     Where the camera stands: index or name.
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
    #[pyo3(signature = (belief, viewpoint=Named::Index(0), *, seconds=None, trials=None, **unknown),
           text_signature = "($self, belief, viewpoint=0, *, seconds=None, trials=None)")]
    fn plan(
        &self,
        py: Python<'_>,
        belief: PyBelief,
        viewpoint: Named,
        seconds: Option<f64>,
        trials: Option<Whole>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyPlan> {
        keywords::refuse(unknown, "Despot.plan")?;
        belief.check_is_of(&self.model)?;
        let budget = budget(seconds, trials)?.unwrap_or(self.budget);
        let plan = self.search(py, &belief.belief, viewpoint.viewpoint(&self.model)?, budget)?;
        Ok(PyPlan { plan, model: Arc::clone(&self.model) })
    }

    /// Return the action of a plan with the planner's own budget: a planner is a policy.
    ///
    /// Parameters
    /// ----------
    /// belief : Belief
    ///     What is known of the objects.
    /// viewpoint : int or str
    ///     Where the camera stands: index or name.
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
    fn act(&self, py: Python<'_>, belief: PyBelief, viewpoint: Named) -> PyResult<Py<PyAny>> {
        let plan = self.plan(py, belief, viewpoint, None, None, None)?;
        actions::to_python(py, plan.plan.action)
    }

    /// What plans depend on, as keywords of the constructor.
    ///
    /// They are scenarios, seed, seconds, trials, regularization, depth, variant.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (config, variant) = self.planner.config();
        let DespotConfig { scenarios, seed, regularization, depth } = *config;
        let (seconds, trials) = match self.budget {
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
        settings.set_item("variant", variant)?;
        Ok(settings)
    }

    /// The model planned for.
    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((PySortingModel,), Bound<'py, PyDict>)> {
        let keywords = self.settings(py)?;
        keywords.set_item("threads", self.threads.number())?;
        let solution = |solution| PySolution { solution, model: Arc::clone(&self.model) };
        keywords.set_item("solution", self.solution.clone().map(solution))?;
        Ok(((self.model(),), keywords))
    }
}

displayed!(PyDespot);
immutable!(PyDespot);
