//! Bounds of the value at an exact belief, and what a scan is worth before its labels are told apart.

mod foresight;
mod look;

use crate::belief::most_likely;
use crate::model::SortingModel;
use crate::one_object::OneObjectPolicy;

pub(crate) use foresight::Foresight;
pub(crate) use look::{Look, Sighting, looks};

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
    upper_knowing(model, viewpoint)(most_likely(&belief[..model.class_count()]).1)
}

/// The same where the most likely class at the belt end has probability `p_right`.
#[inline(always)]
pub(crate) fn upper_knowing(model: &SortingModel, viewpoint: usize) -> impl Fn(f64) -> f64 + '_ {
    let all_right = (model.spec().r_max + most_bonus(model)) / (1.0 - model.discount());
    let moves = model.legal_moves(viewpoint).iter();
    let cheapest = moves.map(|&to| model.motion_cost(viewpoint, to)).fold(f64::INFINITY, f64::min);
    let later = most_bonus(model) + model.discount() * all_right;
    move |p_right| model.decision_reward(p_right).max(-cheapest) + later
}

/// The largest bonus of a scan: all entropy of all positions.
fn most_bonus(model: &SortingModel) -> f64 {
    let entropy = model.position_count() as f64 * (model.class_count() as f64).ln();
    model.spec().information_gain * entropy
}

#[cfg(test)]
mod tests;
