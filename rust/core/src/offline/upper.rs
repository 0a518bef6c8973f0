//! A certified upper bound: values on a grid of beliefs.
//!
//! V* is convex in the belief about each object, the others' held fixed, so interpolating linearly between grid
//! points, position by position, never falls below it. So neither does the fixed point of value iteration that
//! interpolates, and whatever lies above that: see [`super::value_iteration`].

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::simplex_grid::{Combination, SimplexGrid, merged};
use crate::belief::condition;
use crate::index::{Position, Viewpoint};
use crate::model::{Action, Look, SortingModel, shift};
use crate::remaining::Remaining;

/// How fine a grid is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Resolution {
    /// Intervals per axis.
    pub intervals: usize,
    /// See [`SimplexGrid::new`].
    pub grading: f64,
}

impl Resolution {
    /// Decisions lead to the arrival prior at one position, so interpolating there would cost most.
    fn grid(&self, model: &SortingModel) -> SimplexGrid {
        SimplexGrid::new(model.arrival().as_slice(), self.intervals, self.grading)
    }

    /// Number of values.
    pub(super) fn values(&self, model: &SortingModel) -> usize {
        let positions = u32::try_from(model.position_count()).unwrap_or(u32::MAX);
        self.grid(model).len().saturating_pow(positions)
    }
}

/// Grid values, for models with one or two positions in which all viewpoints have the same moves at the same costs.
#[derive(Debug, Clone)]
pub(super) struct GridBound {
    pub resolution: Resolution,
    pub axis: Axis,
    /// Beliefs behind the belt end: 1 if nothing is seen there.
    pub width: usize,
    /// Entry `i * width + j`: belief i at the belt end, j behind it.
    pub values: Vec<f32>,
}

/// The grid of every position.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    pub grid: SimplexGrid,
    pub points: Vec<Vec<f64>>,
}

impl Axis {
    fn new(grid: SimplexGrid) -> Self {
        let points = grid.points();
        Self { grid, points }
    }

    /// The posteriors of one object over all labels, each located and weighted by its probability.
    fn observed(&self, model: &SortingModel, look: Look, belief: &[f64]) -> Combination {
        let mut combination = Combination::new();
        let possible = posteriors(model, look, belief).into_iter().filter(|(p, _)| *p > 0.0);
        for (p, posterior) in possible {
            combination.extend(self.grid.locate(&posterior).into_iter().map(|(i, w)| (i, w * p)));
        }
        merged(combination)
    }

    pub(super) fn all_observed(&self, model: &SortingModel, look: Look) -> Vec<Combination> {
        self.points.par_iter().map(|p| self.observed(model, look, p)).collect()
    }
}

/// Probability and posterior of each label of a look; an impossible one leaves the belief as it is.
pub(super) fn posteriors(model: &SortingModel, look: Look, belief: &[f64]) -> Vec<(f64, Vec<f64>)> {
    let posterior = |label| {
        let mut posterior = belief.to_vec();
        (condition(&mut posterior, model.likelihoods(look, label)), posterior)
    };
    model.labels().map(posterior).collect()
}

impl GridBound {
    /// What being right in every step, everywhere, is worth: no more can be had.
    pub(super) fn new(model: &SortingModel, resolution: Resolution) -> Self {
        let best = rounded_up(model.most_reward() / (1.0 - model.discount()));
        Self::with_values(model, resolution, vec![best; resolution.values(model)])
    }

    /// The bound with these values, as many as the resolution has.
    pub(super) fn with_values(model: &SortingModel, resolution: Resolution, values: Vec<f32>) -> Self {
        let axis = Axis::new(resolution.grid(model));
        let width = if model.position_count() == 2 { axis.points.len() } else { 1 };
        Self { resolution, axis, width, values }
    }

    /// The same bound on another grid: interpolated, so no tighter; if that is finer, the start of tighter ones.
    pub(super) fn refined(&self, model: &SortingModel, resolution: Resolution) -> Self {
        let mut fine = Self::new(model, resolution);
        let rows: Vec<_> = fine.axis.points.par_iter().map(|p| self.axis.grid.locate(p)).collect();
        let sole = [sole()];
        let columns = if self.width == 1 { &sole[..] } else { &rows };
        fine.values.par_chunks_mut(fine.width).zip(&rows).for_each(|(values, row)| {
            for (value, column) in values.iter_mut().zip(columns) {
                *value = rounded_up(self.mixture(row, column));
            }
        });
        fine
    }

    /// Interpolated bound at a belief, one distribution per position.
    pub(super) fn value(&self, belief: &[f64]) -> f64 {
        let l = self.axis.points[0].len();
        self.mixture(&self.axis.grid.locate(&belief[..l]), &self.behind(belief, |b| self.axis.grid.locate(b)))
    }

    /// The action that is best one exact step ahead of the bound, and its value: no more than the bound itself.
    pub(super) fn look_ahead(
        &self,
        model: &SortingModel,
        belief: &[f64],
        viewpoint: Viewpoint,
    ) -> (Action, f64) {
        let decide = Action::Decide(model.best_decision(&belief[..model.kind_count()]).0);
        let value = |action| (action, self.action_value(model, belief, viewpoint, action));
        let moves = model.legal_moves(viewpoint).iter().map(|to| value(Action::Move(*to)));
        moves.fold(value(decide), |best, next| if next.1 > best.1 { next } else { best })
    }

    /// Value of an action, one exact step ahead of the bound.
    pub(super) fn action_value(
        &self,
        model: &SortingModel,
        belief: &[f64],
        viewpoint: Viewpoint,
        action: Action,
    ) -> f64 {
        let step = model.step(action, viewpoint, Remaining::ENDLESS);
        let l = model.kind_count();
        let mut next = belief.to_vec();
        if step.advances() {
            shift(&mut next, model.arrival().as_slice().iter().copied());
        }
        let expected = step.scan.map_or_else(
            || self.value(&next),
            |from| {
                let observed = |j, b: &[f64]| self.axis.observed(model, Look::first(Position(j), from), b);
                self.mixture(&observed(0, &next[..l]), &self.behind(&next, |b| observed(1, b)))
            },
        );
        model.expected_reward(&step, &belief[..l]) + model.discount() * expected
    }

    fn behind(&self, belief: &[f64], combination: impl Fn(&[f64]) -> Combination) -> Combination {
        let l = self.axis.points[0].len();
        if self.width == 1 { sole() } else { combination(&belief[l..]) }
    }

    pub(super) fn mixture(&self, first: &[(u32, f64)], second: &[(u32, f64)]) -> f64 {
        let row = |i: u32| &self.values[i as usize * self.width..];
        let gathered =
            |row: &[f32]| -> f64 { second.iter().map(|(j, w)| w * f64::from(row[*j as usize])).sum() };
        first.iter().map(|(i, weight)| weight * gathered(row(*i))).sum()
    }
}

/// The only belief behind the belt end if there is one position.
pub(super) fn sole() -> Combination {
    vec![(0, 1.0)]
}

/// The nearest `f32` that is no less.
#[allow(clippy::cast_possible_truncation)] // undone where it lost something
pub(super) fn rounded_up(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) < value { nearest.next_up() } else { nearest }
}
