//! Laws of kinds, labels and bins: the same problem written down in another way has the same value.

use proptest::prelude::*;

use super::*;
use crate::belief::Belief;
use crate::testing::{
    belief_of, belts, enumerated_value, models_in_full, models_of_kinds, seeded, small_models,
};

const DEPTH: usize = 3;

/// Bounds of V* by enumeration, at the arrival prior and at a belief about classes.
fn values(spec: &ModelSpec, weights: &[f64], remaining: Option<usize>) -> Vec<(f64, f64)> {
    let model = SortingModel::new(spec.clone()).unwrap();
    let beliefs = [Belief::new(&model), belief_of(&model, weights)];
    let value =
        |belief: Belief| enumerated_value(&model, &belief.with_remaining(remaining), Viewpoint(0), DEPTH);
    beliefs.map(value).to_vec()
}

fn equal(one: &[(f64, f64)], other: &[(f64, f64)]) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * (1.0 + a.abs());
    one.iter().zip(other).all(|(a, b)| near(a.0, b.0) && near(a.1, b.1))
}

/// Every table of a model, changed.
fn with_tables(spec: &ModelSpec, change: impl Fn(&[Vec<f64>]) -> Vec<Vec<f64>>) -> ModelSpec {
    let mut changed = spec.clone();
    for table in changed.p_obs.iter_mut().flatten() {
        *table = change(table);
    }
    changed
}

proptest! {
    #![proptest_config(seeded(16))]

    #[test]
    fn modes_that_look_alike_are_one(
        spec in prop_oneof![small_models(), models_in_full()],
        weights in prop::collection::vec(0.02..1.0_f64, 6),
        share in 0.1..0.9_f64,
        remaining in belts(),
    ) {
        prop_assume!(spec.modes.is_none());
        let mut twice = with_tables(&spec, |rows| rows.iter().flat_map(|row| [row.clone(), row.clone()]).collect());
        twice.modes = Some(vec![vec![share, 1.0 - share]; spec.classes.len()]);
        prop_assert!(equal(&values(&spec, &weights, remaining), &values(&twice, &weights, remaining)));
    }

    #[test]
    fn a_label_in_two_that_tell_the_same_is_one(
        spec in prop_oneof![small_models(), models_of_kinds()],
        weights in prop::collection::vec(0.02..1.0_f64, 6),
        share in 0.1..0.9_f64,
        remaining in belts(),
    ) {
        let split = |row: &Vec<f64>| [&row[1..], &[row[0] * share, row[0] * (1.0 - share)]].concat();
        let mut longer = with_tables(&spec, |rows| rows.iter().map(split).collect());
        let labels = longer.p_obs[0][0][0].len();
        longer.labels = Some((0..labels).map(|z| format!("z{z}")).collect());
        prop_assert!(equal(&values(&spec, &weights, remaining), &values(&longer, &weights, remaining)));
    }

    /// Two classes that look alike and belong into one bin are one class.
    #[test]
    fn classes_that_share_looks_and_bin_are_one(
        spec in small_models(),
        weights in prop::collection::vec(0.02..1.0_f64, 6),
        share in 0.1..0.9_f64,
        remaining in belts(),
    ) {
        let l = spec.classes.len();
        let doubled = |rows: &[Vec<f64>]| [rows, &rows[..1]].concat();
        let mut more = with_tables(&spec, doubled);
        more.classes.push("another".into());
        (more.labels, more.bins) = (Some(spec.classes.clone()), Some(spec.classes.clone()));
        let right = |bin: usize, class: usize| if class % l == bin { spec.r_max } else { -spec.r_min };
        more.reward = Some((0..l).map(|bin| (0..=l).map(|class| right(bin, class)).collect()).collect());
        let mut arrival = vec![1.0 / l as f64; l];
        arrival.push(arrival[0] * (1.0 - share));
        arrival[0] *= share;
        more.arrival = Some(arrival);
        let rows: Vec<f64> = weights
            .chunks(l)
            .flat_map(|row| [&[row[0] * share][..], &row[1..], &[row[0] * (1.0 - share)]].concat())
            .collect();
        prop_assert!(equal(&values(&spec, &weights, remaining), &values(&more, &rows, remaining)));
    }

    /// Rewards that are written out are the paper's.
    #[test]
    fn rewards_may_be_written_out(
        spec in models_in_full(),
        weights in prop::collection::vec(0.02..1.0_f64, 6),
        remaining in belts(),
    ) {
        prop_assume!(spec.reward.is_none());
        let l = spec.classes.len();
        let right = |bin: usize, class: usize| if class == bin { spec.r_max } else { -spec.r_min };
        let mut written = spec.clone();
        written.reward = Some((0..l).map(|bin| (0..l).map(|class| right(bin, class)).collect()).collect());
        prop_assert!(equal(&values(&spec, &weights, remaining), &values(&written, &weights, remaining)));
    }

    #[test]
    fn a_model_file_holds_everything(spec in models_in_full()) {
        prop_assert_eq!(ModelSpec::from_json(&spec.to_json().unwrap()).unwrap(), spec);
    }
}

#[test]
fn a_file_with_both_kinds_of_rewards_is_refused() {
    let text = r#"{"classes": ["a", "b"], "viewpoints": ["p"], "p_obs": [[[[0.9, 0.1], [0.2, 0.8]]]],
                   "reward": [[1, -1], [-1, 1]], "r_min": 5}"#;
    let error = ModelSpec::from_json(text).unwrap_err().to_string();
    assert!(error.contains("reward and r_min"), "{error}");
}
