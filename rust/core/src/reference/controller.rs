//! The belief graph as a policy, valued exactly from below.
//!
//! Inside the graph it takes the action with the highest upper bound; where the graph ends it continues with the best
//! policy known there. Its value from each node is a vector over the joint classes, so every node is itself a policy
//! to continue with: that closes the graph upon itself, and few rounds suffice.
//!
//! Let S be the operator that values every node by its action and its successors: monotone, and
//! `S (X + c) >= S X + discount c` for c <= 0. For *any* X, `X + min (0, min (S X - X)) / (1 - discount)` is at most
//! the policy's value, by the argument of [`super::value_iteration`]; so sweeps may stop at any time.

use nalgebra::{DMatrix, DVectorView, RowDVector};

use super::alpha::{AlphaVectors, joint};
use super::graph::{BeliefGraph, place};
use super::neighbourhoods::good_policies;
use super::reach::Reach;
use crate::model::{Action, SortingModel};

/// A sweep that changes no value by more than this part of `r_max` is the last of its round.
const TOLERANCE: f64 = 1e-5;
/// Nodes whose values become policies to continue with.
const SAMPLE: usize = 2500;

/// The graph's nodes as far as the policy reaches them.
pub(super) struct Controller<'a> {
    model: &'a SortingModel,
    graph: &'a BeliefGraph<'a>,
    reach: &'a Reach,
    /// Values by node: a row of joint classes for each node of the interior, in its order, then for each leaf.
    values: Vec<f64>,
    /// Row of each node of the graph that is reached.
    rows: Vec<u32>,
    /// Per viewpoint, see [`discounted_likelihoods`].
    likelihoods: Vec<Vec<Vec<f64>>>,
    states: usize,
}

impl<'a> Controller<'a> {
    /// All nodes continue with the best of these policies.
    pub(super) fn new(
        model: &'a SortingModel,
        graph: &'a BeliefGraph<'a>,
        reach: &'a Reach,
        alphas: &AlphaVectors,
    ) -> Self {
        let states = alphas.0.ncols();
        let mut rows = vec![u32::MAX; graph.size()];
        for (row, node) in reach.nodes().enumerate() {
            rows[node as usize] = place(row);
        }
        let likelihoods = (0..model.viewpoint_count()).map(|v| discounted_likelihoods(model, v)).collect();
        let mut controller = Self { model, graph, reach, values: Vec::new(), rows, likelihoods, states };
        controller.continue_with(alphas, 0);
        controller
    }

    /// Continue at every leaf with the best of these policies, and sweep.
    pub(super) fn improve(&mut self, alphas: &AlphaVectors, stop: impl Fn() -> bool) {
        self.continue_with(alphas, self.reach.interior.len());
        while self.sweep() > TOLERANCE * self.model.spec().r_max && !stop() {}
        self.certify();
    }

    /// Give all rows from one on the value of the best of these policies there.
    fn continue_with(&mut self, alphas: &AlphaVectors, from: usize) {
        let nodes: Vec<_> = self.reach.nodes().skip(from).collect();
        let belief = |i: usize| self.graph.belief(nodes[i]).0;
        let chosen = good_policies(self.model, alphas, belief, nodes.len());
        self.values.truncate(from * self.states);
        for policy in chosen {
            self.values.extend(alphas.0.row(policy).iter());
        }
    }

    /// Value every node anew, those far from the root first; the largest change of a value.
    fn sweep(&mut self) -> f64 {
        let mut backed_up = vec![0.0; self.states];
        let mut change = 0.0_f64;
        for row in (0..self.reach.interior.len()).rev() {
            self.back_up(row, &mut backed_up);
            for (new, old) in backed_up.iter().zip(&mut self.values[row * self.states..]) {
                change = change.max((new - *old).abs());
                *old = *new;
            }
        }
        change
    }

    /// Lower all values until they are proved; see above.
    fn certify(&mut self) {
        let mut backed_up = vec![0.0; self.states];
        let mut fall = 0.0_f64;
        for row in 0..self.reach.interior.len() {
            self.back_up(row, &mut backed_up);
            let changes = backed_up.iter().zip(&self.values[row * self.states..]).map(|(new, old)| new - old);
            fall = changes.fold(fall, f64::min);
        }
        let shift = fall / (1.0 - self.model.discount());
        let interior = self.reach.interior.len() * self.states;
        self.values[..interior].iter_mut().for_each(|value| *value += shift);
    }

    /// Value of the policy at the root.
    pub(super) fn value(&self) -> f64 {
        let belief = joint(self.model, &self.graph.belief(0).0);
        belief.iter().zip(&self.values).map(|(b, value)| b * value).sum()
    }

    /// Policies to continue with elsewhere: from some nodes of the interior, and those that some leaves continue with.
    pub(super) fn alphas(&self) -> AlphaVectors {
        let interior = self.reach.interior.len();
        let all =
            self.rows_from(0, interior).chain(self.rows_from(interior, interior + self.reach.leaves.len()));
        AlphaVectors(DMatrix::from_rows(&all.collect::<Vec<_>>()))
    }

    fn rows_from(&self, first: usize, last: usize) -> impl Iterator<Item = RowDVector<f64>> {
        let rows = (first..last).step_by((last - first).div_ceil(SAMPLE).max(1));
        rows.map(|row| RowDVector::from_row_slice(&self.values[row * self.states..][..self.states]))
    }

    fn row(&self, node: u32) -> &[f64] {
        &self.values[self.rows[node as usize] as usize * self.states..][..self.states]
    }

    /// One row of S X.
    fn back_up(&self, row: usize, backed_up: &mut [f64]) {
        let Some(step) = self.graph.followed(self.reach.interior[row]) else { return };
        match step.action {
            Action::Decide(label) => self.back_up_decision(label, self.row(step.children[0]), backed_up),
            Action::Move(to) => {
                backed_up.fill(step.reward);
                for (child, likelihood) in step.children.iter().zip(&self.likelihoods[to]) {
                    for ((sum, p), value) in backed_up.iter_mut().zip(likelihood).zip(self.row(*child)) {
                        *sum += p * value;
                    }
                }
            }
        }
    }

    fn back_up_decision(&self, label: usize, next: &[f64], backed_up: &mut [f64]) {
        let (l, arrival) = (self.model.class_count(), self.model.arrival());
        // The class of the arriving object is the last digit of the next joint class.
        let behind = self.states / l;
        for (b, values) in backed_up.chunks_exact_mut(l).enumerate() {
            let expected: f64 = arrival.iter().enumerate().map(|(c, p)| p * next[b + c * behind]).sum();
            for (class, value) in values.iter_mut().enumerate() {
                let reward = self.model.decision_reward(f64::from(u8::from(class == label)));
                *value = reward + self.model.discount() * expected;
            }
        }
    }
}

/// Discounted `P(z | s, v)`: per label vector z, the last position's label changing fastest, a row over the joint
/// classes s.
fn discounted_likelihoods(model: &SortingModel, viewpoint: usize) -> Vec<Vec<f64>> {
    (0..model.position_count()).fold(vec![vec![model.discount()]], |rows, j| {
        let labels = |row: &Vec<f64>| -> Vec<Vec<f64>> {
            let column = |column: DVectorView<'_, f64>| {
                column.iter().flat_map(|p| row.iter().map(move |q| q * p)).collect()
            };
            model.table(j, viewpoint).column_iter().map(column).collect()
        };
        rows.iter().flat_map(labels).collect()
    })
}
