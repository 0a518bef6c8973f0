//! Bounds of the value at an exact belief.

use crate::index::Viewpoint;
use crate::model::SortingModel;
use crate::one_object::OneObjectPolicy;
use crate::remaining::Remaining;

/// Lower bound of V*: the value of executing the one-object policy (see [`OneObjectPolicy`]), any bonus left aside.
///
/// For a model that repeats looks it is an estimate only: the plans take labels as independent.
#[inline(always)]
pub(crate) fn lower(
    model: &SortingModel,
    policy: &OneObjectPolicy,
    (belief, remaining): (&[f64], Remaining),
    viewpoint: Viewpoint,
) -> f64 {
    policy.value(model, (belief, remaining), viewpoint)
}

/// Upper bound of V*: from the second step on, every class is known and each step earns the largest reward and bonus.
///
/// Now, the best is to decide on what is known, or to pay for the cheapest move.
pub(crate) fn upper(
    model: &SortingModel,
    (belief, remaining): (&[f64], Remaining),
    viewpoint: Viewpoint,
) -> f64 {
    upper_knowing(model, viewpoint, remaining)(model.best_decision(&belief[..model.kind_count()]).1)
}

/// The same where the best decision is expected to earn `decided`. Nothing follows the last object.
#[inline(always)]
pub(crate) fn upper_knowing(
    model: &SortingModel,
    viewpoint: Viewpoint,
    remaining: Remaining,
) -> impl Fn(f64) -> f64 + '_ {
    let moves = model.legal_moves(viewpoint).iter();
    let cheapest = moves.map(|&to| model.motion_cost(viewpoint, to)).fold(f64::INFINITY, f64::min);
    let bonus = most_bonus(model);
    let known = |remaining: Remaining| model.discount() * all_known(model, remaining, bonus);
    let (after_decision, after_move) = (known(remaining.after(1)), known(remaining) - cheapest);
    move |decided| {
        if remaining.is_over() {
            return 0.0;
        }
        bonus + (decided + after_decision).max(after_move)
    }
}

/// What is earned at most once every class is known, if every scan earns the largest bonus all the same.
fn all_known(model: &SortingModel, remaining: Remaining, bonus: f64) -> f64 {
    if remaining.is_over() {
        return 0.0;
    }
    let endless = 1.0 / (1.0 - model.discount());
    let left = remaining.0.and_then(|objects| i32::try_from(objects).ok());
    let decisions = left.map_or(endless, |objects| (1.0 - model.discount().powi(objects)) * endless);
    model.most_reward() * decisions + bonus * endless
}

/// The largest bonus of a scan: all entropy of all positions.
fn most_bonus(model: &SortingModel) -> f64 {
    let entropy = model.position_count() as f64 * (model.class_count() as f64).ln();
    model.spec().information_gain * entropy
}

#[cfg(test)]
mod tests;
