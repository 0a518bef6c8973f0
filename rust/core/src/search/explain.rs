//! The searched tree as plain data: why an action was chosen.

use std::sync::Arc;

use super::expand::after;
use super::tree::{Child, Edge, Node, Tree, Values};
use crate::belief::Belief;
use crate::index::{Label, Viewpoint};
use crate::model::{Action, SortingModel};
use crate::planes;

/// A belief of the tree. Values are in the unit of the rewards, as seen from this belief.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeNode {
    /// Where the camera stands.
    pub viewpoint: Viewpoint,
    /// Exact belief, one distribution per position.
    pub belief: Vec<Vec<f64>>,
    /// Estimated value.
    pub value: f64,
    /// Lower bound of the search's own problem.
    pub lower: f64,
    /// Upper bound of the same.
    pub upper: f64,
    /// Number of scenarios that come here; `None` where the search has not been.
    pub scenarios: Option<u64>,
    /// The actions that the search compared; empty where it has not been, or below the depth asked for.
    pub actions: Vec<TreeAction>,
}

/// An action of the tree.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeAction {
    /// The action.
    pub action: Action,
    /// Estimated value.
    pub value: f64,
    /// Lower bound of the search's own problem.
    pub lower: f64,
    /// Upper bound of the same.
    pub upper: f64,
    /// What may be seen, the likeliest first. Labels that no scenario gives are missing.
    pub branches: Vec<TreeBranch>,
}

/// What an action may lead to.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeBranch {
    /// Its probability.
    pub probability: f64,
    /// The labels seen, one per position; `None` if the action brings no scan.
    pub labels: Option<Vec<Label>>,
    /// The belief after it.
    pub node: TreeNode,
}

/// A searched tree, and where it begins.
#[derive(Debug, PartialEq)]
pub(crate) struct Searched {
    pub(super) model: Arc<SortingModel>,
    pub(super) belief: Belief,
    pub(super) viewpoint: Viewpoint,
    pub(super) tree: Tree,
}

impl Searched {
    /// The searched tree down to `depth` planner steps below the root.
    pub(crate) fn tree(&self, depth: usize) -> TreeNode {
        self.node(&self.tree.root, self.belief.clone(), self.viewpoint, depth)
    }

    fn node(&self, child: &Child, belief: Belief, viewpoint: Viewpoint, depth: usize) -> TreeNode {
        let node = child.node.map(|node| &self.tree.nodes[node]);
        let shown = node.filter(|_| depth > 0);
        let Values { lower, upper, estimate, .. } = child.values;
        TreeNode {
            viewpoint,
            value: estimate,
            lower,
            upper,
            scenarios: node.map(|node| planes::count(&node.scenarios)),
            actions: shown.map_or_else(Vec::new, |node| {
                node.edges.iter().map(|edge| self.action(node, edge, depth)).collect()
            }),
            belief: belief
                .visible()
                .chunks_exact(self.model.kind_count())
                .map(|kinds| self.model.class_probabilities(kinds).collect())
                .collect(),
        }
    }

    fn action(&self, from: &Node, edge: &Edge, depth: usize) -> TreeAction {
        let branch = |(number, child): (usize, &Child)| {
            let labels = edge.labels_of(number);
            let (belief, viewpoint) = after(&self.model, from, edge.action, labels.unwrap_or(&[]));
            TreeBranch {
                probability: child.probability,
                labels: labels.map(<[Label]>::to_vec),
                node: self.node(child, belief, viewpoint, depth - 1),
            }
        };
        let mut branches: Vec<_> = edge.children.iter().enumerate().map(branch).collect();
        branches.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        let Values { lower, upper, estimate, .. } = edge.values;
        TreeAction { action: edge.action, value: estimate, lower, upper, branches }
    }
}
