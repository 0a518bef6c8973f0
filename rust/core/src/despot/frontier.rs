//! The tree of a search, and the leaves at which it grows.

use super::Despot;
use super::expand::Expansion;
use super::sightings::{act, at_root};
use crate::index::Viewpoint;
use crate::model::Action;
use crate::planes;
use crate::remaining::Remaining;
use crate::tree::{Child, Node, Place, Tree, id, indices};

/// `xi` of the DESPOT paper: the part of the root's gap that one trial tries to leave.
const TARGET_GAP: f64 = 0.95;

/// Tolerance of the search: it ends once the root's bounds are closer than this, in units of `r_max`.
const GAP_TOLERANCE: f64 = 1e-10;

/// What a search has done.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    /// Leaves expanded, the root left out.
    pub trials: u64,
    /// (scenario, move) pairs simulated at expanded nodes.
    pub scenario_steps: u64,
    /// Beliefs created.
    pub nodes: u64,
}

/// The tree and its leaves on their way to become nodes.
#[derive(Debug, Default)]
pub(crate) struct Frontier {
    pub tree: Tree,
    /// Leaves chosen by trials, to be expanded.
    pub chosen: Vec<Expansion>,
    /// Expanded leaves that wait to be attached to the tree, in the order of their choice.
    pub expanded: Vec<Expansion>,
    pub tally: Tally,
    /// Nodes to be used again.
    spare: Vec<Node>,
}

impl Frontier {
    /// Forget the last tree.
    pub(super) fn restart(&mut self, root: Child, viewpoint: Viewpoint, remaining: Remaining) {
        self.spare.extend(self.tree.nodes.drain(..).rev());
        (self.tree.root, self.tree.viewpoint, self.tree.remaining) = (root, viewpoint, remaining);
        self.tally = Tally { nodes: 1, ..Tally::default() };
    }

    /// Nodes whose memory is kept.
    pub(super) fn size(&self) -> usize {
        self.tree.nodes.len() + self.spare.len()
    }

    /// The leaf that a decision at the root leads to, unless a scan or the end follows.
    pub(super) fn after_decision(&self) -> Option<Place> {
        let root = &self.tree.nodes[0];
        let (edge, decision) =
            (0..).zip(&root.edges).find(|(_, edge)| matches!(edge.action, Action::Decide(_)))?;
        let [leaf] = &root.children[indices(&decision.children)] else { return None };
        (leaf.values.gap() > 0.0).then_some(Place { node: 0, edge, child: decision.children.start })
    }

    /// Choose the leaves of so many trials, or of fewer if nothing else is worth one.
    pub(super) fn choose_leaves(&mut self, despot: &Despot, trials: usize) {
        if self.tree.root.values.gap() < GAP_TOLERANCE * despot.model.spec().r_max {
            return;
        }
        for _ in 0..trials {
            let leaf = self.explore();
            if self.tree.child(leaf).values.gap() <= 0.0 {
                return;
            }
            self.choose(despot, leaf);
        }
    }

    /// Choose a leaf; until it is attached it counts as settled, so that others are chosen elsewhere.
    pub(super) fn choose(&mut self, despot: &Despot, leaf: Option<Place>) {
        let mut node = self.spare.pop().unwrap_or_default();
        node.restart(&self.tree, leaf);
        let mut scan = None;
        if let Some(Place { node: parent, edge, .. }) = leaf {
            let parent = &self.tree.nodes[parent as usize];
            let action = parent.edges[edge as usize].action;
            node.scenarios.extend(&parent.scenarios);
            node.objects.extend(&parent.objects);
            scan = act(&despot.model, (parent, action), &mut node.objects);
        } else {
            node.scenarios.extend(planes::first(despot.config.scenarios));
            node.objects.extend(at_root(&despot.model, self.tree.remaining));
        }
        self.chosen.push(Expansion { node, scan, values: self.tree.child(leaf).values });
        self.tree.apply_virtual_loss(leaf);
    }

    /// One trial: follow the most promising action and the most uncertain label down to a leaf.
    fn explore(&self) -> Option<Place> {
        let tree = &self.tree;
        let (mut place, mut child) = (None, &tree.root);
        while let Some(node) = child.node {
            let from = &tree.nodes[node as usize];
            let edge = from.most_promising_edge();
            let next = self.most_uncertain(&from.children, indices(&from.edges[edge].children));
            place = Some(Place { node, edge: id(edge), child: id(next) });
            child = &from.children[next];
        }
        place
    }

    /// The child with the largest excess uncertainty: its gap beyond its share of the root's target gap.
    fn most_uncertain(&self, children: &[Child], among: std::ops::Range<usize>) -> usize {
        let target = TARGET_GAP * self.tree.root.values.gap();
        let mut best = (among.start, f64::NEG_INFINITY);
        for (index, child) in (among.start..).zip(&children[among]) {
            let excess = child.values.gap() - child.probability * target;
            if excess > best.1 {
                best = (index, excess);
            }
        }
        best.0
    }

    /// Put the expansions for which there was time into the tree, in the order in which they were chosen.
    pub(super) fn attach(&mut self, despot: &Despot) {
        for expansion in self.expanded.drain(..) {
            let place = expansion.node.place;
            self.tree.revise(place, expansion.values);
            if expansion.done() {
                let moves = despot.model.legal_moves(expansion.node.viewpoint).len() as u64;
                self.tally.trials += u64::from(place.is_some());
                self.tally.nodes += expansion.node.children.len() as u64;
                self.tally.scenario_steps += moves * planes::count(&expansion.node.scenarios);
                self.tree.child_mut(place).node = Some(id(self.tree.nodes.len()));
                self.tree.nodes.push(expansion.node);
            } else {
                self.spare.push(expansion.node);
            }
        }
        self.tree.back_up();
    }
}
