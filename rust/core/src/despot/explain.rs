//! The searched tree as plain data: why an action was chosen.

use super::plan::Plan;
use super::sightings::{act, at_root};
use super::workspace::Workspace;
use crate::index::{Label, Viewpoint};
use crate::model::{Action, SortingModel};
use crate::planes;
use crate::tree::{Child, Edge, Node, Object, Values, indices, seen};

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

impl Plan {
    /// The searched tree down to `depth` planner steps below the root.
    #[must_use]
    pub fn tree(&self, depth: usize) -> TreeNode {
        let view = View { model: &self.model, space: &self.space };
        let tree = &self.space.frontier.tree;
        let objects: Vec<_> = at_root(&self.model, tree.remaining).collect();
        view.node((&tree.root, 0, tree.viewpoint), &objects, depth)
    }
}

struct View<'a> {
    model: &'a SortingModel,
    space: &'a Workspace,
}

impl View<'_> {
    /// A child at a depth, with the viewpoint.
    fn node(
        &self,
        (child, at, viewpoint): (&Child, usize, Viewpoint),
        objects: &[Object],
        depth: usize,
    ) -> TreeNode {
        let node = child.node.map(|node| &self.space.frontier.tree.nodes[node as usize]);
        let Values { lower, upper, estimate, .. } = self.unscaled(at, child.probability, child.values);
        let shown = node.filter(|_| depth > 0);
        let actions = shown.map_or_else(Vec::new, |node| self.actions(node, objects, depth));
        TreeNode {
            viewpoint,
            value: estimate,
            lower,
            upper,
            scenarios: node.map(|node| planes::count(&node.scenarios)),
            actions,
            belief: objects
                .iter()
                .map(|object| self.space.knowledge.objects().distribution(*object).to_vec())
                .collect(),
        }
    }

    fn actions(&self, node: &Node, objects: &[Object], depth: usize) -> Vec<TreeAction> {
        node.edges.iter().map(|edge| self.action(node, objects, edge, depth)).collect()
    }

    fn action(&self, from: &Node, objects: &[Object], edge: &Edge, depth: usize) -> TreeAction {
        let Values { lower, upper, estimate, .. } = self.unscaled(from.depth, from.probability, edge.values);
        let children = &from.children[indices(&edge.children)];
        let mut branches: Vec<_> =
            children.iter().map(|child| self.branch(from, objects, edge.action, child, depth)).collect();
        branches.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        TreeAction { action: edge.action, value: estimate, lower, upper, branches }
    }

    fn branch(
        &self,
        from: &Node,
        objects: &[Object],
        action: Action,
        child: &Child,
        depth: usize,
    ) -> TreeBranch {
        let mut objects = objects.to_vec();
        let (below, _, viewpoint) = from.after(action);
        let scan = act(self.model, (from, action), &mut objects);
        if let Some(scan) = &scan {
            self.space.knowledge.sightings.see(self.model, scan, child.labels, &mut objects);
        }
        TreeBranch {
            probability: child.probability / from.probability,
            labels: scan.map(|_| seen(self.model, child.labels).collect()),
            node: self.node((child, below, viewpoint), &objects, depth - 1),
        }
    }

    /// Values as seen from a belief at a depth that is reached with a probability.
    fn unscaled(&self, depth: usize, probability: f64, values: Values) -> Values {
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)] // a depth is at most 1000
        let scale = probability * self.model.discount().powi(depth as i32);
        let Values { lower, upper, estimate, certified } = values;
        Values {
            lower: lower / scale,
            upper: upper / scale,
            estimate: estimate / scale,
            certified: certified / scale,
        }
    }
}
