//! What a planner found.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::model::Action;
use crate::search::{Searched, TreeNode};

/// The outcome of planning.
#[derive(Debug, Serialize, Deserialize)]
pub struct Plan {
    /// The action to take.
    pub action: Action,
    /// Value of every legal action: decisions by label, then moves. Estimates of V*; of DESPOT as published, lower bounds
    /// in its own problem.
    pub values: Vec<(Action, f64)>,
    /// Lower bound of the optimum of the planner's own (sampled, regularised) problem.
    pub lower: f64,
    /// Upper bound of the same optimum.
    pub upper: f64,
    /// Lower bound of V*: the value of a policy that can be executed from here; `None` where the planner knows of none.
    pub certified_lower: Option<f64>,
    /// Upper bound of V*.
    pub certified_upper: f64,
    /// Trials done.
    pub trials: u64,
    /// Wall-clock time spent.
    pub elapsed: Duration,
    /// (scenario, move) pairs simulated at expanded nodes.
    pub scenario_steps: u64,
    /// Belief nodes whose actions were all generated.
    pub expansions: u64,
    /// Belief nodes created.
    pub nodes: u64,
    /// The searched tree, of planners that keep it; it is not written.
    #[serde(skip)]
    pub(crate) searched: Option<Searched>,
}

impl Plan {
    /// The searched tree down to `depth` planner steps below the root; `None` of DESPOT as published, which keeps none.
    #[must_use]
    pub fn tree(&self, depth: usize) -> Option<TreeNode> {
        self.searched.as_ref().map(|searched| searched.tree(depth))
    }
}

/// Equal plans come from equal searches; the time they took does not count.
impl PartialEq for Plan {
    fn eq(&self, other: &Self) -> bool {
        let numbers = |plan: &Self| (plan.trials, plan.scenario_steps, plan.expansions, plan.nodes);
        let bounds = |plan: &Self| (plan.lower, plan.upper, plan.certified_lower, plan.certified_upper);
        self.action == other.action
            && self.values == other.values
            && numbers(self) == numbers(other)
            && bounds(self) == bounds(other)
            && self.searched == other.searched
    }
}
