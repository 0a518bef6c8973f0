use proptest::prelude::*;

use super::outcomes::ScanOutcomes;
use super::*;
use crate::index::{Bin, Label, Position};
use crate::scenario::LookPoint;
use crate::testing::{
    Exact, all_labels, belief_of, belts, enumerable_models, enumerated_value, models_in_full, paper, seeded,
    small_models, tiny_beliefs, tiny_models,
};

/// The optimum of the sampled problem by plain recursion over its whole tree.
///
/// Shares the label planes, the belief and the default policy with the search, but none of its bounds, its order, or
/// its way to book the labels without a branch: those are enumerated one by one here.
struct BruteForce<'a> {
    search: &'a BeliefSearch,
    scenarios: Scenarios<'a>,
}

/// A node: what is known there, and its scenarios one by one.
#[derive(Clone)]
struct Place {
    belief: Belief,
    scenarios: Vec<usize>,
    depth: usize,
    decisions: usize,
    viewpoint: Viewpoint,
}

impl BruteForce<'_> {
    fn optimum(search: &BeliefSearch, belief: &Belief, viewpoint: Viewpoint) -> f64 {
        let scenarios = (0..search.config.scenarios).collect();
        let root = Place { belief: belief.clone(), scenarios, depth: 0, decisions: 0, viewpoint };
        let default = BruteForce::default_value(search, &root);
        let sampled = Scenarios::sampled((&search.model, &search.randoms), belief, search.depth, false);
        BruteForce { search, scenarios: sampled }.value(&root, default)
    }

    fn default_value(search: &BeliefSearch, at: &Place) -> f64 {
        bounds::lower(&search.model, &search.default_policy, at.belief.known(), at.viewpoint)
    }

    /// Value of a node.
    fn value(&mut self, at: &Place, default: f64) -> f64 {
        let BeliefSearch { model, depth, .. } = self.search;
        if at.depth == *depth || at.belief.remaining() == Some(0) {
            return default;
        }
        let mut next = Place { depth: at.depth + 1, decisions: at.decisions + 1, ..at.clone() };
        next.belief.advance(model);
        let (bonus, after) = if model.observes_after_decision() && next.belief.remaining() != Some(0) {
            (next.belief.bonus(model, at.viewpoint), self.scanned(&next))
        } else {
            (0.0, self.value(&next, BruteForce::default_value(self.search, &next)))
        };
        let decided = at.belief.best_decision(model).1 + bonus;
        let mut best = default.max(decided + model.discount() * after);
        for &to in model.legal_moves(at.viewpoint) {
            let step = at.belief.bonus(model, to) - model.motion_cost(at.viewpoint, to);
            let next = Place { depth: at.depth + 1, viewpoint: to, ..at.clone() };
            best = best.max(step + model.discount() * self.scanned(&next));
        }
        best
    }

    /// Expected value over the labels of a scan that ends a step: `at` is what follows, its labels not yet seen.
    fn scanned(&mut self, at: &Place) -> f64 {
        let BeliefSearch { model, default_policy, .. } = self.search;
        let scan = ScanOutcomes::new(model, default_policy, &at.belief, at.viewpoint);
        let mut value = 0.0;
        for z in all_labels(model, scan.positions()) {
            let p: f64 = z.iter().enumerate().map(|(j, z)| scan.probabilities(Position(j))[z.0]).product();
            if p == 0.0 {
                continue;
            }
            let default = scan.default_value(&z);
            let mut below = Place { scenarios: self.through(at, &z), ..at.clone() };
            let mut seen: Vec<_> = z.iter().map(|z| Some(*z)).collect();
            seen.resize(model.position_count(), None);
            below.belief.observe(model, at.viewpoint, &seen).unwrap();
            value += p * if below.scenarios.is_empty() { default } else { self.value(&below, default) };
        }
        value
    }

    /// The scenarios that give these labels to the scan that has led to `at`.
    fn through(&mut self, at: &Place, labels: &[Label]) -> Vec<usize> {
        let model = &self.search.model;
        let mut scenarios = at.scenarios.clone();
        for (position, &z) in model.positions().zip(labels) {
            let look = at.belief.look(model, position, at.viewpoint);
            let look = LookPoint { depth: at.depth - 1, decisions: at.decisions, look };
            let plane = self.scenarios.label(look, z);
            scenarios.retain(|i| plane[i / 64] >> (i % 64) & 1 == 1);
        }
        scenarios
    }
}

/// Where the camera stands at first.
const START: Viewpoint = Viewpoint(0);

fn config(scenarios: usize, depth: usize) -> DespotConfig {
    DespotConfig { scenarios, seed: 3, regularization: 0.0, depth: Some(depth) }
}

proptest! {
    #![proptest_config(seeded(24))]

    #[test]
    fn bounds_bracket_the_sampled_optimum_tighten_and_reach_it(
        spec in prop_oneof![small_models(), models_in_full()],
        scenarios in 1..6_usize,
        restricted in any::<bool>(),
        remaining in belts(),
    ) {
        let mut spec = spec;
        spec.r_min = 15.0;
        if restricted && spec.viewpoints.len() == 2 {
            spec.travel = Some(vec![vec![1], vec![]]);
        }
        let model = SortingModel::new(spec).unwrap();
        let search = BeliefSearch::new(&model, config(scenarios, 5)).unwrap();
        let belief = Belief::new(&model).with_remaining(remaining);
        let optimum = BruteForce::optimum(&search, &belief, START);
        let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
        for trials in [1, 2, 5, 20, 100, 100_000] {
            let plan = search.plan(&belief, START, Budget::Trials(trials)).unwrap();
            prop_assert!(plan.lower <= optimum + 1e-9, "lower {} above {optimum}", plan.lower);
            prop_assert!(plan.upper >= optimum - 1e-9, "upper {} below {optimum}", plan.upper);
            prop_assert!(plan.lower >= lower - 1e-9 && plan.upper <= upper + 1e-9, "bounds never loosen");
            (lower, upper) = (plan.lower, plan.upper);
        }
        prop_assert!(upper - lower < 1e-6, "not solved: [{lower}, {upper}]");
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
        let search = BeliefSearch::new(&model, config(3, 50)).unwrap();
        for trials in [1, 10, 100] {
            let plan = search.plan(&belief, START, Budget::Trials(trials)).unwrap();
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
    ) {
        let tiny = tiny.observing(observe);
        let exact = Exact::new(&tiny);
        let search = BeliefSearch::new(&tiny.model, config(scenarios, 50)).unwrap();
        for belief in [Belief::new(&tiny.model), belief_of(&tiny.model, &weights)] {
            let belief = belief.with_remaining(remaining);
            for (viewpoint, (at_least, at_most)) in tiny.model.viewpoints().zip(exact.bounds(&belief)) {
                for trials in [1, 10, 100] {
                    let plan = search.plan(&belief, viewpoint, Budget::Trials(trials)).unwrap();
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
        let search = BeliefSearch::new(&model, DespotConfig { scenarios: 50, ..DespotConfig::default() }).unwrap();
        let belief = Belief::new(&model).with_remaining(remaining);
        let plan = search.plan(&belief, START, Budget::Trials(20)).unwrap();
        prop_assert!(plan.certified_lower.unwrap() <= plan.certified_upper);
        let best = plan.values.iter().map(|(_, value)| *value).fold(f64::NEG_INFINITY, f64::max);
        let chosen = plan.values.iter().find(|(action, _)| *action == plan.action).unwrap().1;
        prop_assert!(chosen >= best - 1e-9);
    }
}

#[test]
fn the_same_arguments_give_the_same_plan() {
    let search = BeliefSearch::new(&paper(50.0), DespotConfig::default()).unwrap();
    let belief = Belief::new(search.model());
    let plan = |trials| search.plan(&belief, START, Budget::Trials(trials)).unwrap();
    let first = plan(300);
    // Not assert_eq: a plan is too long to print.
    assert!(plan(200) != first);
    assert!(plan(300) == first);
}

#[test]
fn looking_ahead_one_step_is_the_search_without_trials() {
    let model = paper(50.0);
    let look_ahead = LookAhead::new(&model, 1, DespotConfig::default()).unwrap();
    let search = BeliefSearch::new(&model, DespotConfig::default()).unwrap();
    for rows in [[[0.25; 4]; 2], [[0.1, 0.7, 0.1, 0.1], [0.25; 4]], [[0.97, 0.01, 0.01, 0.01], [0.25; 4]]] {
        let belief = Belief::from_rows(&model, &rows.map(|row| row.to_vec())).unwrap();
        let mut started = Search::new(&search, &belief, START).unwrap();
        started.expand_root();
        assert_eq!(look_ahead.act(&belief, START).unwrap(), started.best_action());
    }
}

#[test]
fn looking_ahead_two_steps_compares_all_actions_after_every_branch() {
    let search = BeliefSearch::new(&paper(50.0), config(20, 50)).unwrap();
    let belief = Belief::new(search.model());
    let mut looking = Search::new(&search, &belief, START).unwrap();
    looking.look_ahead(2);
    let [root, below @ ..] = &looking.tree.nodes[..] else { panic!("the root is expanded") };
    let branches: usize = root.edges.iter().map(|edge| edge.children.len()).sum();
    assert_eq!(below.len(), branches);
    assert!(below.iter().all(|node| node.depth == 1 && node.edges.len() == 4));
    for depth in [0, 5] {
        assert!(LookAhead::new(search.model(), depth, DespotConfig::default()).is_err());
    }
}

#[test]
fn only_legal_actions_are_planned() {
    let mut spec = paper(50.0).spec().clone();
    spec.travel = Some(vec![vec![1], vec![0, 2], vec![]]);
    let model = SortingModel::new(spec).unwrap();
    let search = BeliefSearch::new(&model, DespotConfig::default()).unwrap();
    let belief = Belief::new(&model);
    for viewpoint in model.viewpoints() {
        let plan = search.plan(&belief, viewpoint, Budget::Trials(20)).unwrap();
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
    let search = BeliefSearch::new(&paper(50.0), DespotConfig::default()).unwrap();
    let certain = vec![vec![0.0, 0.0, 1.0, 0.0], vec![0.25; 4]];
    let belief = Belief::from_rows(search.model(), &certain).unwrap();
    assert_eq!(search.plan(&belief, START, Budget::Trials(10)).unwrap().action, Action::Decide(Bin(2)));
    let unknown = search.plan(&Belief::new(search.model()), START, Budget::Trials(10)).unwrap().action;
    assert!(matches!(unknown, Action::Move(_)));
}

#[test]
fn a_far_end_of_the_belt_changes_nothing_and_a_near_one_the_value() {
    let search = BeliefSearch::new(&paper(50.0), DespotConfig::default()).unwrap();
    let lower = |remaining| {
        let belief = Belief::new(search.model()).with_remaining(remaining);
        search.plan(&belief, START, Budget::Trials(50)).unwrap().certified_lower.unwrap()
    };
    // A belt that ends has one more node expanded.
    assert!((lower(Some(1000)) - lower(None)).abs() < 0.1);
    let values: Vec<_> = (1..20).map(|objects| lower(Some(objects))).collect();
    assert!(values.is_sorted(), "{values:?}");
    assert!(values[0] > 0.0 && values[0] < 10.0, "one object earns no more than its reward: {}", values[0]);
}

#[test]
fn where_nothing_is_left_nothing_is_planned() {
    let search = BeliefSearch::new(&paper(50.0), DespotConfig::default()).unwrap();
    let error = search
        .plan(&Belief::new(search.model()).with_remaining(Some(0)), START, Budget::Trials(1))
        .unwrap_err();
    let error = error.to_string();
    assert!(error.contains("remaining") && error.contains('0'), "{error}");
}

#[test]
fn settings_without_meaning_are_refused() {
    let model = paper(50.0);
    let regularised = DespotConfig { regularization: 0.1, ..config(5, 5) };
    for bad in
        [config(0, 5), config(5, 0), regularised, DespotConfig { regularization: f64::NAN, ..regularised }]
    {
        assert!(BeliefSearch::new(&model, bad).is_err(), "{bad:?}");
    }
}
