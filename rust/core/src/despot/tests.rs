use proptest::prelude::*;

use super::scan::Scan;
use super::*;
use crate::bounds::{self, Foresight, Sighting};
use crate::index::{Class, Label, Position};
use crate::model::{Action, ModelSpec};
use crate::scenario::LabelPlanes;
use crate::testing::{
    Exact, all_labels, belief_of, belts, enumerable_models, enumerated_value, from_weights, models_in_full,
    paper, seeded, small_models, tiny_beliefs, tiny_models,
};
use crate::tree::id;

/// The optimum of the sampled, regularised problem by plain recursion over its whole tree.
///
/// Shares the label planes, the belief and the default policy with the search, but none of its bounds, its order, or
/// its way to book the labels without a branch: those are enumerated one by one here.
struct BruteForce<'a> {
    despot: &'a Despot,
    labels: LabelPlanes,
}

/// Where a node stands: what is known there, its scenarios one by one, and the probability of coming there.
#[derive(Clone)]
struct Place {
    belief: Belief,
    scenarios: Vec<usize>,
    depth: usize,
    decisions: usize,
    viewpoint: Viewpoint,
    mass: f64,
}

impl BruteForce<'_> {
    fn optimum(despot: &Despot, belief: &Belief, viewpoint: Viewpoint) -> f64 {
        let mut labels = LabelPlanes::default();
        despot.randoms.reach(despot.depth, false);
        labels.restart(&despot.model, &despot.randoms, belief.as_slice());
        let scenarios = (0..despot.config.scenarios).collect();
        let root = Place { belief: belief.clone(), scenarios, depth: 0, decisions: 0, viewpoint, mass: 1.0 };
        let default = BruteForce::default_value(despot, &root);
        BruteForce { despot, labels }.value(&root, default)
    }

    fn default_value(despot: &Despot, at: &Place) -> f64 {
        bounds::lower(&despot.model, &despot.default_policy, at.belief.known(), at.viewpoint)
    }

    /// Regularised value of a node, in units of the node's own reward.
    fn value(&mut self, at: &Place, default: f64) -> f64 {
        let Despot { model, config, depth, discounts, .. } = self.despot;
        if at.depth == *depth || at.belief.remaining() == Some(0) {
            return default;
        }
        let price = config.regularization / (at.mass * discounts[at.depth]);
        let mut next = Place { depth: at.depth + 1, decisions: at.decisions + 1, ..at.clone() };
        next.belief.advance(model);
        let (bonus, after) = if model.observes_after_decision() && next.belief.remaining() != Some(0) {
            (next.belief.bonus(model, at.viewpoint), self.scanned(&next))
        } else {
            (0.0, self.value(&next, BruteForce::default_value(self.despot, &next)))
        };
        let decided = model.decision_reward(at.belief.most_likely(Position(0)).1) + bonus - price;
        let mut best = default.max(decided + model.discount() * after);
        for &to in model.legal_moves(at.viewpoint) {
            let step = at.belief.bonus(model, to) - model.motion_cost(at.viewpoint, to) - price;
            let next = Place { depth: at.depth + 1, viewpoint: to, ..at.clone() };
            best = best.max(step + model.discount() * self.scanned(&next));
        }
        best
    }

    /// Expected value over the labels of a scan that ends a step: `at` is what follows, its labels not yet seen.
    fn scanned(&mut self, at: &Place) -> f64 {
        let Despot { model, default_policy, .. } = self.despot;
        let looks = bounds::looks(model, default_policy, &at.belief, at.viewpoint);
        let unseen = at.belief.horizon().unseen(model.position_count());
        let mut scan = Foresight::default();
        scan.take(default_policy, looks.iter(), at.viewpoint, unseen);
        let mut value = 0.0;
        for z in all_labels(model, looks.len()) {
            let p: f64 = z.iter().enumerate().map(|(j, z)| scan.probability(j, z.0)).product();
            if p == 0.0 {
                continue;
            }
            let default = scan.value_after(&z);
            let mut below = Place { scenarios: self.through(at, &z), mass: at.mass * p, ..at.clone() };
            let mut seen: Vec<_> = z.iter().map(|z| Some(*z)).collect();
            seen.resize(model.position_count(), None);
            below.belief.observe(model, at.viewpoint, &seen).unwrap();
            value += p * if below.scenarios.is_empty() { default } else { self.value(&below, default) };
        }
        value
    }

    /// The scenarios that give these labels to the scan that has led to `at`.
    fn through(&mut self, at: &Place, labels: &[Label]) -> Vec<usize> {
        let Despot { model, randoms, .. } = self.despot;
        let remaining = at.belief.horizon();
        let scan = Scan { depth: at.depth - 1, decisions: at.decisions, viewpoint: at.viewpoint, remaining };
        let mut scenarios = at.scenarios.clone();
        for (position, &z) in model.positions().zip(labels) {
            let last = at.belief.last_label(model, position, at.viewpoint);
            let look = scan.look(Sighting { position, viewpoint: at.viewpoint, last });
            self.labels.require(model, randoms, std::iter::once(look), false);
            let plane = self.labels.label(look, z);
            scenarios.retain(|i| plane[i / 64] >> (i % 64) & 1 == 1);
        }
        scenarios
    }
}

/// Where the camera stands at first.
const START: Viewpoint = Viewpoint(0);

fn config(scenarios: usize, regularization: f64, depth: usize) -> DespotConfig {
    DespotConfig { scenarios, seed: 3, regularization, depth: Some(depth) }
}

proptest! {
    #![proptest_config(seeded(24))]

    #[test]
    fn bounds_bracket_the_sampled_optimum_tighten_and_reach_it(
        spec in prop_oneof![small_models(), models_in_full()],
        scenarios in 1..6_usize,
        regularized in any::<bool>(),
        restricted in any::<bool>(),
        remaining in belts(),
    ) {
        let mut spec = spec;
        spec.r_min = 15.0;
        if restricted && spec.viewpoints.len() == 2 {
            spec.travel = Some(vec![vec![1], vec![]]);
        }
        let model = SortingModel::new(spec).unwrap();
        let lambda = if regularized { 0.3 } else { 0.0 };
        let despot = Despot::new(&model, config(scenarios, lambda, 5)).unwrap();
        let belief = Belief::new(&model).with_remaining(remaining);
        let optimum = BruteForce::optimum(&despot, &belief, START);
        let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
        for trials in [1, 2, 5, 20, 100, 100_000] {
            let plan = despot.plan(&belief, START, Budget::Trials(trials)).unwrap();
            prop_assert!(plan.lower <= optimum + 1e-9, "lower {} above {optimum}", plan.lower);
            prop_assert!(plan.upper >= optimum - 1e-9, "upper {} below {optimum}", plan.upper);
            prop_assert!(plan.lower >= lower - 1e-9 && plan.upper <= upper + 1e-9, "bounds never loosen");
            (lower, upper) = (plan.lower, plan.upper);
        }
        prop_assert!(upper - lower < 1e-6, "not solved: [{lower}, {upper}]");
        let tree = &despot.plan(&belief, START, Budget::Trials(100_000)).unwrap().space.frontier.tree;
        for (index, node) in tree.nodes.iter().enumerate() {
            prop_assert_eq!(tree.child(node.place).node, Some(id(index)), "expanded twice");
        }
        prop_assert!((lower - optimum).abs() < 1e-6, "{lower} is not {optimum}");
    }

    #[test]
    fn certified_bounds_enclose_the_exact_value_where_scenarios_run_out(
        model in enumerable_models(),
        weights in prop::collection::vec(0.02..1.0_f64, 6),
        remaining in belts(),
    ) {
        let belief = belief_of(&model, &weights).with_remaining(remaining);
        let (at_least, at_most) = enumerated_value(&model, &belief, START, 5);
        let despot = Despot::new(&model, config(3, 0.0, 50)).unwrap();
        for trials in [1, 10, 100] {
            let plan = despot.plan(&belief, START, Budget::Trials(trials)).unwrap();
            prop_assert!(plan.certified_lower.is_none_or(|lower| lower <= at_most + 1e-9));
            prop_assert!(plan.certified_upper >= at_least - 1e-9);
        }
    }

    #[test]
    fn certified_bounds_enclose_the_value_to_a_millionth(
        tiny in tiny_models(1..=2),
        weights in tiny_beliefs(),
        observe in any::<bool>(),
        remaining in belts(),
        scenarios in prop_oneof![Just(3_usize), Just(200)],
        lambda in prop_oneof![Just(0.0), Just(0.1)],
    ) {
        let tiny = tiny.observing(observe);
        let exact = Exact::new(&tiny);
        let despot = Despot::new(&tiny.model, config(scenarios, lambda, 50)).unwrap();
        for belief in [Belief::new(&tiny.model), belief_of(&tiny.model, &weights)] {
            let belief = belief.with_remaining(remaining);
            for (viewpoint, (at_least, at_most)) in tiny.model.viewpoints().zip(exact.bounds(&belief)) {
                for trials in [1, 10, 100] {
                    let plan = despot.plan(&belief, viewpoint, Budget::Trials(trials)).unwrap();
                    let (lower, upper) = (plan.certified_lower.unwrap(), plan.certified_upper);
                    prop_assert!(lower <= at_most + 1e-9, "{belief:?}: {lower} above V* = {at_most}");
                    prop_assert!(upper >= at_least - 1e-9, "{belief:?}: {upper} below V* = {at_least}");
                }
            }
        }
    }
}

proptest! {
    // Each case solves a problem of its own.
    #![proptest_config(seeded(8))]

    #[test]
    fn certified_bounds_enclose_each_other_and_the_policy(spec in small_models(), remaining in belts()) {
        let model = SortingModel::new(spec).unwrap();
        let despot = Despot::new(&model, DespotConfig { scenarios: 50, ..DespotConfig::default() }).unwrap();
        let belief = Belief::new(&model).with_remaining(remaining);
        let plan = despot.plan(&belief, START, Budget::Trials(20)).unwrap();
        prop_assert!(plan.certified_lower.unwrap() <= plan.certified_upper);
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
        pool.install(|| despot.plan_in_parallel(&belief, START, Budget::Trials(1000)).unwrap())
    };
    let alone = despot.plan(&belief, START, Budget::Trials(1000)).unwrap();
    for threads in [1, 2, 4, 8, 2] {
        assert_eq!(plan(threads), alone);
    }
}

#[test]
fn only_legal_actions_are_planned() {
    let mut spec = paper(50.0).spec().clone();
    spec.travel = Some(vec![vec![1], vec![0, 2], vec![]]);
    let model = SortingModel::new(spec).unwrap();
    let despot = Despot::new(&model, DespotConfig::default()).unwrap();
    let belief = Belief::new(&model);
    for viewpoint in model.viewpoints() {
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
    assert_eq!(despot.plan(&belief, START, Budget::Trials(10)).unwrap().action, Action::Decide(Class(2)));
    let unknown = despot.plan(&Belief::new(despot.model()), START, Budget::Trials(10)).unwrap().action;
    assert!(matches!(unknown, Action::Move(_)));
}

#[test]
fn a_far_end_of_the_belt_changes_nothing_and_a_near_one_the_value() {
    let despot = Despot::new(&paper(50.0), DespotConfig::default()).unwrap();
    let lower = |remaining| {
        let belief = Belief::new(despot.model()).with_remaining(remaining);
        despot.plan(&belief, START, Budget::Trials(50)).unwrap().certified_lower.unwrap()
    };
    assert!((lower(Some(1000)) - lower(None)).abs() < 1e-3);
    let values: Vec<_> = (1..20).map(|objects| lower(Some(objects))).collect();
    assert!(values.is_sorted(), "{values:?}");
    assert!(values[0] > 0.0 && values[0] < 10.0, "one object earns no more than its reward: {}", values[0]);
}

#[test]
fn where_nothing_is_left_nothing_is_planned() {
    let despot = Despot::new(&paper(50.0), DespotConfig::default()).unwrap();
    let error = despot
        .plan(&Belief::new(despot.model()).with_remaining(Some(0)), START, Budget::Trials(1))
        .unwrap_err();
    let error = error.to_string();
    assert!(error.contains("remaining") && error.contains('0'), "{error}");
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
    let error = Despot::new(&many, DespotConfig::default()).unwrap_err().to_string();
    assert!(error.contains("32 positions") && error.contains("64"), "{error}");
}
