//! A certified upper bound: value iteration on a grid of beliefs.
//!
//! V* is convex in the belief about each object, the others' held fixed, so interpolating linearly between grid
//! points, position by position, never falls below it. Value iteration that starts above V* and interpolates stays
//! above V*: the bound holds at every sweep, converged or not. On a grid, one motion is `-cost + discount A V B^T`
//! with a sparse row in A (B) per point of the first (second) position.

use rayon::prelude::*;

use super::simplex_grid::{Combination, SimplexGrid};
use crate::belief::most_likely;
use crate::model::{Action, SortingModel};
use crate::one_object::dot;

/// How fine a grid is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Resolution {
    /// Intervals per axis.
    pub intervals: usize,
    /// See [`SimplexGrid::new`].
    pub grading: f64,
}

impl Resolution {
    /// Number of values.
    pub(super) fn values(&self, model: &SortingModel) -> usize {
        let positions = u32::try_from(model.position_count()).unwrap_or(u32::MAX);
        SimplexGrid::new(model.class_count(), self.intervals, self.grading).len().saturating_pow(positions)
    }
}

/// Grid values, for models with one or two positions in which all viewpoints have the same moves at the same costs.
#[derive(Debug, Clone)]
pub(super) struct GridBound {
    first: Axis,
    /// `None` if there is one position only.
    second: Option<Axis>,
    /// Entry `i * width + j`: belief i at the belt end, j behind it.
    values: Vec<f64>,
}

/// The grid of one position.
#[derive(Debug, Clone)]
struct Axis {
    grid: SimplexGrid,
    points: Vec<Vec<f64>>,
}

impl Axis {
    fn new(classes: usize, resolution: Resolution) -> Self {
        let grid = SimplexGrid::new(classes, resolution.intervals, resolution.grading);
        let points = grid.points();
        Self { grid, points }
    }

    fn located(&self, points: &[Vec<f64>]) -> Vec<Combination> {
        points.iter().map(|p| self.grid.locate(p)).collect()
    }

    /// The posteriors of one object over all labels, each located and weighted by its probability.
    fn observed(
        &self,
        model: &SortingModel,
        position: usize,
        viewpoint: usize,
        belief: &[f64],
    ) -> Combination {
        let mut combination = Combination::new();
        for column in model.table(position, viewpoint).column_iter() {
            let p = dot(belief, column.as_slice());
            if p > 0.0 {
                let posterior: Vec<f64> = belief.iter().zip(column.iter()).map(|(b, o)| b * o / p).collect();
                combination.extend(self.grid.locate(&posterior).into_iter().map(|(i, w)| (i, w * p)));
            }
        }
        merged(combination)
    }

    fn all_observed(&self, model: &SortingModel, position: usize, viewpoint: usize) -> Vec<Combination> {
        self.points.par_iter().map(|p| self.observed(model, position, viewpoint, p)).collect()
    }
}

/// A legal move with its cost and the sparse rows of A and B.
struct Motion {
    cost: f64,
    first: Vec<Combination>,
    second: Vec<Combination>,
}

/// The only point of an axis that is not there.
fn sole() -> Combination {
    vec![(0, 1.0)]
}

impl GridBound {
    /// The value of being right in every step, everywhere.
    pub(super) fn new(model: &SortingModel, resolution: Resolution) -> Self {
        let axis = Axis::new(model.class_count(), resolution);
        let best = model.spec().r_max / (1.0 - model.discount());
        Self {
            second: (model.position_count() == 2).then(|| axis.clone()),
            first: axis,
            values: vec![best; resolution.values(model)],
        }
    }

    /// The same bound on another grid: interpolated, so no tighter, but the start of tighter ones.
    pub(super) fn refined(&self, model: &SortingModel, resolution: Resolution) -> Self {
        let mut fine = Self::new(model, resolution);
        let rows = self.first.located(&fine.first.points);
        let columns = match (&self.second, &fine.second) {
            (Some(coarse), Some(fine)) => coarse.located(&fine.points),
            _ => vec![sole()],
        };
        let width = fine.width();
        fine.values.par_chunks_mut(width).zip(&rows).for_each(|(values, row)| {
            let mixed = self.mixed_row(row);
            for (value, column) in values.iter_mut().zip(&columns) {
                *value = gather(&mixed, column);
            }
        });
        fine
    }

    fn width(&self) -> usize {
        self.second.as_ref().map_or(1, |axis| axis.points.len())
    }

    /// Value iteration until a sweep lowers no value by more than `tolerance`, or `stop` says so.
    pub(super) fn sweep(&mut self, model: &SortingModel, tolerance: f64, stop: impl Fn() -> bool) {
        let motions = self.motions(model);
        while !stop() {
            let next = self.after_decision(model);
            let swept = self.swept(model, &motions, &next);
            let fall =
                self.values.par_iter().zip(&swept).map(|(old, new)| old - new).reduce(|| 0.0, f64::max);
            self.values = swept;
            if fall < tolerance {
                return;
            }
        }
    }

    /// Interpolated bound at a belief, one distribution per position.
    pub(super) fn value(&self, belief: &[f64]) -> f64 {
        let l = self.first.points[0].len();
        let behind = self.second.as_ref().map_or_else(sole, |axis| axis.grid.locate(&belief[l..]));
        self.mixture(&self.first.grid.locate(&belief[..l]), &behind)
    }

    /// The action that is best one exact step ahead of the bound, and its value: no more than the bound itself.
    pub(super) fn look_ahead(&self, model: &SortingModel, belief: &[f64], viewpoint: usize) -> (Action, f64) {
        let l = model.class_count();
        let advanced = [&belief[l..], model.arrival().as_slice()].concat();
        let (label, p_right) = most_likely(&belief[..l]);
        let decided = model.decision_reward(p_right) + model.discount() * self.value(&advanced);
        let mut best = (Action::Decide(label), decided);
        for &to in model.legal_moves(viewpoint) {
            let first = self.first.observed(model, 0, to, &belief[..l]);
            let behind = |axis: &Axis| axis.observed(model, 1, to, &belief[l..]);
            let second = self.second.as_ref().map_or_else(sole, behind);
            let value = -model.motion_cost(viewpoint, to) + model.discount() * self.mixture(&first, &second);
            if value > best.1 {
                best = (Action::Move(to), value);
            }
        }
        best
    }

    fn motions(&self, model: &SortingModel) -> Vec<Motion> {
        let motion = |&to: &usize| Motion {
            cost: model.motion_cost(0, to),
            first: self.first.all_observed(model, 0, to),
            second: self.second.as_ref().map_or_else(|| vec![sole()], |axis| axis.all_observed(model, 1, to)),
        };
        model.legal_moves(0).iter().map(motion).collect()
    }

    /// Value after a decision, by what was behind the belt end (with one position: a single number).
    fn after_decision(&self, model: &SortingModel) -> Vec<f64> {
        let arrival = model.arrival().as_slice();
        match &self.second {
            None => vec![gather(&self.values, &self.first.grid.locate(arrival))],
            Some(axis) => {
                let behind = axis.grid.locate(arrival);
                let value = |point: &Vec<f64>| self.mixture(&self.first.grid.locate(point), &behind);
                axis.points.par_iter().map(value).collect()
            }
        }
    }

    /// One backup of every value; never above the value before.
    fn swept(&self, model: &SortingModel, motions: &[Motion], next: &[f64]) -> Vec<f64> {
        let mut swept = self.values.clone();
        swept.par_chunks_mut(self.width()).enumerate().for_each(|(i, row)| {
            let reward = model.decision_reward(most_likely(&self.first.points[i]).1);
            let mut best: Vec<f64> = next.iter().map(|value| reward + model.discount() * value).collect();
            for motion in motions {
                let mixed = self.mixed_row(&motion.first[i]);
                for (value, second) in best.iter_mut().zip(&motion.second) {
                    *value = value.max(-motion.cost + model.discount() * gather(&mixed, second));
                }
            }
            for (value, backed_up) in row.iter_mut().zip(best) {
                *value = value.min(backed_up);
            }
        });
        swept
    }

    /// The weighted sum of rows of the values.
    fn mixed_row(&self, rows: &Combination) -> Vec<f64> {
        let mut mixed = vec![0.0; self.width()];
        for (i, weight) in rows {
            for (sum, value) in mixed.iter_mut().zip(&self.values[i * self.width()..]) {
                *sum += weight * value;
            }
        }
        mixed
    }

    fn mixture(&self, first: &Combination, second: &Combination) -> f64 {
        first.iter().map(|(i, weight)| weight * gather(&self.values[i * self.width()..], second)).sum()
    }
}

fn gather(values: &[f64], combination: &Combination) -> f64 {
    combination.iter().map(|(i, weight)| weight * values[*i]).sum()
}

/// The same combination with every point once.
fn merged(mut combination: Combination) -> Combination {
    combination.sort_unstable_by_key(|(point, _)| *point);
    combination.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    combination
}
