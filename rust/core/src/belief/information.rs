//! What a scan is expected to tell.

use super::{Belief, evidence, joint};
use crate::index::{Kind, Position, Viewpoint};
use crate::model::{Look, SortingModel};

/// Mutual information of class and label, in nats: `sum_cz b_c P(z|c) ln(P(z|c) / P(z))`, given the distribution of the
/// kind.
///
/// That is the entropy of the class less its expectation after the look. What a look tells of the mode alone counts
/// nothing.
pub(crate) fn information(model: &SortingModel, distribution: &[f64], look: Look) -> f64 {
    if model.has_modes() {
        return information_about(model, distribution, look, &Groups::of_classes(model));
    }
    let of_label = |label| {
        let likelihoods = model.likelihoods(look, label);
        let predicted = evidence(distribution, likelihoods.clone());
        let joint = distribution.iter().zip(likelihoods).filter(|(b, p)| **b > 0.0 && *p > 0.0);
        joint.map(|(b, p)| b * p * (p / predicted).ln()).sum::<f64>()
    };
    model.labels().map(of_label).sum()
}

/// Kinds in groups: what is asked about an object is which group its kind belongs to.
#[derive(Debug, Clone)]
pub(crate) struct Groups {
    /// Group of each kind.
    of_kind: Vec<usize>,
    count: usize,
}

impl Groups {
    /// A group for each class.
    pub(crate) fn of_classes(model: &SortingModel) -> Self {
        Self::by(model, |kind| model.class_of(kind).0)
    }

    /// Kinds that the same bins are right for form a group.
    pub(crate) fn of_bins(model: &SortingModel) -> Self {
        let right = |kind| model.bins().map(|bin| model.is_right(bin, kind)).collect::<Vec<_>>();
        let mut groups: Vec<Vec<bool>> = Vec::new();
        Self::by(model, |kind| {
            let of_kind = right(kind);
            groups.iter().position(|group| *group == of_kind).unwrap_or_else(|| {
                groups.push(of_kind);
                groups.len() - 1
            })
        })
    }

    fn by(model: &SortingModel, group: impl FnMut(Kind) -> usize) -> Self {
        let of_kind: Vec<usize> = model.kinds().map(group).collect();
        let count = of_kind.iter().max().map_or(0, |last| last + 1);
        Self { of_kind, count }
    }

    fn sums(&self, of_kinds: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut sums = vec![0.0; self.count];
        for (group, p) in self.of_kind.iter().zip(of_kinds) {
            sums[*group] += p;
        }
        sums
    }
}

/// The same about groups of kinds: `sum_gz P(g, z) ln(P(g, z) / (P(g) P(z)))`.
fn information_about(model: &SortingModel, distribution: &[f64], look: Look, groups: &Groups) -> f64 {
    let alone = groups.sums(distribution.iter().copied());
    let of_label = |label| {
        let together = groups.sums(joint(distribution, model.likelihoods(look, label)));
        let predicted: f64 = together.iter().sum();
        let of_group = |(both, alone): (&f64, &f64)| {
            if *both > 0.0 { both * (both / (alone * predicted)).ln() } else { 0.0 }
        };
        together.iter().zip(&alone).map(of_group).sum::<f64>()
    };
    model.labels().map(of_label).sum()
}

/// Entropy of a distribution, in nats.
fn entropy(distribution: &[f64]) -> f64 {
    distribution.iter().filter(|p| **p > 0.0).map(|p| -p * p.ln()).sum()
}

/// Entropy of the class, in nats, given the distribution of the kind.
pub(crate) fn class_entropy(model: &SortingModel, kinds: &[f64]) -> f64 {
    if model.has_modes() {
        return entropy(&model.class_probabilities(kinds).collect::<Vec<_>>());
    }
    entropy(kinds)
}

impl Belief {
    /// Entropy, in nats, that a scan from `viewpoint` is expected to take from the belief about one position.
    #[must_use]
    pub fn information(&self, model: &SortingModel, position: Position, viewpoint: Viewpoint) -> f64 {
        information(model, self.position(position).as_slice(), self.look(model, position, viewpoint))
    }

    /// The same about groups of kinds, such as those that belong into one bin.
    pub(crate) fn information_about(
        &self,
        model: &SortingModel,
        position: Position,
        viewpoint: Viewpoint,
        groups: &Groups,
    ) -> f64 {
        let look = self.look(model, position, viewpoint);
        information_about(model, self.position(position).as_slice(), look, groups)
    }

    /// The bonus of a scan from `viewpoint`: `alpha` times the entropy that it is expected to take from all objects
    /// that are left to decide.
    #[must_use]
    pub fn bonus(&self, model: &SortingModel, viewpoint: Viewpoint) -> f64 {
        let alpha = model.spec().information_gain;
        if alpha > 0.0 {
            let visible = self.remaining.visible(model.position_count());
            let gain = |j| self.information(model, j, viewpoint);
            return alpha * model.positions().take(visible).map(gain).sum::<f64>();
        }
        0.0
    }
}
