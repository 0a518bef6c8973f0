use proptest::prelude::*;

use super::*;
use crate::model::ScalarOrMatrix;
use crate::policy::{OneObject, Threshold};
use crate::testing::{models_in_full, paper, seeded};

fn config(batches: usize) -> EvaluationConfig {
    EvaluationConfig { batches, batch_size: 5, seed: 1, max_looks: 8, ..EvaluationConfig::default() }
}

/// Mean of the differences in units of its standard error.
fn deviation(a: &[f64], b: &[f64]) -> f64 {
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let statistics = Statistics::of(&difference);
    statistics.mean / statistics.standard_error
}

proptest! {
    #![proptest_config(seeded(12))]

    /// Only if labels are drawn as the belief expects them is a decision right as often as the belief says.
    #[test]
    fn beliefs_are_calibrated(spec in models_in_full()) {
        let model = SortingModel::new(spec).unwrap();
        let policy = Threshold::new(&model, 0.9, None).unwrap();
        let result = evaluate(&model, &model, &policy, &config(1000)).unwrap();
        let off = deviation(&result.expected_discounted_returns, &result.discounted_returns);
        prop_assert!(off.abs() < 4.0, "{off} standard errors");
    }
}

#[test]
fn who_takes_repeats_for_new_evidence_grows_overconfident() {
    let model = paper(50.0);
    let mut spec = model.spec().clone();
    spec.repeat = Some(ScalarOrMatrix::Scalar(0.8));
    let truth = SortingModel::new(spec).unwrap();
    let right = |believed: &SortingModel| {
        let policy = Threshold::new(believed, 0.94, None).unwrap();
        let result = evaluate(believed, &truth, &policy, &EvaluationConfig { max_looks: 200, ..config(400) });
        Statistics::of(&result.unwrap().correct.iter().map(|n| *n as f64 / 5.0).collect::<Vec<_>>()).mean
    };
    assert!(right(&truth) > 0.94);
    assert!(right(&model) < 0.85);
}

/// The last objects are worth a longer look: nothing waits behind them.
#[test]
fn it_pays_to_know_that_the_belt_ends() {
    let model = paper(5.0);
    let policy = OneObject::new(&model);
    let returns = |belt_ends| {
        let config = EvaluationConfig { belt_ends, ..config(300) };
        evaluate(&model, &model, &policy, &config).unwrap().expected_discounted_returns
    };
    let gain = deviation(&returns(true), &returns(false));
    assert!(gain > 5.0, "{gain} standard errors");
}
