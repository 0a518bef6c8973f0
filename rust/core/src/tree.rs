//! The arena the search lives in.
//!
//! Values are *scaled*: multiplied by the probability of reaching their node and the discount down to it, so that
//! a node's value is the plain sum of what lies below it. What the search reads all the time (values) lies apart
//! from what it reads once (nodes).

use std::ops::Range;

use crate::model::{Action, SortingModel};

/// Scaled values of a node or an edge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Values {
    /// Lower bound of the regularised value, `l` of the DESPOT paper.
    pub lower: f64,
    /// Upper bound, `mu` of the DESPOT paper.
    pub upper: f64,
    /// Best guess of the value itself: between the bounds, and on average no larger after a backup than before.
    pub estimate: f64,
}

impl Values {
    /// A value that is known.
    pub(crate) fn all(value: f64) -> Self {
        Self { lower: value, upper: value, estimate: value }
    }

    /// How far the bounds are apart.
    pub(crate) fn gap(self) -> f64 {
        self.upper - self.lower
    }

    fn add(&mut self, other: Self) {
        self.lower += other.lower;
        self.upper += other.upper;
        self.estimate += other.estimate;
    }

    fn raise(&mut self, other: Self) {
        self.lower = self.lower.max(other.lower);
        self.upper = self.upper.max(other.upper);
        self.estimate = self.estimate.max(other.estimate);
    }
}

/// A belief node. Its belief and its scenarios are kept once it is expanded; before that they follow from its
/// parent's and its labels.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Node {
    /// Planner steps since the root.
    pub depth: usize,
    /// Decisions since the root.
    pub decisions: usize,
    /// Where the camera stands.
    pub viewpoint: usize,
    /// Probability of the labels on the way here, given the actions.
    pub probability: f64,
    /// Scaled value of the default policy, `l_0` of the DESPOT paper.
    pub default: f64,
    /// The labels that lead here from the parent, as digits in base L, the belt end's last; 0 where there is no scan.
    pub labels: u64,
    /// The edge that leads here; `None` at the root.
    pub parent: Option<u32>,
    /// The node's actions; empty before expansion.
    pub edges: Range<u32>,
    /// Number of the expansion that made the edges.
    pub expansion: u32,
}

impl Node {
    /// The labels that lead here, the belt end's first.
    #[inline(always)]
    pub(crate) fn seen(&self, model: &SortingModel) -> impl Iterator<Item = usize> + use<> {
        let (mut code, base) = (self.labels, model.class_count() as u64);
        (0..model.position_count()).map(move |_| {
            let digit = code % base;
            code /= base;
            // A digit is below L, which is a usize.
            #[allow(clippy::cast_possible_truncation)]
            let label = digit as usize;
            label
        })
    }
}

/// An action at a node.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Edge {
    /// The action.
    pub action: Action,
    /// The node it starts from.
    pub node: u32,
    /// Reward, less the regularisation, plus the values of labels that no scenario gives.
    pub fixed: Values,
    /// Values with what lies below.
    pub values: Values,
    /// One child per label vector that some scenario gives.
    pub children: Range<u32>,
}

/// All nodes and edges of one search; node 0 is the root.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Tree {
    pub nodes: Vec<Node>,
    /// Parallel to `nodes`.
    pub values: Vec<Values>,
    pub edges: Vec<Edge>,
}

/// Indices of an arena, as it stores them; a search stops long before 2^32 nodes.
#[allow(clippy::cast_possible_truncation)]
pub(crate) fn id(index: usize) -> u32 {
    index as u32
}

/// A stored range as one of indices.
pub(crate) fn indices(range: &Range<u32>) -> Range<usize> {
    range.start as usize..range.end as usize
}

impl Tree {
    /// Forget everything but the memory, and start from a root.
    pub(crate) fn restart(&mut self, (root, values): (Node, Values)) {
        self.nodes.clear();
        self.values.clear();
        self.edges.clear();
        self.nodes.push(root);
        self.values.push(values);
    }

    /// The actions of a node.
    pub(crate) fn edges_of(&self, node: usize) -> &[Edge] {
        &self.edges[indices(&self.nodes[node].edges)]
    }

    /// Give a leaf its edges and their children; both buffers are emptied. Ranges of children count from the buffer.
    pub(crate) fn attach(
        &mut self,
        leaf: usize,
        expansion: u32,
        edges: &mut Vec<Edge>,
        children: &mut Vec<(Node, Values)>,
    ) {
        let (first_edge, first_child) = (id(self.edges.len()), id(self.nodes.len()));
        for (number, edge) in (first_edge..).zip(edges.iter_mut()) {
            for (child, _) in &mut children[indices(&edge.children)] {
                child.parent = Some(number);
            }
            edge.children = first_child + edge.children.start..first_child + edge.children.end;
        }
        self.edges.append(edges);
        for (node, values) in children.drain(..) {
            self.nodes.push(node);
            self.values.push(values);
        }
        self.nodes[leaf].edges = first_edge..id(self.edges.len());
        self.nodes[leaf].expansion = expansion;
        for edge in indices(&self.nodes[leaf].edges) {
            self.back_up_edge(edge);
        }
    }

    /// Bounds and estimate from `node` to the root. An expanded node's own come from its edges.
    pub(crate) fn back_up(&mut self, mut node: usize) {
        loop {
            if !self.nodes[node].edges.is_empty() {
                self.values[node] = self.best_values(node);
            }
            let Some(edge) = self.nodes[node].parent else { return };
            self.back_up_edge(edge as usize);
            node = self.edges[edge as usize].node as usize;
        }
    }

    /// Values of an edge from those of its children.
    pub(crate) fn back_up_edge(&mut self, edge: usize) {
        let edge = &mut self.edges[edge];
        edge.values = edge.fixed;
        for child in &self.values[indices(&edge.children)] {
            edge.values.add(*child);
        }
    }

    /// Bellman's equation: the best action; the bounds also know the default policy.
    fn best_values(&self, node: usize) -> Values {
        let default = self.nodes[node].default;
        let mut best = Values { lower: default, upper: default, estimate: f64::NEG_INFINITY };
        for edge in self.edges_of(node) {
            best.raise(edge.values);
        }
        best.estimate = best.estimate.max(best.lower).min(best.upper);
        best
    }

    /// The action with the highest upper bound, the first among equals.
    pub(crate) fn most_promising_edge(&self, node: usize) -> &Edge {
        let edges = self.edges_of(node);
        edges
            .iter()
            .fold(&edges[0], |best, edge| if edge.values.upper > best.values.upper { edge } else { best })
    }
}
