//! What is known of a moving belt.

use super::timing::Timing;
use crate::index::Position;
use crate::model::SortingModel;

/// An exact belief, and the clock.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct State {
    /// Distribution of the kind per place, the exit's first.
    pub rows: Vec<Vec<f64>>,
    /// Whether the object at each place is decided, or missing.
    pub decided: Vec<bool>,
    /// Ticks since the belt last advanced, below `ticks_per_place`; since the last decision if it advances on decisions.
    pub offset: usize,
    /// Objects that have not come to a place yet; `None` for a belt that never ends.
    pub to_come: Option<usize>,
}

impl State {
    /// A belt full of unseen objects that has just advanced and never ends.
    pub(crate) fn unseen(timing: &Timing, arrival: &[f64]) -> Self {
        Self {
            rows: vec![arrival.to_vec(); timing.places],
            decided: vec![false; timing.places],
            offset: 0,
            to_come: None,
        }
    }

    /// Ticks that the object at a place has left.
    pub(crate) fn ticks_left(&self, timing: &Timing, place: usize) -> usize {
        (place + 1) * timing.ticks_per_place - self.offset
    }

    /// Ticks that the first object to come has left until the exit.
    pub(crate) fn first_to_come(&self, timing: &Timing) -> usize {
        self.ticks_left(timing, timing.places)
    }

    /// The undecided objects, the most urgent first: ticks left, and belief.
    pub(crate) fn undecided<'a>(
        &'a self,
        timing: &'a Timing,
    ) -> impl Iterator<Item = (usize, &'a [f64])> + 'a {
        let undecided = self.decided.iter().enumerate().filter(|(_, decided)| !**decided);
        undecided.map(|(place, _)| (self.ticks_left(timing, place), self.rows[place].as_slice()))
    }

    /// Whether nothing is left to decide, now or later.
    pub(crate) fn is_over(&self) -> bool {
        self.to_come == Some(0) && self.decided.iter().all(|decided| *decided)
    }

    /// Mark the object at a place as decided. It stays where it is, unless the belt advances on decisions: then the place
    /// behind it comes to the exit. The ticks of the decision have still to pass.
    pub(crate) fn decide(&mut self, timing: &Timing, arrival: &[f64], position: Position) {
        self.decided[position.0] = true;
        if timing.advances_on_decisions() {
            self.advance(arrival);
        }
    }

    /// Let time pass. What the objects that pass the exit undecided cost, discounted to now.
    pub(crate) fn pass(&mut self, timing: &Timing, model: &SortingModel, ticks: usize) -> f64 {
        let mut missed = 0.0;
        let mut passed = 0;
        while passed + timing.ticks_per_place - self.offset <= ticks {
            passed += timing.ticks_per_place - self.offset;
            if !self.decided[0] {
                let price = crate::one_object::dot(&self.rows[0], &timing.missed);
                missed += price * model.discount().powi(i32::try_from(passed).unwrap_or(i32::MAX));
            }
            self.advance(model.arrival().as_slice());
        }
        self.offset += ticks - passed;
        missed
    }

    /// The belt advances by one place (eq. 8).
    fn advance(&mut self, arrival: &[f64]) {
        self.offset = 0;
        self.rows.rotate_left(1);
        self.decided.rotate_left(1);
        let last = self.rows.len() - 1;
        self.rows[last] = arrival.to_vec();
        self.decided[last] = self.to_come == Some(0);
        self.to_come = self.to_come.map(|objects| objects.saturating_sub(1));
    }
}
