//! Laws of the search, against complete enumeration.

use proptest::prelude::*;

use super::super::tests::{FROM, enumerated, paper_timing, tiny_belts};
use super::*;
use crate::config::NEVER;
use crate::index::{Bin, Position};
use crate::testing::{paper, seeded};

/// A search that costs little to prepare and to run.
fn planned(model: &SortingModel, timing: &Timing, state: &State, trials: u64) -> (Searching, MovingPlan) {
    let config = MovingConfig { scenarios: 32, ..MovingConfig::default() };
    let searching = Searching::new(&Arc::new(model.clone()), timing, config, &NEVER).unwrap();
    let found = searching.search(state, FROM, Budget::Trials(trials), &NEVER).unwrap();
    (searching, found)
}

/// What is lost by an action, if everything after it is optimal.
fn regret(searching: &Searching, state: &State, found: &MovingPlan) -> f64 {
    let (model, timing) = (&searching.model, searching.timing());
    let best = enumerated(model, timing, (state, FROM));
    let (next, viewpoint, earned) = searching.after(state, FROM, found.action);
    let discount = searching.discount(found.action, FROM);
    let value = match found.action {
        MovingAction::Look(_) => super::super::tests::labelled(model, timing, (&next, viewpoint), 0),
        _ => enumerated(model, timing, (&next, viewpoint)),
    };
    best - earned - discount * value
}

proptest! {
    #![proptest_config(seeded(32))]

    #[test]
    fn the_value_lies_between_the_bounds_and_little_is_lost((model, timing, state) in tiny_belts()) {
        prop_assume!(!state.is_over());
        let value = enumerated(&model, &timing, (&state, FROM));
        let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
        for trials in [1, 10, 200] {
            let (searching, found) = planned(&model, &timing, &state, trials);
            prop_assert!(found.lower <= value + 1e-9 && value <= found.upper + 1e-9, "{found:?} for {value}");
            prop_assert!(lower <= found.lower + 1e-9 && found.upper <= upper + 1e-9, "{found:?} got worse");
            (lower, upper) = (found.lower, found.upper);
            if trials == 200 {
                let lost = regret(&searching, &state, &found);
                prop_assert!(lost < 0.5, "{lost} of {value} lost: {found:?}");
            }
        }
    }

    /// With a budget of trials a plan is a pure function of its arguments.
    #[test]
    fn plans_repeat((model, timing, state) in tiny_belts()) {
        prop_assume!(!state.is_over());
        let [(_, a), (_, b)] = [0, 1].map(|_| planned(&model, &timing, &state, 20));
        prop_assert_eq!((a.action, a.values, a.lower, a.upper), (b.action, b.values, b.lower, b.upper));
    }
}

#[test]
fn a_certain_object_in_reach_is_decided_at_once() {
    let model = paper(50.0);
    let timing = paper_timing(&model, 4);
    let mut state = State::unseen(&timing, model.arrival().as_slice());
    state.rows[1] = vec![0.0, 0.0, 1.0, 0.0];
    let (_, found) = planned(&model, &timing, &state, 1);
    assert_eq!(found.action, MovingAction::Decide { position: Position(1), bin: Bin(2) });
}

#[test]
fn nothing_is_planned_where_nothing_is_left() {
    let model = paper(50.0);
    let timing = paper_timing(&model, 4);
    let mut state = State::unseen(&timing, model.arrival().as_slice());
    (state.decided, state.to_come) = (vec![true; 2], Some(0));
    let searching = Searching::new(&Arc::new(model), &timing, MovingConfig::default(), &NEVER).unwrap();
    let error = searching.search(&state, FROM, Budget::Trials(1), &NEVER).unwrap_err();
    assert!(error.to_string().contains("no object is left"), "{error}");
}
