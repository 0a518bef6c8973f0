//! The belief graph as a policy, valued exactly from below: a finite-state controller.
//!
//! Inside the graph it takes the action with the highest upper bound. Its value from each node is a vector over the
//! joint kinds, so every node is itself a policy to continue with where the graph ends: that closes the graph upon
//! itself, and few rounds suffice.
//!
//! Let S be the operator that values every node by its action and its successors: monotone, and
//! `S (X + c) >= S X + discount c` for c <= 0. For *any* X, `X + min (0, min (S X - X)) / (1 - discount)` is at most
//! the policy's value, by the argument of [`super::value_iteration`]; so sweeps may stop at any time.

use nalgebra::{DMatrix, DVectorView, RowDVector};
use rayon::prelude::*;

use super::alpha::{AlphaVectors, joint};
use super::graph::{BeliefGraph, Followed, place};
use super::neighbourhoods::{Candidates, good_policies};
use super::reach::Reach;
use crate::index::{Bin, Viewpoint};
use crate::model::{Action, SortingModel};

/// Sweeps that change the root, and lower any value, by less than this part of `r_max` suffice.
const TOLERANCE: f64 = 1e-5;
/// Sweeps before all values are levelled.
const SWEEPS: usize = 4;
/// Rows that are compared with their backups at once.
const BLOCK: usize = 1024;
/// Nodes whose values become policies to continue with anywhere.
const SAMPLE: usize = 2500;

/// What is done at a node.
struct NodeAction {
    action: Action,
    reward: f64,
    /// Where the rows that it leads to end, those of the node before being their start.
    end: usize,
}

/// The graph's nodes as far as the policy reaches them.
pub(super) struct Controller<'a> {
    model: &'a SortingModel,
    graph: &'a BeliefGraph<'a>,
    reach: &'a Reach,
    /// A row of joint kinds for each node of the interior, in its order; then for each policy known before.
    values: Vec<f64>,
    /// Row of each node of the graph that is reached; of a leaf, that of the policy it continues with.
    rows: Vec<u32>,
    /// By node of the interior.
    steps: Vec<NodeAction>,
    successors: Vec<u32>,
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
        let interior = reach.interior.len();
        let likelihoods = model.viewpoints().map(|v| discounted_likelihoods(model, v)).collect();
        let (rows, states) = (vec![u32::MAX; graph.size()], alphas.0.ncols());
        let (values, steps, successors) = Default::default();
        let mut controller =
            Self { model, graph, reach, values, rows, steps, successors, likelihoods, states };
        let known = alphas.0.transpose();
        let everywhere: Vec<_> = reach.nodes().collect();
        let belief = |i: usize| graph.belief(everywhere[i]).0;
        let all = Candidates {
            values: known.as_slice(),
            states,
            anywhere: (0..known.ncols()).collect(),
            nearby: 0,
        };
        let chosen = good_policies(model, &all, belief, everywhere.len());
        for (row, (node, policy)) in everywhere.iter().zip(chosen).enumerate() {
            let inside = row < interior;
            controller.rows[*node as usize] = place(if inside { row } else { interior + policy });
            if inside {
                controller.values.extend(&known.as_slice()[policy * states..][..states]);
            }
        }
        controller.values.extend(known.as_slice());
        controller.link();
        controller
    }

    /// Continue at every leaf with the best of the graph's own policies and those known before.
    pub(super) fn close(&mut self) {
        let interior = self.reach.interior.len();
        let leaves = &self.reach.leaves;
        let known = interior..self.values.len() / self.states;
        let anywhere = sample(interior).chain(known).collect();
        let candidates = Candidates { values: &self.values, states: self.states, anywhere, nearby: interior };
        let nodes: Vec<_> = self.reach.nodes().collect();
        let belief = |i: usize| self.graph.belief(nodes[i]).0;
        let chosen = good_policies(self.model, &candidates, belief, leaves.len());
        for ((leaf, _), policy) in leaves.iter().zip(chosen) {
            self.rows[*leaf as usize] = place(policy);
        }
        self.link();
    }

    /// Lay out what the sweeps go through.
    fn link(&mut self) {
        self.steps.clear();
        self.successors.clear();
        let followed = self.reach.interior.iter().filter_map(|node| self.graph.followed(*node));
        for Followed { action, reward, children, .. } in followed {
            self.successors.extend(children.iter().map(|child| self.rows[*child as usize]));
            self.steps.push(NodeAction { action, reward, end: self.successors.len() });
        }
    }

    /// Sweep until the root's value has settled, or `stop` says so; then prove the values.
    pub(super) fn evaluate(&mut self, stop: impl Fn() -> bool) {
        let most = TOLERANCE * self.model.reward_scale();
        let mut before = f64::NEG_INFINITY;
        loop {
            let (least, mean) = self.changes();
            let settled = (self.value() - before).abs() < most && least > -most;
            if settled || stop() {
                return self.shift(least.min(0.0));
            }
            before = self.value();
            self.shift(mean);
            for _ in 0..SWEEPS {
                self.sweep();
            }
        }
    }

    /// Value every node anew, those far from the root first.
    fn sweep(&mut self) {
        let mut backed_up = vec![0.0; self.states];
        for row in (0..self.reach.interior.len()).rev() {
            self.back_up(row, &mut backed_up);
            self.values[row * self.states..][..self.states].copy_from_slice(&backed_up);
        }
    }

    /// The least and the mean of S X - X.
    fn changes(&self) -> (f64, f64) {
        let interior = self.reach.interior.len();
        let rows = self.values[..interior * self.states].par_chunks(BLOCK * self.states).enumerate();
        let changes = |(block, old): (usize, &[f64])| {
            let mut backed_up = vec![0.0; self.states];
            let (mut least, mut sum) = (f64::INFINITY, 0.0);
            for (row, old) in old.chunks_exact(self.states).enumerate() {
                self.back_up(block * BLOCK + row, &mut backed_up);
                for (new, old) in backed_up.iter().zip(old) {
                    least = least.min(new - old);
                    sum += new - old;
                }
            }
            (least, sum)
        };
        let (least, sum) =
            rows.map(changes).reduce(|| (f64::INFINITY, 0.0), |a, b| (a.0.min(b.0), a.1 + b.1));
        (least, sum / (interior * self.states) as f64)
    }

    /// Add what a change of all values by this, step after step, amounts to.
    fn shift(&mut self, change: f64) {
        let shift = change / (1.0 - self.model.discount());
        let interior = self.reach.interior.len() * self.states;
        self.values[..interior].iter_mut().for_each(|value| *value += shift);
    }

    /// Value of the policy at the root.
    pub(super) fn value(&self) -> f64 {
        let belief = joint(self.model, &self.graph.belief(0).0);
        belief.iter().zip(&self.values).map(|(b, value)| b * value).sum()
    }

    /// Policies to continue with elsewhere: from some nodes of the interior.
    pub(super) fn alphas(&self) -> AlphaVectors {
        let interior = self.reach.interior.len();
        let row = |row: usize| RowDVector::from_row_slice(&self.values[row * self.states..][..self.states]);
        AlphaVectors(DMatrix::from_rows(&sample(interior).map(row).collect::<Vec<_>>()))
    }

    fn row(&self, row: u32) -> &[f64] {
        &self.values[row as usize * self.states..][..self.states]
    }

    /// One row of S X.
    fn back_up(&self, row: usize, backed_up: &mut [f64]) {
        let NodeAction { action, reward, end } = self.steps[row];
        let start = if row == 0 { 0 } else { self.steps[row - 1].end };
        let successors = &self.successors[start..end];
        match action {
            Action::Decide(bin) => self.back_up_decision(bin, self.row(successors[0]), backed_up),
            Action::Move(to) => {
                backed_up.fill(reward);
                for (next, likelihood) in successors.iter().zip(&self.likelihoods[to.0]) {
                    for ((sum, p), value) in backed_up.iter_mut().zip(likelihood).zip(self.row(*next)) {
                        *sum += p * value;
                    }
                }
            }
        }
    }

    fn back_up_decision(&self, decided: Bin, next: &[f64], backed_up: &mut [f64]) {
        let (n, arrival) = (self.model.kind_count(), self.model.arrival());
        // The kind of the arriving object is the last digit of the next joint kind.
        let behind = self.states / n;
        for (b, values) in backed_up.chunks_exact_mut(n).enumerate() {
            let expected: f64 = arrival.iter().enumerate().map(|(c, p)| p * next[b + c * behind]).sum();
            for (kind, value) in self.model.kinds().zip(values) {
                *value = self.model.reward(decided, kind) + self.model.discount() * expected;
            }
        }
    }
}

/// About [`SAMPLE`] of so many rows.
fn sample(rows: usize) -> impl Iterator<Item = usize> {
    (0..rows).step_by(rows.div_ceil(SAMPLE).max(1))
}

/// Discounted `P(z | s, v)`: per label vector z, the last position's label changing fastest, a row over the joint
/// kinds s.
fn discounted_likelihoods(model: &SortingModel, viewpoint: Viewpoint) -> Vec<Vec<f64>> {
    model.positions().fold(vec![vec![model.discount()]], |rows, j| {
        let labels = |row: &Vec<f64>| -> Vec<Vec<f64>> {
            let column = |column: DVectorView<'_, f64>| {
                column.iter().flat_map(|p| row.iter().map(move |q| q * p)).collect()
            };
            model.table(j, viewpoint).column_iter().map(column).collect()
        };
        rows.iter().flat_map(labels).collect()
    })
}
