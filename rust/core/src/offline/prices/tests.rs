use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use proptest::prelude::*;
use rayon::ThreadPoolBuilder;

use super::super::SLACK;
use super::super::watch::Progress;
use super::*;
use crate::model::{ModelSpec, ScalarOrMatrix};
use crate::one_object::OneObjectPolicy;
use crate::testing::{
    Exact, belief_of, enumerable_models, enumerated_value, from_weights, paper, seeded, tiny_beliefs,
    tiny_models,
};

/// The bound at the arrival prior, and the one at any belief.
struct Solved {
    upper: f64,
    bound: PricedBound,
}

impl Solved {
    fn ahead(&self, belief: &Belief, viewpoint: Viewpoint) -> f64 {
        self.bound.upper(belief.as_slice(), viewpoint) + SLACK
    }
}

fn solve(model: &SortingModel, milliseconds: u64) -> Solved {
    noting(model, milliseconds, &mut |_, _| {})
}

fn noting(model: &SortingModel, milliseconds: u64, progress: Progress<'_>) -> Solved {
    let (time, stop) = (Duration::from_millis(milliseconds), AtomicBool::new(false));
    let watch = Watch::new(time, &stop, progress, (f64::NEG_INFINITY, f64::INFINITY));
    let bound = PricedBound::improved(model, &watch, 1.0);
    Solved { upper: watch.bounds().1 + SLACK, bound }
}

proptest! {
    #![proptest_config(seeded(8))]

    #[test]
    fn the_bound_is_no_less_than_the_value_to_a_millionth(
        tiny in tiny_models(1..=2),
        beliefs in prop::collection::vec(tiny_beliefs(), 3),
    ) {
        let (model, exact) = (&tiny.model, Exact::new(&tiny));
        let bound = solve(model, 50);
        prop_assert!(bound.upper >= exact.bounds(&Belief::new(model))[0].0);
        let start = std::iter::once(Belief::new(model));
        for belief in start.chain(beliefs.iter().map(|weights| belief_of(model, weights))) {
            for (viewpoint, (at_least, _)) in model.viewpoints().zip(exact.bounds(&belief)) {
                let ahead = bound.ahead(&belief, viewpoint);
                prop_assert!(ahead >= at_least, "{belief:?}: {ahead} below V* = {at_least}");
            }
        }
    }

    #[test]
    fn one_position_by_itself_has_no_price_to_pay(tiny in tiny_models(1..=1)) {
        let model = &tiny.model;
        let (_, at_most) = Exact::new(&tiny).bounds(&Belief::new(model))[0];
        let upper = solve(model, 10_000).upper;
        prop_assert!(upper - at_most < 2e-3 * (model.spec().r_max + at_most.abs()), "{upper}, V* = {at_most}");
    }

    #[test]
    fn the_bound_is_no_less_than_the_enumerated_value(
        model in enumerable_models(),
        weights in prop::collection::vec(0.02..1.0_f64, 6),
    ) {
        let bound = solve(&model, 50);
        for belief in [Belief::new(&model), belief_of(&model, &weights)] {
            let (at_least, _) = enumerated_value(&model, &belief, Viewpoint(0), 4);
            prop_assert!(bound.ahead(&belief, Viewpoint(0)) >= at_least);
        }
    }

    #[test]
    fn the_bound_is_no_less_than_what_the_one_object_policy_earns(
        (h, k, l) in (2..=3_usize, 1..=3_usize, 2..=7_usize),
        tables in prop::collection::vec(0.01..1.0_f64, 3 * 3 * 49),
        right in 0.0..3.0_f64,
        costs in prop::collection::vec(0.2..2.0_f64, 3),
        restricted in any::<bool>(),
        beliefs in prop::collection::vec(prop::collection::vec(0.001..1.0_f64, 21), 4),
    ) {
        let model = SortingModel::new(scaled_up(h, k, l, &tables, right, &costs, restricted)).unwrap();
        let (bound, policy) = (solve(&model, 100), OneObjectPolicy::solve(&model));
        for weights in beliefs {
            let belief = belief_of(&model, &weights);
            for viewpoint in model.viewpoints() {
                let earned = policy.value(&model, belief.known(), viewpoint);
                prop_assert!(bound.ahead(&belief, viewpoint) >= earned);
            }
        }
    }

    #[test]
    fn two_classes_may_change_their_names(tiny in tiny_models(1..=2)) {
        let model = &tiny.model;
        let mut spec = model.spec().clone();
        spec.arrival = spec.arrival.map(|arrival| arrival.into_iter().rev().collect());
        for rows in spec.p_obs.iter_mut().flatten() {
            rows.reverse();
            for row in rows {
                row.reverse();
            }
        }
        let (one, other) = (solve(model, 10_000), solve(&SortingModel::new(spec).unwrap(), 10_000));
        let difference = (one.upper - other.upper).abs();
        prop_assert!(difference < 2e-3 * (model.spec().r_max + one.upper.abs()), "{difference}");
    }
}

/// Random tables that are right more often, moves that differ in cost, and some that are forbidden.
fn scaled_up(
    h: usize,
    k: usize,
    l: usize,
    tables: &[f64],
    right: f64,
    costs: &[f64],
    restricted: bool,
) -> ModelSpec {
    let mut spec = from_weights(h, k, l, tables);
    for rows in spec.p_obs.iter_mut().flatten() {
        for (class, row) in rows.iter_mut().enumerate() {
            row[class] += right;
            let sum: f64 = row.iter().sum();
            for p in row {
                *p /= sum;
            }
        }
    }
    if restricted {
        let cost = |from: usize, to: usize| costs[to] + if from == to { 0.0 } else { 0.5 };
        spec.motion_cost =
            ScalarOrMatrix::Matrix((0..k).map(|from| (0..k).map(|to| cost(from, to)).collect()).collect());
        spec.travel = Some((0..k).map(|from| (from..k).chain([0]).collect::<Vec<_>>()).map(unique).collect());
    }
    spec
}

fn unique(mut list: Vec<usize>) -> Vec<usize> {
    list.sort_unstable();
    list.dedup();
    list
}

#[test]
fn bounds_only_fall_and_are_far_below_the_closed_form() {
    for (model, most) in [(paper(50.0), 30.0), (paper(50.0).with_positions(1).unwrap(), 18.2)] {
        let improved = |doubled: u32| {
            let seen = Mutex::new(Vec::new());
            let mut note = |_, upper| seen.lock().unwrap().push(upper);
            let bound = noting(&model, 1500 << doubled, &mut note);
            let seen = seen.into_inner().unwrap();
            assert!(seen.windows(2).all(|pair| pair[1] <= pair[0]), "{seen:?}");
            bound.upper
        };
        // With more and more time: how far it gets in some depends on the machine.
        assert!(
            (0..6).map(improved).any(|upper| upper < most),
            "not below {most} within a minute and a half"
        );
    }
}

#[test]
fn any_number_of_threads_finds_the_same_bound() {
    let mut spec = paper(50.0).with_positions(2).unwrap().spec().clone();
    let two =
        |rows: &Vec<Vec<f64>>| vec![vec![rows[0][0], 1.0 - rows[0][0]], vec![1.0 - rows[1][1], rows[1][1]]];
    spec.p_obs = spec.p_obs.iter().map(|row| row.iter().map(two).collect()).collect();
    spec.classes.truncate(2);
    let model = SortingModel::new(spec).unwrap();
    let with_threads = |threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(&model, 100_000).upper)
    };
    assert_eq!(with_threads(1).to_bits(), with_threads(2).to_bits());
}

#[test]
fn what_was_saved_bounds_every_belief_as_before() {
    let mut spec = paper(50.0).spec().clone();
    spec.p_obs.push(spec.p_obs[1].clone());
    let model = SortingModel::new(spec).unwrap();
    let Solved { bound, .. } = solve(&model, 300);
    let text = serde_json::to_string(&bound.to_saved()).unwrap();
    let restored = PricedBound::restored(&model, serde_json::from_str(&text).unwrap()).unwrap();
    for weights in [vec![1.0; 12], (1..13).map(f64::from).collect()] {
        let belief = belief_of(&model, &weights);
        let value = |bound: &PricedBound| bound.value(belief.as_slice(), Viewpoint(1)).to_bits();
        assert_eq!(value(&restored), value(&bound));
    }
    let two = model.with_positions(2).unwrap();
    assert!(PricedBound::restored(&two, serde_json::from_str(&text).unwrap()).is_none());
}
