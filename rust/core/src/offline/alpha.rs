//! Values of policies that can be executed, as vectors over the joint kinds of all visible objects.
//!
//! Joint kind `n^1 + N n^2 + ...`. Following the best of the policies is worth the largest product with the joint
//! belief, so that is a lower bound of V* at every belief.

use crate::model::SortingModel;
use crate::one_object::OneObjectPolicy;
use nalgebra::{DMatrix, DVector};

/// A row per policy.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AlphaVectors(pub DMatrix<f64>);

impl AlphaVectors {
    /// Value of the best policy at a belief, one distribution per position.
    pub(super) fn value(&self, model: &SortingModel, belief: &[f64]) -> f64 {
        (&self.0 * joint(model, belief)).max()
    }

    /// The one-object policy's plans for the objects of each belief, one after the other.
    pub(super) fn chained(model: &SortingModel, policy: &OneObjectPolicy, beliefs: &[Vec<f64>]) -> Self {
        let rows: Vec<_> = beliefs.iter().map(|b| chain_values(model, policy, b).transpose()).collect();
        Self(DMatrix::from_rows(&rows))
    }
}

/// Value of executing one plan per visible object, by joint kind: from the last position to the first, `G(n)` plus
/// `D(n)` times what follows.
fn chain_values(model: &SortingModel, policy: &OneObjectPolicy, belief: &[f64]) -> DVector<f64> {
    let end = DVector::from_element(1, policy.arrival_values()[0]);
    policy.chain(model, belief).iter().rev().fold(end, |after, (gain, discount)| {
        let l = gain.len();
        DVector::from_fn(l * after.len(), |i, _| gain[i % l] + discount[i % l] * after[i / l])
    })
}

/// The product of the positions' distributions.
pub(super) fn joint(model: &SortingModel, belief: &[f64]) -> DVector<f64> {
    let positions = belief.chunks_exact(model.kind_count());
    positions.fold(DVector::from_element(1, 1.0), |joint, position| {
        let size = joint.len();
        DVector::from_fn(size * position.len(), |i, _| joint[i % size] * position[i / size])
    })
}

/// Number of joint kinds of all visible objects.
pub(super) fn joint_kinds(model: &SortingModel) -> usize {
    model.kind_count().pow(u32::try_from(model.position_count()).unwrap_or(u32::MAX))
}
