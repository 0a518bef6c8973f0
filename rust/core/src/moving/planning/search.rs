//! The planner: a search in a tree of exact beliefs with a clock, in which scenarios choose the branches.
//!
//! The tree, its trials and its backups are those of [`crate::search`], with a discount of its own for each action.
//! A node's belief is exact and factored. At a leaf the default policy ([`super::serving`]) is the lower
//! bound, the priced bound ([`super::priced`]) the upper one, and the estimate lies between them. Both are known after
//! a look in expectation over all label vectors without enumerating them: the bound is a sum over objects, and the
//! default policy chooses the plan of each object by the object's own label.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use rand::RngExt;

use super::deadline::{DeadlineProblem, DeadlineValues};
use super::priced::PricedBound;
use super::serving::Serving;
use crate::config::{Budget, Clock};
use crate::error::{Result, argument_error};
use crate::index::Viewpoint;
use crate::model::SortingModel;
use crate::moving::action::MovingAction;
use crate::moving::state::State;
use crate::moving::timing::Timing;
use crate::sampling::{Purpose, stream};
use crate::search::{Child, GAP_TOLERANCE, Place, TARGET_GAP, Tree, Values, first_best};

/// Scenarios of a planner that is given no number of them.
pub const DEFAULT_MOVING_SCENARIOS: usize = 64;
/// Steps to look ahead of a planner that is given no number of them.
pub const DEFAULT_MOVING_DEPTH: usize = 40;
/// More than any belief needs, and deeper than any tree grows.
const MOST: usize = 10_000;
/// How far an estimate lies from the default policy's value to the priced bound.
pub const DEFAULT_OPTIMISM: f64 = 0.5;

/// Settings of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingConfig {
    /// Number of scenarios, which choose the label vectors that get a branch.
    pub scenarios: usize,
    /// Their seed.
    pub seed: u64,
    /// Actions to look ahead.
    pub depth: usize,
    /// How far an estimate at a leaf lies from the default policy's value, 0, to the priced bound, 1.
    pub optimism: f64,
}

impl Default for MovingConfig {
    fn default() -> Self {
        Self {
            scenarios: DEFAULT_MOVING_SCENARIOS,
            seed: 0,
            depth: DEFAULT_MOVING_DEPTH,
            optimism: DEFAULT_OPTIMISM,
        }
    }
}

impl MovingConfig {
    fn check(&self) -> Result<()> {
        for (name, value) in [("scenarios", self.scenarios), ("depth", self.depth)] {
            if !(1..=MOST).contains(&value) {
                return argument_error(format!("{name} = {value}; give between 1 and {MOST}"));
            }
        }
        if (0.0..=1.0).contains(&self.optimism) {
            return Ok(());
        }
        argument_error(format!(
            "optimism = {}; give 0 (estimate leaves by the default policy) to 1 (by the upper bound)",
            self.optimism
        ))
    }
}

/// The outcome of planning.
#[derive(Debug, Clone)]
pub struct MovingPlan {
    /// The action to take.
    pub action: MovingAction,
    /// Estimated value of every action that was compared: of the decisions on an object the best one, and those that cannot
    /// be improved by waiting alone.
    pub values: Vec<(MovingAction, f64)>,
    /// Lower bound of V: the value of a policy that can be executed.
    pub lower: f64,
    /// Upper bound of V.
    pub upper: f64,
    /// Trials done.
    pub trials: u64,
    /// Wall-clock time spent.
    pub elapsed: Duration,
    /// Belief nodes whose actions were all generated.
    pub expansions: u64,
    /// Belief nodes created.
    pub nodes: u64,
}

/// The search, prepared for a belt.
#[derive(Debug, Clone)]
pub(crate) struct Searching {
    pub model: Arc<SortingModel>,
    pub config: MovingConfig,
    pub serving: Serving,
    pub bound: PricedBound,
    /// Values of one object whose looks cost nothing.
    free: DeadlineValues,
    /// Randoms per scenario, depth and place.
    randoms: Arc<Vec<f64>>,
}

impl Searching {
    pub(crate) fn new(
        model: &Arc<SortingModel>,
        timing: &Timing,
        config: MovingConfig,
        stop: &AtomicBool,
    ) -> Result<Self> {
        config.check()?;
        let problem = Arc::new(DeadlineProblem::new(model, timing));
        let free = problem.values(&vec![0.0; problem.horizon() + 1]);
        let per_scenario = config.depth * timing.places;
        let drawn = |scenario| {
            let mut rng = stream(config.seed, Purpose::Scenario, scenario);
            (0..per_scenario).map(move |_| rng.random::<f64>())
        };
        Ok(Self {
            serving: Serving::new(model, timing, stop),
            bound: PricedBound::new(problem),
            free,
            randoms: Arc::new((0..config.scenarios as u64).flat_map(drawn).collect()),
            model: Arc::clone(model),
            config,
        })
    }

    pub(crate) fn timing(&self) -> &Timing {
        self.bound.problem().timing()
    }

    pub(super) fn scenarios(&self) -> usize {
        self.config.scenarios
    }

    #[allow(clippy::cast_possible_truncation)] // scenarios are few
    pub(super) fn random(&self, scenario: u64, depth: usize, place: usize) -> f64 {
        let places = self.timing().places;
        self.randoms[(scenario as usize * self.config.depth + depth) * places + place]
    }

    /// State and viewpoint after a step and before any label, and what the step earns until then.
    pub(crate) fn after(
        &self,
        state: &State,
        viewpoint: Viewpoint,
        step: MovingAction,
    ) -> (State, Viewpoint, f64) {
        let (timing, model) = (self.timing(), &self.model);
        let mut next = state.clone();
        let earned = match step {
            MovingAction::Look(to) => -model.motion_cost(viewpoint, to),
            MovingAction::Wait => 0.0,
            MovingAction::Decide { position, bin } => {
                next.decide(timing, model.arrival().as_slice(), position);
                model.expected_decision_reward(bin, &state.rows[position.0])
            }
        };
        let missed = next.pass(timing, model, timing.ticks(step, viewpoint));
        (next, step.viewpoint(viewpoint), earned - missed)
    }

    /// Discount of what follows a step.
    pub(super) fn discount(&self, step: MovingAction, viewpoint: Viewpoint) -> f64 {
        self.model.discount().powi(i32::try_from(self.timing().ticks(step, viewpoint)).unwrap_or(i32::MAX))
    }

    /// The most that an object is worth if looks at it cost nothing and the camera is its own.
    pub(super) fn with_free_looks(&self, left: usize, viewpoint: Viewpoint, belief: &[f64]) -> f64 {
        let problem = self.bound.problem();
        problem.at(&self.free, left, problem.group(viewpoint), &problem.locate(belief))
    }

    /// An estimate between a lower and an upper bound.
    pub(super) fn between(&self, lower: f64, upper: f64) -> f64 {
        lower + self.config.optimism * (upper - lower)
    }

    /// Values of a leaf at a depth.
    pub(super) fn leaf(&self, depth: usize, lower: f64, certified: f64) -> Values {
        let certified = certified.max(lower);
        let upper = if depth < self.config.depth { certified } else { lower };
        Values { lower, upper, estimate: self.between(lower, certified), certified }
    }

    /// Search from a state until the budget is spent or `stop` is set.
    pub(crate) fn search(
        &self,
        state: &State,
        viewpoint: Viewpoint,
        budget: Budget,
        stop: &AtomicBool,
    ) -> Result<MovingPlan> {
        budget.check()?;
        if state.is_over() {
            return argument_error("no object is left to decide, on the belt or to come; stop here");
        }
        let mut clock = Clock::started(budget, stop);
        let values = self.leaf(0, self.serving.value(state, viewpoint), self.bound.value(state, viewpoint));
        let tree = Tree { root: Child { values, probability: 1.0, node: None }, nodes: Vec::new() };
        let mut search = Search { planner: self, state, viewpoint, tree, nodes_created: 1 };
        search.expand(None);
        while let Some(leaf) = search.leaf_of_next_trial().filter(|_| clock.allows_another()) {
            search.expand(Some(leaf));
            clock.count();
        }
        Ok(search.found(&clock))
    }
}

/// One search.
pub(super) struct Search<'a> {
    pub(super) planner: &'a Searching,
    pub(super) state: &'a State,
    pub(super) viewpoint: Viewpoint,
    pub(super) tree: Tree<MovingAction, State>,
    pub(super) nodes_created: u64,
}

impl Search<'_> {
    /// The leaf to expand next; none if that would change nothing.
    fn leaf_of_next_trial(&self) -> Option<Place> {
        let gap = self.tree.root.values.gap();
        if gap < GAP_TOLERANCE * self.planner.model.reward_scale() {
            return None;
        }
        let leaf = self.tree.explore(TARGET_GAP * gap);
        leaf.filter(|leaf| self.tree.child(Some(*leaf)).values.gap() > 0.0)
    }

    fn found(self, clock: &Clock<'_>) -> MovingPlan {
        let edges = &self.tree.nodes[0].edges;
        let bounds = self.tree.root.values;
        MovingPlan {
            action: edges[first_best(edges, |edge| edge.values.estimate)].action,
            values: edges.iter().map(|edge| (edge.action, edge.values.estimate)).collect(),
            lower: bounds.lower,
            upper: bounds.certified,
            trials: clock.trials(),
            elapsed: clock.elapsed(),
            expansions: self.tree.nodes.len() as u64,
            nodes: self.nodes_created,
        }
    }
}

#[cfg(test)]
mod tests;
