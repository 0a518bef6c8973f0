//! Bounds of the value at an exact belief, and what a look is worth before its labels are told apart.

use crate::belief::{Memory, entropy, most_likely};
use crate::model::SortingModel;
use crate::one_object::{OneObjectPolicy, dot};

/// Lower bound of V*: the value of executing the one-object policy (see [`OneObjectPolicy`]), any bonus left aside.
///
/// For a model that repeats looks it is an estimate only: the plans take labels as independent.
#[inline(always)]
pub(crate) fn lower(model: &SortingModel, policy: &OneObjectPolicy, belief: &[f64], viewpoint: usize) -> f64 {
    policy.value(model, belief, viewpoint)
}

/// Upper bound of V*: from the second step on, every class is known and each step earns `r_max` and the largest bonus.
///
/// Now, the best is to decide on what is known, or to pay for the cheapest move.
pub(crate) fn upper(model: &SortingModel, belief: &[f64], viewpoint: usize) -> f64 {
    upper_knowing(model, most_likely(&belief[..model.class_count()]).1, viewpoint)
}

/// The same where the most likely class at the belt end has probability `p_right`.
#[inline(always)]
pub(crate) fn upper_knowing(model: &SortingModel, p_right: f64, viewpoint: usize) -> f64 {
    let all_right = (model.spec().r_max + most_bonus(model)) / (1.0 - model.discount());
    let moves = model.legal_moves(viewpoint).iter();
    let cheapest = moves.map(|&to| model.motion_cost(viewpoint, to)).fold(f64::INFINITY, f64::min);
    model.decision_reward(p_right).max(-cheapest) + most_bonus(model) + model.discount() * all_right
}

/// The largest bonus of a scan: all entropy of all positions.
fn most_bonus(model: &SortingModel) -> f64 {
    let entropy = model.position_count() as f64 * (model.class_count() as f64).ln();
    model.spec().information_gain * entropy
}

/// One scan from a viewpoint, taken apart: every label of every position with its probability, its posterior,
/// and the one-object plan that is then best for that object.
///
/// Positions are independent, so `H * L` entries describe all `L^H` outcomes. The buffers are reused.
#[derive(Debug, Default)]
pub(crate) struct Look {
    classes: usize,
    groups: usize,
    group: usize,
    /// Entry `j * L + z`.
    probabilities: Vec<f64>,
    /// Entry `(j * L + z) * L + c`.
    posteriors: Vec<f64>,
    /// What is left to learn after each label, where learning is rewarded; entry `j * L + z`, and 0 elsewhere.
    entropies: Vec<f64>,
    /// Stage of position j after label z for an object whose turn starts in group g: `(j * L + z) * G + g`.
    gains: Vec<f64>,
    /// Its discount into group s: `((j * L + z) * G + g) * G + s`.
    discounts: Vec<f64>,
    /// Expected value of position j and what follows, per group: `j * G + g`, behind the last the arrival values.
    expected: Vec<f64>,
}

impl Look {
    /// Take apart a scan from `viewpoint` at the belief with one distribution per position.
    #[inline(always)]
    pub(crate) fn take(
        &mut self,
        model: &SortingModel,
        policy: &OneObjectPolicy,
        belief: &[f64],
        memory: &Memory,
        viewpoint: usize,
    ) {
        let (l, g) = (model.class_count(), policy.group_count());
        let h = belief.len() / l;
        (self.classes, self.groups, self.group) = (l, g, policy.group(viewpoint));
        self.probabilities.resize(h * l, 0.0);
        self.posteriors.resize(h * l * l, 0.0);
        self.entropies.resize(h * l, 0.0);
        self.gains.resize(h * l * g, 0.0);
        self.discounts.resize(h * l * g * g, 0.0);
        self.expected.clear();
        self.expected.resize(h * g, 0.0);
        self.expected.extend(policy.arrival_values());
        for (j, position) in belief.chunks_exact(l).enumerate().rev() {
            let last = memory.last(model, j, viewpoint);
            for z in 0..l {
                self.outcome(position, j * l + z, model.likelihoods(j, viewpoint, last, z));
                if model.spec().information_gain > 0.0 {
                    self.entropies[j * l + z] = entropy(self.posterior(j, z));
                }
                self.stages(policy, j, z);
            }
        }
    }

    /// Probability and posterior of one label.
    #[inline(always)]
    fn outcome(&mut self, position: &[f64], at: usize, likelihoods: impl Iterator<Item = f64>) {
        let posterior = &mut self.posteriors[at * self.classes..][..self.classes];
        let mut total = 0.0;
        for ((joint, b), p) in posterior.iter_mut().zip(position).zip(likelihoods) {
            *joint = b * p;
            total += *joint;
        }
        self.probabilities[at] = total;
        if total > 0.0 {
            let factor = 1.0 / total;
            for entry in posterior {
                *entry *= factor;
            }
        }
    }

    /// The best plan for an object after one label, chosen for what is expected of the objects behind it.
    #[inline(always)]
    fn stages(&mut self, policy: &OneObjectPolicy, j: usize, z: usize) {
        let (g, at) = (self.groups, j * self.classes + z);
        if self.probabilities[at] <= 0.0 {
            return;
        }
        let posterior = &self.posteriors[at * self.classes..][..self.classes];
        let (here, behind) = self.expected.split_at_mut((j + 1) * g);
        for group in 0..g {
            let (plan, value) = policy.best(group, posterior, &behind[..g]);
            self.gains[at * g + group] = plan.gain_at(posterior);
            for (entry, discount) in
                self.discounts[(at * g + group) * g..][..g].iter_mut().zip(plan.discounts_at(posterior))
            {
                *entry = discount;
            }
            here[j * g + group] += self.probabilities[at] * value;
        }
    }

    /// Expected value of following those plans, over all labels: a lower bound of the value after the scan.
    pub(crate) fn value(&self) -> f64 {
        self.expected[self.group]
    }

    /// What is left to learn about one position after its label, where learning is rewarded.
    #[inline(always)]
    pub(crate) fn entropy(&self, position: usize, label: usize) -> f64 {
        self.entropies[position * self.classes + label]
    }

    /// The same expected over all labels of all positions.
    pub(crate) fn expected_entropy(&self) -> f64 {
        dot(&self.probabilities, &self.entropies)
    }

    /// `P(z | b, v)` of one position's label.
    #[inline(always)]
    pub(crate) fn probability(&self, position: usize, label: usize) -> f64 {
        self.probabilities[position * self.classes + label]
    }

    /// `P(z | b, v)` of every label of one position.
    pub(crate) fn probabilities_of(&self, position: usize) -> &[f64] {
        &self.probabilities[position * self.classes..][..self.classes]
    }

    /// The posterior of one position after its label.
    #[inline(always)]
    pub(crate) fn posterior(&self, position: usize, label: usize) -> &[f64] {
        &self.posteriors[(position * self.classes + label) * self.classes..][..self.classes]
    }

    /// Value, per group, of position j after its label, when `behind` is that of the positions behind it.
    #[inline(always)]
    pub(crate) fn value_from(&self, position: usize, label: usize, behind: &[f64], out: &mut [f64]) {
        let at = (position * self.classes + label) * self.groups;
        for (group, value) in out.iter_mut().enumerate() {
            let discounts = &self.discounts[(at + group) * self.groups..][..self.groups];
            *value = self.gains[at + group] + dot(discounts, behind);
        }
    }

    /// Group in which the camera stands after the scan.
    pub(crate) fn group(&self) -> usize {
        self.group
    }
}

#[cfg(test)]
mod tests;
