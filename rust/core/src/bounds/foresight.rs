//! What the default policy makes of a scan: one plan per label of every position.
//!
//! Positions are independent, so `H * L` entries describe all `L^H` outcomes.

use super::look::{Look, value};
use crate::index::Viewpoint;
use crate::one_object::{OneObjectPolicy, dot};
use crate::remaining::Remaining;

/// The plans chosen, each for what is expected of the objects behind its own. The buffers are reused.
#[derive(Debug, Default)]
pub(crate) struct Foresight {
    classes: usize,
    groups: usize,
    group: usize,
    /// `P(z | b, v)`: entry `j * L + z`.
    probabilities: Vec<f64>,
    /// What is left to learn after each label, where learning is rewarded.
    entropies: Vec<f64>,
    /// `G` and `D_s` of the plan for position j after label z if its turn starts in group g: `(j * L + z) * G + g`.
    plans: Vec<f64>,
    /// Expected value of position j and what follows, per group: `j * G + g`, behind the last the arrival values.
    expected: Vec<f64>,
}

impl Foresight {
    /// Choose plans for the looks that a scan from `viewpoint` takes, the belt end's first.
    #[inline(always)]
    pub(crate) fn take<'a>(
        &mut self,
        policy: &OneObjectPolicy,
        looks: impl DoubleEndedIterator<Item = &'a Look> + Clone,
        viewpoint: Viewpoint,
        unseen: Remaining,
    ) {
        (self.groups, self.group) = (policy.group_count(), policy.group(viewpoint));
        self.probabilities.clear();
        self.entropies.clear();
        for look in looks.clone() {
            self.classes = look.probabilities().len();
            self.probabilities.extend(look.probabilities());
            self.entropies.extend(look.entropies());
        }
        let outcomes = self.probabilities.len();
        self.plans.resize(outcomes * self.groups * (1 + self.groups), 0.0);
        self.expected.clear();
        self.expected.resize(outcomes / self.classes * self.groups, 0.0);
        self.expected.extend(policy.values_of_unseen(unseen));
        for (back, look) in looks.rev().enumerate() {
            let position = outcomes / self.classes - 1 - back;
            for label in 0..self.classes {
                for group in 0..self.groups {
                    self.choose(look, position, label, group);
                }
            }
        }
    }

    /// The best plan after one label (the first among equals) for what is expected behind.
    #[inline(always)]
    fn choose(&mut self, look: &Look, position: usize, label: usize, group: usize) {
        let at = position * self.classes + label;
        let (here, behind) = self.expected.split_at_mut((position + 1) * self.groups);
        if let Some((plan, value)) = look.best(label, group, &behind[..self.groups]) {
            let length = 1 + self.groups;
            self.plans[(at * self.groups + group) * length..][..length].copy_from_slice(plan);
            here[position * self.groups + group] += self.probabilities[at] * value;
        }
    }

    /// Expected value of following those plans, over all labels: a lower bound of the value after the scan.
    pub(crate) fn value(&self) -> f64 {
        self.expected[self.group]
    }

    /// Value of the objects that have still to arrive, per group.
    #[cfg(test)]
    pub(super) fn unseen(&self) -> &[f64] {
        &self.expected[self.expected.len() - self.groups..]
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

    /// Value, per group, of position j after its label, when `behind` is that of the positions behind it.
    #[inline(always)]
    pub(crate) fn value_from(&self, position: usize, label: usize, behind: &[f64], out: &mut [f64]) {
        let length = 1 + self.groups;
        let plans = &self.plans[(position * self.classes + label) * self.groups * length..];
        for (value_here, plan) in out.iter_mut().zip(plans.chunks_exact(length)).take(self.groups) {
            *value_here = value(plan, behind);
        }
    }

    /// Group in which the camera stands after the scan.
    pub(crate) fn group(&self) -> usize {
        self.group
    }
}
