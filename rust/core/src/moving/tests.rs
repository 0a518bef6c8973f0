//! Laws of belief, simulation and threshold policies.

use proptest::prelude::*;

use super::*;
use crate::error::Error;
use crate::index::{Bin, Kind, Label, Position, Viewpoint};
use crate::model::{Look, SortingModel};
use crate::testing::{enumerable_models, paper, seeded};

mod stepwise;

const FROM: Viewpoint = Viewpoint(0);

fn belt(model: &SortingModel, ticks_per_place: usize) -> MovingBelt {
    let missed = Some(vec![10.0; model.class_count()]);
    let spec = MovingSpec { missed, ..MovingSpec::new(Drive::Constant { ticks_per_place }) };
    MovingBelt::new(model.clone(), spec).unwrap()
}

/// One undecided object and no other: the belief of a belt whose places behind it are empty.
fn one_object(belt: &MovingBelt) -> MovingBelief {
    MovingBelief::new(belt, Some(1))
}

#[test]
fn the_belt_advances_on_its_own_and_an_undecided_object_is_missed_when_it_leaves() {
    let model = paper(50.0);
    let belt = belt(&model, 3);
    let mut belief = MovingBelief::new(&belt, Some(3));
    assert_eq!((belief.offset(), belief.to_come()), (0, Some(1)));
    assert!(belief.advance_time(&belt, 2).abs() < 1e-12);
    assert_eq!((belief.offset(), belief.ticks_left(&belt, Position(1))), (2, Some(4)));
    let missed = belief.advance_time(&belt, 2);
    assert!((missed - 10.0 * model.discount()).abs() < 1e-12, "{missed}");
    assert_eq!((belief.offset(), belief.to_come()), (1, Some(0)));
    assert_eq!(belief.decided(), [false, false]);
    belief.decide(&belt, Position(0)).unwrap();
    assert!(belief.advance_time(&belt, 2).abs() < 1e-12);
    assert_eq!(belief.decided(), [false, true]);
    belief.decide(&belt, Position(0)).unwrap();
    assert!(belief.is_over());
}

#[test]
fn what_cannot_be_decided_or_seen_is_refused_and_nothing_changes() {
    let model = paper(50.0);
    let belt = belt(&model, 3);
    let mut belief = MovingBelief::new(&belt, None);
    assert!(belief.decide(&belt, Position(1)).unwrap_err().to_string().contains("out of reach"));
    belief.decide(&belt, Position(0)).unwrap();
    let before = belief.clone();
    assert!(belief.decide(&belt, Position(0)).unwrap_err().to_string().contains("decided already"));
    for (viewpoint, labels) in [(0, vec![None]), (9, vec![None; 2]), (0, vec![None, Some(Label(9))])] {
        assert!(matches!(belief.observe(&belt, Viewpoint(viewpoint), &labels), Err(Error::Argument(_))));
    }
    belief.observe(&belt, FROM, &[Some(Label(1)), None]).unwrap();
    assert_eq!(belief, before, "labels of decided objects are ignored");
}

proptest! {
    #![proptest_config(seeded(48))]

    /// One scan, an advance of the belt, another scan: rows are the marginals of the joint posterior over the kinds of all
    /// objects that were seen.
    #[test]
    fn the_belief_is_the_joint_posterior(model in enumerable_models(), first in 0..4_usize, second in 0..4_usize) {
        let belt = belt(&model, 1);
        let places = model.position_count();
        let labels = |code: usize| -> Vec<Option<Label>> {
            (0..places).map(|j| Some(Label((code >> j) % 2))).collect()
        };
        let (first, second) = (labels(first), labels(second));
        let mut belief = MovingBelief::new(&belt, None);
        belief.observe(&belt, FROM, &first).unwrap();
        belief.advance_time(&belt, 1);
        belief.observe(&belt, FROM, &second).unwrap();

        let n = model.kind_count();
        let objects = places + 1;
        let mut marginals = vec![vec![0.0; n]; places];
        for code in 0..n.pow(u32::try_from(objects).unwrap()) {
            let kinds: Vec<_> = (0..objects).map(|i| Kind(code / n.pow(u32::try_from(i).unwrap()) % n)).collect();
            let mut p: f64 = kinds.iter().map(|kind| model.arrival()[kind.0]).product();
            for (j, position) in model.positions().enumerate() {
                let look = Look::first(position, FROM);
                p *= model.likelihood(look, first[j].unwrap(), kinds[j]);
                p *= model.likelihood(look, second[j].unwrap(), kinds[j + 1]);
            }
            for (j, row) in marginals.iter_mut().enumerate() {
                row[kinds[j + 1].0] += p;
            }
        }
        for (position, row) in model.positions().zip(marginals) {
            let sum: f64 = row.iter().sum();
            let held = belief.position(position);
            prop_assert!((held.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            prop_assert!(held.iter().zip(&row).all(|(b, p)| (b - p / sum).abs() < 1e-9), "{held:?} {row:?}");
        }
    }

    /// The mean of simulated runs is the policy's value, which is found by trying every label vector.
    #[test]
    fn runs_earn_on_average_what_enumeration_says(
        model in enumerable_models(),
        ticks_per_place in 2..=3_usize,
        high in 0.6..0.95_f64,
        per_tick in any::<bool>(),
    ) {
        const RUNS: usize = 2000;
        let belt = belt(&model, ticks_per_place);
        let rule = if per_tick { LookRule::InformationPerTick } else { LookRule::MostUrgent };
        let policy = MovingThreshold::new(&belt, high, 0.5, rule).unwrap();
        let config = MovingRuns { runs: RUNS, objects: 2, seed: 7, viewpoint: FROM };
        let outcomes = evaluate_moving(&belt, &policy, &config).unwrap();
        let mean = outcomes.iter().map(|run| run.discounted).sum::<f64>() / RUNS as f64;
        let squares = outcomes.iter().map(|run| (run.discounted - mean).powi(2)).sum::<f64>();
        let error = (squares / (RUNS * (RUNS - 1)) as f64).sqrt();
        let value = value_of(&belt, &policy, &MovingBelief::new(&belt, Some(2)), FROM);
        prop_assert!((mean - value).abs() < 5.0 * error + 1e-9, "{mean} +- {error}, {value}");
        for run in outcomes {
            prop_assert_eq!(run.right + run.wrong + run.missed.iter().sum::<u64>(), 2);
            prop_assert_eq!(run.confusion.iter().sum::<u64>(), run.right + run.wrong);
        }
    }

    /// Whatever the policy does, it meets the same objects.
    #[test]
    fn policies_meet_the_same_objects(model in enumerable_models(), seed in 0..1000_u64) {
        let belt = belt(&model, 2);
        let config = MovingRuns { runs: 5, objects: 4, seed, viewpoint: FROM };
        let classes = |high: f64| -> Vec<Vec<u64>> {
            let policy = MovingThreshold::new(&belt, high, high, LookRule::MostUrgent).unwrap();
            let outcomes = evaluate_moving(&belt, &policy, &config).unwrap();
            let l = model.class_count();
            outcomes
                .iter()
                .map(|run| (0..l).map(|c| {
                    run.missed[c] + run.confusion.iter().skip(c).step_by(l).sum::<u64>()
                }).collect())
                .collect()
        };
        prop_assert_eq!(classes(0.5), classes(0.99));
    }
}

/// A decision of four ticks on the object in front leaves the one behind no time: it has to be taken before the next look.
#[test]
fn the_last_chance_counts_the_decisions_in_front() {
    let model = paper(5.0);
    for (sort_ticks, decided) in [(0, false), (4, true)] {
        let spec =
            MovingSpec { reach: 2, sort_ticks, ..MovingSpec::new(Drive::Constant { ticks_per_place: 2 }) };
        let belt = MovingBelt::new(model.clone(), spec).unwrap();
        let policy = MovingThreshold::new(&belt, 1.0, 1.0, LookRule::MostUrgent).unwrap();
        let action = policy.act(&MovingBelief::new(&belt, Some(2)), FROM).unwrap();
        let first = matches!(action, MovingAction::Decide { position: Position(0), .. });
        assert_eq!(first, decided, "{action:?}");
    }
}

/// What a policy is worth, by every label vector it may meet.
fn value_of(
    belt: &MovingBelt,
    policy: &dyn MovingPolicy,
    belief: &MovingBelief,
    viewpoint: Viewpoint,
) -> f64 {
    if belief.is_over() {
        return 0.0;
    }
    let model = belt.model();
    let mut next = belief.clone();
    match policy.act(belief, viewpoint).unwrap() {
        MovingAction::Wait => {
            let missed = next.advance_time(belt, 1);
            model.discount() * value_of(belt, policy, &next, viewpoint) - missed
        }
        MovingAction::Decide { position, bin } => {
            next.decide(belt, position).unwrap();
            model.expected_decision_reward(bin, belief.position(position))
                + value_of(belt, policy, &next, viewpoint)
        }
        MovingAction::Look(to) => {
            let missed = next.advance_time(belt, 1);
            let seen = value_of_scan((belt, policy), &next, to, &mut Vec::new());
            model.discount() * seen - missed - model.motion_cost(viewpoint, to)
        }
    }
}

fn value_of_scan(
    (belt, policy): (&MovingBelt, &dyn MovingPolicy),
    belief: &MovingBelief,
    viewpoint: Viewpoint,
    labels: &mut Vec<Option<Label>>,
) -> f64 {
    let position = Position(labels.len());
    if position.0 == belt.model().position_count() {
        let mut seen = belief.clone();
        seen.observe(belt, viewpoint, labels).unwrap();
        return value_of(belt, policy, &seen, viewpoint);
    }
    let mut sum = 0.0;
    let decided = belief.decided()[position.0];
    let possible: Vec<_> = if decided { vec![None] } else { belt.model().labels().map(Some).collect() };
    for label in possible {
        let p = label.map_or(1.0, |label| belief.label_probability(belt, position, viewpoint, label));
        labels.push(label);
        sum += p * value_of_scan((belt, policy), belief, viewpoint, labels);
        labels.pop();
    }
    sum
}

/// With a threshold that is never reached, an object is decided at its last chance, if that is better than a miss.
#[test]
fn the_last_chance_is_taken_where_it_is_worth_more_than_a_miss() {
    for (r_min, decided) in [(5.0, true), (500.0, false)] {
        let model = paper(r_min);
        let belt = belt(&model, 3);
        let policy = MovingThreshold::new(&belt, 1.0, 1.0, LookRule::MostUrgent).unwrap();
        let mut belief = one_object(&belt);
        assert!(matches!(policy.act(&belief, FROM).unwrap(), MovingAction::Look(_)));
        belief.advance_time(&belt, 2);
        let action = policy.act(&belief, FROM).unwrap();
        let expected = MovingAction::Decide { position: Position(0), bin: Bin(0) };
        assert_eq!(action == expected, decided, "{action:?}");
    }
}

#[test]
fn a_falling_threshold_decides_late_what_a_high_one_does_not() {
    let model = paper(5.0);
    let belt = belt(&model, 4);
    let mut belief = one_object(&belt);
    let label = Label(0);
    belief.observe(&belt, FROM, &[Some(label), None]).unwrap();
    let sure = belief.position(Position(0)).iter().copied().fold(0.0, f64::max);
    let falling = MovingThreshold::new(&belt, 1.0, sure - 0.2, LookRule::MostUrgent).unwrap();
    // Between the entry, 8 ticks before the exit, and the exit it falls by 0.655: 0.63 with 4 ticks left, 0.44 with 2.
    assert!(matches!(falling.act(&belief, FROM).unwrap(), MovingAction::Look(_)), "{sure}");
    belief.advance_time(&belt, 2);
    assert!(matches!(falling.act(&belief, FROM).unwrap(), MovingAction::Decide { .. }), "{sure}");
    let constant = MovingThreshold::new(&belt, 1.0, 1.0, LookRule::MostUrgent).unwrap();
    assert!(matches!(constant.act(&belief, FROM).unwrap(), MovingAction::Look(_)));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let model = paper(50.0);
    let belt = belt(&model, 3);
    for (high, low) in [(0.5, 0.9), (1.1, 0.9), (0.9, 0.0), (f64::NAN, 0.5)] {
        let error = MovingThreshold::new(&belt, high, low, LookRule::MostUrgent).unwrap_err().to_string();
        assert!(error.contains("threshold"), "{error}");
    }
    let policy = MovingThreshold::new(&belt, 0.9, 0.9, LookRule::MostUrgent).unwrap();
    for (runs, objects) in [(0, 5), (5, 0)] {
        let config = MovingRuns { runs, objects, seed: 0, viewpoint: FROM };
        assert!(matches!(evaluate_moving(&belt, &policy, &config), Err(Error::Argument(_))));
    }
    let config = MovingRuns { runs: 1, objects: 2, seed: 0, viewpoint: FROM };
    let error = evaluate_moving(&belt, &Wrong, &config).unwrap_err();
    assert!(matches!(&error, Error::Policy(text) if text.contains("out of reach")), "{error}");
}

/// Decides what is out of reach.
struct Wrong;

impl MovingPolicy for Wrong {
    fn act(&self, _: &MovingBelief, _: Viewpoint) -> crate::error::Result<MovingAction> {
        Ok(MovingAction::Decide { position: Position(1), bin: Bin(0) })
    }
}
