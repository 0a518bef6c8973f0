use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::config::{Budget, DespotConfig, NEVER};
use crate::index::{Bin, Label};
use crate::model::{Look, ModelSpec, ScalarOrMatrix};
use crate::scenario::LookPoint;
use crate::testing::{
    all_labels, belief_of, belts, enumerable_models, enumerated_value, models_in_full, paper, seeded,
    small_models,
};

/// The optimum of the sampled, regularised problem by plain recursion over all policies' trees.
///
/// Shares the sampled classes and labels and the default policy with the search; scenarios go one by one, histories are
/// kept whole, and there are no bounds.
struct BruteForce<'a> {
    search: Search<'a>,
}

#[derive(Clone)]
struct Place {
    scenarios: Vec<usize>,
    /// Labels since the belt moved, `(position, viewpoint, label)`, the latest last.
    seen: Vec<(Position, Viewpoint, Label)>,
    depth: usize,
    decisions: usize,
    viewpoint: Viewpoint,
}

impl BruteForce<'_> {
    fn optimum(despot: &Despot, belief: &Belief, viewpoint: Viewpoint) -> f64 {
        let (model, scenarios) = (despot.model(), (0..despot.config().scenarios).collect());
        let looks = model.positions().flat_map(|j| model.viewpoints().map(move |v| (j, v)));
        let seen = looks.filter_map(|(j, v)| Some((j, v, belief.last_label(model, j, v)?))).collect();
        let root = Place { scenarios, seen, depth: 0, decisions: 0, viewpoint };
        BruteForce { search: despot.search(belief, false, &|| false) }.value(&root)
    }

    fn is_in(plane: &[u64], scenario: usize) -> bool {
        plane[scenario / 64] >> (scenario % 64) & 1 == 1
    }

    fn last(&self, at: &Place, position: Position, viewpoint: Viewpoint) -> Option<Label> {
        let repeats = self.search.model.repeat(position, viewpoint) > 0.0;
        let same = |(j, v, _): &&(Position, Viewpoint, Label)| repeats && (*j, *v) == (position, viewpoint);
        at.seen.iter().rev().find(same).map(|(_, _, z)| *z)
    }

    fn shares(&self, at: &Place, object: usize) -> Vec<f64> {
        let planes = self.search.scenarios.kinds(object).chunks(self.search.scenarios.words());
        let all = at.scenarios.len() as f64;
        planes
            .map(|plane| at.scenarios.iter().filter(|i| Self::is_in(plane, **i)).count() as f64 / all)
            .collect()
    }

    /// Weighted, discounted, regularised value.
    fn value(&self, at: &Place) -> f64 {
        let Search { model, bounds, scenarios, lambda, .. } = &self.search;
        let remaining = self.search.remaining.after(at.decisions);
        if at.scenarios.is_empty() || remaining.is_over() {
            return 0.0;
        }
        let visible = remaining.visible(model.position_count());
        let weight = at.scenarios.len() as f64 / scenarios.count() as f64
            * model.discount().powi(i32::try_from(at.depth).unwrap());
        let shares: Vec<f64> = (0..visible).flat_map(|j| self.shares(at, at.decisions + j)).collect();
        let fresh = model.viewpoints().all(|v| self.last(at, Position(0), v).is_none());
        let histogram = Histogram { shares: &shares, remaining, viewpoint: at.viewpoint, fresh };
        let mut best = weight * bounds.default_policy(&histogram, &mut Vec::new()).0;
        if at.depth == self.search.depth {
            return best;
        }
        let next = Place { depth: at.depth + 1, ..at.clone() };
        for bin in model.bins() {
            let advanced = Place { decisions: at.decisions + 1, seen: Vec::new(), ..next.clone() };
            let after = if model.observes_after_decision() && !remaining.after(1).is_over() {
                self.scanned(&advanced, remaining.after(1).visible(model.position_count()))
            } else {
                self.value(&advanced)
            };
            let earned: f64 = model.kinds().zip(&shares).map(|(n, share)| share * model.reward(bin, n)).sum();
            best = best.max(weight * earned - lambda + after);
        }
        for &to in model.legal_moves(at.viewpoint) {
            let after = self.scanned(&Place { viewpoint: to, ..next.clone() }, visible);
            best = best.max(-weight * model.motion_cost(at.viewpoint, to) - lambda + after);
        }
        best
    }

    /// The scan that ends a step: `at` is what follows, its labels not yet seen.
    fn scanned(&self, at: &Place, visible: usize) -> f64 {
        let Place { depth, decisions, viewpoint, .. } = *at;
        let through = |labels: &Vec<Label>| {
            let mut below = at.clone();
            for (position, &z) in self.search.model.positions().zip(labels) {
                let last = self.last(at, position, viewpoint);
                let look =
                    LookPoint { depth: depth - 1, decisions, look: Look { position, viewpoint, last } };
                let plane = &self.search.scenarios.labels(look)[z.0 * self.search.scenarios.words()..];
                below.scenarios.retain(|i| Self::is_in(plane, *i));
                below.seen.push((position, viewpoint, z));
            }
            self.value(&below)
        };
        all_labels(self.search.model, visible).iter().map(through).sum()
    }
}

/// Where the camera stands at first.
const START: Viewpoint = Viewpoint(0);

fn config(scenarios: usize, regularization: f64, depth: usize) -> DespotConfig {
    DespotConfig { scenarios, seed: 3, regularization, depth: Some(depth) }
}

/// Everything that the planner takes, and that changes what it searches.
fn varied_models() -> impl Strategy<Value = SortingModel> {
    let costs = prop::collection::vec(0.1..3.0_f64, 4);
    (prop_oneof![small_models(), models_in_full()], any::<bool>(), prop::option::of(costs), 5.0..60.0_f64)
        .prop_map(|(mut spec, restricted, costs, r_min)| {
            (spec.r_min, spec.information_gain) = (r_min, 0.0);
            if spec.viewpoints.len() == 2 {
                if restricted {
                    spec.travel = Some(vec![vec![1], vec![]]);
                }
                if let Some(costs) = costs {
                    spec.motion_cost = ScalarOrMatrix::Matrix(costs.chunks(2).map(<[f64]>::to_vec).collect());
                }
            }
            SortingModel::new(spec).unwrap()
        })
}

proptest! {
    #![proptest_config(seeded(48))]

    #[test]
    fn bounds_enclose_the_sampled_optimum_tighten_and_reach_it(
        model in varied_models(),
        weights in prop::collection::vec(0.02..1.0_f64, 6),
        scenarios in prop_oneof![1..7_usize, Just(70)],
        lambda in prop_oneof![Just(0.0), Just(0.05), Just(1.0)],
        remaining in belts(),
    ) {
        let despot = Despot::new(&model, config(scenarios, lambda, 4)).unwrap();
        let mut belief = belief_of(&model, &weights);
        let seen: Vec<_> = (0..model.position_count()).map(|_| Some(Label(0))).collect();
        belief.observe(&model, START, &seen).unwrap();
        let belief = belief.with_remaining(remaining);
        let optimum = BruteForce::optimum(&despot, &belief, START);
        let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
        for trials in [1, 2, 5, 20, 50, 100, 200, 500, 100_000] {
            let plan = despot.plan(&belief, START, Budget::Trials(trials)).unwrap();
            prop_assert!(plan.lower <= optimum + 1e-9, "lower {} above {optimum}", plan.lower);
            prop_assert!(plan.upper >= optimum - 1e-9, "upper {} below {optimum}", plan.upper);
            prop_assert!(plan.lower >= lower - 1e-9 && plan.upper <= upper + 1e-9, "bounds never loosen");
            (lower, upper) = (plan.lower, plan.upper);
        }
        prop_assert!(upper - lower < 1e-6, "not solved: [{lower}, {upper}]");
        prop_assert!((lower - optimum).abs() < 1e-6, "{lower} is not {optimum}");
    }

    #[test]
    fn the_default_policy_earns_no_more_than_the_best(
        model in enumerable_models(),
        weights in prop::collection::vec(0.02..1.0_f64, 6),
        remaining in belts(),
    ) {
        let belief = belief_of(&model, &weights).with_remaining(remaining);
        let (shares, remaining) = (belief.visible(), belief.objects_left());
        let at = Histogram { shares, remaining, viewpoint: START, fresh: true };
        let (value, action) = Bounds::new(&model, &NEVER).default_policy(&at, &mut Vec::new());
        let (_, at_most) = enumerated_value(&model, &belief, START, 4);
        prop_assert!(value <= at_most + 1e-9, "{value} above V* <= {at_most}");
        let legal = |to| model.legal_moves(START).contains(&to);
        prop_assert!(matches!(action, Action::Decide(_)) || matches!(action, Action::Move(to) if legal(to)));
    }

    #[test]
    fn relabelling_the_classes_relabels_the_plan(
        model in varied_models(),
        weights in prop::collection::vec(0.02..1.0_f64, 6),
        scenarios in 1..7_usize,
        remaining in belts(),
    ) {
        prop_assume!(model.spec().modes.is_none());
        let weights = &weights[..model.position_count() * model.class_count()];
        let mut spec = model.spec().clone();
        for table in spec.p_obs.iter_mut().flatten() {
            table.reverse();
            for row in table {
                row.reverse();
            }
        }
        let reversed_model = SortingModel::new(spec).unwrap();
        let mirror: Vec<f64> =
            weights.chunks(model.class_count()).flat_map(|row| row.iter().rev().copied()).collect();
        let belief = belief_of(&model, weights).with_remaining(remaining);
        let reversed_belief = belief_of(&reversed_model, &mirror).with_remaining(remaining);
        let despot = Despot::new(&model, config(scenarios, 0.02, 4)).unwrap();
        let mut reversed = Despot::new(&reversed_model, *despot.config()).unwrap();
        reversed.randoms = Arc::new(despot.randoms.mirrored());
        let budget = Budget::Trials(100_000);
        let plan = despot.plan(&belief, START, budget).unwrap();
        let other = reversed.plan(&reversed_belief, START, budget).unwrap();
        prop_assert!((plan.lower - other.lower).abs() < 1e-9, "{} and {}", plan.lower, other.lower);
        match (plan.action, other.action) {
            (Action::Decide(label), Action::Decide(other)) => {
                let share = |despot: &Despot, belief: &Belief, bin: Bin| {
                    let search = despot.search(belief, false, &|| false);
                    let plane = &search.scenarios.kinds(0)[bin.0..=bin.0];
                    (plane[0] & ((1 << scenarios) - 1)).count_ones()
                };
                // Equally frequent classes are equally good.
                prop_assert_eq!(share(&despot, &belief, label), share(&reversed, &reversed_belief, other));
            }
            (action, other) => prop_assert_eq!(action, other),
        }
    }

    /// One scenario is no uncertainty: every class is known.
    #[test]
    fn with_one_scenario_it_plans_clairvoyantly(model in varied_models(), remaining in belts()) {
        let despot = Despot::new(&model, config(1, 0.0, 6)).unwrap();
        let belief = Belief::new(&model).with_remaining(remaining);
        let plan = despot.plan(&belief, START, Budget::Trials(100_000)).unwrap();
        let search = despot.search(&belief, false, &|| false);
        // Of a reward matrix the upper bound takes the largest entry, whatever the class.
        prop_assume!(model.spec().reward.is_none());
        let class = search.scenarios.kinds(0).iter().position(|plane| plane & 1 == 1).unwrap();
        prop_assert_eq!(plan.action, Action::Decide(Bin(class)));
        let right = search.bounds.upper(Remaining(Some(remaining.unwrap_or(6))));
        if remaining.is_some() {
            prop_assert!((plan.lower - right).abs() < 1e-6, "{} is not {right}", plan.lower);
        } else {
            let tail = plan.lower - right;
            let most = model.discount().powi(6) * search.bounds.upper(Remaining::ENDLESS);
            prop_assert!(tail <= most + 1e-6, "{} is more than {right} and {most}", plan.lower);
        }
    }
}

#[test]
fn plans_do_not_depend_on_threads_or_repetition() {
    let config = DespotConfig { scenarios: 1000, regularization: 0.01, ..DespotConfig::default() };
    let despot = Despot::new(&paper(50.0), config).unwrap();
    let belief = Belief::new(despot.model());
    let plan = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| despot.plan_in_parallel(&belief, START, Budget::Trials(1500)).unwrap())
    };
    let alone = despot.plan(&belief, START, Budget::Trials(1500)).unwrap();
    for threads in [1, 2, 4, 8, 2] {
        assert!(plan(threads) == alone);
    }
}

#[test]
fn bounds_tighten_through_batches_of_trials() {
    let config = DespotConfig { regularization: 0.02, ..DespotConfig::default() };
    let despot = Despot::new(&paper(50.0), config).unwrap();
    let belief = Belief::new(despot.model());
    let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
    for trials in [1, 31, 32, 100, 300, 1000, 2000] {
        let plan = despot.plan(&belief, START, Budget::Trials(trials)).unwrap();
        assert_eq!(plan.trials, trials);
        assert!(plan.lower <= plan.upper && plan.lower >= lower - 1e-9 && plan.upper <= upper + 1e-9);
        (lower, upper) = (plan.lower, plan.upper);
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
        let mut legal: Vec<_> = model.bins().map(Action::Decide).collect();
        legal.extend(model.legal_moves(viewpoint).iter().map(|to| Action::Move(*to)));
        let planned: Vec<_> = plan.values.iter().map(|(action, _)| *action).collect();
        assert_eq!(planned, legal);
        assert!(planned.contains(&plan.action));
    }
}

#[test]
fn a_certain_object_is_decided_and_an_unknown_one_looked_at() {
    let despot = Despot::new(&paper(50.0), DespotConfig::default()).unwrap();
    let certain = vec![vec![0.0, 0.0, 1.0, 0.0], vec![0.25; 4]];
    let belief = Belief::from_rows(despot.model(), &certain).unwrap();
    assert_eq!(despot.plan(&belief, START, Budget::Trials(100)).unwrap().action, Action::Decide(Bin(2)));
    let unknown = despot.plan(&Belief::new(despot.model()), START, Budget::Trials(100)).unwrap().action;
    assert!(matches!(unknown, Action::Move(_)));
}

#[test]
fn a_high_price_leaves_the_default_policy() {
    let dear = DespotConfig { regularization: 1e3, ..DespotConfig::default() };
    let despot = Despot::new(&paper(50.0), dear).unwrap();
    let belief = Belief::new(despot.model());
    let plan = despot.plan(&belief, START, Budget::Trials(100)).unwrap();
    assert!((plan.lower - plan.upper).abs() < 1e-12);
    assert!(plan.values.iter().all(|(_, value)| *value < plan.lower));
    assert!(matches!(plan.action, Action::Move(_)), "{:?}", plan.action);
}

#[test]
fn what_it_cannot_plan_for_is_refused() {
    let model = paper(50.0);
    for bad in [config(0, 0.0, 5), config(5, -1.0, 5), config(5, 0.0, 0)] {
        assert!(Despot::new(&model, bad).is_err(), "{bad:?}");
    }
    let bonus = ModelSpec { information_gain: 0.5, ..model.spec().clone() };
    let error = Despot::new(&SortingModel::new(bonus).unwrap(), config(5, 0.0, 5)).unwrap_err();
    assert!(error.to_string().contains("information_gain"), "{error}");
}
