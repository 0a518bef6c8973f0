//! Belief nodes and their actions, as the arena stores them.

use crate::index::Viewpoint;
use crate::model::Action;

/// A belief node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NodeId(pub u32);

/// A belief node's action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct EdgeId(pub u32);

/// `b_0`, or the leaf that a branch grows from.
pub(super) const ROOT: NodeId = NodeId(0);

/// The edge into the root: it says where the root is, and is no action of any node.
pub(super) const ENTRY: EdgeId = EdgeId(0);

/// Scenarios of one word of a plane; only words with any are kept.
pub(super) type Word = (u32, u64);

/// Values of a node or an edge, weighted by its share of the scenarios and discounted down to it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Values {
    /// `l`: lower bound of the regularised value.
    pub lower: f64,
    /// `mu`: upper bound of the regularised value.
    pub upper: f64,
    /// `U`: upper bound of the value without regularisation.
    pub utility: f64,
}

impl Values {
    pub(super) fn all(value: f64) -> Self {
        Self { lower: value, upper: value, utility: value }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            lower: self.lower + other.lower,
            upper: self.upper + other.upper,
            utility: self.utility + other.utility,
        }
    }

    pub(super) fn max(self, other: Self) -> Self {
        Self {
            lower: self.lower.max(other.lower),
            upper: self.upper.max(other.upper),
            utility: self.utility.max(other.utility),
        }
    }
}

/// What a history of actions has led to, whatever was seen.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Place {
    /// `Delta(b)`: planner steps since the root.
    pub depth: usize,
    /// Decisions since the root.
    pub decisions: usize,
    /// Where the camera stands.
    pub viewpoint: Viewpoint,
    /// Whether no label from any viewpoint can repeat one already seen at the belt end.
    pub fresh: bool,
    /// Whether a scan has led here.
    pub scanned: bool,
}

/// `b` of the paper: a history of actions and labels. One cache line, since most of what a search touches are nodes
/// that it never expands; what siblings share is in their [`Edge`].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Node {
    /// The action that has led here; of the root and of nothing else [`ENTRY`].
    pub parent: EdgeId,
    /// `|Phi_b|`: how many scenarios come here.
    pub count: u32,
    /// Which: `Phi_b`, a range of the tree's words.
    pub scenarios: (u32, u32),
    /// The actions: the first, and their number; all or none.
    pub actions: (u32, u16),
    /// Whether MAKE-DEFAULT has settled its values.
    pub settled: bool,
    /// The labels of the scan that has led here, as digits in base Z, the belt end's first.
    pub labels: u64,
    /// `l_0`: the default policy's value.
    pub default: f64,
    pub values: Values,
}

impl Node {
    pub(super) fn is_leaf(&self) -> bool {
        self.actions.1 == 0
    }

    pub(super) fn edges(&self) -> impl Iterator<Item = EdgeId> + use<> {
        let (first, count) = self.actions;
        (first..first + u32::from(count)).map(EdgeId)
    }

    pub(super) fn gap(&self) -> f64 {
        self.values.upper - self.values.lower
    }
}

/// An action at a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub from: NodeId,
    pub action: Action,
    /// Weighted and discounted, without the regularisation: `rho(b, a) + lambda`.
    pub reward: f64,
    pub children: (u32, u32),
    /// Where it leads, which is the same for all children.
    pub to: Place,
    pub values: Values,
}

impl Edge {
    pub(super) fn children(&self) -> impl Iterator<Item = NodeId> + use<> {
        (self.children.0..self.children.1).map(NodeId)
    }
}
