//! Models and oracles for the tests of several rooms.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::model::{ModelSpec, SortingModel};

/// Property tests draw the same cases on every machine.
pub(crate) fn seeded(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(2019),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// The paper's model, with another penalty.
pub(crate) fn paper(r_min: f64) -> SortingModel {
    let text = include_str!("../../../tests/fixtures/paper.json");
    let mut spec = ModelSpec::from_json(text).expect("the fixture is a model file");
    spec.r_min = r_min;
    SortingModel::new(spec).expect("the fixture is a model")
}

/// A model of given numbers of positions, viewpoints and classes from weights in (0, 1).
pub(crate) fn from_weights(h: usize, k: usize, l: usize, weights: &[f64]) -> ModelSpec {
    let mut weights = weights.iter().copied();
    let mut row = || -> Vec<f64> {
        let row: Vec<f64> = weights.by_ref().take(l).collect();
        let sum: f64 = row.iter().sum();
        row.iter().map(|w| w / sum).collect()
    };
    let p_obs = (0..h).map(|_| (0..k).map(|_| (0..l).map(|_| row()).collect()).collect()).collect();
    let names = |prefix: &str, n: usize| (0..n).map(|i| format!("{prefix}{i}")).collect();
    ModelSpec::new(names("c", l), names("p", k), p_obs)
}

/// Small random models: 1 or 2 positions and viewpoints, 2 or 3 classes, tables without zeros.
pub(crate) fn small_models() -> impl Strategy<Value = ModelSpec> {
    (1..=2_usize, 1..=2_usize, 2..=3_usize).prop_flat_map(|(h, k, l)| {
        prop::collection::vec(0.02..1.0_f64, h * k * l * l)
            .prop_map(move |weights| from_weights(h, k, l, &weights))
    })
}
