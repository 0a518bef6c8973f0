//! Policies for a moving belt.

use super::action::MovingAction;
use super::belief::MovingBelief;
use super::belt::MovingBelt;
use crate::belief::information;
use crate::error::{Result, argument_error};
use crate::index::{Bin, Position, Viewpoint};
use crate::model::Look;
use crate::one_object::dot;

/// Names the next action on a moving belt.
pub trait MovingPolicy: Sync {
    /// The action to take with the camera at `viewpoint`.
    ///
    /// # Errors
    /// Whatever keeps the policy from naming one; the caller passes it on.
    fn act(&self, belief: &MovingBelief, viewpoint: Viewpoint) -> Result<MovingAction>;
}

/// Where a threshold policy looks from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LookRule {
    /// From where most is learnt about the undecided object nearest to the exit.
    MostUrgent,
    /// From where most is learnt per tick about all undecided objects.
    InformationPerTick,
}

/// Decide an object once a decision is likely enough to be right, or at its last chance.
///
/// The threshold falls linearly from the entry of the last place to the exit, where it is `low`; thresholds of the optimal
/// policy fall towards a deadline (Frazier & Yu 2007). At the last chance, when after the next look and the decisions on the
/// objects in front of it an object would have passed the exit, the most urgent object that is worth more than `-missed` is
/// decided. On a belt that advances on decisions no object has a deadline, and the threshold is `high`.
#[derive(Debug, Clone)]
pub struct MovingThreshold {
    belt: MovingBelt,
    high: f64,
    low: f64,
    rule: LookRule,
}

/// A look that a threshold policy may take next.
struct Candidate {
    to: Viewpoint,
    ticks: usize,
    worth: f64,
}

impl MovingThreshold {
    /// Thresholds from `high` at the entry to `low` at the exit; the same number twice for a constant one.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] unless `0 < low <= high <= 1`.
    pub fn new(belt: &MovingBelt, high: f64, low: f64, rule: LookRule) -> Result<Self> {
        if !(low > 0.0 && low <= high && high <= 1.0) {
            return argument_error(format!(
                "thresholds {high} at the entry and {low} at the exit; they are probabilities above 0 and at most 1, and the \
                 second is not larger, 0.95 and 0.6 for example"
            ));
        }
        Ok(Self { belt: belt.clone(), high, low, rule })
    }

    /// The threshold with so many ticks left until the exit.
    fn threshold(&self, ticks_left: usize) -> f64 {
        if self.belt.timing().advances_on_decisions() {
            return self.high;
        }
        let span = self.belt.timing().visible().saturating_sub(1).max(1);
        let share = ticks_left.saturating_sub(1) as f64 / span as f64;
        self.low + (self.high - self.low) * share
    }

    /// The best bin of an object, whether it is likely enough to be right, and whether it is worth more than missing.
    fn judged(&self, row: &[f64], ticks_left: usize) -> (Bin, bool, bool) {
        let model = self.belt.model();
        let (bin, reward) = model.best_decision(row);
        let sure = model.probability_right(bin, row) >= self.threshold(ticks_left);
        (bin, sure, reward > -dot(row, &self.belt.timing().missed))
    }

    /// The look that tells most, by the rule; none where no look ends before the most urgent object has passed.
    fn look(&self, open: &[(usize, &[f64])], from: Viewpoint) -> Option<Candidate> {
        let (model, timing) = (self.belt.model(), self.belt.timing());
        let told = |(left, row): &(usize, &[f64]), to: Viewpoint, ticks: usize| {
            let place = left.checked_sub(ticks).filter(|left| *left > 0).and_then(|left| timing.place(left));
            place.map(|place| information(model, row, Look::first(place, to)))
        };
        let candidates = model.legal_moves(from).iter().filter_map(|&to| {
            let ticks = timing.look(from, to);
            let first = told(open.first()?, to, ticks);
            let worth = match self.rule {
                LookRule::MostUrgent => first?,
                LookRule::InformationPerTick => {
                    let sum: f64 = open.iter().filter_map(|object| told(object, to, ticks)).sum();
                    sum / ticks as f64
                }
            };
            Some(Candidate { to, ticks, worth })
        });
        candidates.fold(None, |best: Option<Candidate>, next| match best {
            Some(best) if best.worth >= next.worth => Some(best),
            _ => Some(next),
        })
    }
}

impl MovingPolicy for MovingThreshold {
    fn act(&self, belief: &MovingBelief, viewpoint: Viewpoint) -> Result<MovingAction> {
        let (model, timing, state) = (self.belt.model(), self.belt.timing(), belief.state());
        model.check_viewpoint(viewpoint)?;
        let (mut open, mut pending) = (Vec::new(), Vec::new());
        for position in model.positions().filter(|j| !state.decided[j.0]) {
            let left = state.ticks_left(timing, position.0);
            let row = state.rows[position.0].as_slice();
            let (bin, sure, worthwhile) = self.judged(row, left);
            if sure && worthwhile && timing.in_reach(left) {
                return Ok(MovingAction::Decide { position, bin });
            }
            if worthwhile {
                pending.push((position, left, bin));
            }
            if !sure {
                open.push((left, row));
            }
        }
        let look = self.look(&open, viewpoint);
        let ticks = look.as_ref().map_or(1, |look| look.ticks);
        // Decisions are taken one after the other, the most urgent one first.
        let too_late = |(before, (_, left, _)): (usize, &(Position, usize, Bin))| {
            *left <= ticks + before * timing.sort_ticks
        };
        if let Some(&(position, left, bin)) =
            pending.first().filter(|_| pending.iter().enumerate().any(too_late))
        {
            if timing.in_reach(left) {
                return Ok(MovingAction::Decide { position, bin });
            }
            return Ok(MovingAction::Wait);
        }
        Ok(look.map_or(MovingAction::Wait, |look| MovingAction::Look(look.to)))
    }
}
