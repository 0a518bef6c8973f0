//! Models and oracles for the tests of several modules.

mod exact;

use std::hash::{BuildHasher, Hasher, RandomState};

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::belief::Belief;
use crate::index::{Label, Position, Viewpoint};
use crate::model::{ModelSpec, ScalarOrMatrix, SortingModel};
pub(crate) use exact::{Exact, tiny_beliefs, tiny_models};

/// Property tests draw the same cases on every machine. `BELTSORT_LAWS=1` (`make laws`) draws ten times as many, from
/// the seed in `PROPTEST_RNG_SEED` or another one each time; a test that fails prints it.
pub(crate) fn seeded(cases: u32) -> ProptestConfig {
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::default() };
    if std::env::var("BELTSORT_LAWS").is_ok_and(|value| value == "1") {
        let seed = match config.rng_seed {
            RngSeed::Fixed(seed) => seed,
            RngSeed::Random => RandomState::new().build_hasher().finish(),
        };
        eprintln!("PROPTEST_RNG_SEED={seed}");
        return ProptestConfig { cases: 10 * cases, rng_seed: RngSeed::Fixed(seed), ..config };
    }
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(2019), ..config }
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

/// The same with everything that goes beyond the paper's model: repeated labels from some viewpoints, a scan after
/// each decision in half of them, and a bonus for information.
pub(crate) fn models_in_full() -> impl Strategy<Value = ModelSpec> {
    let repeats = prop::collection::vec(prop_oneof![Just(0.0), 0.05..0.95_f64], 4);
    (small_models(), repeats, any::<bool>(), 0.1..2.0_f64).prop_map(|(mut spec, repeats, observe, alpha)| {
        let rows = repeats.chunks(2).take(spec.p_obs.len());
        spec.repeat =
            Some(ScalarOrMatrix::Matrix(rows.map(|row| row[..spec.viewpoints.len()].to_vec()).collect()));
        spec.observe_after_decision = observe;
        spec.information_gain = alpha;
        spec
    })
}

/// Small random models that a few steps nearly decide, some with restricted travel.
pub(crate) fn enumerable_models() -> impl Strategy<Value = SortingModel> {
    (small_models(), any::<bool>()).prop_map(|(mut spec, restricted)| {
        (spec.discount, spec.r_min) = (0.5, 20.0);
        if restricted && spec.viewpoints.len() == 2 {
            spec.travel = Some(vec![vec![1], vec![0, 1]]);
        }
        SortingModel::new(spec).expect("random rows are distributions")
    })
}

/// The belief whose rows are these weights, normalised.
pub(crate) fn belief_of(model: &SortingModel, weights: &[f64]) -> Belief {
    let row = |row: &[f64]| row.iter().map(|w| w / row.iter().sum::<f64>()).collect();
    let rows: Vec<Vec<f64>> =
        weights.chunks(model.class_count()).take(model.position_count()).map(row).collect();
    Belief::from_rows(model, &rows).expect("normalised rows are distributions")
}

/// A belt that never ends, or ends after one to three objects.
pub(crate) fn belts() -> impl Strategy<Value = Option<usize>> {
    prop::option::of(1..=3_usize)
}

/// Bounds of V* by complete enumeration of `depth` steps, with what any policy can earn at most or least behind.
pub(crate) fn enumerated_value(
    model: &SortingModel,
    belief: &Belief,
    viewpoint: Viewpoint,
    depth: usize,
) -> (f64, f64) {
    if belief.remaining() == Some(0) {
        return (0.0, 0.0);
    }
    if depth == 0 {
        let spec = model.spec();
        let bonus = spec.information_gain * model.position_count() as f64 * (model.class_count() as f64).ln();
        let worst = -spec.r_max.max(spec.r_min) - 1.0;
        return (worst / (1.0 - model.discount()), (spec.r_max + bonus) / (1.0 - model.discount()));
    }
    let after = |reward: f64, (low, high): (f64, f64)| {
        (reward + model.discount() * low, reward + model.discount() * high)
    };
    let mut advanced = belief.clone();
    advanced.advance(model);
    let reward = model.decision_reward(belief.most_likely(Position(0)).1);
    let mut best = if model.observes_after_decision() {
        let reward = reward + advanced.bonus(model, viewpoint);
        after(reward, value_of_scan(model, &advanced, viewpoint, depth - 1))
    } else {
        after(reward, enumerated_value(model, &advanced, viewpoint, depth - 1))
    };
    for &to in model.legal_moves(viewpoint) {
        let reward = belief.bonus(model, to) - model.motion_cost(viewpoint, to);
        let value = after(reward, value_of_scan(model, belief, to, depth - 1));
        best = (best.0.max(value.0), best.1.max(value.1));
    }
    best
}

/// Expectation of [`enumerated_value`] over the labels of a scan.
fn value_of_scan(model: &SortingModel, belief: &Belief, viewpoint: Viewpoint, depth: usize) -> (f64, f64) {
    all_labels(model, model.position_count()).iter().fold((0.0, 0.0), |value, labels| {
        let p = probability(model, belief, viewpoint, labels);
        let mut posterior = belief.clone();
        let seen: Vec<_> = labels.iter().map(|z| Some(*z)).collect();
        posterior.observe(model, viewpoint, &seen).unwrap();
        let next = enumerated_value(model, &posterior, viewpoint, depth);
        (value.0 + p * next.0, value.1 + p * next.1)
    })
}

/// Every label vector of a scan of one or two objects.
pub(crate) fn all_labels(model: &SortingModel, objects: usize) -> Vec<Vec<Label>> {
    let pairs = |a| model.labels().map(move |b| vec![a, b]);
    match objects {
        1 => model.labels().map(|z| vec![z]).collect(),
        _ => model.labels().flat_map(pairs).collect(),
    }
}

/// Probability of a label vector.
pub(crate) fn probability(
    model: &SortingModel,
    belief: &Belief,
    viewpoint: Viewpoint,
    labels: &[Label],
) -> f64 {
    let predicted = belief.label_probabilities(model, viewpoint).unwrap();
    labels.iter().enumerate().map(|(j, z)| predicted[(z.0, j)]).product()
}
