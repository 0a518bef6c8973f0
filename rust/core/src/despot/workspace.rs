//! The memory of a search, handed from plan to plan.

use std::ops::{Deref, DerefMut};
use std::sync::{Arc, Mutex, PoisonError};

use super::Despot;
use super::branch::Scan;
use super::expand::{Expansion, Scratch};
use super::objects::Objects;
use crate::belief::Belief;
use crate::model::{Action, SortingModel};
use crate::scenario::{LabelPlanes, LookPoint};
use crate::tree::{Child, Node, Object, Place, Tree, id, seen};

/// Nodes that are kept for the next plan at most: an occasional long search would hold its memory for ever.
const MOST_KEPT: usize = 100_000;

/// Everything that a search writes to. Its content never outlives a plan, its memory does.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    pub tree: Tree,
    pub labels: LabelPlanes,
    pub objects: Objects,
    /// The belief at the root, one distribution per position.
    pub root: Vec<f64>,
    /// The leaves of a batch.
    pub expansions: Vec<Expansion>,
    /// One per task.
    pub scratch: Vec<Scratch>,
    /// The looks of a batch.
    points: Vec<LookPoint>,
    /// Nodes to be used again.
    spare: Vec<Node>,
}

impl Workspace {
    /// Forget the last search and start from a root.
    pub(super) fn restart(
        &mut self,
        Despot { model, default_policy, randoms, .. }: &Despot,
        (belief, viewpoint): (&Belief, usize),
        root: Child,
    ) {
        self.root = belief.as_slice().to_vec();
        self.labels.restart(model, randoms, belief.as_slice());
        self.objects.restart(model, default_policy, belief);
        self.spare.extend(self.tree.nodes.drain(..).rev());
        (self.tree.root, self.tree.viewpoint) = (root, viewpoint);
        self.tree.remaining = belief.horizon();
    }

    /// Choose a leaf for an expansion; until it is attached the leaf counts as settled.
    pub(super) fn choose(&mut self, model: &SortingModel, leaf: Option<Place>) {
        let mut node = self.spare.pop().unwrap_or_default();
        node.restart(&self.tree, leaf);
        node.objects.clear();
        if let Some(Place { node: parent, edge, .. }) = leaf {
            let parent = &self.tree.nodes[parent as usize];
            node.objects.extend(&parent.objects);
            let action = parent.edges[edge as usize].action;
            self.follow(model, (parent, action), node.labels, &mut node.objects);
        } else {
            node.objects.extend(self.objects.at_root());
        }
        self.expansions.push(Expansion { node, values: self.tree.child(leaf).values });
        self.tree.settle(leaf);
    }

    /// The objects after an action at a node, given the code of the labels that it has brought.
    pub(super) fn follow(
        &self,
        model: &SortingModel,
        (node, action): (&Node, Action),
        labels: u64,
        objects: &mut Vec<Object>,
    ) {
        if let Action::Decide(_) = action {
            self.objects.shift(objects, node.remaining);
        }
        if let Some(scan) = Scan::of(model, node, action) {
            for ((j, z), object) in seen(model, labels).enumerate().zip(objects) {
                *object = self.objects.after(*object, (j, scan.viewpoint), z);
            }
        }
    }

    /// Have all that the expansions of the chosen leaves share.
    pub(super) fn prepare(&mut self, Despot { model, default_policy, randoms, .. }: &Despot, parallel: bool) {
        let depths = self.expansions.iter().map(|expansion| expansion.node.depth);
        randoms.reach(depths.max().unwrap_or(0), parallel);
        let (first, mut objects) = (self.objects.count(), Vec::new());
        let mut points = std::mem::take(&mut self.points);
        for Expansion { node, .. } in &self.expansions {
            let moves = model.legal_moves(node.viewpoint).iter().map(|to| Action::Move(*to));
            for action in moves.chain([Action::Decide(0)]) {
                let Some(scan) = Scan::of(model, node, action) else { continue };
                objects.clone_from(&node.objects);
                if let Action::Decide(_) = action {
                    self.objects.shift(&mut objects, node.remaining);
                }
                self.objects.require(model, &objects, scan.viewpoint);
                points.extend(objects.iter().enumerate().map(|(position, object)| {
                    scan.look(self.objects.sighting(*object, position, scan.viewpoint))
                }));
            }
        }
        self.objects.work_out(model, default_policy, first, parallel);
        self.labels.require(model, randoms, points.drain(..), parallel);
        self.points = points;
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
