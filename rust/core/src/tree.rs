//! The arena the search lives in.
//!
//! Values are *scaled*: multiplied by the probability of reaching their belief and the discount down to it, so that
//! a belief's value is the plain sum of what lies below it. Most beliefs are leaves; a leaf is a [`Child`] of its
//! parent and nothing else. A [`Node`] is a belief that is expanded; it owns its children.

use std::ops::Range;

use crate::index::{Label, Viewpoint};
use crate::model::{Action, SortingModel};
use crate::remaining::Remaining;

/// Scaled values of a belief or an edge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Values {
    /// Lower bound of the regularised value, `l` of the DESPOT paper.
    pub lower: f64,
    /// Upper bound of the same, `mu` of the DESPOT paper.
    pub upper: f64,
    /// Best guess of V*: on average no larger after a backup than before.
    pub estimate: f64,
    /// Upper bound of V*. In a large tree `upper` is none: there labels without a scenario follow the default policy.
    pub certified: f64,
}

impl Values {
    /// A value that is known.
    pub(crate) fn all(value: f64) -> Self {
        Self { lower: value, upper: value, estimate: value, certified: value }
    }

    /// How far the bounds are apart.
    pub(crate) fn gap(self) -> f64 {
        self.upper - self.lower
    }

    fn add(&mut self, other: Self) {
        self.lower += other.lower;
        self.upper += other.upper;
        self.estimate += other.estimate;
        self.certified += other.certified;
    }

    fn raise(&mut self, other: Self) {
        self.lower = self.lower.max(other.lower);
        self.upper = self.upper.max(other.upper);
        self.estimate = self.estimate.max(other.estimate);
        self.certified = self.certified.max(other.certified);
    }
}

/// A belief as its parent sees it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Child {
    /// A leaf's lower bound is the default policy's value.
    pub values: Values,
    /// Probability of the labels on the way here, given the actions.
    pub probability: f64,
    /// The labels that lead here from the parent, as digits in base L, the belt end's last; 0 where there is no scan.
    pub labels: u64,
    /// Its node, once it is expanded.
    pub node: Option<u32>,
}

/// Labels from their code, the belt end's first.
#[inline(always)]
pub(crate) fn seen(model: &SortingModel, mut code: u64) -> impl Iterator<Item = Label> + use<> {
    let base = model.class_count() as u64;
    (0..model.position_count()).map(move |_| {
        let digit = code % base;
        code /= base;
        // A digit is below L, which is a usize.
        #[allow(clippy::cast_possible_truncation)]
        let label = Label(digit as usize);
        label
    })
}

/// An action at a node.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Edge {
    /// The action.
    pub action: Action,
    /// Reward, less the regularisation, plus the values of labels that no scenario gives.
    pub fixed: Values,
    /// Values with what lies below.
    pub values: Values,
    /// Of the node's children: one per label vector that some scenario gives.
    pub children: Range<u32>,
    /// Whether a child's values have changed since.
    stale: bool,
}

/// What is known about one object: a label of a look, each by its number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Object {
    pub look: u32,
    pub label: u32,
}

/// Where in the tree a child is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    pub node: u32,
    pub edge: u32,
    pub child: u32,
}

/// A belief that is expanded.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Node {
    /// The child that it is; `None` at the root.
    pub place: Option<Place>,
    /// Planner steps since the root.
    pub depth: usize,
    /// Decisions since the root.
    pub decisions: usize,
    /// Where the camera stands.
    pub viewpoint: Viewpoint,
    /// Objects left to decide.
    pub remaining: Remaining,
    /// As its child's.
    pub probability: f64,
    /// As its child's.
    pub labels: u64,
    /// Scaled value of the default policy, `l_0` of the DESPOT paper.
    pub default: f64,
    /// The objects at the positions, the belt end's first: the exact belief.
    pub objects: Vec<Object>,
    /// Plane of the scenarios that come here.
    pub scenarios: Vec<u64>,
    /// The actions.
    pub edges: Vec<Edge>,
    /// Each edge has a range of them.
    pub children: Vec<Child>,
}

impl Node {
    /// Become the root's or a leaf's node, not expanded yet; the memory is kept.
    pub(crate) fn restart(&mut self, tree: &Tree, place: Option<Place>) {
        let child = tree.child(place);
        (self.depth, self.decisions, self.viewpoint) = (0, 0, tree.viewpoint);
        if let Some(Place { node, edge, .. }) = place {
            let parent = &tree.nodes[node as usize];
            (self.depth, self.decisions, self.viewpoint) = parent.after(parent.edges[edge as usize].action);
        }
        self.remaining = tree.remaining.after(self.decisions);
        (self.place, self.labels) = (place, child.labels);
        (self.probability, self.default) = (child.probability, child.values.lower);
        self.objects.clear();
        self.scenarios.clear();
        self.edges.clear();
        self.children.clear();
    }

    /// Depth, decisions and viewpoint after an action.
    pub(crate) fn after(&self, action: Action) -> (usize, usize, Viewpoint) {
        match action {
            Action::Move(viewpoint) => (self.depth + 1, self.decisions, viewpoint),
            Action::Decide(_) => (self.depth + 1, self.decisions + 1, self.viewpoint),
        }
    }

    /// Add an action; its children are those from `first` on.
    pub(crate) fn push_edge(&mut self, action: Action, fixed: Values, first: usize) {
        let children = id(first)..id(self.children.len());
        self.edges.push(Edge { action, fixed, values: fixed, children, stale: false });
        self.back_up_edge(self.edges.len() - 1);
    }

    /// Values of an edge from those of its children.
    fn back_up_edge(&mut self, edge: usize) {
        let edge = &mut self.edges[edge];
        (edge.values, edge.stale) = (edge.fixed, false);
        for child in &self.children[indices(&edge.children)] {
            edge.values.add(child.values);
        }
    }

    /// Bellman's equation: the best action; the bounds also know the default policy.
    pub(crate) fn best_values(&self) -> Values {
        let (default, none) = (self.default, f64::NEG_INFINITY);
        let mut best = Values { lower: default, upper: default, estimate: none, certified: none };
        for edge in &self.edges {
            best.raise(edge.values);
        }
        best.estimate = best.estimate.min(best.certified).max(best.lower);
        best
    }

    /// The action with the highest upper bound, the first among equals.
    pub(crate) fn most_promising_edge(&self) -> usize {
        let better = |best: usize, edge: usize| {
            if self.edges[edge].values.upper > self.edges[best].values.upper { edge } else { best }
        };
        (1..self.edges.len()).fold(0, better)
    }
}

/// All nodes of one search; node 0 is the root's.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Tree {
    pub nodes: Vec<Node>,
    /// The root as a child of nobody.
    pub root: Child,
    /// Where the camera stands at the root.
    pub viewpoint: Viewpoint,
    /// Objects left to decide at the root.
    pub remaining: Remaining,
    /// Edges to back up, by node and number.
    stale: Vec<(u32, u32)>,
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
    /// The child at a place.
    pub(crate) fn child(&self, place: Option<Place>) -> &Child {
        match place {
            None => &self.root,
            Some(Place { node, child, .. }) => &self.nodes[node as usize].children[child as usize],
        }
    }

    pub(crate) fn child_mut(&mut self, place: Option<Place>) -> &mut Child {
        match place {
            None => &mut self.root,
            Some(Place { node, child, .. }) => &mut self.nodes[node as usize].children[child as usize],
        }
    }

    /// Virtual loss: until a chosen leaf has been expanded, its upper bound counts as low as its lower bound, so that
    /// the other trials of a batch choose other leaves.
    pub(crate) fn apply_virtual_loss(&mut self, mut place: Option<Place>) {
        let mut upper = self.child(place).values.lower;
        loop {
            let values = &mut self.child_mut(place).values;
            let lost = values.upper - upper;
            values.upper = upper;
            let Some(Place { node, edge, .. }) = place.filter(|_| lost > 0.0) else { return };
            let node = &mut self.nodes[node as usize];
            let values = &mut node.edges[edge as usize].values;
            values.upper = (values.upper - lost).max(values.lower);
            upper = node.edges.iter().fold(node.default, |upper, edge| upper.max(edge.values.upper));
            place = node.place;
        }
    }

    /// Give a child values that its ancestors do not know yet.
    pub(crate) fn revise(&mut self, place: Option<Place>, values: Values) {
        self.child_mut(place).values = values;
        let mut above = place;
        while let Some(Place { node, edge, .. }) = above {
            let parent = &mut self.nodes[node as usize];
            if std::mem::replace(&mut parent.edges[edge as usize].stale, true) {
                return;
            }
            self.stale.push((node, edge));
            above = parent.place;
        }
    }

    /// Bounds and estimates of all that lies above revised children. A node's number is above its parent's.
    pub(crate) fn back_up(&mut self) {
        self.stale.sort_unstable();
        while let Some((index, edge)) = self.stale.pop() {
            let node = &mut self.nodes[index as usize];
            node.back_up_edge(edge as usize);
            if self.stale.last().is_none_or(|(next, _)| *next != index) {
                let (place, values) = (node.place, node.best_values());
                self.child_mut(place).values = values;
            }
        }
    }
}
