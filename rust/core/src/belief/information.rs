//! What a scan is expected to tell.

use std::ops::Range;

use super::{Belief, evidence, joint};
use crate::index::{Position, Viewpoint};
use crate::model::{Look, SortingModel};

/// Mutual information of class and label, in nats: `sum_cz b_c P(z|c) ln(P(z|c) / P(z))`, given the distribution of the
/// kind.
///
/// That is the entropy of the class less its expectation after the look. What a look tells of the mode alone counts
/// nothing.
pub(crate) fn information(model: &SortingModel, distribution: &[f64], look: Look) -> f64 {
    if model.has_modes() {
        return information_about(
            model,
            distribution,
            look,
            model.classes().map(|class| model.kinds_of(class)),
        );
    }
    let of_label = |label| {
        let likelihoods = model.likelihoods(look, label);
        let predicted = evidence(distribution, likelihoods.clone());
        let joint = distribution.iter().zip(likelihoods).filter(|(b, p)| **b > 0.0 && *p > 0.0);
        joint.map(|(b, p)| b * p * (p / predicted).ln()).sum::<f64>()
    };
    model.labels().map(of_label).sum()
}

/// The same about groups of kinds: `sum_gz P(g, z) ln(P(g, z) / (P(g) P(z)))`.
fn information_about(
    model: &SortingModel,
    distribution: &[f64],
    look: Look,
    groups: impl Iterator<Item = Range<usize>> + Clone,
) -> f64 {
    let of_label = |label| {
        let joint: Vec<f64> = joint(distribution, model.likelihoods(look, label)).collect();
        let predicted: f64 = joint.iter().sum();
        let of_group = |group: Range<usize>| {
            let (both, alone) =
                (joint[group.clone()].iter().sum::<f64>(), distribution[group].iter().sum::<f64>());
            if both > 0.0 { both * (both / (alone * predicted)).ln() } else { 0.0 }
        };
        groups.clone().map(of_group).sum::<f64>()
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
