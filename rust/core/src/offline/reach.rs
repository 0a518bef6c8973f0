//! What the policy that is greedy in the upper bound reaches from the root of the belief graph.
//!
//! At the root the graph improves on the grid where the policy stays inside it: what is wrong with the grid's bound
//! enters through the leaves, each weighted by `E[discount^steps]` of entering it. The sum of these weights, the exit
//! mass, is the part of the grid's error that is left; so the leaves with the largest weights are expanded next.

use super::graph::{BeliefGraph, NodeId};

/// Sweeps that follow the policy's steps; the graph is nearly in order, so few are needed.
const SWEEPS: usize = 6;
/// Backups of every node reached, after each growth.
const BACKUPS: usize = 2;
/// Growth of the graph at once, as a part of the nodes reached.
const GROWTH: f64 = 0.2;
const LEAST_GROWTH: usize = 16;

/// The nodes reached.
pub(super) struct Reach {
    /// Those whose best action is followed, nearest to the root first.
    pub interior: Vec<NodeId>,
    /// Those where the graph ends, and their weights.
    pub leaves: Vec<(NodeId, f64)>,
}

impl Reach {
    pub(super) fn new(graph: &BeliefGraph<'_>, discount: f64) -> Self {
        let mut seen = vec![false; graph.size()];
        let (mut interior, mut leaves) = (Vec::new(), Vec::new());
        let mut reached = vec![0];
        seen[0] = true;
        let mut next = 0;
        while next < reached.len() {
            let node = reached[next];
            next += 1;
            let Some(step) = graph.followed(node) else {
                leaves.push((node, 0.0));
                continue;
            };
            interior.push(node);
            for &child in step.children {
                if !std::mem::replace(&mut seen[child as usize], true) {
                    reached.push(child);
                }
            }
        }
        let mut reach = Self { interior, leaves };
        reach.weigh(graph, discount);
        reach
    }

    fn weigh(&mut self, graph: &BeliefGraph<'_>, discount: f64) {
        let mut mass = vec![0.0; graph.size()];
        mass[0] = 1.0;
        for _ in 0..SWEEPS {
            for &node in &self.interior {
                let here = std::mem::take(&mut mass[node as usize]);
                let Some(step) = graph.followed(node) else { continue };
                for (child, p) in step.children.iter().zip(step.probabilities) {
                    mass[*child as usize] += discount * p * here;
                }
            }
        }
        for (leaf, weight) in &mut self.leaves {
            *weight = mass[*leaf as usize];
        }
    }

    /// All of them, the interior first.
    pub(super) fn nodes(&self) -> impl Iterator<Item = NodeId> {
        self.interior.iter().copied().chain(self.leaves.iter().map(|(leaf, _)| *leaf))
    }

    /// Expand the heaviest leaves and carry what that brings to the root, until `stop` says so.
    pub(super) fn grow(mut self, graph: &mut BeliefGraph<'_>, stop: impl Fn() -> bool) {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a part of a length
        let wanted = (GROWTH * self.interior.len() as f64) as usize;
        let count = wanted.max(LEAST_GROWTH).min(self.leaves.len());
        if count < self.leaves.len() {
            self.leaves.select_nth_unstable_by(count, |a, b| b.1.total_cmp(&a.1));
        }
        for (leaf, _) in &self.leaves[..count] {
            if stop() {
                break;
            }
            graph.expand(*leaf);
        }
        for _ in 0..BACKUPS {
            for node in self.interior.iter().rev() {
                graph.back_up(*node);
            }
        }
    }
}
