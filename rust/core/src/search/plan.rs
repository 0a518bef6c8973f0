//! The plan that a search has found.

use std::sync::Arc;

use super::Search;
use super::explain::Searched;
use super::tree::first_best;
use crate::bounds;
use crate::config::Clock;
use crate::index::{Bin, Position};
use crate::model::Action;
use crate::offline::Certificate;
use crate::plan::Plan;

impl Search<'_> {
    /// The action with the highest estimate.
    pub(super) fn best_action(&self) -> Action {
        let edges = &self.tree.nodes[0].edges;
        edges[first_best(edges, |edge| edge.values.estimate)].action
    }

    pub(super) fn into_plan(self, clock: &Clock<'_>) -> Plan {
        let model = &self.planner.model;
        let mut values = Vec::new();
        for edge in &self.tree.nodes[0].edges {
            match edge.action {
                Action::Decide(best) => values.extend(self.decisions(best, edge.values.estimate)),
                Action::Move(_) => values.push((edge.action, edge.values.estimate)),
            }
        }
        let bounds = self.tree.root.values;
        let closed = bounds::upper(model, self.belief.known(), self.viewpoint);
        let ahead = |bound: &Certificate| bound.one_step_ahead(model, self.belief.as_slice(), self.viewpoint);
        let certified = self.planner.certificate_for(self.belief).map_or(f64::INFINITY, ahead);
        Plan {
            action: self.best_action(),
            values,
            lower: bounds.lower,
            upper: bounds.upper,
            certified_lower: (!model.ever_repeats()).then_some(bounds.lower),
            certified_upper: closed.min(certified).min(bounds.certified),
            trials: clock.trials(),
            elapsed: clock.elapsed(),
            scenario_steps: self.scenario_steps,
            expansions: self.tree.nodes.len() as u64,
            nodes: self.nodes_created,
            searched: Some(Searched {
                model: Arc::clone(model),
                belief: self.belief.clone(),
                viewpoint: self.viewpoint,
                tree: self.tree,
            }),
        }
    }

    /// Value of each decision: they differ from the best one in their immediate reward only.
    fn decisions(&self, best: Bin, value: f64) -> impl Iterator<Item = (Action, f64)> + '_ {
        let (model, belief) = (&self.planner.model, self.belief.position(Position(0)));
        let reward = move |bin: Bin| model.expected_decision_reward(bin, belief.as_slice());
        model.bins().map(move |bin| (Action::Decide(bin), value + reward(bin) - reward(best)))
    }
}
