//! Laws of planning, against complete enumeration on tiny belts that end.

use std::sync::Arc;

use proptest::prelude::*;

use super::deadline::{DeadlineProblem, Kinds};
use super::priced::PricedBound;
use super::serving::Serving;
use crate::belief::condition;
use crate::config::NEVER;
use crate::index::{Class, Position, Viewpoint};
use crate::model::{Look, SortingModel};
use crate::moving::state::State;
use crate::moving::timing::Timing;
use crate::testing::{enumerable_models, paper, seeded};

/// Where the camera starts.
pub(super) const FROM: Viewpoint = Viewpoint(0);

/// The value of a state, by trying every action and every label vector until the belt is empty.
pub(super) fn enumerated(
    model: &SortingModel,
    timing: &Timing,
    (state, viewpoint): (&State, Viewpoint),
) -> f64 {
    if state.is_over() {
        return 0.0;
    }
    let after = |ticks: usize| {
        let mut next = state.clone();
        let missed = next.pass(timing, model, ticks);
        (next, missed, model.discount().powi(i32::try_from(ticks).unwrap()))
    };
    let (next, missed, discount) = after(1);
    let mut best = discount * enumerated(model, timing, (&next, viewpoint)) - missed;
    for place in (0..timing.reach).filter(|place| !state.decided[*place]) {
        let (mut decided, reward) = (state.clone(), model.best_decision(&state.rows[place]).1);
        decided.decided[place] = true;
        let missed = decided.pass(timing, model, timing.sort_ticks);
        let discount = model.discount().powi(i32::try_from(timing.sort_ticks).unwrap());
        best = best.max(reward - missed + discount * enumerated(model, timing, (&decided, viewpoint)));
    }
    for &to in model.legal_moves(viewpoint) {
        let (next, missed, discount) = after(timing.look(viewpoint, to));
        let value = labelled(model, timing, (&next, to), 0);
        best = best.max(discount * value - model.motion_cost(viewpoint, to) - missed);
    }
    best
}

/// Expectation of [`enumerated`] over the labels of the objects from a place on.
pub(super) fn labelled(
    model: &SortingModel,
    timing: &Timing,
    (state, viewpoint): (&State, Viewpoint),
    place: usize,
) -> f64 {
    if place == timing.places {
        return enumerated(model, timing, (state, viewpoint));
    }
    if state.decided[place] {
        return labelled(model, timing, (state, viewpoint), place + 1);
    }
    let look = Look::first(Position(place), viewpoint);
    let mut sum = 0.0;
    for label in model.labels() {
        let mut next = state.clone();
        let p = condition(&mut next.rows[place], model.likelihoods(look, label));
        if p > 0.0 {
            sum += p * labelled(model, timing, (&next, viewpoint), place + 1);
        }
    }
    sum
}

/// A tiny belt: model, durations, and a state with at most one object to come.
pub(super) fn tiny_belts() -> impl Strategy<Value = (SortingModel, Timing, State)> {
    let durations = (1..=3_usize, 1..=2_usize, prop::collection::vec(1..=2_usize, 4), 0..=1_usize);
    let start = (0..3_usize, 0..=1_usize, any::<bool>(), prop::collection::vec(0.02..1.0_f64, 8));
    let missed = prop::collection::vec(0.0..8.0_f64, 3);
    (enumerable_models(), durations, start, missed, prop_oneof![Just(0.9), Just(0.6)]).prop_map(
        |(
            model,
            (period, reach, looks, sort_ticks),
            (offset, to_come, decided, weights),
            missed,
            discount,
        )| {
            let mut spec = model.spec().clone();
            spec.discount = discount;
            let model = SortingModel::new(spec).unwrap();
            let (k, places) = (model.viewpoint_count(), model.position_count());
            let kinds = model.kinds().map(|kind| missed[model.class_of(kind).0]).collect();
            let timing = Timing {
                ticks_per_place: period,
                reach: reach.min(places),
                sort_ticks,
                missed: kinds,
                places,
                look_ticks: looks[..k * k].to_vec(),
                viewpoints: k,
            };
            let n = model.kind_count();
            let row = |place: usize| {
                let weights: Vec<f64> =
                    (0..n).map(|kind| weights[(place * n + kind) % weights.len()]).collect();
                weights.iter().map(|w| w / weights.iter().sum::<f64>()).collect()
            };
            let state = State {
                rows: (0..places).map(row).collect(),
                decided: (0..places).map(|place| decided && place == 1).collect(),
                offset: offset % period,
                to_come: Some(to_come),
            };
            (model, timing, state)
        },
    )
}

/// The paper's model on a belt with a reach of all places.
pub(super) fn paper_timing(model: &SortingModel, ticks_per_place: usize) -> Timing {
    let (places, viewpoints) = (model.position_count(), model.viewpoint_count());
    Timing {
        ticks_per_place,
        reach: places,
        sort_ticks: 0,
        missed: vec![10.0; model.kind_count()],
        places,
        look_ticks: vec![1; viewpoints * viewpoints],
        viewpoints,
    }
}

proptest! {
    #![proptest_config(seeded(48))]

    #[test]
    fn the_priced_bound_is_at_least_the_value((model, timing, state) in tiny_belts()) {
        let problem = Arc::new(DeadlineProblem::new(&model, &timing));
        let value = enumerated(&model, &timing, (&state, FROM));
        for bound in PricedBound::new(problem).each() {
            prop_assert!(bound.value(&state, FROM) >= value - 1e-9, "{} below {value}", bound.value(&state, FROM));
        }
    }

    #[test]
    fn the_default_policy_earns_at_most_the_value((model, timing, state) in tiny_belts()) {
        let serving = Serving::new(&model, &timing, &NEVER);
        let (value, earned) = (enumerated(&model, &timing, (&state, FROM)), serving.value(&state, FROM));
        prop_assert!(earned <= value + 1e-9, "{earned} above {value}");
    }

    /// One object that pays for its looks alone: the grid's bound is nearly exact.
    #[test]
    fn one_object_with_a_deadline_is_solved((model, timing, mut state) in tiny_belts()) {
        let timing = Timing { sort_ticks: 0, ..timing };
        let problem = DeadlineProblem::new(&model, &timing);
        let values = problem.values(&vec![1.0; problem.horizon() + 1]);
        state.to_come = Some(0);
        for place in 0..timing.places {
            state.decided = (0..timing.places).map(|other| other != place).collect();
            let value = enumerated(&model, &timing, (&state, FROM));
            let n = state.ticks_left(&timing, place);
            let bound = problem.at(&values, n, problem.group(FROM), &problem.locate(&state.rows[place]));
            prop_assert!(value - 1e-9 <= bound && bound < value + 0.6, "{bound} for {value}");
        }
    }

    /// Places that see alike, all in reach: the set of beliefs at which one decides grows towards the exit.
    #[test]
    fn thresholds_fall_towards_the_exit((model, timing, _) in tiny_belts(), ticks_per_place in 3..6_usize) {
        let mut spec = model.spec().clone();
        spec.p_obs = vec![spec.p_obs[0].clone(); spec.p_obs.len()];
        let model = SortingModel::new(spec).unwrap();
        let timing = Timing { ticks_per_place, reach: timing.places, ..timing };
        let problem = DeadlineProblem::new(&model, &timing);
        let values = problem.values(&vec![1.0; problem.horizon() + 1]);
        for class in model.classes() {
            let kinds = Kinds::towards(&model, class);
            let thresholds: Vec<_> = (1..=timing.visible())
                .map(|n| problem.threshold(&values, n, 0, &kinds).unwrap_or(f64::INFINITY))
                .collect();
            prop_assert!(thresholds.windows(2).all(|pair| pair[0] <= pair[1]), "{thresholds:?}");
        }
    }
}

#[test]
fn thresholds_of_the_paper_fall_where_places_see_alike() {
    let model = paper(50.0).with_positions(1).unwrap();
    let problem = DeadlineProblem::new(&model, &paper_timing(&model, 8));
    let values = problem.values(&vec![1.0; problem.horizon() + 1]);
    let kinds = Kinds::towards(&model, Class(0));
    let thresholds: Vec<_> = (1..=8).map(|n| problem.threshold(&values, n, 0, &kinds).unwrap()).collect();
    assert!(thresholds.windows(2).all(|pair| pair[0] <= pair[1]), "{thresholds:?}");
    assert!(thresholds[7] > thresholds[0] + 0.1, "{thresholds:?}");
}

#[test]
fn improved_shares_lower_the_bound_of_the_paper() {
    let model = paper(50.0);
    let timing = paper_timing(&model, 3);
    let bound = PricedBound::new(Arc::new(DeadlineProblem::new(&model, &timing)));
    let state = State::unseen(&timing, model.arrival().as_slice());
    let [uniform, improved] = bound.each().map(|bound| bound.value(&state, FROM));
    assert!(improved < uniform, "{improved}, {uniform}");
    let shares = bound.shares();
    for first in 1..=3 {
        let sum: f64 = shares[first..].iter().step_by(3).sum();
        assert!(shares.iter().all(|share| *share >= 0.0) && (sum - 1.0).abs() < 1e-9, "{shares:?}");
    }
}
