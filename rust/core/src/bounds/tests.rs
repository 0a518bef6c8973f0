use proptest::prelude::*;

use super::*;
use crate::belief::Belief;
use crate::testing::{seeded, small_models};

const DEPTH: usize = 5;
const DISCOUNT: f64 = 0.5;

/// Bounds of V* by complete enumeration to [`DEPTH`] steps, with what any policy can earn at most or least behind.
fn exact(model: &SortingModel, belief: &Belief, viewpoint: usize, depth: usize) -> (f64, f64) {
    if depth == DEPTH {
        let step = model.spec().r_max.max(model.spec().r_min) + 1.0;
        return (-step / (1.0 - model.discount()), model.spec().r_max / (1.0 - model.discount()));
    }
    let discounted = |(low, high): (f64, f64)| (model.discount() * low, model.discount() * high);
    let mut after = belief.clone();
    after.advance(model);
    let next = discounted(exact(model, &after, viewpoint, depth + 1));
    let reward = model.decision_reward(belief.most_likely(0).1);
    let mut best = (reward + next.0, reward + next.1);
    for &to in model.legal_moves(viewpoint) {
        let mut value = (-model.motion_cost(viewpoint, to), -model.motion_cost(viewpoint, to));
        for labels in all_labels(model) {
            let mut posterior = belief.clone();
            let p = probability(model, belief, to, &labels);
            let seen: Vec<_> = labels.iter().map(|z| Some(*z)).collect();
            posterior.observe(model, to, &seen).unwrap();
            let next = discounted(exact(model, &posterior, to, depth + 1));
            value = (value.0 + p * next.0, value.1 + p * next.1);
        }
        best = (best.0.max(value.0), best.1.max(value.1));
    }
    best
}

fn all_labels(model: &SortingModel) -> Vec<Vec<usize>> {
    let l = model.class_count();
    match model.position_count() {
        1 => (0..l).map(|z| vec![z]).collect(),
        _ => (0..l * l).map(|z| vec![z / l, z % l]).collect(),
    }
}

fn probability(model: &SortingModel, belief: &Belief, viewpoint: usize, labels: &[usize]) -> f64 {
    let predicted = belief.label_probabilities(model, viewpoint).unwrap();
    labels.iter().enumerate().map(|(j, z)| predicted[(*z, j)]).product()
}

proptest! {
    #![proptest_config(seeded(12))]

    #[test]
    fn bounds_at_exact_beliefs_bracket_the_exact_value(
        spec in small_models(),
        weights in prop::collection::vec(0.02..1.0_f64, 6),
        restricted in any::<bool>(),
    ) {
        let mut spec = spec;
        (spec.discount, spec.r_min) = (DISCOUNT, 20.0);
        if restricted && spec.viewpoints.len() == 2 {
            spec.travel = Some(vec![vec![1], vec![0, 1]]);
        }
        let model = SortingModel::new(spec).unwrap();
        let l = model.class_count();
        let rows: Vec<Vec<f64>> = weights
            .chunks(l)
            .take(model.position_count())
            .map(|row| row.iter().map(|w| w / row.iter().sum::<f64>()).collect())
            .collect();
        let belief = Belief::from_rows(&model, &rows).unwrap();
        let policy = OneObjectPolicy::solve(&model);
        let (at_least, at_most) = exact(&model, &belief, 0, 0);
        let (low, high) = (
            lower(&model, &policy, belief.as_slice(), 0),
            upper(&model, belief.as_slice(), 0),
        );
        prop_assert!(low <= at_most + 1e-9, "lower bound {low} above V* <= {at_most}");
        prop_assert!(high >= at_least - 1e-9, "upper bound {high} below V* >= {at_least}");
    }

    #[test]
    fn a_look_taken_apart_sums_up_to_the_whole(spec in small_models()) {
        let model = SortingModel::new(spec).unwrap();
        let policy = OneObjectPolicy::solve(&model);
        let belief = Belief::new(&model);
        let look = Look::new(&model, &policy, belief.as_slice(), 0);
        let labels = all_labels(&model);
        let mass: f64 = labels.iter().map(|z| look.probability(z)).sum();
        let value: f64 = labels.iter().map(|z| look.probability(z) * look.value_after(z)).sum();
        prop_assert!((mass - 1.0).abs() < 1e-12);
        prop_assert!((value - look.value()).abs() < 1e-9 * (1.0 + value.abs()));
        for z in labels {
            let mut posterior = belief.clone();
            let seen: Vec<_> = z.iter().map(|z| Some(*z)).collect();
            posterior.observe(&model, 0, &seen).unwrap();
            for (a, b) in look.posterior(&z).iter().zip(posterior.as_slice()) {
                prop_assert!((a - b).abs() < 1e-12);
            }
            let best = lower(&model, &policy, posterior.as_slice(), 0);
            prop_assert!(look.value_after(&z) <= best + 1e-9, "plans chosen later are no worse");
        }
    }
}
