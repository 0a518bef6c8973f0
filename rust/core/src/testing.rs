//! Models and oracles for the tests of several modules.

mod exact;

use std::hash::{BuildHasher, Hasher, RandomState};

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::belief::Belief;
use crate::index::{Label, Viewpoint};
use crate::model::{ModelSpec, ScalarOrMatrix, SortingModel, Tables};
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
    ModelSpec::new(names("c", l), names("p", k), tables((h, k, l, l), weights))
}

/// Tables of a shape (H, K, N, Z) from weights in (0, 1).
fn tables((h, k, n, z): (usize, usize, usize, usize), weights: &[f64]) -> Tables<f64> {
    let mut weights = weights.iter().copied();
    let mut row = || -> Vec<f64> { normalised(&weights.by_ref().take(z).collect::<Vec<_>>()) };
    (0..h).map(|_| (0..k).map(|_| (0..n).map(|_| row()).collect()).collect()).collect()
}

fn normalised(weights: &[f64]) -> Vec<f64> {
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

fn names(prefix: &str, n: usize) -> Vec<String> {
    (0..n).map(|i| format!("{prefix}{i}")).collect()
}

/// Small random models: 1 or 2 positions and viewpoints, 2 or 3 classes, tables without zeros.
pub(crate) fn small_models() -> impl Strategy<Value = ModelSpec> {
    (1..=2_usize, 1..=2_usize, 2..=3_usize).prop_flat_map(|(h, k, l)| {
        prop::collection::vec(0.02..1.0_f64, h * k * l * l)
            .prop_map(move |weights| from_weights(h, k, l, &weights))
    })
}

/// Small models of two classes of one or two modes each, with two or three labels and bins that are not the classes.
pub(crate) fn models_of_kinds() -> impl Strategy<Value = ModelSpec> {
    let sizes = (1..=2_usize, 1..=2_usize, (1..=2_usize, 1..=2_usize), 2..=3_usize, 2..=3_usize);
    let weights = prop::collection::vec(0.02..1.0_f64, 2 * 2 * 4 * 3);
    let modes = prop::collection::vec(0.1..1.0_f64, 4);
    let rewards = prop::collection::vec(-20.0..10.0_f64, 6);
    (sizes, weights, modes, rewards).prop_map(|((h, k, (a, b), z, bins), weights, modes, mut rewards)| {
        let mut spec = ModelSpec::new(names("c", 2), names("p", k), tables((h, k, a + b, z), &weights));
        (spec.labels, spec.bins) = (Some(names("z", z)), Some(names("b", bins)));
        spec.modes = Some(vec![normalised(&modes[..a]), normalised(&modes[2..2 + b])]);
        (rewards[0], rewards[3]) = (10.0, 10.0);
        spec.reward = Some(rewards.chunks(2).take(bins).map(<[f64]>::to_vec).collect());
        spec
    })
}

/// Everything that goes beyond the paper's model: modes, labels and bins in a third of them, repeated labels from some
/// viewpoints, a scan after each decision in half of them, and a bonus for information.
pub(crate) fn models_in_full() -> impl Strategy<Value = ModelSpec> {
    let repeats = prop::collection::vec(prop_oneof![Just(0.0), 0.05..0.95_f64], 4);
    let models = prop_oneof![2 => small_models(), 1 => models_of_kinds()];
    (models, repeats, any::<bool>(), 0.1..2.0_f64).prop_map(|(mut spec, repeats, observe, alpha)| {
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
    let models = prop_oneof![2 => small_models(), 1 => models_of_kinds()];
    (models, any::<bool>()).prop_map(|(mut spec, restricted)| {
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
        let worst = -model.most_reward().max(-model.least_reward()) - 1.0;
        return (worst / (1.0 - model.discount()), (model.most_reward() + bonus) / (1.0 - model.discount()));
    }
    let after = |reward: f64, (low, high): (f64, f64)| {
        (reward + model.discount() * low, reward + model.discount() * high)
    };
    let mut advanced = belief.clone();
    advanced.advance(model);
    let reward = belief.best_decision(model).1;
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
