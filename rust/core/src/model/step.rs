//! What an action does, whatever is seen afterwards: to the camera, to the belt, and what it costs.

use super::{Action, SortingModel};
use crate::index::{Bin, Viewpoint};
use crate::remaining::Remaining;

/// What an action does before anything is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    /// Where the camera stands afterwards.
    pub viewpoint: Viewpoint,
    /// Objects left to decide afterwards.
    pub remaining: Remaining,
    /// The bin that the object at the belt end goes to, if it is sorted: then the belt advances.
    pub decided: Option<Bin>,
    /// From where a scan follows within the same step, if one does.
    pub scan: Option<Viewpoint>,
    /// What the motion costs.
    pub cost: f64,
}

impl SortingModel {
    /// What an action does with the camera at a viewpoint and so many objects left to decide.
    ///
    /// A scan follows each move, and a decision where the model observes after decisions and something is left to see.
    #[inline(always)]
    pub(crate) fn step(&self, action: Action, viewpoint: Viewpoint, remaining: Remaining) -> Step {
        match action {
            Action::Move(to) => Step {
                viewpoint: to,
                remaining,
                decided: None,
                scan: Some(to),
                cost: self.motion_cost(viewpoint, to),
            },
            Action::Decide(bin) => {
                let remaining = remaining.after(1);
                let scans = self.observes_after_decision() && !remaining.is_over();
                let scan = scans.then_some(viewpoint);
                Step { viewpoint, remaining, decided: Some(bin), scan, cost: 0.0 }
            }
        }
    }

    /// What a step is expected to earn, any bonus left aside, given the distribution of the object at the belt end.
    #[inline(always)]
    pub(crate) fn expected_reward(&self, step: &Step, belt_end: &[f64]) -> f64 {
        step.decided.map_or(-step.cost, |bin| self.expected_decision_reward(bin, belt_end))
    }
}

impl Step {
    /// Whether the belt advances: see [`shift`].
    #[inline(always)]
    pub(crate) fn advances(&self) -> bool {
        self.decided.is_some()
    }
}

/// The belt advances (eq. 8): what holds of each position holds of the next one nearer to the belt end, and at the
/// last position `arriving` begins. Each position may take several entries, as many as arrive.
#[inline(always)]
pub(crate) fn shift<T>(entries: &mut [T], arriving: impl ExactSizeIterator<Item = T>) {
    let behind = entries.len() - arriving.len();
    entries.rotate_left(arriving.len());
    for (entry, arriving) in entries[behind..].iter_mut().zip(arriving) {
        *entry = arriving;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::model::ScalarOrMatrix;
    use crate::testing::{from_weights, seeded};

    const FROM: Viewpoint = Viewpoint(1);

    fn model(observe_after_decision: bool) -> SortingModel {
        let mut spec = from_weights(1, 2, 2, &[0.5; 8]);
        spec.motion_cost = ScalarOrMatrix::Matrix(vec![vec![0.0, 1.0], vec![3.0, 0.0]]);
        spec.observe_after_decision = observe_after_decision;
        SortingModel::new(spec).unwrap()
    }

    #[test]
    fn a_move_takes_the_camera_and_leaves_the_belt() {
        let to = Viewpoint(0);
        for observes in [false, true] {
            for remaining in [None, Some(1), Some(2)].map(Remaining) {
                let step = model(observes).step(Action::Move(to), FROM, remaining);
                let expected = Step { viewpoint: to, remaining, decided: None, scan: Some(to), cost: 3.0 };
                assert_eq!(step, expected);
            }
        }
    }

    #[test]
    fn a_decision_moves_the_belt_and_a_scan_follows_if_there_is_something_to_see() {
        let scan_after = |observes, objects| {
            let bin = Bin(1);
            let step = model(observes).step(Action::Decide(bin), FROM, Remaining(objects));
            let remaining = Remaining(objects.map(|objects| objects - 1));
            let scan = step.scan;
            assert_eq!(step, Step { viewpoint: FROM, remaining, decided: Some(bin), scan, cost: 0.0 });
            step.scan
        };
        for objects in [None, Some(2), Some(1)] {
            assert_eq!(scan_after(false, objects), None);
        }
        assert_eq!(scan_after(true, None), Some(FROM));
        assert_eq!(scan_after(true, Some(2)), Some(FROM));
        assert_eq!(scan_after(true, Some(1)), None);
    }

    #[test]
    fn motion_costs_and_decisions_earn_what_is_expected_of_them() {
        let model = model(false);
        let earned = |action| {
            let step = model.step(action, FROM, Remaining::ENDLESS);
            model.expected_reward(&step, &[0.25, 0.75])
        };
        assert!((earned(Action::Move(Viewpoint(0))) + 3.0).abs() < 1e-12);
        assert!((earned(Action::Decide(Bin(1))) - (0.75 * 10.0 - 0.25 * 50.0)).abs() < 1e-12);
    }

    proptest! {
        #![proptest_config(seeded(64))]

        /// A flat list with several entries per position shifts as a list with an entry per position does.
        #[test]
        fn every_position_takes_over_the_one_behind_it(
            rows in prop::collection::vec(prop::collection::vec(any::<u8>(), 3), 1..5),
            arriving in prop::collection::vec(any::<u8>(), 3),
        ) {
            let mut flat = rows.concat();
            shift(&mut flat, arriving.iter().copied());
            let expected: Vec<_> = rows[1..].iter().chain([&arriving]).cloned().collect();
            prop_assert_eq!(flat, expected.concat());
            let mut shifted = rows;
            shift(&mut shifted, std::iter::once(arriving));
            prop_assert_eq!(shifted, expected);
        }
    }
}
