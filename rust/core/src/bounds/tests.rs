use proptest::prelude::*;

use super::*;
use crate::belief::Belief;
use crate::testing::{
    Exact, belief_of, belts, enumerable_models, enumerated_value, seeded, tiny_beliefs, tiny_models,
};

proptest! {
    #![proptest_config(seeded(12))]

    #[test]
    fn bounds_at_exact_beliefs_bracket_the_exact_value(
        model in enumerable_models(),
        weights in prop::collection::vec(0.02..1.0_f64, 6),
        remaining in belts(),
    ) {
        let belief = belief_of(&model, &weights).with_remaining(remaining);
        let policy = OneObjectPolicy::solve(&model);
        let (at_least, at_most) = enumerated_value(&model, &belief, Viewpoint(0), 5);
        let (low, high) = (
            lower(&model, &policy, belief.known(), Viewpoint(0)),
            upper(&model, belief.known(), Viewpoint(0)),
        );
        prop_assert!(low <= at_most + 1e-9, "lower bound {low} above V* <= {at_most}");
        prop_assert!(high >= at_least - 1e-9, "upper bound {high} below V* >= {at_least}");
    }
}

proptest! {
    #![proptest_config(seeded(24))]

    #[test]
    fn bounds_bracket_the_value_to_a_millionth(
        tiny in tiny_models(1..=2),
        weights in tiny_beliefs(),
        observe in any::<bool>(),
    ) {
        let tiny = tiny.observing(observe);
        let (model, exact) = (&tiny.model, Exact::new(&tiny));
        let policy = OneObjectPolicy::solve(model);
        for belief in [Belief::new(model), belief_of(model, &weights)] {
            for remaining in [None, Some(1), Some(2), Some(3)] {
                let belief = belief.clone().with_remaining(remaining);
                for (viewpoint, (at_least, at_most)) in model.viewpoints().zip(exact.bounds(&belief)) {
                    let low = lower(model, &policy, belief.known(), viewpoint);
                    let high = upper(model, belief.known(), viewpoint);
                    prop_assert!(low <= at_most + 1e-9, "{belief:?}: {low} above V* = {at_most}");
                    prop_assert!(high >= at_least - 1e-9, "{belief:?}: {high} below V* = {at_least}");
                }
            }
        }
    }

    /// One object at a time is all there is to one position: the policy is as good as its plans are many.
    #[test]
    fn the_one_object_policy_is_nearly_optimal_for_one_position(tiny in tiny_models(1..=1)) {
        let (model, belief) = (&tiny.model, Belief::new(&tiny.model));
        let policy = OneObjectPolicy::solve(model);
        for (viewpoint, (at_least, _)) in model.viewpoints().zip(Exact::new(&tiny).bounds(&belief)) {
            let low = lower(model, &policy, belief.known(), viewpoint);
            prop_assert!(low >= at_least - 1e-2 * model.spec().r_max, "{low} far below V* = {at_least}");
        }
    }
}
