//! One look at one object, taken apart: every label with its probability, its posterior, and what the default policy
//! makes of it. Nothing here depends on other objects.

use crate::belief::{Belief, condition, entropy, information, most_likely};
use crate::index::{Class, Label, Viewpoint};
pub(crate) use crate::model::Look as Sighting;
use crate::model::SortingModel;
use crate::one_object::{OneObjectPolicy, Turn, Weighed};

/// What a look may tell. The buffers are reused.
#[derive(Debug, Default)]
pub(crate) struct Look {
    classes: usize,
    groups: usize,
    /// Entry z.
    probabilities: Vec<f64>,
    /// Entry `z * L + c`.
    posteriors: Vec<f64>,
    /// The most likely class after each label, and its probability.
    most_likely: Vec<(Class, f64)>,
    /// What is left to learn after each label, where learning is rewarded, and 0 elsewhere.
    entropies: Vec<f64>,
    /// What the look is expected to tell, where learning is rewarded.
    information: f64,
    /// The plans that may be best after each label from each group: `G`, then `D_s`.
    plans: Vec<f64>,
    /// Where the plans of label z and group g end: entry `z * G + g`.
    ends: Vec<usize>,
}

impl Look {
    /// Take apart a look at an object with this distribution; `known` tells after which label of which look the same
    /// is known of the object as after one of these.
    pub(crate) fn take<'a>(
        &mut self,
        model: &SortingModel,
        policy: &OneObjectPolicy,
        distribution: &[f64],
        (sighting, ends): (Sighting, bool),
        weighed: &mut Weighed,
        known: impl Fn(usize) -> Option<(&'a Self, usize)>,
    ) {
        self.clear(model, policy);
        let rewarded = model.spec().information_gain > 0.0;
        let told = || information(model, distribution, sighting);
        self.information = if rewarded { told() } else { 0.0 };
        let behind = model.position_count() - 1 - sighting.position.0;
        for z in 0..self.classes {
            self.outcome(distribution, model.likelihoods(sighting, Label(z)));
            self.entropies.push(if rewarded { entropy(self.posterior(z)) } else { 0.0 });
            let known = known(z);
            for group in 0..self.groups {
                if let Some((look, label)) = known {
                    self.plans.extend(look.plans(label, group));
                } else if self.probabilities[z] > 0.0 {
                    let posterior = &self.posteriors[z * self.classes..];
                    policy.candidates(Turn { group, behind, ends }, posterior, &mut self.plans, weighed);
                }
                self.ends.push(self.plans.len());
            }
        }
    }

    /// Take the distributions at all positions, and behind them that of an unseen object, for posteriors, as if each
    /// were that of a label.
    pub(crate) fn pretend<'a>(
        &mut self,
        model: &SortingModel,
        policy: &OneObjectPolicy,
        distributions: impl Iterator<Item = &'a [f64]>,
        ends: bool,
    ) {
        self.clear(model, policy);
        let mut weighed = Weighed::default();
        for (position, distribution) in distributions.enumerate() {
            self.posteriors.extend(distribution);
            self.most_likely.push(most_likely(distribution));
            let behind = (model.position_count() - 1).saturating_sub(position);
            for group in 0..self.groups {
                let turn = Turn { group, behind, ends };
                policy.candidates(turn, distribution, &mut self.plans, &mut weighed);
                self.ends.push(self.plans.len());
            }
        }
    }

    fn clear(&mut self, model: &SortingModel, policy: &OneObjectPolicy) {
        (self.classes, self.groups) = (model.class_count(), policy.group_count());
        self.probabilities.clear();
        self.posteriors.clear();
        self.most_likely.clear();
        self.entropies.clear();
        self.plans.clear();
        self.ends.clear();
    }

    /// Probability and posterior of the next label.
    fn outcome(&mut self, distribution: &[f64], likelihoods: impl Iterator<Item = f64> + Clone) {
        let first = self.posteriors.len();
        self.posteriors.extend(distribution);
        let posterior = &mut self.posteriors[first..];
        self.probabilities.push(condition(posterior, likelihoods));
        self.most_likely.push(most_likely(posterior));
    }

    /// `P(z | b, v)` of every label.
    #[inline(always)]
    pub(crate) fn probabilities(&self) -> &[f64] {
        &self.probabilities
    }

    /// The posterior after a label.
    #[inline(always)]
    pub(crate) fn posterior(&self, label: usize) -> &[f64] {
        &self.posteriors[label * self.classes..][..self.classes]
    }

    /// The most likely class after a label, and its probability.
    #[inline(always)]
    pub(crate) fn most_likely(&self, label: usize) -> (Class, f64) {
        self.most_likely[label]
    }

    /// What is left to learn after each label, where learning is rewarded.
    #[inline(always)]
    pub(crate) fn entropies(&self) -> &[f64] {
        &self.entropies
    }

    /// What the look is expected to tell, where learning is rewarded.
    #[inline(always)]
    pub(crate) fn information(&self) -> f64 {
        self.information
    }

    /// The best plan after a label from a group (the first among equals) when `behind` follows, and its value; none
    /// for a label of probability 0.
    #[inline(always)]
    pub(crate) fn best(&self, label: usize, group: usize, behind: &[f64]) -> Option<(&[f64], f64)> {
        let mut best = (f64::NEG_INFINITY, None);
        for plan in self.plans(label, group).chunks_exact(1 + self.groups) {
            let value = value(plan, behind);
            if value > best.0 {
                best = (value, Some(plan));
            }
        }
        best.1.map(|plan| (plan, best.0))
    }

    /// The plans that may be best after a label from a group, each its `G` and `D_s` at the posterior.
    #[inline(always)]
    fn plans(&self, label: usize, group: usize) -> &[f64] {
        let at = label * self.groups + group;
        let first = if at == 0 { 0 } else { self.ends[at - 1] };
        &self.plans[first..self.ends[at]]
    }
}

/// Value of a plan, given its `G` and `D_s`, when `behind` follows.
#[inline(always)]
pub(super) fn value(plan: &[f64], behind: &[f64]) -> f64 {
    plan[1..].iter().zip(behind).fold(plan[0], |value, (discount, w)| value + w * discount)
}

/// A look from one viewpoint at every object that is left at a position.
pub(crate) fn looks(
    model: &SortingModel,
    policy: &OneObjectPolicy,
    belief: &Belief,
    viewpoint: Viewpoint,
) -> Vec<Look> {
    let ends = belief.horizon().ends();
    let mut weighed = Weighed::default();
    let look = |(position, distribution)| {
        let mut look = Look::default();
        let sighting = belief.look(model, position, viewpoint);
        look.take(model, policy, distribution, (sighting, ends), &mut weighed, |_| None);
        look
    };
    model.positions().zip(belief.visible().chunks_exact(model.class_count())).map(look).collect()
}
