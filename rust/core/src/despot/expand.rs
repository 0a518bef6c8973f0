//! Expanding a leaf: all its actions, and a child per label vector that its scenarios give.

use super::{NodePlace, Search};
use crate::belief::most_likely;
use crate::bounds::{self, Look};
use crate::model::Action;
use crate::scenario::{ScanPoint, labels};
use crate::tree::Node;

impl Search<'_> {
    /// Generate every action of a leaf.
    pub(super) fn expand(&mut self, leaf: usize) {
        let model = &self.despot.model;
        let node = self.tree.nodes[leaf].clone();
        self.scenarios.reach(model, node.depth);
        let mut actions = vec![self.decide(&node)];
        for &to in model.legal_moves(node.viewpoint) {
            actions.push(self.move_to(&node, to));
            self.scenario_steps += node.scenarios.len() as u64;
        }
        self.expansions += 1;
        self.tree.attach(leaf, actions);
    }

    /// Decide the most likely label: one child, the belt advanced, nothing observed.
    fn decide(&self, node: &Node) -> (Action, f64, Vec<Node>) {
        let model = &self.despot.model;
        let l = model.class_count();
        let (label, p_right) = most_likely(&node.belief[..l]);
        let belief = [&node.belief[l..], model.arrival().as_slice()].concat();
        let place = NodePlace {
            depth: node.depth + 1,
            decisions: node.decisions + 1,
            viewpoint: node.viewpoint,
            probability: node.probability,
        };
        let reward = self.scale(node) * model.decision_reward(p_right) - self.despot.config.regularization;
        let value = bounds::lower(model, &self.despot.default_policy, &belief, node.viewpoint);
        (Action::Decide(label), reward, vec![self.node(place, belief, node.scenarios.clone(), value)])
    }

    /// Move and scan: a child per label vector that a scenario gives; the other label vectors follow the default
    /// policy.
    fn move_to(&self, node: &Node, to: usize) -> (Action, f64, Vec<Node>) {
        let model = &self.despot.model;
        let look = Look::new(model, &self.despot.default_policy, &node.belief, to);
        let mut without_branch = look.value();
        let mut children = Vec::new();
        for (labels, scenarios) in self.branches(node, to) {
            let probability = look.probability(&labels);
            let value = look.value_after(&labels);
            without_branch -= probability * value;
            let place = NodePlace {
                depth: node.depth + 1,
                decisions: node.decisions,
                viewpoint: to,
                probability: node.probability * probability,
            };
            children.push(self.node(place, look.posterior(&labels), scenarios, value));
        }
        let step = -model.motion_cost(node.viewpoint, to) + model.discount() * without_branch;
        let reward = self.scale(node) * step - self.despot.config.regularization;
        (Action::Move(to), reward, children)
    }

    /// The node's scenarios, by the labels they give to a scan from `viewpoint`; in the order of the labels.
    fn branches(&self, node: &Node, viewpoint: usize) -> Vec<(Vec<usize>, Vec<u32>)> {
        let model = &self.despot.model;
        let at = ScanPoint { depth: node.depth, decisions: node.decisions, viewpoint };
        let code = |scenario: u32| self.scenarios.label_code(model, scenario as usize, at);
        let mut coded: Vec<(u64, u32)> = node.scenarios.iter().map(|&i| (code(i), i)).collect();
        coded.sort_unstable();
        coded
            .chunk_by(|a, b| a.0 == b.0)
            .map(|branch| (labels(model, branch[0].0), branch.iter().map(|(_, i)| *i).collect()))
            .collect()
    }

    fn scale(&self, node: &Node) -> f64 {
        let Node { depth, decisions, viewpoint, probability, .. } = *node;
        NodePlace { depth, decisions, viewpoint, probability }.scale(&self.despot.model)
    }
}
