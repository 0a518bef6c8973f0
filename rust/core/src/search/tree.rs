//! The tree of a search.
//!
//! A [`Node`] is a belief whose actions were generated; a belief that was not expanded is a [`Child`] of its parent and
//! nothing else. Values are expected discounted rewards as seen from the belief itself. An action has a discount of its own,
//! since actions may differ in how long they take.

use crate::belief::Belief;
use crate::index::{Label, Viewpoint};
use crate::model::Action;

/// Values of a belief or of an action.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Values {
    /// Lower bound of the sampled problem's optimum, and of V*: `l` of the DESPOT paper.
    pub lower: f64,
    /// Upper bound of the sampled problem's optimum, `mu` of the DESPOT paper. It is no bound of V*: in the sampled problem
    /// labels without a scenario follow the default policy.
    pub upper: f64,
    /// Estimate of V*, by which the action is chosen.
    pub estimate: f64,
    /// Upper bound of V*.
    pub certified: f64,
}

impl Values {
    /// A value that is known.
    pub(crate) fn all(value: f64) -> Self {
        Self { lower: value, upper: value, estimate: value, certified: value }
    }

    /// How far the bounds of the sampled problem are apart.
    pub(crate) fn gap(self) -> f64 {
        self.upper - self.lower
    }

    fn map(self, other: Self, combine: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            lower: combine(self.lower, other.lower),
            upper: combine(self.upper, other.upper),
            estimate: combine(self.estimate, other.estimate),
            certified: combine(self.certified, other.certified),
        }
    }
}

/// A belief as its parent sees it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Child {
    /// Its values; a leaf's lower bound is the default policy's value.
    pub values: Values,
    /// Probability of its labels, given the parent's belief and the action.
    pub probability: f64,
    /// Its node, once it is expanded.
    pub node: Option<usize>,
}

/// An action at a node.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Edge<A = Action> {
    /// The action.
    pub action: A,
    /// Discount of what follows it.
    pub discount: f64,
    /// Reward, and the discounted value of the labels that no scenario gives.
    pub fixed: Values,
    /// Value of the action: `fixed`, and the discounted values of the children.
    pub values: Values,
    /// One per label vector that some scenario gives; one alone where no scan follows the action.
    pub children: Vec<Child>,
    /// The label vectors of the children one after the other; empty where no scan follows the action.
    pub labels: Vec<Label>,
}

impl<A> Edge<A> {
    /// Labels that lead to a child, one per position; `None` where no scan follows the action.
    pub(crate) fn labels_of(&self, child: usize) -> Option<&[Label]> {
        let length = self.labels.len() / self.children.len();
        (length > 0).then(|| &self.labels[child * length..][..length])
    }

    /// Bellman's equation for one action.
    fn back_up(&mut self) {
        let discount = self.discount;
        let sum =
            |sum: Values, child: &Child| sum.map(child.values, |a, b| a + discount * child.probability * b);
        self.values = self.children.iter().fold(self.fixed, sum);
    }
}

/// Where in the tree a child is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Place {
    pub node: usize,
    pub edge: usize,
    pub child: usize,
}

/// An expanded belief.
#[derive(Debug, PartialEq)]
pub(crate) struct Node<A = Action, B = Belief> {
    /// The child that it is; `None` at the root.
    pub place: Option<Place>,
    /// Planner steps since the root.
    pub depth: usize,
    /// Decisions since the root.
    pub decisions: usize,
    /// Where the camera stands.
    pub viewpoint: Viewpoint,
    /// The exact belief.
    pub belief: B,
    /// Value of the default policy, `l_0` of the DESPOT paper.
    pub default: f64,
    /// The scenarios that come here, one bit each.
    pub scenarios: Vec<u64>,
    /// The actions: deciding, then the legal moves.
    pub edges: Vec<Edge<A>>,
}

impl<A, B> Node<A, B> {
    /// Bellman's equation: the best action. The bounds also know the default policy.
    fn values(&self) -> Values {
        let none = f64::NEG_INFINITY;
        let default = Values { lower: self.default, upper: self.default, estimate: none, certified: none };
        let mut best = self.edges.iter().fold(default, |best, edge| best.map(edge.values, f64::max));
        best.estimate = best.estimate.min(best.certified).max(best.lower);
        best
    }
}

/// All nodes of one search; node 0 is the root's.
#[derive(Debug, PartialEq)]
pub(crate) struct Tree<A = Action, B = Belief> {
    pub nodes: Vec<Node<A, B>>,
    /// The root as a child of nobody.
    pub root: Child,
}

impl<A, B> Tree<A, B> {
    /// The child at a place; the root at none.
    pub(crate) fn child(&self, place: Option<Place>) -> &Child {
        place.map_or(&self.root, |Place { node, edge, child }| &self.nodes[node].edges[edge].children[child])
    }

    fn child_mut(&mut self, place: Option<Place>) -> &mut Child {
        match place {
            None => &mut self.root,
            Some(Place { node, edge, child }) => &mut self.nodes[node].edges[edge].children[child],
        }
    }

    /// Put an expanded leaf into the tree, and back its values up to the root.
    pub(crate) fn attach(&mut self, mut node: Node<A, B>) {
        node.edges.iter_mut().for_each(Edge::back_up);
        let (mut place, mut values) = (node.place, node.values());
        let index = self.nodes.len();
        self.child_mut(place).node = Some(index);
        self.nodes.push(node);
        loop {
            self.child_mut(place).values = values;
            let Some(Place { node, edge, .. }) = place else { return };
            let parent = &mut self.nodes[node];
            parent.edges[edge].back_up();
            (place, values) = (parent.place, parent.values());
        }
    }

    /// The leaf that a trial leads to: from each node along the action with the highest upper bound and the child with
    /// the largest excess uncertainty, that is the part of its gap that goes beyond its share of `target`.
    pub(crate) fn explore(&self, target: f64) -> Option<Place> {
        let (mut place, mut child, mut scale) = (None, &self.root, 1.0);
        while let Some(index) = child.node {
            let node = &self.nodes[index];
            let edge = first_best(&node.edges, |edge| edge.values.upper);
            scale *= node.edges[edge].discount;
            let excess = |child: &Child| child.probability * (scale * child.values.gap() - target);
            let number = first_best(&node.edges[edge].children, excess);
            place = Some(Place { node: index, edge, child: number });
            child = &node.edges[edge].children[number];
        }
        place
    }
}

/// Index of the item with the highest score, the first among equals.
pub(crate) fn first_best<T>(items: &[T], score: impl Fn(&T) -> f64) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (index, item) in items.iter().enumerate() {
        let score = score(item);
        if score > best.1 {
            best = (index, score);
        }
    }
    best.0
}
