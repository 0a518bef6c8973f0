//! The arena the search lives in.
//!
//! Values are *scaled*: multiplied by the probability of reaching their node and the discount down to it, so that
//! a node's value is the plain sum of what lies below it.

use std::ops::Range;

use crate::model::Action;

/// A belief node.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    /// Planner steps since the root.
    pub depth: usize,
    /// Decisions since the root.
    pub decisions: usize,
    /// Where the camera stands.
    pub viewpoint: usize,
    /// Exact belief, one distribution per position.
    pub belief: Vec<f64>,
    /// Indices of the scenarios that pass through this node, ascending.
    pub scenarios: Vec<u32>,
    /// Probability of the labels on the way here, given the actions.
    pub probability: f64,
    /// Scaled value of the default policy, `l_0` of the DESPOT paper.
    pub default: f64,
    /// Scaled bounds of the regularised value, `l` and `mu` of the DESPOT paper.
    pub lower: f64,
    /// See `lower`.
    pub upper: f64,
    /// The node's actions; empty before expansion.
    pub edges: Range<usize>,
}

impl Node {
    pub(crate) fn is_leaf(&self) -> bool {
        self.edges.is_empty()
    }

    pub(crate) fn gap(&self) -> f64 {
        self.upper - self.lower
    }
}

/// An action at a node.
#[derive(Debug, Clone)]
pub(crate) struct Edge {
    /// The action.
    pub action: Action,
    /// Scaled reward, less the regularisation, plus the value of labels that no scenario gives.
    pub reward: f64,
    /// One child per label vector that some scenario gives.
    pub children: Range<usize>,
    /// Scaled bounds.
    pub lower: f64,
    /// See `lower`.
    pub upper: f64,
}

/// All nodes and edges of one search; node 0 is the root.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    pub nodes: Vec<Node>,
    pub edges: Vec<Edge>,
}

impl Tree {
    /// Attach the actions of a node, each with its children.
    pub(crate) fn attach(&mut self, node: usize, actions: Vec<(Action, f64, Vec<Node>)>) {
        let first = self.edges.len();
        for (action, reward, children) in actions {
            let start = self.nodes.len();
            self.nodes.extend(children);
            let edge = Edge { action, reward, children: start..self.nodes.len(), lower: 0.0, upper: 0.0 };
            self.edges.push(edge);
        }
        self.nodes[node].edges = first..self.edges.len();
        for edge in first..self.edges.len() {
            self.back_up_edge(edge);
        }
        self.back_up_node(node);
    }

    /// Bounds of an edge from those of its children.
    fn back_up_edge(&mut self, edge: usize) {
        let children = &self.nodes[self.edges[edge].children.clone()];
        let lower: f64 = children.iter().map(|child| child.lower).sum();
        let upper: f64 = children.iter().map(|child| child.upper).sum();
        let edge = &mut self.edges[edge];
        edge.lower = edge.reward + lower;
        edge.upper = edge.reward + upper;
    }

    /// Bellman's equation: the default policy or the best action, for both bounds.
    fn back_up_node(&mut self, node: usize) {
        let edges = &self.edges[self.nodes[node].edges.clone()];
        let lower = edges.iter().map(|edge| edge.lower).fold(f64::NEG_INFINITY, f64::max);
        let upper = edges.iter().map(|edge| edge.upper).fold(f64::NEG_INFINITY, f64::max);
        let node = &mut self.nodes[node];
        // Rounding must not loosen a bound that was proved before.
        node.lower = node.lower.max(lower);
        node.upper = node.upper.min(upper.max(node.default)).max(node.lower);
    }

    /// Bounds along a path of (node, edge) pairs, from its far end to the root.
    pub(crate) fn back_up(&mut self, path: &[(usize, usize)]) {
        for &(node, edge) in path.iter().rev() {
            self.back_up_edge(edge);
            self.back_up_node(node);
        }
    }

    /// The action with the highest upper bound, the first among equals.
    pub(crate) fn most_promising_edge(&self, node: usize) -> usize {
        let edges = self.nodes[node].edges.clone();
        edges.clone().fold(edges.start, |best, edge| {
            if self.edges[edge].upper > self.edges[best].upper { edge } else { best }
        })
    }
}
