//! What a scan is expected to tell.

use super::{Belief, evidence};
use crate::index::{Position, Viewpoint};
use crate::model::{Look, SortingModel};

/// Mutual information of class and label, in nats: `sum_cz b_c P(z|c) ln(P(z|c) / P(z))`.
///
/// That is the entropy of `distribution` less its expectation after the look.
pub(crate) fn information(model: &SortingModel, distribution: &[f64], look: Look) -> f64 {
    let of_label = |label| {
        let likelihoods = model.likelihoods(look, label);
        let predicted = evidence(distribution, likelihoods.clone());
        let joint = distribution.iter().zip(likelihoods).filter(|(b, p)| **b > 0.0 && *p > 0.0);
        joint.map(|(b, p)| b * p * (p / predicted).ln()).sum::<f64>()
    };
    model.labels().map(of_label).sum()
}

/// Entropy of a distribution, in nats.
pub(crate) fn entropy(distribution: &[f64]) -> f64 {
    distribution.iter().filter(|p| **p > 0.0).map(|p| -p * p.ln()).sum()
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
