//! A certified upper bound of V* for any number of positions: prices on what camera and belt do.
//!
//! Positions are tied together only by sharing one camera and one belt. Let each of them control its own, pay it
//! `lambda_i(s, a)` for each action a in mode s (where the camera stands), with `sum_i lambda_i(s, a)` what the action
//! earns (less the cost of a move), and let `W_i(x, s)` be the best that an object of belief x at position i, and
//! those that come to its place, can get:
//!
//! * look from k': `W_i(x, s) >= lambda_i(s, k') + discount E_z W_i(x^z, s')`,
//! * advance: `W_i(x, s) >= lambda_i(s, advance) + discount W_{i-1}(x, s')` for i >= 1,
//! * decide: `W_0(x, s) >= lambda_0(s, advance) + max_b sum_c x(c) R[b, c] + discount W_{H-1}(arrival, s')`.
//!
//! Then `V*(x_0, ..., x_{H-1}, s) <= sum_i W_i(x_i, s)`: added up over positions these are Bellman's inequalities for
//! the sum, and Bellman's operator is monotone. H problems of N states take the place of one of N^H. This is a Lagrangian
//! relaxation, or an additive approximate linear programme (Castanon, CDC 1997; Hitchings & Castanon, ACC 2010; Adelman &
//! Mersereau, Operations Research 2008). The bound is convex in the prices, and its subgradient is how often each
//! position wants each action beyond the average of all: prices make positions agree.

mod bundle;
mod faces;
mod improvement;
mod object;
mod points;
mod problem;
mod saved;
mod shared;
#[cfg(test)]
mod tests;
mod usage;

use super::watch::Watch;
use crate::belief::Belief;
use crate::bounds;
use crate::index::{Position, Viewpoint};
use crate::model::{Action, SortingModel};
use crate::remaining::Remaining;
pub(crate) use faces::Faces;
use improvement::Improvement;
pub(crate) use object::ObjectModel;
use points::Points;
pub(crate) use points::Rows;
use problem::Values;
pub(super) use saved::SavedPrices;
use shared::Shared;

/// An upper bound of V* at any belief.
#[derive(Debug, Clone)]
pub(super) struct PricedBound {
    model: SortingModel,
    points: Points,
    shared: Shared,
    values: Values,
}

impl PricedBound {
    /// Improve prices until nothing more is gained, or this part of the time is over. Each bound on the way is proved.
    pub(super) fn improved(model: &SortingModel, watch: &Watch<'_>, until: f64) -> Self {
        let (points, shared, values) = Improvement::new(model, watch, until).run();
        let bound = Self { model: model.clone(), points, shared, values };
        watch.report_upper(bound.look_ahead(Belief::new(model).as_slice(), Viewpoint(0)).1);
        bound
    }

    /// One distribution per position. The clock may read anything: the least bound counts.
    pub(super) fn value(&self, belief: &[f64], viewpoint: Viewpoint) -> f64 {
        let rows: Vec<_> = self.model.positions().zip(belief.chunks_exact(self.model.kind_count())).collect();
        let rows: Vec<_> = rows.iter().map(|(i, row)| (*i, self.points.locate(*i, row))).collect();
        let sum = |mode| rows.iter().map(|(i, row)| self.values.average(mode, *i, row)).sum();
        let known = bounds::upper(&self.model, (belief, Remaining::ENDLESS), viewpoint);
        self.shared.modes_at(viewpoint).map(sum).fold(known, f64::min)
    }

    /// What the belief about one object adds to the bound, per mode that a camera at a viewpoint may be in.
    pub(super) fn parts(&self, position: Position, belief: &[f64], viewpoint: Viewpoint) -> Vec<f64> {
        let row = self.points.locate(position, belief);
        self.shared.modes_at(viewpoint).map(|mode| self.values.average(mode, position, &row)).collect()
    }

    /// The better of the bound itself and the one that is one exact step ahead of it.
    pub(super) fn upper(&self, belief: &[f64], viewpoint: Viewpoint) -> f64 {
        self.look_ahead(belief, viewpoint).1.min(self.value(belief, viewpoint))
    }

    /// The action that is best one exact step ahead of the sum over positions, and its value.
    ///
    /// Since labels of one scan are independent given the belief, the expectation of the sum is the sum of each
    /// position's own: no label vectors are enumerated.
    pub(super) fn look_ahead(&self, belief: &[f64], viewpoint: Viewpoint) -> (Action, f64) {
        let l = self.model.kind_count();
        let (bin, reward) = self.model.best_decision(&belief[..l]);
        let advanced = [&belief[l..], self.model.arrival().as_slice()].concat();
        let decided = reward + self.model.discount() * self.value(&advanced, viewpoint);
        let mut best = (Action::Decide(bin), decided);
        for &to in self.model.legal_moves(viewpoint) {
            let value =
                self.model.discount() * self.expected(belief, to) - self.model.motion_cost(viewpoint, to);
            if value > best.1 {
                best = (Action::Move(to), value);
            }
        }
        best
    }

    /// Expectation of the bound over the labels of a scan.
    fn expected(&self, belief: &[f64], viewpoint: Viewpoint) -> f64 {
        let modes = self.shared.modes_at(viewpoint);
        let mut sums = vec![0.0; modes.len()];
        for (position, row) in self.model.positions().zip(belief.chunks_exact(self.model.kind_count())) {
            for (p, posterior) in self.points.object.look(position, viewpoint, row) {
                let located = self.points.locate(position, &posterior);
                for (sum, mode) in sums.iter_mut().zip(modes.clone()) {
                    *sum += p * self.values.average(mode, position, &located);
                }
            }
        }
        sums.into_iter().fold(f64::INFINITY, f64::min)
    }
}
