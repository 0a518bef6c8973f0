use proptest::prelude::*;

use super::*;
use crate::belief::Belief;
use crate::index::Label;
use crate::testing::{
    Exact, all_labels, belief_of, belts, enumerable_models, enumerated_value, seeded, small_models,
    tiny_beliefs, tiny_models,
};

impl Foresight {
    /// Value of following the chosen plans after the given labels, one per position.
    pub(crate) fn value_after(&self, labels: &[Label]) -> f64 {
        let mut behind = self.unseen().to_vec();
        for (j, z) in labels.iter().enumerate().rev() {
            let mut here = behind.clone();
            self.value_from(j, z.0, &behind, &mut here);
            behind = here;
        }
        behind[self.group()]
    }
}

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

    #[test]
    fn a_look_taken_apart_sums_up_to_the_whole(spec in small_models(), remaining in belts()) {
        let model = SortingModel::new(spec).unwrap();
        let policy = OneObjectPolicy::solve(&model);
        let belief = Belief::new(&model).with_remaining(remaining);
        let looks = looks(&model, &policy, &belief, Viewpoint(0));
        let mut scan = Foresight::default();
        scan.take(&policy, looks.iter(), Viewpoint(0), belief.horizon().unseen(model.position_count()));
        let labels = all_labels(&model, looks.len());
        let probability = |z: &Vec<Label>| -> f64 {
            z.iter().enumerate().map(|(j, z)| scan.probability(j, z.0)).product()
        };
        let mass: f64 = labels.iter().map(probability).sum();
        let value: f64 = labels.iter().map(|z| probability(z) * scan.value_after(z)).sum();
        prop_assert!((mass - 1.0).abs() < 1e-12);
        prop_assert!((value - scan.value()).abs() < 1e-9 * (1.0 + value.abs()));
        for z in labels {
            let mut posterior = belief.clone();
            let mut seen: Vec<_> = z.iter().map(|z| Some(*z)).collect();
            seen.resize(model.position_count(), None);
            posterior.observe(&model, Viewpoint(0), &seen).unwrap();
            let taken_apart = z.iter().enumerate().flat_map(|(j, z)| looks[j].posterior(z.0));
            for (a, b) in taken_apart.zip(posterior.as_slice()) {
                prop_assert!((a - b).abs() < 1e-12);
            }
            let best = lower(&model, &policy, posterior.known(), Viewpoint(0));
            prop_assert!(scan.value_after(&z) <= best + 1e-9, "plans chosen later are no worse");
        }
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
