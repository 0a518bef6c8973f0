//! What all positions share: where the camera stands, and how long ago the belt moved.
//!
//! Prices may depend on whatever all positions know. The *clock* counts the looks since the belt last moved, up to a
//! limit: it changes nothing in the problem, but positions that agree on it agree better on what to do next.

use crate::index::Viewpoint;
use crate::model::SortingModel;
use crate::one_object::viewpoint_groups;

/// A viewpoint group and a reading of the clock.
pub(super) type Mode = usize;

/// An action in a mode; what has a price. Numbered through all modes.
pub(super) type Choice = usize;

/// A look from a viewpoint.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Look {
    pub viewpoint: Viewpoint,
    pub cost: f64,
    pub next: Mode,
}

/// The moves of a mode, each followed by one scan, and the mode in which the belt leaves it.
#[derive(Debug, Clone)]
pub(super) struct Moves {
    pub looks: Vec<Look>,
    pub after_advance: Mode,
    /// Choice of the first look; those of the others follow, then that of the belt's advance.
    pub first_choice: Choice,
}

impl Moves {
    pub(super) fn advance(&self) -> Choice {
        self.first_choice + self.looks.len()
    }
}

/// All modes.
#[derive(Debug, Clone)]
pub(super) struct Shared {
    pub modes: Vec<Moves>,
    group_of: Vec<usize>,
    clock: usize,
    /// What the camera itself earns by each choice: less the cost of a move.
    pub earned: Vec<f64>,
}

impl Shared {
    /// Modes of a model with a clock of so many readings, at least one.
    pub(super) fn new(model: &SortingModel, clock: usize) -> Self {
        let (group_of, groups) = viewpoint_groups(model);
        let mut shared = Self { modes: Vec::new(), group_of, clock, earned: Vec::new() };
        for mode in 0..groups * clock {
            let (group, time) = (mode / clock, mode % clock);
            let from = Viewpoint(shared.group_of.iter().position(|g| *g == group).unwrap_or(0));
            let later = (time + 1).min(clock - 1);
            let look = |&viewpoint: &Viewpoint| Look {
                viewpoint,
                cost: model.motion_cost(from, viewpoint),
                next: shared.group_of[viewpoint.0] * clock + later,
            };
            let looks: Vec<_> = model.legal_moves(from).iter().map(look).collect();
            let first_choice = shared.earned.len();
            shared.earned.extend(looks.iter().map(|look| -look.cost));
            shared.earned.push(0.0);
            shared.modes.push(Moves { looks, after_advance: group * clock, first_choice });
        }
        shared
    }

    /// The modes that a camera at a viewpoint may be taken to be in: the clock may read anything.
    pub(super) fn modes_at(&self, viewpoint: Viewpoint) -> std::ops::Range<Mode> {
        let first = self.group_of[viewpoint.0] * self.clock;
        first..first + self.clock
    }

    /// The mode right after the belt has moved.
    pub(super) fn start(&self, viewpoint: Viewpoint) -> Mode {
        self.modes_at(viewpoint).start
    }

    /// Readings of the clock.
    pub(super) fn clock(&self) -> usize {
        self.clock
    }

    pub(super) fn choices(&self) -> usize {
        self.earned.len()
    }
}
