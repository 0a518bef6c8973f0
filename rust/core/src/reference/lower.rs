//! A certified lower bound: a policy graph, valued exactly.
//!
//! A node is an action and the node to follow after each label vector; its value is a vector over the joint classes
//! of all visible objects (`c^1 + L c^2 + ...`), the exact worth of a policy that can be executed. So the best node
//! for a belief is a lower bound of V* there. Improved at a set of beliefs as in point-based policy iteration (Ji,
//! Parr, Li, Liao & Carin, AAAI 2007).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::belief::most_likely;
use crate::model::{Action, SortingModel};
use crate::one_object::OneObjectPolicy;

/// Sweeps of policy evaluation between two improvements; cheap beside them.
const EVALUATIONS: usize = 40;

#[derive(Debug, Clone, PartialEq)]
struct Node {
    values: DVector<f64>,
    /// The action, and the node after each label vector (after a decision the only one). None where the value is that
    /// of another policy, which is executed as a whole.
    inner: Option<(Action, Vec<usize>)>,
}

/// A policy graph with a node per belief, for models whose viewpoints are all alike.
#[derive(Debug, Clone)]
pub(super) struct PolicyGraph {
    /// The joint belief that each node is for.
    beliefs: Vec<DVector<f64>>,
    /// The joint belief after a decision, likewise.
    advanced: Vec<DVector<f64>>,
    /// The label decided, likewise.
    labels: Vec<usize>,
    nodes: Vec<Node>,
    /// The nodes' values as rows, for choosing among them by a product.
    stacked: DMatrix<f64>,
    /// `P(z | s, v)` per viewpoint: a row per joint class, a column per label vector, both numbered alike.
    likelihoods: Vec<DMatrix<f64>>,
}

impl PolicyGraph {
    /// Start from the one-object policy's plans for the objects of each belief.
    pub(super) fn new(model: &SortingModel, policy: &OneObjectPolicy, points: &[Vec<f64>]) -> Self {
        let l = model.class_count();
        let advance = |b: &Vec<f64>| joint(model, &[&b[l..], model.arrival().as_slice()].concat());
        let chained = |b: &Vec<f64>| Node { values: chain_values(model, policy, b), inner: None };
        let mut graph = Self {
            beliefs: points.iter().map(|b| joint(model, b)).collect(),
            advanced: points.iter().map(advance).collect(),
            labels: points.iter().map(|b| most_likely(&b[..l]).0).collect(),
            nodes: points.iter().map(chained).collect(),
            stacked: DMatrix::zeros(0, 0),
            likelihoods: (0..model.viewpoint_count()).map(|v| joint_likelihood(model, v)).collect(),
        };
        graph.stack();
        graph
    }

    /// Value of the best node at a belief, one distribution per position.
    pub(super) fn value(&self, model: &SortingModel, belief: &[f64]) -> f64 {
        (&self.stacked * joint(model, belief)).max()
    }

    /// One improvement of every node, then evaluation of the graph.
    ///
    /// No node's value at its own belief ever falls.
    pub(super) fn improve(&mut self, model: &SortingModel) {
        self.nodes = (0..self.nodes.len()).into_par_iter().map(|i| self.improved(model, i)).collect();
        for _ in 0..EVALUATIONS {
            self.nodes = (0..self.nodes.len()).into_par_iter().map(|i| self.evaluated(model, i)).collect();
        }
        self.stack();
    }

    fn stack(&mut self) {
        let states = self.likelihoods[0].nrows();
        self.stacked = DMatrix::from_fn(self.nodes.len(), states, |i, s| self.nodes[i].values[s]);
    }

    /// What is best one step ahead of the graph, or the node as it is.
    fn improved(&self, model: &SortingModel, index: usize) -> Node {
        let belief = &self.beliefs[index];
        let best_next = |joint: &DVector<f64>| (&self.stacked * joint).imax();
        let decide = (Action::Decide(self.labels[index]), vec![best_next(&self.advanced[index])]);
        let moves = model.legal_moves(0).iter().map(|&to| {
            let mut weighted = self.likelihoods[to].clone();
            for mut column in weighted.column_iter_mut() {
                column.component_mul_assign(belief);
            }
            let worth = &self.stacked * weighted;
            (Action::Move(to), worth.column_iter().map(|column| column.imax()).collect())
        });
        let mut best = self.nodes[index].clone();
        for (action, next) in std::iter::once(decide).chain(moves) {
            let values = self.value_of(model, action, &next);
            if values.dot(belief) > best.values.dot(belief) {
                best = Node { values, inner: Some((action, next)) };
            }
        }
        best
    }

    /// The node with the value of its action followed by its successors as they are now, unless that is worse at its
    /// own belief.
    fn evaluated(&self, model: &SortingModel, index: usize) -> Node {
        let node = &self.nodes[index];
        let Some((action, next)) = &node.inner else { return node.clone() };
        let values = self.value_of(model, *action, next);
        let better = values.dot(&self.beliefs[index]) > node.values.dot(&self.beliefs[index]);
        let values = if better { values } else { node.values.clone() };
        Node { values, ..node.clone() }
    }

    /// Value of an action followed by given nodes, by joint class.
    fn value_of(&self, model: &SortingModel, action: Action, next: &[usize]) -> DVector<f64> {
        match action {
            Action::Decide(label) => value_of_deciding(model, label, &self.nodes[next[0]].values),
            Action::Move(to) => {
                let likelihood = &self.likelihoods[to];
                let mut after = DVector::zeros(likelihood.nrows());
                for (column, next) in likelihood.column_iter().zip(next) {
                    after += column.component_mul(&self.nodes[*next].values);
                }
                after.map(|value| model.discount() * value - model.motion_cost(0, to))
            }
        }
    }
}

/// Value of executing one plan per visible object, by joint class: from the last position to the first, `G(c)` plus
/// `D(c)` times what follows.
fn chain_values(model: &SortingModel, policy: &OneObjectPolicy, belief: &[f64]) -> DVector<f64> {
    let end = DVector::from_element(1, policy.arrival_values()[0]);
    policy.chain(model, belief).iter().rev().fold(end, |after, (gain, discount)| {
        let l = gain.len();
        DVector::from_fn(l * after.len(), |i, _| gain[i % l] + discount[i % l] * after[i / l])
    })
}

fn value_of_deciding(model: &SortingModel, label: usize, next: &DVector<f64>) -> DVector<f64> {
    let l = model.class_count();
    // The class of the arriving object is the last digit of the next joint class.
    let behind = next.len() / l;
    let expected = DVector::from_fn(behind, |b, _| {
        model.arrival().iter().enumerate().map(|(c, p)| p * next[b + c * behind]).sum::<f64>()
    });
    DVector::from_fn(next.len(), |s, _| {
        model.decision_reward(f64::from(u8::from(s % l == label))) + model.discount() * expected[s / l]
    })
}

/// The product of the positions' distributions.
fn joint(model: &SortingModel, belief: &[f64]) -> DVector<f64> {
    let positions = belief.chunks_exact(model.class_count());
    positions.fold(DVector::from_element(1, 1.0), |joint, position| {
        let size = joint.len();
        DVector::from_fn(size * position.len(), |i, _| joint[i % size] * position[i / size])
    })
}

/// `P(z | s, v)`: a row per joint class, a column per label vector.
fn joint_likelihood(model: &SortingModel, viewpoint: usize) -> DMatrix<f64> {
    (0..model.position_count()).fold(DMatrix::from_element(1, 1, 1.0), |joint, j| {
        let (table, size) = (model.table(j, viewpoint), joint.nrows());
        let states = size * table.nrows();
        DMatrix::from_fn(states, states, |s, z| joint[(s % size, z % size)] * table[(s / size, z / size)])
    })
}
