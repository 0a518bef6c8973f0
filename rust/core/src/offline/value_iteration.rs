//! Value iteration on a grid of beliefs, and the proof of what it ends with.
//!
//! Let T be the interpolated Bellman operator on the grid: monotone, and `T (U + c) = T U + discount c`. For *any* U,
//! `W = U + m / (1 - discount)` with `m = max (T U - U)` satisfies `T W <= W`, so sweeps from W fall to T's fixed
//! point, which is no less than V* (see [`super::upper`]): W is an upper bound. So sweeps may be rounded, start
//! anywhere and stop at any time; one last sweep in `f64` finds m, which may well be negative. Only differences
//! between beliefs have to converge, not the constant they share, and those converge much faster than `discount^n`.

use rayon::prelude::*;

use super::sparse::{LANES, Real, Rows, gather, mix};
use super::upper::{Axis, GridBound, rounded_up, sole};
use crate::index::{Position, Viewpoint};
use crate::model::{Look, SortingModel};

/// One Bellman operator in the arithmetic T.
struct Operator<'a, T> {
    discount: T,
    /// Of deciding on the object at the belt end, by its belief.
    rewards: Vec<T>,
    motions: Vec<Motion<T>>,
    /// The arrival prior as a row.
    arrival: Rows<T>,
    axis: &'a Axis,
}

/// A legal move: `-cost + (discount A) V B^T` with a sparse row in A (B) per belief at (behind) the belt end.
struct Motion<T> {
    cost: T,
    first: Rows<T>,
    second: Rows<T>,
}

impl<'a, T: Real> Operator<'a, T> {
    fn new(model: &SortingModel, axis: &'a Axis) -> Self {
        // All viewpoints are alike: where the camera comes from does not matter.
        let from = Viewpoint(0);
        let observed = |position, to| axis.all_observed(model, Look::first(Position(position), to));
        let second = |to| if model.position_count() == 1 { vec![sole()] } else { observed(1, to) };
        let motion = |&to: &Viewpoint| Motion {
            cost: T::of(-model.motion_cost(from, to)),
            first: Rows::new(&observed(0, to), model.discount()),
            second: Rows::new(&second(to), 1.0),
        };
        let reward = |point: &Vec<f64>| T::of(model.best_decision(point).1);
        Self {
            discount: T::of(model.discount()),
            rewards: axis.points.iter().map(reward).collect(),
            motions: model.legal_moves(from).iter().map(motion).collect(),
            arrival: Rows::new(&[axis.grid.locate(model.arrival().as_slice())], 1.0),
            axis,
        }
    }

    /// Discounted value after a decision, by what was behind the belt end (with one position: a single number).
    fn after_decision(&self, values: &[f32], width: usize) -> Vec<T> {
        let expected = |values: &[f32]| {
            let mut sum = T::of(0.0);
            for (i, weight) in self.arrival.row(0) {
                sum += *weight * T::from(values[*i as usize]);
            }
            self.discount * sum
        };
        if width == 1 { vec![expected(values)] } else { values.chunks_exact(width).map(expected).collect() }
    }

    /// The values of up to [`LANES`] rows from `first` on, backed up; entry j holds column j of each.
    fn backed_up(&self, values: &[f32], next: &[T], first: usize) -> Vec<[T; LANES]> {
        let width = next.len();
        // Lanes beyond the last row repeat it.
        let rows: [usize; LANES] = std::array::from_fn(|lane| (first + lane).min(self.axis.points.len() - 1));
        let rewards = rows.map(|i| self.rewards[i]);
        let mut best: Vec<_> = next.iter().map(|value| rewards.map(|reward| reward + *value)).collect();
        let mut mixed = vec![[T::of(0.0); LANES]; width];
        let mut sum = vec![T::of(0.0); width];
        for motion in &self.motions {
            for (lane, i) in rows.into_iter().enumerate() {
                mix(motion.first.row(i), values, &mut sum);
                for (lanes, value) in mixed.iter_mut().zip(&sum) {
                    lanes[lane] = *value;
                }
            }
            for (best, row) in best.iter_mut().zip(motion.second.iter()) {
                for (best, value) in best.iter_mut().zip(gather(row, &mixed)) {
                    let value = value + motion.cost;
                    *best = if value > *best { value } else { *best };
                }
            }
        }
        best
    }
}

impl GridBound {
    /// Sweep until the differences between beliefs have settled to `tolerance`, or `stop` says so; then raise, or
    /// lower, all values until they are proved.
    pub(super) fn improve(&mut self, model: &SortingModel, tolerance: f64, stop: impl Fn() -> bool) {
        let operator = Operator::<f32>::new(model, &self.axis);
        let settled = tolerance * (1.0 - model.discount());
        let mut swept = self.values.clone();
        while !stop() {
            let (fall, rise) = sweep(&operator, &self.values, self.width, &mut swept);
            std::mem::swap(&mut self.values, &mut swept);
            if f64::from(rise - fall) < settled {
                break;
            }
        }
        self.certify(model);
    }

    /// The shift by `m / (1 - discount)`; see the proof above.
    pub(super) fn certify(&mut self, model: &SortingModel) {
        let shift = self.largest_rise(model) / (1.0 - model.discount());
        self.values.par_iter_mut().for_each(|value| *value = rounded_up(f64::from(*value) + shift));
    }

    /// `max (T U - U)`.
    pub(super) fn largest_rise(&self, model: &SortingModel) -> f64 {
        let operator = Operator::<f64>::new(model, &self.axis);
        let next = operator.after_decision(&self.values, self.width);
        let rows = self.values.par_chunks(LANES * self.width).enumerate();
        let rise = |(block, old): (usize, &[f32])| {
            let new = operator.backed_up(&self.values, &next, block * LANES);
            let rises = old.iter().enumerate().map(|(e, old)| {
                let (lane, column) = (e / self.width, e % self.width);
                new[column][lane] - f64::from(*old)
            });
            rises.fold(f64::NEG_INFINITY, f64::max)
        };
        rows.map(rise).reduce(|| f64::NEG_INFINITY, f64::max)
    }
}

/// `swept = T values`, and the least and the largest of its rises.
fn sweep(operator: &Operator<'_, f32>, values: &[f32], width: usize, swept: &mut [f32]) -> (f32, f32) {
    let next = operator.after_decision(values, width);
    let blocks = swept.par_chunks_mut(LANES * width).zip(values.par_chunks(LANES * width)).enumerate();
    let back_up = |(block, (new, old)): (usize, (&mut [f32], &[f32]))| {
        let best = operator.backed_up(values, &next, block * LANES);
        let mut range = (f32::INFINITY, f32::NEG_INFINITY);
        for (lane, (new, old)) in new.chunks_exact_mut(width).zip(old.chunks_exact(width)).enumerate() {
            for ((new, old), best) in new.iter_mut().zip(old).zip(&best) {
                *new = best[lane];
                range = (range.0.min(*new - old), range.1.max(*new - old));
            }
        }
        range
    };
    let joined = |a: (f32, f32), b: (f32, f32)| (a.0.min(b.0), a.1.max(b.1));
    blocks.map(back_up).reduce(|| (f32::INFINITY, f32::NEG_INFINITY), joined)
}
