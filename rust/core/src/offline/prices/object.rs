//! One object by itself: N hidden states, Z labels of a look, and what deciding on it is worth.

use crate::belief::condition;
use crate::index::{Position, Viewpoint};
use crate::model::SortingModel;
use crate::one_object::dot;

/// What single objects are, whatever camera and belt do.
#[derive(Debug, Clone)]
pub(crate) struct ObjectModel {
    pub discount: f64,
    pub arrival: Vec<f64>,
    viewpoints: usize,
    positions: usize,
    /// Per position and viewpoint the likelihoods `P(z | state)`, entry `z * N + state`.
    likelihoods: Vec<Vec<f64>>,
    /// Worth of each decision for each state.
    rewards: Vec<Vec<f64>>,
}

impl ObjectModel {
    /// The states are the kinds.
    pub(crate) fn new(model: &SortingModel) -> Self {
        let (h, k) = (model.position_count(), model.viewpoint_count());
        // Tables lie column by column.
        let table = |index: usize| model.table(Position(index / k), Viewpoint(index % k)).as_slice().to_vec();
        let reward = |bin| model.kinds().map(|kind| model.reward(bin, kind)).collect();
        Self {
            discount: model.discount(),
            arrival: model.arrival().as_slice().to_vec(),
            viewpoints: k,
            positions: h,
            likelihoods: (0..h * k).map(table).collect(),
            rewards: model.bins().map(reward).collect(),
        }
    }

    pub(crate) fn states(&self) -> usize {
        self.arrival.len()
    }

    pub(crate) fn viewpoints(&self) -> usize {
        self.viewpoints
    }

    pub(crate) fn positions(&self) -> usize {
        self.positions
    }

    /// Worth of the best decision: `max_b sum_c belief(c) R[b, c]`.
    pub(crate) fn reward(&self, belief: &[f64]) -> f64 {
        self.rewards.iter().map(|reward| dot(belief, reward)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Probability and posterior (Bayes' rule, eq. 7) of each label that a look may give.
    pub(crate) fn look<'a>(
        &'a self,
        position: Position,
        viewpoint: Viewpoint,
        belief: &'a [f64],
    ) -> impl Iterator<Item = (f64, Vec<f64>)> + 'a {
        let likelihoods = &self.likelihoods[position.0 * self.viewpoints + viewpoint.0];
        likelihoods.chunks_exact(belief.len()).filter_map(move |likelihood| {
            let mut posterior = belief.to_vec();
            let p = condition(&mut posterior, likelihood.iter().copied());
            (p > 0.0).then_some((p, posterior))
        })
    }
}
