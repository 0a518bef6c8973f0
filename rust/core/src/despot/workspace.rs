//! The memory of a search, handed from plan to plan.

use std::ops::{Deref, DerefMut};
use std::sync::{Arc, Mutex, PoisonError};

use super::branch::Scan;
use super::expand::Expansion;
use crate::belief::{Belief, Memory};
use crate::model::{Action, SortingModel};
use crate::planes;
use crate::scenario::{LabelPlanes, LookPoint, Randoms};
use crate::tree::{Node, Tree, Values, id};

/// Nodes of a tree that is not kept for the next plan: an occasional long search would hold its memory for ever.
const MOST_KEPT: usize = 4_000_000;

/// Everything that a search writes to. Its content never outlives a plan, its memory does.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    pub tree: Tree,
    pub labels: LabelPlanes,
    /// What is known at the root: belief, one distribution per position, and last labels.
    pub root: (Vec<f64>, Memory),
    /// Of expanded nodes, one after the other: beliefs, last labels and scenarios.
    beliefs: Vec<f64>,
    memories: Vec<Memory>,
    scenarios: Vec<u64>,
    words: usize,
    /// One per leaf of a batch.
    pub expansions: Vec<Expansion>,
}

impl Workspace {
    /// Forget the last search and start from a root.
    pub(super) fn restart(
        &mut self,
        model: &SortingModel,
        randoms: &Randoms,
        belief: &Belief,
        root: (Node, Values),
    ) {
        self.root = (belief.as_slice().to_vec(), belief.memory().clone());
        self.beliefs.clear();
        self.memories.clear();
        self.scenarios.clear();
        self.words = planes::words(randoms.count());
        self.labels.restart(model, randoms, belief.as_slice());
        self.tree.restart(root);
    }

    /// Belief, last labels and scenarios of an expanded node.
    pub(super) fn expanded(&self, expansion: u32) -> (&[f64], &Memory, &[u64]) {
        let (at, width) = (expansion as usize, self.root.0.len());
        let scenarios = &self.scenarios[at * self.words..][..self.words];
        (&self.beliefs[at * width..][..width], &self.memories[at], scenarios)
    }

    /// Number of expanded nodes.
    pub(super) fn expanded_count(&self) -> usize {
        self.memories.len()
    }

    /// Choose a leaf for an expansion; until it is attached the leaf counts as settled.
    pub(super) fn choose(&mut self, index: usize, leaf: usize) {
        if index == self.expansions.len() {
            self.expansions.push(Expansion::default());
        }
        let values = &mut self.tree.values[leaf];
        let expansion = &mut self.expansions[index];
        (expansion.leaf, expansion.values, expansion.done) = (leaf, *values, false);
        values.upper = values.lower;
        self.tree.back_up(leaf);
    }

    /// Have the label planes that the first expansions need.
    pub(super) fn require_labels(
        &mut self,
        model: &SortingModel,
        randoms: &Randoms,
        expansions: usize,
        parallel: bool,
    ) {
        let mut labels = std::mem::take(&mut self.labels);
        let leaves = self.expansions[..expansions].iter().map(|expansion| &self.tree.nodes[expansion.leaf]);
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
            let fresh = Memory::default();
            let memory = if scan.decisions > node.decisions { &fresh } else { &memory };
            let looks: Vec<_> =
                (0..model.position_count()).map(|position| scan.look(model, memory, position)).collect();
            looks
        })
    }

    /// The last labels at a leaf.
    fn memory_at(&self, model: &SortingModel, node: &Node) -> Memory {
        let Some(edge) = node.parent else { return self.root.1.clone() };
        let edge = &self.tree.edges[edge as usize];
        let (_, before, _) = self.expanded(self.tree.nodes[edge.node as usize].expansion);
        let mut memory = before.clone();
        if let Action::Decide(_) = edge.action {
            memory.clear();
        }
        if Scan::of(model, node, edge.action).is_some() {
            for (position, label) in node.seen(model).enumerate() {
                memory.remember(model, position, node.viewpoint, label);
            }
        }
        memory
    }

    /// Put an expansion into the tree, if there was time for it; the number of its leaf's scenarios.
    pub(super) fn attach(&mut self, index: usize) -> Option<u64> {
        let expansion = &mut self.expansions[index];
        let leaf = expansion.leaf;
        self.tree.values[leaf] = expansion.values;
        if !expansion.done {
            self.tree.back_up(leaf);
            return None;
        }
        let number = id(self.memories.len());
        self.beliefs.extend(&expansion.belief);
        self.memories.push(expansion.memory.clone());
        self.scenarios.extend(&expansion.scenarios);
        self.tree.attach(leaf, number, &mut expansion.edges, &mut expansion.children);
        self.tree.back_up(leaf);
        Some(planes::count(&self.expansions[index].scenarios))
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
        if space.tree.nodes.capacity() <= MOST_KEPT {
            self.pool.0.lock().unwrap_or_else(PoisonError::into_inner).push(space);
        }
    }
}
