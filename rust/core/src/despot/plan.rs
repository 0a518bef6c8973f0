//! What a search found.

use std::time::Duration;

use super::Search;
use crate::bounds;
use crate::model::Action;

/// The outcome of planning.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The action to take.
    pub action: Action,
    /// Value of every legal action, as far as the search knows it from below: decisions by label, then moves.
    pub values: Vec<(Action, f64)>,
    /// Lower bound of the optimum of the search's own (sampled, regularised) problem.
    pub lower: f64,
    /// Upper bound of the same optimum.
    pub upper: f64,
    /// Lower bound of V*: the value of a policy that can be executed from here.
    pub certified_lower: f64,
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
}

impl Search<'_> {
    pub(super) fn into_plan(self) -> Plan {
        let root = &self.tree.nodes[0];
        let mut values = Vec::new();
        for edge in &self.tree.edges[root.edges.clone()] {
            match edge.action {
                Action::Decide(best) => values.extend(self.decisions(best, edge.lower)),
                Action::Move(_) => values.push((edge.action, edge.lower)),
            }
        }
        Plan {
            action: self.best_action(),
            values,
            lower: root.lower,
            upper: root.upper,
            certified_lower: if self.regularised() { root.default } else { root.lower },
            certified_upper: bounds::upper(&self.despot.model, &root.belief, root.viewpoint),
            trials: self.trials,
            elapsed: self.start.elapsed(),
            scenario_steps: self.scenario_steps,
            expansions: self.expansions,
            nodes: self.tree.nodes.len() as u64,
        }
    }

    /// Whether the bounds are lowered by a price per policy node; the default policy's value never is.
    fn regularised(&self) -> bool {
        self.despot.config.regularization > 0.0
    }

    /// The action with the highest lower bound; the default policy's own if regularisation finds no planned one
    /// worth its price.
    fn best_action(&self) -> Action {
        let root = &self.tree.nodes[0];
        let mut best = None;
        for edge in &self.tree.edges[root.edges.clone()] {
            if best.is_none_or(|(_, lower)| edge.lower > lower) {
                best = Some((edge.action, edge.lower));
            }
        }
        match best {
            Some((action, lower)) if lower >= root.default || !self.regularised() => action,
            _ => self.despot.default_policy.action(&self.despot.model, &root.belief, root.viewpoint),
        }
    }

    /// Value of each decision: they differ from the best one in their immediate reward only.
    fn decisions(&self, best: usize, value: f64) -> impl Iterator<Item = (Action, f64)> + '_ {
        let model = &self.despot.model;
        let belief = &self.tree.nodes[0].belief;
        let reward = |label: usize| model.decision_reward(belief[label]);
        (0..model.class_count())
            .map(move |label| (Action::Decide(label), value + reward(label) - reward(best)))
    }
}
