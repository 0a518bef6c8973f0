//! A certified lower bound at the root of the belief graph: the exact value of a policy.
//!
//! The policy takes the action with the highest upper bound while it is inside the graph, and where the graph ends
//! follows the one-object policy. Backups that start below its value approach it from below, so they may stop at any
//! time. For models that [`super::controller`] is not made for.

use super::graph::BeliefGraph;
use super::reach::Reach;
use crate::model::SortingModel;
use crate::one_object::OneObjectPolicy;
use crate::remaining::Remaining;

/// A sweep that raises the root by less than this part of `r_max` is the last.
const TOLERANCE: f64 = 1e-7;

/// Value at the root of the policy that the graph and the one-object policy make up.
pub(super) fn policy_value(
    model: &SortingModel,
    policy: &OneObjectPolicy,
    graph: &BeliefGraph<'_>,
    reach: &Reach,
    stop: impl Fn() -> bool,
) -> f64 {
    let mut values = vec![f64::NEG_INFINITY; graph.size()];
    for node in reach.nodes() {
        let (belief, viewpoint) = graph.belief(node);
        values[node as usize] = policy.value(model, (&belief, Remaining::ENDLESS), viewpoint);
    }
    loop {
        let before = values[0];
        for &node in reach.interior.iter().rev() {
            let Some(followed) = graph.followed(node) else { continue };
            let worth = followed
                .children
                .iter()
                .zip(followed.probabilities)
                .map(|(child, p)| p * values[*child as usize]);
            let value = followed.reward + model.discount() * worth.sum::<f64>();
            values[node as usize] = value.max(values[node as usize]);
        }
        if stop() || values[0] - before < TOLERANCE * model.reward_scale() {
            return values[0];
        }
    }
}
