use proptest::prelude::*;

use std::sync::atomic::Ordering;

use super::controller::Controller;
use super::evaluation::policy_value;
use super::graph::{BeliefGraph, ROOT};
use super::reach::Reach;
use super::*;
use crate::index::Bin;
use crate::model::ModelSpec;
use crate::testing::{
    Exact, belief_of, enumerable_models, enumerated_value, from_weights, paper, seeded, tiny_beliefs,
    tiny_models,
};

fn solve(model: &SortingModel, milliseconds: u64) -> Solution {
    Solution::solve(model, Duration::from_millis(milliseconds), &AtomicBool::new(false), &mut |_, _| {})
        .unwrap()
}

/// Solve with more and more time, until the solution is good enough for what is to be tested.
fn solved_until(enough: impl Fn(&Solution) -> bool, model: &SortingModel, milliseconds: u64) -> Solution {
    (0..8).map(|n| solve(model, milliseconds << n)).find(enough).expect("good enough in a few minutes")
}

proptest! {
    #![proptest_config(seeded(8))]

    #[test]
    fn certificates_enclose_the_enumerated_value(
        model in enumerable_models(),
        weights in prop::collection::vec(0.02..1.0_f64, 6),
    ) {
        let anywhere = belief_of(&model, &weights);
        let solution = solve(&model, 60);
        let start = (Belief::new(&model), (solution.lower, solution.upper));
        let elsewhere = (anywhere.clone(), solution.bounds(&anywhere, Viewpoint(0)).unwrap());
        for (belief, (lower, upper)) in [start, elsewhere] {
            let (at_least, at_most) = enumerated_value(&model, &belief, Viewpoint(0), 4);
            prop_assert!(lower <= upper);
            prop_assert!(lower <= at_most, "lower bound {lower} above V* <= {at_most}");
            prop_assert!(upper >= at_least, "upper bound {upper} below V* >= {at_least}");
        }
    }

    #[test]
    fn certificates_enclose_the_value_to_a_millionth(
        tiny in tiny_models(1..=2),
        beliefs in prop::collection::vec(tiny_beliefs(), 3),
    ) {
        let (model, exact) = (&tiny.model, Exact::new(&tiny));
        let solution = solve(model, 100);
        let (at_least, at_most) = exact.bounds(&Belief::new(model))[0];
        let (lower, upper) = (solution.lower, solution.upper);
        prop_assert!(lower <= at_most && upper >= at_least, "[{lower}, {upper}] without V* = {at_least}");
        let start = std::iter::once(Belief::new(model));
        for belief in start.chain(beliefs.iter().map(|weights| belief_of(model, weights))) {
            for (viewpoint, (at_least, at_most)) in model.viewpoints().zip(exact.bounds(&belief)) {
                let (lower, upper) = solution.bounds(&belief, viewpoint).unwrap();
                prop_assert!(lower <= at_most, "{belief:?}: {lower} above V* = {at_most}");
                prop_assert!(upper >= at_least, "{belief:?}: {upper} below V* = {at_least}");
            }
        }
    }

    #[test]
    fn the_certificate_of_one_position_is_tight(tiny in tiny_models(1..=1)) {
        let model = &tiny.model;
        // Where viewpoints differ the upper bound is the closed form, lowered by search.
        let tight = |s: &Solution| !all_alike(model) || s.upper - s.lower < 5e-3 * model.spec().r_max;
        let solution = solved_until(tight, model, 250);
        let (lower, upper) = (solution.lower, solution.upper);
        let (at_least, at_most) = Exact::new(&tiny).bounds(&Belief::new(model))[0];
        prop_assert!(lower <= at_most && upper >= at_least, "[{lower}, {upper}] without V* = {at_least}");
    }
}

#[test]
fn one_object_problems_are_solved() {
    // SARSOP, two minutes each: 46.987, [17.496, 17.500], [5.820, 5.842].
    for (r_min, at_least, at_most, gap) in
        [(5.0, 46.986, 46.988, 0.001), (50.0, 17.4955, 17.5, 0.01), (500.0, 5.8195, 5.842, 0.2)]
    {
        let model = paper(r_min).with_positions(1).unwrap();
        let solution = solved_until(|s| s.upper - s.lower < gap * s.lower, &model, 1000);
        let (lower, upper) = (solution.lower, solution.upper);
        assert!(
            at_least <= upper && lower <= at_most,
            "[{lower}, {upper}] contradicts the published optimum"
        );
    }
}

#[test]
fn bounds_at_the_start_only_tighten() {
    let model = paper(50.0);
    let tightened = (0..7).any(|n| {
        let mut seen = Vec::new();
        let mut note = |lower, upper| seen.push((lower, upper));
        let time = Duration::from_secs(1 << n);
        let solution = Solution::solve(&model, time, &AtomicBool::new(false), &mut note).unwrap();
        for pair in seen.windows(2) {
            assert!(pair[0].0 <= pair[1].0 + 1e-9 && pair[0].1 >= pair[1].1 - 1e-9, "{pair:?}");
        }
        seen.len() > 2 && solution.lower > 18.0 && solution.upper < 40.0
    });
    assert!(tightened);
}

#[test]
fn the_policy_looks_at_the_unknown_and_decides_the_certain() {
    let model = paper(50.0);
    let solution = solved_until(|s| s.upper - s.lower < 10.0, &model, 500);
    assert!(matches!(solution.act(&Belief::new(&model), Viewpoint(0)).unwrap(), Action::Move(_)));
    let certain = Belief::from_rows(&model, &[vec![0.0, 1.0, 0.0, 0.0], vec![0.25; 4]]).unwrap();
    assert_eq!(solution.act(&certain, Viewpoint(2)).unwrap(), Action::Decide(Bin(1)));
}

#[test]
fn a_set_flag_stops_the_solver() {
    let stop = AtomicBool::new(false);
    let mut stop_at_once = |_, _| stop.store(true, Ordering::Relaxed);
    let for_ever = Duration::from_secs(1 << 20);
    let solution = Solution::solve(&paper(50.0), for_ever, &stop, &mut stop_at_once).unwrap();
    assert!(solution.lower <= solution.upper);
}

#[test]
fn what_cannot_be_solved_is_refused() {
    let refused = |model: &SortingModel, time| {
        Solution::solve(model, time, &AtomicBool::new(false), &mut |_, _| {}).unwrap_err().to_string()
    };
    let error = refused(&paper(50.0), Duration::ZERO);
    assert!(error.contains("seconds") && error.contains('0'), "{error}");
    let spec = ModelSpec { observe_after_decision: true, ..paper(50.0).spec().clone() };
    let error = refused(&SortingModel::new(spec).unwrap(), Duration::from_secs(1));
    assert!(error.contains("observe_after_decision"), "{error}");
}

#[test]
fn a_model_whose_label_vectors_are_too_many_has_both_bounds_and_a_policy() {
    let mut spec = paper(50.0).spec().clone();
    while spec.p_obs.len() < 7 {
        spec.p_obs.push(spec.p_obs[1].clone());
    }
    let model = SortingModel::new(spec).unwrap();
    let closed = bounds::upper(&model, Belief::new(&model).known(), Viewpoint(0));
    let solution = solved_until(|solution| solution.upper < 0.9 * closed, &model, 1000);
    assert!(0.0 < solution.lower && solution.lower < solution.upper);
    assert!(matches!(solution.act(&Belief::new(&model), Viewpoint(0)).unwrap(), Action::Move(_)));
}

#[test]
fn a_certified_grid_lies_above_its_own_backup() {
    let model = paper(50.0);
    let arrival = Belief::new(&model).as_slice().to_vec();
    let mut bound = GridBound::new(&model, stages::resolution(8.0, 0.6));
    // Stopped long before it has converged, or as soon as it has: proved either way.
    for sweeps in [3, 1000] {
        let left = std::cell::Cell::new(sweeps);
        bound.improve(&model, 1e-3, || left.replace(left.get() - 1) == 0);
        assert!(bound.largest_rise(&model) < 1e-5, "{}", bound.largest_rise(&model));
        assert!(bound.look_ahead(&model, &arrival, Viewpoint(0)).1 <= bound.value(&arrival));
    }
    let finer = bound.refined(&model, stages::resolution(11.0, 0.6));
    assert!(finer.value(&arrival) >= bound.value(&arrival) - 1e-4, "interpolated, so no tighter");
}

/// A searched graph with what it is searched by.
fn with_searched<T>(
    model: &SortingModel,
    rounds: usize,
    then: impl FnOnce(&BeliefGraph<'_>, &LeafBounds) -> T,
) -> T {
    let arrival = Belief::new(model).as_slice().to_vec();
    let mut grid = GridBound::new(model, stages::resolution(8.0, 0.6));
    grid.improve(model, 1e-3, || false);
    let leaves = LeafBounds {
        policy: OneObjectPolicy::solve(model),
        grid: Some(Arc::new(grid)),
        prices: None,
        alphas: None,
    };
    let mut graph = BeliefGraph::new(model, &leaves, &arrival, Viewpoint(0));
    for _ in 0..rounds {
        Reach::new(&graph, model.discount()).grow(&mut graph, || false);
    }
    then(&graph, &leaves)
}

#[test]
fn search_lowers_the_bound_and_the_exit_mass() {
    let model = paper(50.0);
    let after = |rounds| {
        with_searched(&model, rounds, |graph, _| {
            let exit_mass: f64 = Reach::new(graph, 0.95).leaves.iter().map(|(_, weight)| weight).sum();
            (exit_mass, graph.upper(ROOT))
        })
    };
    let [(all, grid), (some, searched), (less, further)] = [0, 10, 25].map(after);
    assert!((all - 1.0).abs() < 1e-12);
    assert!(less < some && some < all, "{all} {some} {less}");
    assert!(further < searched && searched < grid, "{grid} {searched} {further}");
}

#[test]
fn policies_of_the_graph_improve_and_stay_below_the_upper_bound() {
    for r_min in [5.0, 50.0] {
        let model = paper(r_min);
        with_searched(&model, 20, |graph, leaves| {
            let reach = Reach::new(graph, model.discount());
            let arrival = graph.belief(ROOT).0;
            let simple = AlphaVectors::chained(&model, &leaves.policy, std::slice::from_ref(&arrival));
            let mut controller = Controller::new(&model, graph, &reach, &simple);
            controller.evaluate(|| true);
            assert!(controller.value() <= graph.upper(ROOT), "certified however early it is stopped");
            controller.evaluate(|| false);
            let first = controller.value();
            controller.close();
            controller.evaluate(|| false);
            assert!(first < controller.value() && controller.value() <= graph.upper(ROOT));
            let chained = policy_value(&model, &leaves.policy, graph, &reach, || false);
            assert!(chained <= graph.upper(ROOT));
        });
    }
}

proptest! {
    #![proptest_config(seeded(12))]

    #[test]
    fn what_search_finds_is_proved_however_early_it_is_stopped(tiny in tiny_models(1..=2), rounds in 1..12_usize) {
        let model = &tiny.model;
        prop_assume!(all_alike(model));
        let (at_least, at_most) = Exact::new(&tiny).bounds(&Belief::new(model))[0];
        let at_most = at_most + SLACK * model.spec().r_max;
        with_searched(model, rounds, |graph, leaves| {
            let reach = Reach::new(graph, model.discount());
            let simple = AlphaVectors::chained(model, &leaves.policy, &[graph.belief(ROOT).0]);
            prop_assert!(graph.upper(ROOT) >= at_least - SLACK * model.spec().r_max);
            prop_assert!(policy_value(model, &leaves.policy, graph, &reach, || false) <= at_most);
            for sweeps in [0, 1, 2, 3, 1000] {
                let left = std::cell::Cell::new(sweeps);
                let stop = || left.replace(left.get() - 1) == 0;
                let mut controller = Controller::new(model, graph, &reach, &simple);
                controller.evaluate(stop);
                prop_assert!(controller.value() <= at_most, "{} above V* = {at_most}", controller.value());
                controller.close();
                left.set(sweeps);
                controller.evaluate(stop);
                prop_assert!(controller.value() <= at_most, "{} above V* = {at_most}", controller.value());
            }
            Ok(())
        })?;
    }
}

#[test]
fn many_classes_begin_with_a_coarser_grid() {
    let model = SortingModel::new(from_weights(2, 1, 12, &[0.5; 2 * 144])).unwrap();
    let solution = solved_until(|s| s.upper < 200.0, &model, 200);
    assert!(solution.lower <= solution.upper);
}
