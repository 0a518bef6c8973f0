//! The memory of a search, handed from plan to plan.

use std::ops::{Deref, DerefMut};
use std::sync::{Arc, Mutex, PoisonError};

use super::branch::Scan;
use super::expand::{Expansion, Scratch};
use crate::belief::{Belief, Memory};
use crate::model::{Action, SortingModel};
use crate::scenario::{LabelPlanes, LookPoint, Randoms};
use crate::tree::{Child, Node, Place, Tree, id, seen};

/// Nodes that are kept for the next plan at most: an occasional long search would hold its memory for ever.
const MOST_KEPT: usize = 100_000;

/// Everything that a search writes to. Its content never outlives a plan, its memory does.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    pub tree: Tree,
    pub labels: LabelPlanes,
    /// What is known at the root: belief, one distribution per position, and last labels.
    pub root: (Vec<f64>, Memory),
    /// The leaves of a batch.
    pub expansions: Vec<Expansion>,
    /// One per task.
    pub scratch: Vec<Scratch>,
    /// Nodes to be used again.
    spare: Vec<Node>,
}

impl Workspace {
    /// Forget the last search and start from a root.
    pub(super) fn restart(
        &mut self,
        model: &SortingModel,
        randoms: &Randoms,
        (belief, viewpoint): (&Belief, usize),
        root: Child,
    ) {
        self.root = (belief.as_slice().to_vec(), belief.memory().clone());
        self.labels.restart(model, randoms, belief.as_slice());
        self.spare.extend(self.tree.nodes.drain(..).rev());
        (self.tree.root, self.tree.viewpoint) = (root, viewpoint);
    }

    /// Choose a leaf for an expansion; until it is attached the leaf counts as settled.
    pub(super) fn choose(&mut self, leaf: Option<Place>) {
        let mut node = self.spare.pop().unwrap_or_default();
        node.restart(&self.tree, leaf);
        self.expansions.push(Expansion { node, values: self.tree.child(leaf).values });
        self.tree.settle(leaf);
    }

    /// Have the label planes that the chosen leaves need.
    pub(super) fn require_labels(&mut self, model: &SortingModel, randoms: &Randoms, parallel: bool) {
        let mut labels = std::mem::take(&mut self.labels);
        let leaves = self.expansions.iter().map(|expansion| &expansion.node);
        randoms.reach(leaves.clone().map(|node| node.depth).max().unwrap_or(0), parallel);
        labels.require(model, randoms, leaves.flat_map(|node| self.looks_at(model, node)), parallel);
        self.labels = labels;
    }

    /// The looks that any action at a leaf brings.
    fn looks_at(&self, model: &SortingModel, node: &Node) -> impl Iterator<Item = LookPoint> {
        let memory = self.memory_at(model, node);
        let moves = model.legal_moves(node.viewpoint).iter().map(|to| Action::Move(*to));
        let scans = moves.chain([Action::Decide(0)]).filter_map(|action| Scan::of(model, node, action));
        scans.flat_map(move |scan| {
            let decided = scan.decisions > node.decisions;
            let memory = if decided { Memory::default() } else { memory.clone() };
            (0..model.position_count()).map(move |position| scan.look(model, &memory, position))
        })
    }

    /// The last labels at a leaf.
    fn memory_at(&self, model: &SortingModel, leaf: &Node) -> Memory {
        let Some(Place { node, edge, .. }) = leaf.place else { return self.root.1.clone() };
        let parent = &self.tree.nodes[node as usize];
        let action = parent.edges[edge as usize].action;
        let mut memory = parent.memory.clone();
        if let Action::Decide(_) = action {
            memory.clear();
        }
        if Scan::of(model, parent, action).is_some() {
            for (position, label) in seen(model, leaf.labels).enumerate() {
                memory.remember(model, position, leaf.viewpoint, label);
            }
        }
        memory
    }

    /// Put the expansions for which there was time into the tree, in the order in which they were chosen.
    pub(super) fn attach(&mut self) {
        for expansion in self.expansions.drain(..) {
            let place = expansion.node.place;
            self.tree.revise(place, expansion.values);
            if expansion.done() {
                self.tree.child_mut(place).node = Some(id(self.tree.nodes.len()));
                self.tree.nodes.push(expansion.node);
            } else {
                self.spare.push(expansion.node);
            }
        }
        self.tree.back_up();
    }
}

/// Workspaces that no search uses at the moment.
#[derive(Debug, Clone, Default)]
pub(super) struct Pool(Arc<Mutex<Vec<Workspace>>>);

impl Pool {
    pub(super) fn lease(&self) -> Lease {
        let space = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        Lease { space: space.unwrap_or_default(), pool: self.clone() }
    }
}

/// A workspace that returns to its pool.
#[derive(Debug)]
pub(super) struct Lease {
    space: Workspace,
    pool: Pool,
}

impl Deref for Lease {
    type Target = Workspace;

    fn deref(&self) -> &Workspace {
        &self.space
    }
}

impl DerefMut for Lease {
    fn deref_mut(&mut self) -> &mut Workspace {
        &mut self.space
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        let space = std::mem::take(&mut self.space);
        if space.tree.nodes.len() + space.spare.len() <= MOST_KEPT {
            self.pool.0.lock().unwrap_or_else(PoisonError::into_inner).push(space);
        }
    }
}
