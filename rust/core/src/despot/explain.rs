//! The searched tree as plain data: why an action was chosen.

use super::branch::Scan;
use super::follow;
use super::plan::Plan;
use super::workspace::Workspace;
use crate::belief::Memory;
use crate::model::{Action, SortingModel};
use crate::planes;
use crate::tree::{Edge, Values, indices};

/// A belief of the tree. Values are in the unit of the rewards, as seen from this belief.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeNode {
    /// Where the camera stands.
    pub viewpoint: usize,
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
    pub labels: Option<Vec<usize>>,
    /// The belief after it.
    pub node: TreeNode,
}

impl Plan {
    /// The searched tree down to `depth` planner steps below the root.
    #[must_use]
    pub fn tree(&self, depth: usize) -> TreeNode {
        let view = View { model: &self.model, space: &self.space };
        view.node(0, &self.space.root, depth)
    }
}

/// Belief and last labels.
type Known = (Vec<f64>, Memory);

struct View<'a> {
    model: &'a SortingModel,
    space: &'a Workspace,
}

impl View<'_> {
    fn node(&self, index: usize, known: &Known, depth: usize) -> TreeNode {
        let tree = &self.space.tree;
        let (node, expanded) = (&tree.nodes[index], !tree.nodes[index].edges.is_empty());
        let Values { lower, upper, estimate } = self.unscaled(index, tree.values[index]);
        let edges = if depth > 0 { tree.edges_of(index) } else { &[] };
        TreeNode {
            viewpoint: node.viewpoint,
            value: estimate,
            lower,
            upper,
            scenarios: expanded.then(|| planes::count(self.space.expanded(node.expansion).2)),
            actions: edges.iter().map(|edge| self.action(index, known, edge, depth)).collect(),
            belief: known.0.chunks_exact(self.model.class_count()).map(<[f64]>::to_vec).collect(),
        }
    }

    fn action(&self, from: usize, known: &Known, edge: &Edge, depth: usize) -> TreeAction {
        let Values { lower, upper, estimate } = self.unscaled(from, edge.values);
        let mut branches: Vec<_> = indices(&edge.children)
            .map(|child| self.branch(from, known, edge.action, child, depth))
            .collect();
        branches.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        TreeAction { action: edge.action, value: estimate, lower, upper, branches }
    }

    fn branch(&self, from: usize, known: &Known, action: Action, child: usize, depth: usize) -> TreeBranch {
        let nodes = &self.space.tree.nodes;
        let (mut belief, mut memory) = known.clone();
        follow(self.model, &mut belief, &mut memory, action, &nodes[child]);
        let scan = Scan::of(self.model, &nodes[from], action);
        TreeBranch {
            probability: nodes[child].probability / nodes[from].probability,
            labels: scan.map(|_| nodes[child].seen(self.model).collect()),
            node: self.node(child, &(belief, memory), depth - 1),
        }
    }

    /// Values as seen from a node.
    fn unscaled(&self, node: usize, values: Values) -> Values {
        let node = &self.space.tree.nodes[node];
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)] // a depth is at most 1000
        let scale = node.probability * self.model.discount().powi(node.depth as i32);
        Values { lower: values.lower / scale, upper: values.upper / scale, estimate: values.estimate / scale }
    }
}
