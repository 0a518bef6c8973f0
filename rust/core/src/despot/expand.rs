//! Expanding a leaf: all its actions, each with its children.

use super::branch::{Brancher, Scan};
use super::shortfall::left_to_learn;
use super::workspace::Workspace;
use super::{Despot, follow};
use crate::belief::{Memory, most_likely, shift};
use crate::bounds;
use crate::model::Action;
use crate::planes;
use crate::tree::{Edge, Node, Values, id};

/// What expanding one leaf made, in buffers that are reused; nothing of it is in the tree yet.
#[derive(Debug, Default)]
pub(super) struct Expansion {
    /// The leaf, and its values before it was chosen.
    pub leaf: usize,
    pub values: Values,
    /// Whether the time sufficed.
    pub done: bool,
    /// What is known at the leaf: its exact belief, one distribution per position, and the last labels.
    pub belief: Vec<f64>,
    pub memory: Memory,
    /// Plane of the scenarios that pass through it.
    pub scenarios: Vec<u64>,
    /// Children of an edge are a range of `children`.
    pub edges: Vec<Edge>,
    pub children: Vec<(Node, Values)>,
    /// What is known once the belt has advanced.
    advanced: (Vec<f64>, Memory),
    brancher: Brancher,
}

impl Expansion {
    /// Expand `self.leaf`, compiled for the CPU at hand.
    pub(super) fn run(&mut self, despot: &Despot, space: &Workspace) {
        pulp::Arch::new().dispatch(Run { expansion: self, despot, space });
        self.done = true;
    }

    #[inline(always)]
    fn expand(&mut self, despot: &Despot, space: &Workspace) {
        self.edges.clear();
        self.children.clear();
        let node = space.tree.nodes[self.leaf].clone();
        self.arrive(despot, space, &node);
        self.decide(despot, space, &node);
        for &to in despot.model.legal_moves(node.viewpoint) {
            self.move_to(despot, space, &node, to);
        }
    }

    /// Belief and scenarios of the leaf, from its parent's.
    #[inline(always)]
    fn arrive(&mut self, despot: &Despot, space: &Workspace, node: &Node) {
        self.belief.clear();
        self.scenarios.clear();
        let Some(edge) = node.parent else {
            self.belief.extend(&space.root.0);
            self.memory.clone_from(&space.root.1);
            self.scenarios.extend(planes::first(despot.config.scenarios));
            return;
        };
        let edge = &space.tree.edges[edge as usize];
        let parent = &space.tree.nodes[edge.node as usize];
        let (belief, memory, scenarios) = space.expanded(parent.expansion);
        self.belief.extend(belief);
        self.memory.clone_from(memory);
        self.scenarios.extend(scenarios);
        if let Some(scan) = Scan::of(&despot.model, parent, edge.action) {
            let before = if matches!(edge.action, Action::Decide(_)) { &Memory::default() } else { memory };
            for (j, z) in node.seen(&despot.model).enumerate() {
                let plane = space.labels.label(scan.look(&despot.model, before, j), z);
                for (word, plane) in self.scenarios.iter_mut().zip(plane) {
                    *word &= plane;
                }
            }
        }
        follow(&despot.model, &mut self.belief, &mut self.memory, edge.action, node);
    }

    /// Decide the most likely label and advance the belt; if a scan follows, see what it gives.
    #[inline(always)]
    fn decide(&mut self, despot: &Despot, space: &Workspace, node: &Node) {
        let model = &despot.model;
        let (label, p_right) = most_likely(&self.belief[..model.class_count()]);
        let action = Action::Decide(label);
        let (belief, memory) = &mut self.advanced;
        belief.clone_from(&self.belief);
        memory.clone_from(&self.memory);
        shift(model, belief, memory);
        let reward = model.decision_reward(p_right);
        let first = self.children.len();
        let fixed = if let Some(scan) = Scan::of(model, node, action) {
            self.brancher.take(despot, belief, memory, &scan);
            self.brancher.branch(despot, space, (node, &scan, memory, &self.scenarios), &mut self.children);
            self.brancher.fixed(despot, node, reward + scan.bonus(model, belief, memory))
        } else {
            let below =
                Node { depth: node.depth + 1, decisions: node.decisions + 1, labels: 0, ..node.clone() };
            let value = bounds::lower(model, &despot.default_policy, belief, node.viewpoint);
            let upper = bounds::upper(model, belief, node.viewpoint);
            self.children.push(despot.leaf(below, value, left_to_learn(model, belief), upper));
            Values::all(despot.scale(node) * reward - despot.config.regularization)
        };
        self.edge(action, fixed, first);
    }

    /// Move and scan.
    #[inline(always)]
    fn move_to(&mut self, despot: &Despot, space: &Workspace, node: &Node, to: usize) {
        let model = &despot.model;
        let scan = Scan { depth: node.depth, decisions: node.decisions, viewpoint: to };
        let reward = scan.bonus(model, &self.belief, &self.memory) - model.motion_cost(node.viewpoint, to);
        let first = self.children.len();
        self.brancher.take(despot, &self.belief, &self.memory, &scan);
        self.brancher.branch(despot, space, (node, &scan, &self.memory, &self.scenarios), &mut self.children);
        let fixed = self.brancher.fixed(despot, node, reward);
        self.edge(Action::Move(to), fixed, first);
    }

    fn edge(&mut self, action: Action, fixed: Values, first: usize) {
        let children = id(first)..id(self.children.len());
        self.edges.push(Edge { action, node: id(self.leaf), fixed, values: fixed, children });
    }
}

/// The arguments of an expansion; unlike a closure it is sure to be inlined into the dispatch.
struct Run<'a> {
    expansion: &'a mut Expansion,
    despot: &'a Despot,
    space: &'a Workspace,
}

impl pulp::NullaryFnOnce for Run<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.expansion.expand(self.despot, self.space);
    }
}
