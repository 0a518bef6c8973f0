//! When things happen on a moving belt, as one object sees them: in ticks until it passes the exit.
//!
//! With `n >= 1` ticks left an object is at place `(n - 1) / ticks_per_place`, 0 nearest to the exit; with `n = 0` it has
//! passed the exit. All objects of a belt have the same remainder of `n` by `ticks_per_place`.

use super::action::MovingAction;
use crate::index::{Position, Viewpoint};
use crate::model::SortingModel;

/// Stands for the ticks between two advances of a belt that advances on decisions alone: more than ever pass.
pub(crate) const NEVER: usize = usize::MAX >> 12;

/// Durations and places of a moving belt.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Timing {
    /// Ticks between two advances by one place, whatever is decided; [`NEVER`] if the belt advances on decisions.
    pub ticks_per_place: usize,
    /// Places, from the exit, at which an object can be decided.
    pub reach: usize,
    /// Ticks of a decision, in which the camera does nothing else; those of the advance if the belt advances on decisions.
    pub sort_ticks: usize,
    /// Price of an undecided object at the exit, per kind.
    pub missed: Vec<f64>,
    /// Places that are seen, H.
    pub places: usize,
    /// Ticks of a look from one viewpoint at another one, entry `from * K + to`.
    pub look_ticks: Vec<usize>,
    /// Viewpoints, K.
    pub viewpoints: usize,
}

impl Timing {
    /// Ticks from entering the last place to the exit.
    pub(crate) fn visible(&self) -> usize {
        self.places * self.ticks_per_place
    }

    /// Whether the belt advances by one place with each decision, and otherwise stands.
    pub(crate) fn advances_on_decisions(&self) -> bool {
        self.ticks_per_place == NEVER
    }

    /// Ticks of an action.
    pub(crate) fn ticks(&self, action: MovingAction, from: Viewpoint) -> usize {
        match action {
            MovingAction::Look(to) => self.look(from, to),
            MovingAction::Wait => 1,
            MovingAction::Decide { .. } => self.sort_ticks,
        }
    }

    /// Ticks of a look.
    pub(crate) fn look(&self, from: Viewpoint, to: Viewpoint) -> usize {
        self.look_ticks[from.0 * self.viewpoints + to.0]
    }

    /// Ticks of the longest look.
    pub(crate) fn longest_look(&self) -> usize {
        self.look_ticks.iter().copied().max().unwrap_or(1)
    }

    /// Where an object is with `n >= 1` ticks left; none before it is seen.
    pub(crate) fn place(&self, n: usize) -> Option<Position> {
        let place = (n - 1) / self.ticks_per_place;
        (place < self.places).then_some(Position(place))
    }

    /// Whether an object with `n` ticks left can be decided.
    pub(crate) fn in_reach(&self, n: usize) -> bool {
        n >= 1 && n <= self.reach * self.ticks_per_place
    }

    /// Ticks until an object with `n` left comes into reach.
    pub(crate) fn until_reach(&self, n: usize) -> usize {
        n.saturating_sub(self.reach * self.ticks_per_place)
    }

    /// The group of each viewpoint, and the number of groups: viewpoints of a group have the same moves at the same costs
    /// in the same time, so no value depends on which of them the camera stands at.
    pub(crate) fn groups(&self, model: &SortingModel) -> (Vec<usize>, usize) {
        let moves = |from: Viewpoint| -> Vec<(Viewpoint, u64, usize)> {
            let legal = model.legal_moves(from).iter();
            legal.map(|&to| (to, model.motion_cost(from, to).to_bits(), self.look(from, to))).collect()
        };
        let mut known: Vec<Vec<_>> = Vec::new();
        let group_of = model
            .viewpoints()
            .map(|from| {
                let moves = moves(from);
                known.iter().position(|other| *other == moves).unwrap_or_else(|| {
                    known.push(moves);
                    known.len() - 1
                })
            })
            .collect();
        (group_of, known.len())
    }
}
