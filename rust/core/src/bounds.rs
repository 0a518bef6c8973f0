//! Bounds of the value at an exact belief, and what a look is worth before its labels are told apart.

use crate::belief::most_likely;
use crate::model::SortingModel;
use crate::one_object::{OneObjectPolicy, Stage, dot};

/// Lower bound of V*: the value of executing the one-object policy (see [`OneObjectPolicy`]).
pub(crate) fn lower(model: &SortingModel, policy: &OneObjectPolicy, belief: &[f64], viewpoint: usize) -> f64 {
    policy.value(model, belief, viewpoint)
}

/// Upper bound of V*: from the second step on, every class is known and each step earns `r_max`.
///
/// Now, the best is to decide on what is known, or to pay for the cheapest move.
pub(crate) fn upper(model: &SortingModel, belief: &[f64], viewpoint: usize) -> f64 {
    let all_right = model.spec().r_max / (1.0 - model.discount());
    let (_, p_right) = most_likely(&belief[..model.class_count()]);
    let moves = model.legal_moves(viewpoint).iter();
    let cheapest = moves.map(|&to| model.motion_cost(viewpoint, to)).fold(f64::INFINITY, f64::min);
    model.decision_reward(p_right).max(-cheapest) + model.discount() * all_right
}

/// One scan from a viewpoint, taken apart: every label of every position with its probability, its posterior,
/// and the one-object plan that is then best for that object.
///
/// Positions are independent, so `H * L` entries describe all `L^H` outcomes.
pub(crate) struct Look {
    classes: usize,
    group: usize,
    /// Entry `j * L + z`.
    outcomes: Vec<Outcome>,
    arrival_values: Vec<f64>,
    value: f64,
}

struct Outcome {
    probability: f64,
    posterior: Vec<f64>,
    /// Per viewpoint group from which the object's turn may start; empty if the label is impossible.
    stages: Vec<Stage>,
}

impl Look {
    /// Take apart a scan from `viewpoint` at the belief with one distribution per position.
    pub(crate) fn new(
        model: &SortingModel,
        policy: &OneObjectPolicy,
        belief: &[f64],
        viewpoint: usize,
    ) -> Self {
        let l = model.class_count();
        let mut outcomes: Vec<Outcome> = belief
            .chunks_exact(l)
            .enumerate()
            .flat_map(|(j, position)| (0..l).map(move |z| outcome(model, position, j, viewpoint, z)))
            .collect();
        let mut expected = policy.arrival_values().to_vec();
        for labels in outcomes.chunks_exact_mut(l).rev() {
            for outcome in labels.iter_mut().filter(|o| o.probability > 0.0) {
                let stage = |group| policy.stage(group, &outcome.posterior, &expected);
                outcome.stages = (0..policy.group_count()).map(stage).collect();
            }
            expected = expectation(labels, &expected);
        }
        let arrival_values = policy.arrival_values().to_vec();
        let group = policy.group(viewpoint);
        Self { classes: l, group, outcomes, arrival_values, value: expected[group] }
    }

    /// Expected value of following those plans, over all labels: a lower bound of the value after the scan.
    pub(crate) fn value(&self) -> f64 {
        self.value
    }

    /// Value of following those plans after the given labels, one per position.
    pub(crate) fn value_after(&self, labels: &[usize]) -> f64 {
        let mut worth = self.arrival_values.clone();
        for (j, z) in labels.iter().enumerate().rev() {
            let stages = &self.outcome(j, *z).stages;
            worth = stages.iter().map(|stage| stage.value(&worth)).collect();
        }
        worth[self.group]
    }

    /// `P(z | b, v)` of the given labels, one per position.
    pub(crate) fn probability(&self, labels: &[usize]) -> f64 {
        labels.iter().enumerate().map(|(j, z)| self.outcome(j, *z).probability).product()
    }

    /// The posterior after the given labels, one distribution per position.
    pub(crate) fn posterior(&self, labels: &[usize]) -> Vec<f64> {
        labels.iter().enumerate().flat_map(|(j, z)| self.outcome(j, *z).posterior.iter().copied()).collect()
    }

    fn outcome(&self, position: usize, label: usize) -> &Outcome {
        &self.outcomes[position * self.classes + label]
    }
}

fn outcome(model: &SortingModel, position: &[f64], index: usize, viewpoint: usize, label: usize) -> Outcome {
    let column = model.table(index, viewpoint).column(label);
    let probability = dot(position, column.as_slice());
    let posterior = position.iter().zip(column.iter()).map(|(b, p)| b * p / probability).collect();
    Outcome { probability, posterior, stages: Vec::new() }
}

/// Expected value over one position's labels, per group, when `after` follows.
fn expectation(labels: &[Outcome], after: &[f64]) -> Vec<f64> {
    let mut expected = vec![0.0; after.len()];
    for outcome in labels {
        for (sum, stage) in expected.iter_mut().zip(&outcome.stages) {
            *sum += outcome.probability * stage.value(after);
        }
    }
    expected
}

#[cfg(test)]
mod tests;
