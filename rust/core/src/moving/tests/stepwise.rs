//! A belt that advances on decisions is the model alone, if every action takes one tick.

use proptest::prelude::*;

use super::*;
use crate::belief::Belief;
use crate::model::Action;
use crate::policy::{Policy, Threshold};
use crate::simulate::{EvaluationConfig, evaluate};
use crate::testing::{Exact, all_labels, belief_of, belts, enumerated_value, tiny_models};

/// A belt that advances on decisions, all of whose actions take one tick: the model alone.
fn stepwise(model: &SortingModel) -> MovingBelt {
    MovingBelt::new(model.clone(), MovingSpec::new(Drive::OnDecision { advance_ticks: 1 })).unwrap()
}

/// A policy for the model, on a belt that advances on decisions.
struct Stepwise<'a>(&'a SortingModel, &'a dyn Policy);

impl MovingPolicy for Stepwise<'_> {
    fn act(&self, belief: &MovingBelief, viewpoint: Viewpoint) -> crate::error::Result<MovingAction> {
        let rows: Vec<_> = self.0.positions().map(|j| belief.position(j).to_vec()).collect();
        Ok(match self.1.act(&Belief::from_rows(self.0, &rows)?, viewpoint)? {
            Action::Move(to) => MovingAction::Look(to),
            Action::Decide(bin) => MovingAction::Decide { position: Position(0), bin },
        })
    }
}

proptest! {
    #![proptest_config(seeded(48))]

    /// Where the belt advances on decisions and every action takes a tick, Bellman's operator is that of the model: so many
    /// steps of it, from the same values behind them, give the same.
    #[test]
    fn a_belt_that_advances_on_decisions_is_the_model(
        model in enumerable_models(),
        weights in prop::collection::vec(0.02..1.0_f64, 8),
        remaining in belts(),
        depth in 1..=4_usize,
    ) {
        let alone = belief_of(&model, &weights).with_remaining(remaining);
        let rows: Vec<_> =
            alone.as_slice().chunks_exact(model.kind_count()).map(<[f64]>::to_vec).collect();
        let places = model.position_count();
        let decided = (0..places).map(|j| remaining.is_some_and(|objects| j >= objects)).collect();
        let to_come = remaining.map(|objects| objects.saturating_sub(places));
        let belt = stepwise(&model);
        let belief = MovingBelief::from_parts(&belt, &rows, decided, 0, to_come).unwrap();
        let (low, high) = enumerated_value(&model, &alone, FROM, depth);
        let found = stepwise_value(&belt, &belief, FROM, depth);
        prop_assert!((low - found.0).abs() < 1e-9 && (high - found.1).abs() < 1e-9, "{low} {high} {found:?}");
    }

    /// The same, against the exact solution of tiny models.
    #[test]
    fn a_belt_that_advances_on_decisions_has_the_models_value(tiny in tiny_models(1..=2), remaining in belts()) {
        let (low, high) = Exact::new(&tiny).bounds(&Belief::new(&tiny.model).with_remaining(remaining))[0];
        let belt = stepwise(&tiny.model);
        let (at_least, at_most) = stepwise_value(&belt, &MovingBelief::new(&belt, remaining), FROM, 5);
        prop_assert!(at_least <= high + 1e-9 && low <= at_most + 1e-9, "[{low}, {high}] [{at_least}, {at_most}]");
    }

    /// The same policy meets the same objects and earns the same rewards.
    #[test]
    fn runs_of_a_belt_that_advances_on_decisions_are_batches_of_the_model(
        model in enumerable_models(),
        threshold in 0.5..0.9_f64,
        seed in 0..1000_u64,
    ) {
        let policy = Threshold::new(&model, threshold, None).unwrap();
        let config = EvaluationConfig { batches: 8, batch_size: 5, seed, ..EvaluationConfig::default() };
        let batches = evaluate(&model, &model, &policy, &config).unwrap();
        prop_assume!(batches.forced.iter().all(|forced| *forced == 0));
        let belt = stepwise(&model);
        let runs = MovingRuns { runs: 8, objects: 5, seed, viewpoint: FROM };
        let runs = evaluate_moving(&belt, &Stepwise(&model, &policy), &runs).unwrap();
        for (index, run) in runs.into_iter().enumerate() {
            prop_assert!((run.total - batches.returns[index]).abs() < 1e-9);
            prop_assert!((run.discounted - batches.discounted_returns[index]).abs() < 1e-9);
            prop_assert_eq!((run.ticks, run.right), (batches.steps[index], batches.correct[index]));
            prop_assert_eq!(&run.confusion, &batches.confusion[index]);
        }
    }
}

/// Bounds of the value of a belt that advances on decisions by so many steps, as [`enumerated_value`] has them.
fn stepwise_value(
    belt: &MovingBelt,
    belief: &MovingBelief,
    viewpoint: Viewpoint,
    depth: usize,
) -> (f64, f64) {
    let model = belt.model();
    if belief.is_over() {
        return (0.0, 0.0);
    }
    if depth == 0 {
        return enumerated_value(model, &Belief::new(model), viewpoint, 0);
    }
    let after = |reward: f64, (low, high): (f64, f64)| {
        (reward + model.discount() * low, reward + model.discount() * high)
    };
    let mut decided = belief.clone();
    decided.decide(belt, Position(0)).unwrap();
    assert!(decided.advance_time(belt, belt.decision_ticks()).abs() < 1e-12);
    let reward = model.best_decision(belief.position(Position(0))).1;
    let mut highest = after(reward, stepwise_value(belt, &decided, viewpoint, depth - 1));
    for &to in model.legal_moves(viewpoint) {
        let mut next = belief.clone();
        next.advance_time(belt, belt.look_ticks(viewpoint, to));
        let mut seen = (0.0, 0.0);
        for labels in all_labels(model, model.position_count()) {
            let shown: Vec<_> = labels
                .iter()
                .zip(next.decided())
                .map(|(label, decided)| (!decided).then_some(*label))
                .collect();
            // A place without an object gives no label: its label vectors are one.
            let alike = |(label, shown): (&Label, &Option<Label>)| shown.is_some() || label.0 == 0;
            if !labels.iter().zip(&shown).all(alike) {
                continue;
            }
            let p: f64 = model
                .positions()
                .zip(&shown)
                .map(|(j, label)| label.map_or(1.0, |label| next.label_probability(belt, j, to, label)))
                .product();
            let mut posterior = next.clone();
            posterior.observe(belt, to, &shown).unwrap();
            let value = stepwise_value(belt, &posterior, to, depth - 1);
            seen = (seen.0 + p * value.0, seen.1 + p * value.1);
        }
        let value = after(-model.motion_cost(viewpoint, to), seen);
        highest = (highest.0.max(value.0), highest.1.max(value.1));
    }
    highest
}
