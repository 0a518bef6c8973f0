use proptest::prelude::*;

use super::*;
use crate::belief::most_likely;
use crate::bounds::Look;
use crate::model::{Action, ModelSpec};
use crate::scenario::{ScanPoint, labels};
use crate::testing::{from_weights, paper, seeded, small_models};

/// The optimum of the sampled, regularised problem by plain recursion over its whole tree.
///
/// Shares the scenarios, the posteriors and the default policy with the search, but none of its bounds, its order,
/// or its way to book the labels without a branch: those are enumerated one by one here.
struct BruteForce<'a> {
    despot: &'a Despot,
    scenarios: Scenarios,
}

impl BruteForce<'_> {
    fn optimum(despot: &Despot, belief: &Belief, viewpoint: usize) -> f64 {
        let mut scenarios = Scenarios::sample(belief, despot.config.scenarios, despot.config.seed);
        scenarios.reach(&despot.model, despot.depth);
        let all: Vec<usize> = (0..despot.config.scenarios).collect();
        let default = bounds::lower(&despot.model, &despot.default_policy, belief.as_slice(), viewpoint);
        let at = ScanPoint { depth: 0, decisions: 0, viewpoint };
        BruteForce { despot, scenarios }.value(belief.as_slice(), &all, at, 1.0, default)
    }

    /// Regularised value of a node reached with probability `mass`, in units of the node's own reward.
    fn value(&self, belief: &[f64], scenarios: &[usize], at: ScanPoint, mass: f64, default: f64) -> f64 {
        let Despot { model, default_policy, config, depth, .. } = self.despot;
        if at.depth == *depth {
            return default;
        }
        let price = config.regularization / (mass * model.discount().powi(i32::try_from(at.depth).unwrap()));
        let l = model.class_count();
        let advanced = [&belief[l..], model.arrival().as_slice()].concat();
        let below = ScanPoint { depth: at.depth + 1, decisions: at.decisions + 1, ..at };
        let next_default = bounds::lower(model, default_policy, &advanced, at.viewpoint);
        let mut best = default.max(
            model.decision_reward(most_likely(&belief[..l]).1) - price
                + model.discount() * self.value(&advanced, scenarios, below, mass, next_default),
        );
        for &to in model.legal_moves(at.viewpoint) {
            let look = Look::new(model, default_policy, belief, to);
            let scan = ScanPoint { viewpoint: to, ..at };
            let below = ScanPoint { depth: at.depth + 1, ..scan };
            let mut value = -model.motion_cost(at.viewpoint, to) - price;
            for code in 0..label_vectors(model).unwrap() {
                let z = labels(model, code);
                let p = look.probability(&z);
                let through: Vec<usize> = scenarios
                    .iter()
                    .copied()
                    .filter(|&i| self.scenarios.label_code(model, i, scan) == code)
                    .collect();
                let after = look.value_after(&z);
                let continued = if through.is_empty() {
                    after
                } else {
                    self.value(&look.posterior(&z), &through, below, mass * p, after)
                };
                value += model.discount() * p * continued;
            }
            best = best.max(value);
        }
        best
    }
}

fn config(scenarios: usize, regularization: f64, depth: usize) -> DespotConfig {
    DespotConfig { scenarios, seed: 3, regularization, depth: Some(depth) }
}

proptest! {
    #![proptest_config(seeded(24))]

    #[test]
    fn bounds_bracket_the_sampled_optimum_tighten_and_reach_it(
        spec in small_models(),
        scenarios in 1..6_usize,
        regularized in any::<bool>(),
        restricted in any::<bool>(),
    ) {
        let mut spec = spec;
        spec.r_min = 15.0;
        if restricted && spec.viewpoints.len() == 2 {
            spec.travel = Some(vec![vec![1], vec![]]);
        }
        let model = SortingModel::new(spec).unwrap();
        let lambda = if regularized { 0.3 } else { 0.0 };
        let despot = Despot::new(&model, config(scenarios, lambda, 5)).unwrap();
        let belief = Belief::new(&model);
        let optimum = BruteForce::optimum(&despot, &belief, 0);
        let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
        for trials in [1, 2, 5, 20, 100, 100_000] {
            let plan = despot.plan(&belief, 0, Budget::Trials(trials)).unwrap();
            prop_assert!(plan.lower <= optimum + 1e-9, "lower {} above {optimum}", plan.lower);
            prop_assert!(plan.upper >= optimum - 1e-9, "upper {} below {optimum}", plan.upper);
            prop_assert!(plan.lower >= lower - 1e-12 && plan.upper <= upper + 1e-12, "bounds never loosen");
            (lower, upper) = (plan.lower, plan.upper);
        }
        prop_assert!(upper - lower < 1e-6, "not solved: [{lower}, {upper}]");
        prop_assert!((lower - optimum).abs() < 1e-6, "{lower} is not {optimum}");
    }

    #[test]
    fn certified_bounds_enclose_each_other_and_the_policy(spec in small_models()) {
        let model = SortingModel::new(spec).unwrap();
        let despot = Despot::new(&model, DespotConfig { scenarios: 50, ..DespotConfig::default() }).unwrap();
        let plan = despot.plan(&Belief::new(&model), 0, Budget::Trials(20)).unwrap();
        prop_assert!(plan.certified_lower <= plan.certified_upper);
        let best = plan.values.iter().map(|(_, value)| *value).fold(f64::NEG_INFINITY, f64::max);
        let chosen = plan.values.iter().find(|(action, _)| *action == plan.action).unwrap().1;
        prop_assert!(chosen >= best - 1e-9);
    }
}

#[test]
fn plans_do_not_depend_on_threads_or_repetition() {
    let despot =
        Despot::new(&paper(50.0), DespotConfig { scenarios: 2000, ..DespotConfig::default() }).unwrap();
    let belief = Belief::new(despot.model());
    let plan = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut plan = pool.install(|| despot.plan(&belief, 0, Budget::Trials(30)).unwrap());
        plan.elapsed = Duration::ZERO;
        plan
    };
    let once = plan(1);
    for threads in [1, 2, 8] {
        assert_eq!(plan(threads), once);
    }
}

#[test]
fn only_legal_actions_are_planned() {
    let mut spec = paper(50.0).spec().clone();
    spec.travel = Some(vec![vec![1], vec![0, 2], vec![]]);
    let model = SortingModel::new(spec).unwrap();
    let despot = Despot::new(&model, DespotConfig::default()).unwrap();
    let belief = Belief::new(&model);
    for viewpoint in 0..3 {
        let plan = despot.plan(&belief, viewpoint, Budget::Trials(20)).unwrap();
        let moves: Vec<_> = plan
            .values
            .iter()
            .filter_map(|(a, _)| if let Action::Move(v) = a { Some(*v) } else { None })
            .collect();
        assert_eq!(moves, model.legal_moves(viewpoint));
        assert!(plan.values.iter().any(|(action, _)| *action == plan.action));
    }
}

#[test]
fn a_certain_object_is_decided_and_an_unknown_one_looked_at() {
    let despot = Despot::new(&paper(50.0), DespotConfig::default()).unwrap();
    let certain = vec![vec![0.0, 0.0, 1.0, 0.0], vec![0.25; 4]];
    let belief = Belief::from_rows(despot.model(), &certain).unwrap();
    assert_eq!(despot.plan(&belief, 0, Budget::Trials(10)).unwrap().action, Action::Decide(2));
    let unknown = despot.plan(&Belief::new(despot.model()), 0, Budget::Trials(10)).unwrap().action;
    assert!(matches!(unknown, Action::Move(_)));
}

#[test]
fn settings_without_meaning_are_refused() {
    let model = paper(50.0);
    for bad in [config(0, 0.0, 5), config(5, -1.0, 5), config(5, f64::NAN, 5), config(5, 0.0, 0)] {
        assert!(Despot::new(&model, bad).is_err(), "{bad:?}");
    }
    let many = ModelSpec {
        p_obs: from_weights(32, 1, 4, &[0.5; 32 * 16]).p_obs,
        ..from_weights(1, 1, 4, &[0.5; 16])
    };
    let many = SortingModel::new(many).unwrap();
    assert!(Despot::new(&many, DespotConfig::default()).unwrap_err().to_string().contains("label vectors"));
}
