//! Exact beliefs that can be reached, with certified upper bounds.
//!
//! The order of looks does not matter to a belief, and after a decision beliefs recur, so paths meet again and close
//! into cycles: a graph is far smaller than a tree. Posteriors and their probabilities are exact. Where the graph
//! ends the grid bounds the value from above; Bellman backups carry that inwards.
//!
//! An action whose grid value is below the best one's bound is only valued, never followed.

use std::collections::HashMap;
use std::ops::Range;

use super::LeafBounds;
use super::objects::{ARRIVING, ObjectId, Objects};
use crate::index::Viewpoint;
use crate::model::{Action, SortingModel, Step, shift};
use crate::remaining::Remaining;

/// Nodes of the graph up to 16 joint kinds, fewer beyond; each takes about 300 bytes, its actions and its value as a
/// policy included.
pub(super) const MOST_NODES: usize = 12_000_000;
/// No actions yet.
const NONE: u32 = u32::MAX;

pub(super) type NodeId = u32;

/// Where the search begins. It also follows labels that are impossible: then any policy will do.
pub(super) const ROOT: NodeId = 0;

/// An action at a node: deciding, or one of the legal moves.
#[derive(Clone)]
struct Arm {
    reward: f64,
    upper: f64,
    /// Its children; empty before it is followed.
    start: u32,
    end: u32,
}

impl Arm {
    fn children(&self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// An action that is followed, with what it leads to.
pub(super) struct Followed<'a> {
    pub action: Action,
    pub reward: f64,
    pub children: &'a [NodeId],
    pub probabilities: &'a [f64],
}

/// What one action leads to: rows of places, and their probabilities.
struct Outcomes {
    places: Vec<u32>,
    probabilities: Vec<f64>,
}

/// The graph.
pub(super) struct BeliefGraph<'a> {
    model: &'a SortingModel,
    leaves: &'a LeafBounds,
    objects: Objects<'a>,
    /// Per node the camera's viewpoint group, then the object at each position.
    places: Vec<u32>,
    upper: Vec<f64>,
    /// Where the arms of each node begin: deciding, then the legal moves.
    first_arm: Vec<u32>,
    arms: Vec<Arm>,
    /// Child and probability, arm by arm.
    children: Vec<NodeId>,
    probabilities: Vec<f64>,
    known: HashMap<Box<[u32]>, NodeId>,
}

impl<'a> BeliefGraph<'a> {
    pub(super) fn new(
        model: &'a SortingModel,
        leaves: &'a LeafBounds,
        root: &[f64],
        viewpoint: Viewpoint,
    ) -> Self {
        let mut graph = Self {
            model,
            leaves,
            objects: Objects::new(model, leaves.grid.as_deref()),
            places: Vec::new(),
            upper: Vec::new(),
            first_arm: Vec::new(),
            arms: Vec::new(),
            children: Vec::new(),
            probabilities: Vec::new(),
            known: HashMap::new(),
        };
        let mut places = vec![place(leaves.policy.group(viewpoint))];
        places.extend(root.chunks_exact(model.kind_count()).map(|belief| graph.objects.id(belief)));
        graph.node(&places);
        graph
    }

    /// Number of nodes.
    pub(super) fn size(&self) -> usize {
        self.upper.len()
    }

    pub(super) fn upper(&self, node: NodeId) -> f64 {
        self.upper[node as usize]
    }

    /// A node's belief, one distribution per position, and a viewpoint of its group.
    pub(super) fn belief(&self, node: NodeId) -> (Vec<f64>, Viewpoint) {
        let places = self.places_of(node);
        let belief = places[1..].iter().flat_map(|object| self.objects.belief(*object)).copied().collect();
        (belief, self.leaves.policy.representative(places[0] as usize))
    }

    /// The action with the highest upper bound; none if the graph ends here.
    pub(super) fn followed(&self, node: NodeId) -> Option<Followed<'_>> {
        let best = self.best_arm(node)?;
        let arm = &self.arms[best];
        (arm.start < arm.end).then(|| Followed {
            action: self.action(node, best - self.first_arm[node as usize] as usize),
            reward: arm.reward,
            children: &self.children[arm.children()],
            probabilities: &self.probabilities[arm.children()],
        })
    }

    /// Follow the action with the highest upper bound.
    pub(super) fn expand(&mut self, node: NodeId) {
        if self.first_arm[node as usize] == NONE {
            self.first_arm[node as usize] = place(self.arms.len());
            for arm in 0..self.arm_count(node) {
                self.value_arm(node, arm);
            }
        }
        if let Some(arm) = self.best_arm(node) {
            let outcomes = self.outcomes(node, arm - self.first_arm[node as usize] as usize);
            let start = place(self.children.len());
            for (places, p) in outcomes.places.chunks_exact(self.stride()).zip(&outcomes.probabilities) {
                let child = if *p > 0.0 { self.node(places) } else { ROOT };
                self.children.push(child);
            }
            self.probabilities.extend(outcomes.probabilities);
            (self.arms[arm].start, self.arms[arm].end) = (start, place(self.children.len()));
        }
        self.back_up(node);
    }

    /// Bellman's equation for the upper bound, which never rises; only actions that may be the best are valued anew.
    pub(super) fn back_up(&mut self, node: NodeId) {
        while let Some(best) = self.best_arm(node) {
            let arm = &self.arms[best];
            let upper = if arm.start == arm.end { arm.upper } else { self.worth(arm).min(arm.upper) };
            let fell = upper < arm.upper;
            self.arms[best].upper = upper;
            if !fell {
                self.upper[node as usize] = self.upper[node as usize].min(upper);
                return;
            }
        }
    }

    fn worth(&self, arm: &Arm) -> f64 {
        let weighted = self.children[arm.children()].iter().zip(&self.probabilities[arm.children()]);
        let expected: f64 = weighted.map(|(child, p)| p * self.upper[*child as usize]).sum();
        arm.reward + self.model.discount() * expected
    }

    /// The arm with the highest upper bound (the first among equals); none before the node has any.
    fn best_arm(&self, node: NodeId) -> Option<usize> {
        let first = self.first_arm[node as usize];
        if first == NONE {
            return None;
        }
        let arms = first as usize..first as usize + self.arm_count(node);
        arms.reduce(|a, b| if self.arms[b].upper > self.arms[a].upper { b } else { a })
    }

    fn viewpoint(&self, node: NodeId) -> Viewpoint {
        self.leaves.policy.representative(self.places_of(node)[0] as usize)
    }

    fn arm_count(&self, node: NodeId) -> usize {
        1 + self.model.legal_moves(self.viewpoint(node)).len()
    }

    fn value_arm(&mut self, node: NodeId, arm: usize) {
        let outcomes = self.outcomes(node, arm);
        let rows = outcomes.places.chunks_exact(self.stride()).zip(&outcomes.probabilities);
        let possible = rows.filter(|(_, p)| **p > 0.0);
        let expected: f64 = possible.map(|(places, p)| p * self.leaf_bound(places)).sum();
        let reward = self.model.expected_reward(&self.step(node, arm), self.belief_at_end(node));
        let upper = reward + self.model.discount() * expected;
        self.arms.push(Arm { reward, upper, start: 0, end: 0 });
    }

    fn action(&self, node: NodeId, arm: usize) -> Action {
        match arm {
            0 => Action::Decide(self.model.best_decision(self.belief_at_end(node)).0),
            _ => Action::Move(self.model.legal_moves(self.viewpoint(node))[arm - 1]),
        }
    }

    fn step(&self, node: NodeId, arm: usize) -> Step {
        self.model.step(self.action(node, arm), self.viewpoint(node), Remaining::ENDLESS)
    }

    fn belief_at_end(&self, node: NodeId) -> &[f64] {
        self.objects.belief(self.places_of(node)[1])
    }

    fn outcomes(&mut self, node: NodeId, arm: usize) -> Outcomes {
        let step = self.step(node, arm);
        let group = place(self.leaves.policy.group(step.viewpoint));
        let mut objects = self.places_of(node)[1..].to_vec();
        if step.advances() {
            shift(&mut objects, std::iter::once(ARRIVING));
        }
        let Some(from) = step.scan else {
            return Outcomes { places: [&[group], &objects[..]].concat(), probabilities: vec![1.0] };
        };
        let mut rows = Outcomes { places: vec![group], probabilities: vec![1.0] };
        for (j, object) in self.model.positions().zip(objects) {
            let look = self.objects.look(object, j, from);
            rows = rows.with(1 + j.0, self.objects.outcomes(look));
        }
        rows
    }

    fn stride(&self) -> usize {
        1 + self.model.position_count()
    }

    fn places_of(&self, node: NodeId) -> &[u32] {
        &self.places[node as usize * self.stride()..][..self.stride()]
    }

    /// The node of a belief, new or known.
    fn node(&mut self, places: &[u32]) -> NodeId {
        if let Some(known) = self.known.get(places) {
            return *known;
        }
        let id = place(self.upper.len());
        self.places.extend(places);
        self.upper.push(self.leaf_bound(places));
        self.first_arm.push(NONE);
        self.known.insert(places.into(), id);
        id
    }

    fn leaf_bound(&self, places: &[u32]) -> f64 {
        let objects = &places[1..];
        if let Some(grid) = &self.leaves.grid {
            let behind = objects.get(1).map_or(&[(0, 1.0)][..], |object| self.objects.located(*object));
            return grid.mixture(self.objects.located(objects[0]), behind);
        }
        let belief: Vec<f64> = objects.iter().flat_map(|o| self.objects.belief(*o)).copied().collect();
        let viewpoint = self.leaves.policy.representative(places[0] as usize);
        self.leaves.upper(self.model, &belief, viewpoint)
    }
}

impl Outcomes {
    /// Every row followed by every outcome of one more object.
    fn with(&self, stride: usize, outcomes: &[(ObjectId, f64)]) -> Self {
        let mut longer = Self { places: Vec::new(), probabilities: Vec::new() };
        for (row, p) in self.places.chunks_exact(stride).zip(&self.probabilities) {
            for (object, q) in outcomes {
                longer.places.extend(row);
                longer.places.push(*object);
                longer.probabilities.push(p * q);
            }
        }
        longer
    }
}

/// An index as the arenas hold it: they stay far below 2^32 entries, see [`MOST_NODES`].
#[allow(clippy::cast_possible_truncation)]
pub(super) fn place(index: usize) -> u32 {
    index as u32
}
