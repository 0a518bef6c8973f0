//! Expanding a leaf: all its actions, each with its children.

use super::Despot;
use super::branch::Brancher;
use super::objects::Objects;
use super::scan::Scan;
use super::shortfall::left_to_learn;
use super::sightings::act;
use crate::bounds::{self, Sighting};
use crate::index::{Position, Viewpoint};
use crate::model::Action;
use crate::tree::{Child, Node, Object, Values, seen};

/// A chosen leaf, on its way to become a node; nothing of it is in the tree yet.
#[derive(Debug, Default)]
pub(super) struct Expansion {
    /// Its scenarios are its parent's until it is expanded.
    pub node: Node,
    /// The scan that has led to it.
    pub scan: Option<Scan>,
    /// Its values before it was chosen, then those that its expansion has found.
    pub values: Values,
}

impl Expansion {
    /// Expand the leaf, compiled for the CPU at hand.
    pub(super) fn run(&mut self, despot: &Despot, known: Objects<'_>, scratch: &mut Scratch) {
        pulp::Arch::new().dispatch(Run { node: &mut self.node, scan: self.scan, despot, known, scratch });
        self.values = self.node.best_values();
    }

    /// Whether the time sufficed.
    pub(super) fn done(&self) -> bool {
        !self.node.edges.is_empty()
    }
}

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// The objects once the belt has advanced, and what they are worth.
    advanced: (Vec<Object>, Vec<f64>),
    brancher: Brancher,
}

/// The arguments of an expansion; unlike a closure it is sure to be inlined into the dispatch.
struct Run<'a> {
    node: &'a mut Node,
    scan: Option<Scan>,
    despot: &'a Despot,
    known: Objects<'a>,
    scratch: &'a mut Scratch,
}

impl pulp::NullaryFnOnce for Run<'_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        self.arrive();
        self.decide();
        for &to in self.despot.model.legal_moves(self.node.viewpoint) {
            self.move_to(to);
        }
    }
}

impl Run<'_> {
    /// Scenarios of the leaf: those of its parent's that give its labels.
    #[inline(always)]
    fn arrive(&mut self) {
        let Self { node, scan, despot, known, .. } = self;
        let Some(scan) = scan else { return };
        let objects = (0..).map(Position).zip(&node.objects);
        for ((position, object), z) in objects.zip(seen(&despot.model, node.labels)) {
            let last = known.sightings.label_before(*object);
            let look = scan.look(Sighting { position, viewpoint: scan.viewpoint, last });
            let plane = known.label(look, z);
            for (word, plane) in node.scenarios.iter_mut().zip(plane) {
                *word &= plane;
            }
        }
    }

    /// Decide the most likely label and advance the belt; if a scan follows, see what it gives.
    #[inline(always)]
    fn decide(&mut self) {
        let Self { node, despot, known, scratch: Scratch { advanced: (objects, worth), brancher }, .. } =
            self;
        let model = &despot.model;
        let (class, p_right) = known.most_likely(node.objects[0]);
        let action = Action::Decide(class);
        objects.clone_from(&node.objects);
        let scan = act(model, (node, action), objects);
        let reward = model.decision_reward(p_right);
        let first = node.children.len();
        let fixed = if let Some(scan) = scan {
            let bonus = brancher.take(despot, *known, objects, &scan);
            brancher.branch(despot, *known, node);
            brancher.fixed(despot, node, reward + bonus)
        } else {
            let remaining = node.remaining.after(1);
            let unseen = remaining.unseen(objects.len());
            let value = known.value(&despot.default_policy, (objects, unseen), node.viewpoint, worth);
            let entropy = left_to_learn(model, objects.iter().map(|object| known.distribution(*object)));
            let p_right = objects.first().map_or(0.0, |object| known.most_likely(*object).1);
            let upper = bounds::upper_knowing(model, node.viewpoint, remaining)(p_right);
            let below = (node.depth + 1, node.probability, remaining);
            let values = despot.leaf(below, value, entropy, upper);
            node.children.push(Child { values, probability: node.probability, labels: 0, node: None });
            let reward = despot.scale(node.depth, node.probability) * reward;
            Values { certified: reward, ..Values::all(reward - despot.config.regularization) }
        };
        node.push_edge(action, fixed, first);
    }

    /// Move and scan.
    #[inline(always)]
    fn move_to(&mut self, to: Viewpoint) {
        let Self { node, despot, known, scratch: Scratch { brancher, .. }, .. } = self;
        let scan =
            Scan { depth: node.depth, decisions: node.decisions, viewpoint: to, remaining: node.remaining };
        let first = node.children.len();
        let bonus = brancher.take(despot, *known, &node.objects, &scan);
        brancher.branch(despot, *known, node);
        let fixed = brancher.fixed(despot, node, bonus - despot.model.motion_cost(node.viewpoint, to));
        node.push_edge(Action::Move(to), fixed, first);
    }
}
