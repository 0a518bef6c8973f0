//! Exact beliefs that can be reached, each with certified bounds: heuristic search in the belief graph.
//!
//! The order of looks does not matter to a belief, so paths meet again and a graph is far smaller than a tree. Every
//! action of an expanded node leads to exact posteriors with exact probabilities; bounds come from the leaves:
//! below, the value of executing the one-object policy from there; above, the grid. Bellman backups keep both proved.
//! Trials follow HSVI (Smith & Simmons 2004): the action with the highest upper bound, the label vector that
//! contributes most to the gap.

use std::collections::HashMap;

use super::LeafBounds;
use crate::belief::most_likely;
use crate::model::SortingModel;
use crate::one_object::dot;

/// Beliefs that agree to this much count as equal; it moves a value by less than [`super::SLACK`].
const RESOLUTION: f64 = 1e-11;
/// Part of the root's gap that a trial does not look below.
const TARGET: f64 = 0.5;

type NodeId = u32;
type Key = (usize, Vec<u64>);

/// A belief with the camera in one viewpoint group.
struct Node {
    group: usize,
    /// One distribution per position.
    belief: Vec<f64>,
    lower: f64,
    upper: f64,
    /// Empty before expansion.
    edges: Vec<Edge>,
}

struct Edge {
    reward: f64,
    /// Next node and its probability.
    children: Vec<(NodeId, f64)>,
}

/// The graph; node 0 is the root.
pub(super) struct BeliefGraph<'a> {
    model: &'a SortingModel,
    leaves: &'a LeafBounds,
    nodes: Vec<Node>,
    known: HashMap<Key, NodeId>,
}

impl<'a> BeliefGraph<'a> {
    pub(super) fn new(
        model: &'a SortingModel,
        leaves: &'a LeafBounds,
        root: &[f64],
        viewpoint: usize,
    ) -> Self {
        let mut graph = Self { model, leaves, nodes: Vec::new(), known: HashMap::new() };
        graph.node(leaves.policy.group(viewpoint), root.to_vec());
        graph
    }

    /// Bounds of the root.
    pub(super) fn bounds(&self) -> (f64, f64) {
        (self.nodes[0].lower, self.nodes[0].upper)
    }

    /// Number of nodes.
    pub(super) fn size(&self) -> usize {
        self.nodes.len()
    }

    /// One trial: down to where the gap no longer matters, then backups on the way up.
    pub(super) fn trial(&mut self) {
        let mut path = Vec::new();
        let (mut node, mut target) = (0, TARGET * self.gap(0));
        loop {
            if self.nodes[node].edges.is_empty() {
                self.expand(node);
            }
            path.push(node);
            target /= self.model.discount();
            match self.most_uncertain_child(node, target) {
                Some(child) => node = child,
                None => break,
            }
        }
        for node in path.into_iter().rev() {
            self.back_up(node);
        }
    }

    fn gap(&self, node: usize) -> f64 {
        self.nodes[node].upper - self.nodes[node].lower
    }

    fn most_uncertain_child(&self, node: usize, target: f64) -> Option<usize> {
        let edges = &self.nodes[node].edges;
        let best = edges
            .iter()
            .map(|edge| (edge, self.worth(edge).1))
            .reduce(|a, b| if b.1 > a.1 { b } else { a })?;
        best.0
            .children
            .iter()
            .map(|(child, p)| (*child as usize, p * (self.gap(*child as usize) - target)))
            .filter(|(_, excess)| *excess > 0.0)
            .reduce(|a, b| if b.1 > a.1 { b } else { a })
            .map(|(child, _)| child)
    }

    /// Bellman's equation for both bounds; neither ever loosens.
    fn back_up(&mut self, node: usize) {
        let worths = self.nodes[node].edges.iter().map(|edge| self.worth(edge));
        let best = |a: (f64, f64), b: (f64, f64)| (a.0.max(b.0), a.1.max(b.1));
        let (lower, upper) = worths.fold((f64::NEG_INFINITY, f64::NEG_INFINITY), best);
        let node = &mut self.nodes[node];
        node.lower = node.lower.max(lower);
        node.upper = node.upper.min(upper);
    }

    /// Bounds of an action's value.
    fn worth(&self, edge: &Edge) -> (f64, f64) {
        let (mut lower, mut upper) = (0.0, 0.0);
        for (child, p) in &edge.children {
            lower += p * self.nodes[*child as usize].lower;
            upper += p * self.nodes[*child as usize].upper;
        }
        (edge.reward + self.model.discount() * lower, edge.reward + self.model.discount() * upper)
    }

    fn expand(&mut self, node: usize) {
        let (group, belief) = (self.nodes[node].group, self.nodes[node].belief.clone());
        let from = self.leaves.policy.representative(group);
        let mut edges = vec![self.decide(group, &belief)];
        for &to in self.model.legal_moves(from) {
            edges.push(self.move_to(from, to, &belief));
        }
        self.nodes[node].edges = edges;
    }

    fn decide(&mut self, group: usize, belief: &[f64]) -> Edge {
        let l = self.model.class_count();
        let (_, p_right) = most_likely(&belief[..l]);
        let next = self.node(group, [&belief[l..], self.model.arrival().as_slice()].concat());
        let reward = self.model.decision_reward(p_right);
        Edge { reward, children: vec![(next, 1.0)] }
    }

    fn move_to(&mut self, from: usize, to: usize, belief: &[f64]) -> Edge {
        let mut outcomes = vec![(1.0, Vec::new())];
        for (j, position) in belief.chunks_exact(self.model.class_count()).enumerate() {
            let posteriors = posteriors(self.model, j, to, position);
            outcomes = outcomes
                .iter()
                .flat_map(|(p, known)| {
                    posteriors.iter().map(move |(q, b)| (p * q, [known.as_slice(), b].concat()))
                })
                .collect();
        }
        let group = self.leaves.policy.group(to);
        let children = outcomes.into_iter().map(|(p, belief)| (self.node(group, belief), p)).collect();
        Edge { reward: -self.model.motion_cost(from, to), children }
    }

    /// The node of a belief, new or known.
    fn node(&mut self, group: usize, belief: Vec<f64>) -> NodeId {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a probability over 1e-11
        let key = (group, belief.iter().map(|b| (b / RESOLUTION).round() as u64).collect());
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let (lower, upper) =
            self.leaves.bounds(self.model, &belief, self.leaves.policy.representative(group));
        // The search stops long before 2^32 nodes: see `super::MOST_NODES`.
        #[allow(clippy::cast_possible_truncation)]
        let id = self.nodes.len() as NodeId;
        self.nodes.push(Node { group, belief, lower, upper: upper.max(lower), edges: Vec::new() });
        self.known.insert(key, id);
        id
    }
}

/// Probability and posterior of each possible label of one position.
fn posteriors(
    model: &SortingModel,
    position: usize,
    viewpoint: usize,
    belief: &[f64],
) -> Vec<(f64, Vec<f64>)> {
    let table = model.table(position, viewpoint);
    let weighted = table.column_iter().map(|column| (dot(belief, column.as_slice()), column));
    weighted
        .filter(|(p, _)| *p > 0.0)
        .map(|(p, column)| (p, belief.iter().zip(column.iter()).map(|(b, o)| b * o / p).collect()))
        .collect()
}
