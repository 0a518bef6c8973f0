//! What a scan may tell, object by object.
//!
//! Given the belief, the labels of different objects are independent: `H * L` entries describe all `L^H` label vectors.

use crate::belief::{Belief, class_entropy, condition, information};
use crate::bounds;
use crate::index::{Label, Position, Viewpoint};
use crate::model::SortingModel;
use crate::one_object::OneObjectPolicy;

/// The labels that a scan from a viewpoint may give, and what the default policy makes of them.
///
/// The default policy executes one conditional plan per object (see [`OneObjectPolicy`]). After a scan it chooses the plan
/// of each object by that object's label, for what it *expects* of the objects behind. So its value after a label
/// vector is a lower bound of V*, and the expectation over all label vectors is a sum over positions.
#[derive(Debug)]
pub(crate) struct ScanOutcomes {
    labels: usize,
    groups: usize,
    /// Viewpoint group in which the camera stands after the scan.
    group: usize,
    /// `P(z | b, v)`: entry `position * L + z`.
    probabilities: Vec<f64>,
    /// Entropy of the posterior after each label where the model rewards information, and 0 elsewhere.
    entropies: Vec<f64>,
    /// `G` and `D_s` of the plan chosen after each label, per group in which its turn comes.
    plans: Vec<f64>,
    /// Expected value of each position and all behind it, per group; the last row is the value of unseen objects.
    expected: Vec<f64>,
    /// Upper bound of V* after each label of the object at the belt end.
    uppers: Vec<f64>,
    /// Bonus for what the scan is expected to tell.
    pub(crate) bonus: f64,
}

impl ScanOutcomes {
    /// The outcomes of a scan from `viewpoint` of the objects that are left at the positions.
    pub(crate) fn new(
        model: &SortingModel,
        policy: &OneObjectPolicy,
        belief: &Belief,
        viewpoint: Viewpoint,
    ) -> Self {
        let (labels, groups) = (model.label_count(), policy.group_count());
        let positions = belief.objects_left().visible(model.position_count());
        let unseen = belief.objects_left().unseen(model.position_count());
        let mut outcomes = Self {
            labels,
            groups,
            group: policy.group(viewpoint),
            probabilities: vec![0.0; positions * labels],
            entropies: vec![0.0; positions * labels],
            plans: vec![0.0; positions * labels * groups * (1 + groups)],
            expected: vec![0.0; positions * groups],
            uppers: vec![0.0; labels],
            bonus: 0.0,
        };
        outcomes.expected.extend(policy.values_of_unseen(unseen));
        let upper = bounds::upper_knowing(model, viewpoint, belief.objects_left());
        let mut posterior = vec![0.0; model.kind_count()];
        for position in (0..positions).rev().map(Position) {
            let prior = belief.position(position);
            let look = belief.look(model, position, viewpoint);
            if model.spec().information_gain > 0.0 {
                let gain = information(model, prior.as_slice(), look);
                outcomes.bonus += model.spec().information_gain * gain;
            }
            for label in model.labels() {
                posterior.copy_from_slice(prior.as_slice());
                let probability = condition(&mut posterior, model.likelihoods(look, label));
                let at = outcomes.index(position, label);
                outcomes.probabilities[at] = probability;
                if probability == 0.0 {
                    continue;
                }
                if model.spec().information_gain > 0.0 {
                    outcomes.entropies[at] = class_entropy(model, &posterior);
                }
                if position == Position(0) {
                    outcomes.uppers[label.0] = upper(model.best_decision(&posterior).1);
                }
                outcomes.choose_plans(policy, &posterior, position, label);
            }
        }
        outcomes
    }

    /// The best plan after one label from each group, given what is expected of the objects behind.
    fn choose_plans(
        &mut self,
        policy: &OneObjectPolicy,
        posterior: &[f64],
        position: Position,
        label: Label,
    ) {
        let (groups, at) = (self.groups, self.index(position, label));
        let (here, behind) = self.expected.split_at_mut((position.0 + 1) * groups);
        let plans = self.plans[at * groups * (1 + groups)..].chunks_exact_mut(1 + groups);
        for (group, chosen) in plans.take(groups).enumerate() {
            let (plan, value) = policy.best(group, posterior, &behind[..groups]);
            chosen[0] = plan.gain_at(posterior);
            for (entry, discount) in chosen[1..].iter_mut().zip(plan.discounts_at(posterior)) {
                *entry = discount;
            }
            here[position.0 * groups + group] += self.probabilities[at] * value;
        }
    }

    fn index(&self, position: Position, label: Label) -> usize {
        position.0 * self.labels + label.0
    }

    /// Number of positions at which objects are left.
    pub(crate) fn positions(&self) -> usize {
        self.probabilities.len() / self.labels
    }

    /// `P(z | b, v)` of every label of one position.
    pub(crate) fn probabilities(&self, position: Position) -> &[f64] {
        &self.probabilities[position.0 * self.labels..][..self.labels]
    }

    /// Entropy of the posterior of one position, where the model rewards information, and 0 elsewhere.
    pub(crate) fn entropy(&self, position: Position, label: Label) -> f64 {
        self.entropies[self.index(position, label)]
    }

    /// The same summed over the positions, expected over all labels.
    pub(crate) fn expected_entropy(&self) -> f64 {
        self.probabilities.iter().zip(&self.entropies).map(|(p, entropy)| p * entropy).sum()
    }

    /// Value of the default policy expected over all labels.
    pub(crate) fn expected_value(&self) -> f64 {
        self.expected[self.group]
    }

    /// Value, per group, of the objects that have still to arrive.
    pub(crate) fn unseen(&self) -> &[f64] {
        &self.expected[self.expected.len() - self.groups..]
    }

    /// Value, per group, of a position after its label and of all behind it, when `behind` is the value of the latter.
    pub(crate) fn value_after(&self, position: Position, label: Label, behind: &[f64]) -> Vec<f64> {
        let plans = &self.plans[self.index(position, label) * self.groups * (1 + self.groups)..];
        let value = |plan: &[f64]| plan[1..].iter().zip(behind).fold(plan[0], |sum, (d, w)| sum + d * w);
        plans.chunks_exact(1 + self.groups).take(self.groups).map(value).collect()
    }

    /// Viewpoint group in which the camera stands after the scan.
    pub(crate) fn group(&self) -> usize {
        self.group
    }

    /// Upper bound of V* after a label of the object at the belt end.
    pub(crate) fn upper(&self, label: Label) -> f64 {
        self.uppers[label.0]
    }

    /// The same expected over its labels.
    pub(crate) fn expected_upper(&self) -> f64 {
        self.probabilities(Position(0)).iter().zip(&self.uppers).map(|(p, upper)| p * upper).sum()
    }
}

#[cfg(test)]
impl ScanOutcomes {
    /// Value of following the chosen plans after the given labels, one per position.
    pub(super) fn default_value(&self, labels: &[Label]) -> f64 {
        let unseen = self.unseen().to_vec();
        let after = |behind: Vec<f64>, (j, z): (usize, &Label)| self.value_after(Position(j), *z, &behind);
        labels.iter().enumerate().rev().fold(unseen, after)[self.group]
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::testing::{all_labels, belts, seeded, small_models};

    proptest! {
        #![proptest_config(seeded(12))]

        #[test]
        fn what_is_expected_is_the_mean_over_all_label_vectors(spec in small_models(), remaining in belts()) {
            let model = SortingModel::new(spec).unwrap();
            let policy = OneObjectPolicy::solve(&model);
            let belief = Belief::new(&model).with_remaining(remaining);
            let scan = ScanOutcomes::new(&model, &policy, &belief, Viewpoint(0));
            let (mut mass, mut value) = (0.0, 0.0);
            for z in all_labels(&model, scan.positions()) {
                let mut posterior = belief.clone();
                let mut seen: Vec<_> = z.iter().map(|z| Some(*z)).collect();
                seen.resize(model.position_count(), None);
                posterior.observe(&model, Viewpoint(0), &seen).unwrap();
                let best = bounds::lower(&model, &policy, posterior.known(), Viewpoint(0));
                prop_assert!(scan.default_value(&z) <= best + 1e-9, "plans chosen later are no worse");
                prop_assert!((scan.upper(z[0]) - bounds::upper(&model, posterior.known(), Viewpoint(0))).abs() < 1e-9);
                let p: f64 = z.iter().enumerate().map(|(j, z)| scan.probabilities(Position(j))[z.0]).product();
                mass += p;
                value += p * scan.default_value(&z);
            }
            prop_assert!((mass - 1.0).abs() < 1e-12);
            prop_assert!((value - scan.expected_value()).abs() < 1e-9 * (1.0 + value.abs()));
        }
    }
}
