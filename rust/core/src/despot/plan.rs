//! What a search found.

use std::sync::Arc;
use std::time::Duration;

use super::Despot;
use super::search::Search;
use super::workspace::Lease;
use crate::bounds;
use crate::index::{Class, Viewpoint};
use crate::model::{Action, SortingModel};
use crate::remaining::Remaining;
use crate::tree::Edge;

/// The outcome of planning. It keeps the searched tree, and gives the memory back when it is dropped.
#[derive(Debug)]
pub struct Plan {
    /// The action to take.
    pub action: Action,
    /// Estimated value of every legal action: decisions by label, then moves.
    pub values: Vec<(Action, f64)>,
    /// Lower bound of the optimum of the search's own (sampled, regularised) problem.
    pub lower: f64,
    /// Upper bound of the same optimum.
    pub upper: f64,
    /// Lower bound of V*: the value of a policy that can be executed from here; `None` if the model repeats looks.
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
    pub(super) model: Arc<SortingModel>,
    pub(super) space: Lease,
}

/// Equal plans come from equal searches, node by node; the time they took does not count.
impl PartialEq for Plan {
    fn eq(&self, other: &Self) -> bool {
        let numbers = |plan: &Self| (plan.trials, plan.scenario_steps, plan.expansions, plan.nodes);
        let certified = |plan: &Self| (plan.certified_lower, plan.certified_upper);
        self.action == other.action
            && self.values == other.values
            && numbers(self) == numbers(other)
            && certified(self) == certified(other)
            && self.space.frontier.tree == other.space.frontier.tree
    }
}

impl Despot {
    /// Upper bound of V*. It is no part of the search, but of the time that a plan takes.
    pub(super) fn certified_upper(
        &self,
        (belief, remaining): (&[f64], Remaining),
        viewpoint: Viewpoint,
    ) -> f64 {
        let closed = bounds::upper(&self.model, (belief, remaining), viewpoint);
        let endless = self.certificate.as_ref().filter(|_| remaining == Remaining::ENDLESS);
        let grid = endless.map(|grid| grid.at(&self.model, belief, viewpoint));
        grid.map_or(closed, |grid| grid.min(closed))
    }
}

impl Search<'_> {
    pub(super) fn into_plan(self, certified_upper: f64) -> Plan {
        let (tree, tally) = (&self.space.frontier.tree, self.space.frontier.tally);
        let (root, bounds) = (&tree.nodes[0], tree.root.values);
        let mut values = Vec::new();
        for edge in &root.edges {
            match edge.action {
                Action::Decide(best) => values.extend(self.decisions(best, edge.values.estimate)),
                Action::Move(_) => values.push((edge.action, edge.values.estimate)),
            }
        }
        Plan {
            action: self.best_action(),
            values,
            lower: bounds.lower,
            upper: bounds.upper,
            certified_lower: (!self.despot.model.ever_repeats()).then_some(if self.regularised() {
                root.default
            } else {
                bounds.lower
            }),
            certified_upper: certified_upper.min(bounds.certified),
            trials: tally.trials,
            elapsed: self.clock.elapsed(),
            scenario_steps: tally.scenario_steps,
            expansions: tree.nodes.len() as u64,
            nodes: tally.nodes,
            model: Arc::clone(&self.despot.model),
            space: self.space,
        }
    }

    /// Whether the bounds are lowered by a price per policy node; the default policy's value never is.
    fn regularised(&self) -> bool {
        self.despot.config.regularization > 0.0
    }

    /// The action with the highest value; with regularisation, that with the highest lower bound, or the default
    /// policy's own if no planned one is worth its price.
    fn best_action(&self) -> Action {
        let Despot { model, default_policy, .. } = self.despot;
        let root = &self.space.frontier.tree.nodes[0];
        let worth = |edge: &Edge| if self.regularised() { edge.values.lower } else { edge.values.estimate };
        let best = root
            .edges
            .iter()
            .fold(&root.edges[0], |best, edge| if worth(edge) > worth(best) { edge } else { best });
        if self.regularised() && worth(best) < root.default {
            return default_policy.action(model, (&self.space.root, root.remaining), root.viewpoint);
        }
        best.action
    }

    /// Value of each decision: they differ from the best one in their immediate reward only.
    fn decisions(&self, best: Class, value: f64) -> impl Iterator<Item = (Action, f64)> + '_ {
        let model = &self.despot.model;
        let belief = &self.space.root;
        let reward = |class: Class| model.decision_reward(belief[class.0]);
        model.classes().map(move |class| (Action::Decide(class), value + reward(class) - reward(best)))
    }
}
