//! The one-object problem: look at the object at the belt end until it pays to decide.
//!
//! Its solution is a set of conditional plans. Each plan is known exactly by two functions of the true class c:
//! the expected discounted reward `G(c)` up to and including its decision, and the expected discount
//! `D_s(c) = E[discount^steps; the camera ends in viewpoint group s | c]` after it. Executing a plan from belief b
//! and continuing with value `W_s` is worth `sum_c b_c (G(c) + sum_s D_s(c) W_s)`, whatever the continuation.
//!
//! Viewpoints with the same moves at the same costs are one *group*: in the paper's model there is one.

mod plan_set;
mod reachable;
mod solve;
mod stored;

use nalgebra::DVector;

use crate::index::Viewpoint;
use crate::model::{Action, SortingModel};
use crate::remaining::Remaining;
use plan_set::{ConditionalPlan, PlanSet};
pub(crate) use reachable::reachable_beliefs;

/// Plans for one object, and what executing the best of them for ever is worth.
#[derive(Debug, Clone)]
pub struct OneObjectPolicy {
    /// Group of each viewpoint.
    group_of: Vec<usize>,
    /// Plans per group.
    plans: Vec<PlanSet>,
    /// Value of starting with an unseen object, per group.
    arrival_values: Vec<f64>,
    /// Value of 0, 1, 2, ... unseen objects on a belt that ends, per group; that of more is an endless belt's.
    unseen_values: Vec<Vec<f64>>,
}

impl OneObjectPolicy {
    /// Number of viewpoint groups.
    #[inline(always)]
    pub(crate) fn group_count(&self) -> usize {
        self.plans.len()
    }

    /// Group of a viewpoint.
    #[inline(always)]
    pub(crate) fn group(&self, viewpoint: Viewpoint) -> usize {
        self.group_of[viewpoint.0]
    }

    /// A viewpoint of a group; all of them have the same moves at the same costs.
    pub(crate) fn representative(&self, group: usize) -> Viewpoint {
        Viewpoint(self.group_of.iter().position(|g| *g == group).unwrap_or(0))
    }

    /// Value of an unseen object at the belt end and unseen ones behind it, per group.
    pub(crate) fn arrival_values(&self) -> &[f64] {
        &self.arrival_values
    }

    /// Value of the objects that have still to arrive, per group.
    #[inline(always)]
    pub(crate) fn values_of_unseen(&self, unseen: Remaining) -> &[f64] {
        let ending = unseen.0.and_then(|objects| self.unseen_values.get(objects));
        ending.unwrap_or(&self.arrival_values)
    }

    /// The best plan for one object from a group, given what follows it.
    #[inline(always)]
    pub(crate) fn best(&self, group: usize, belief: &[f64], continuation: &[f64]) -> (&ConditionalPlan, f64) {
        self.plans[group].best(belief, continuation)
    }

    /// Value of what follows the object at the belt end, per group: the objects behind it, each by the best plan
    /// for what is known of it *now*. `belief` holds one distribution per position.
    #[inline(always)]
    fn continuation(&self, (belief, remaining): (&[f64], Remaining), classes: usize) -> Vec<f64> {
        let positions = belief.len() / classes;
        let mut worth = self.values_of_unseen(remaining.unseen(positions)).to_vec();
        let visible = remaining.visible(positions);
        for position in belief.chunks_exact(classes).take(visible).skip(1).rev() {
            worth = (0..self.group_count()).map(|s| self.best(s, position, &worth).1).collect();
        }
        worth
    }

    /// Value of executing one plan per visible object, each chosen now; no less than this can be had.
    ///
    /// `G(b^1) + D(b^1) (G(b^2) + D(b^2) (... + D(b^H) V_1(arrival)))`: exact for that policy, because the labels
    /// it ignores are independent of those it uses. A lower bound of V* for any H.
    #[inline(always)]
    pub(crate) fn value(
        &self,
        model: &SortingModel,
        (belief, remaining): (&[f64], Remaining),
        viewpoint: Viewpoint,
    ) -> f64 {
        let l = model.kind_count();
        if remaining.is_over() {
            return 0.0;
        }
        self.best(self.group(viewpoint), &belief[..l], &self.continuation((belief, remaining), l)).1
    }

    /// `G(c)` and `D(c)`, a pair per position, of the plans that [`OneObjectPolicy::value`] executes.
    ///
    /// For models with a single viewpoint group.
    pub(crate) fn chain(&self, model: &SortingModel, belief: &[f64]) -> Vec<(DVector<f64>, DVector<f64>)> {
        let mut worth = self.arrival_values.clone();
        let mut chain = Vec::new();
        for position in belief.chunks_exact(model.kind_count()).rev() {
            let (plan, value) = self.best(0, position, &worth);
            chain.push((plan.gain.clone(), plan.discount_to.clone()));
            worth = vec![value];
        }
        chain.reverse();
        chain
    }

    /// First action of the plan that [`OneObjectPolicy::value`] executes.
    pub(crate) fn action(
        &self,
        model: &SortingModel,
        (belief, remaining): (&[f64], Remaining),
        viewpoint: Viewpoint,
    ) -> Action {
        let l = model.kind_count();
        self.best(self.group(viewpoint), &belief[..l], &self.continuation((belief, remaining), l)).0.action
    }
}

#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// The group of each viewpoint, and the number of groups.
pub(crate) fn viewpoint_groups(model: &SortingModel) -> (Vec<usize>, usize) {
    let moves = |from| -> Vec<(Viewpoint, u64)> {
        let cost = |to| model.motion_cost(from, to).to_bits();
        model.legal_moves(from).iter().map(|&to| (to, cost(to))).collect()
    };
    let mut kinds: Vec<Vec<(Viewpoint, u64)>> = Vec::new();
    let group_of = model
        .viewpoints()
        .map(|from| {
            let kind = moves(from);
            kinds.iter().position(|known| *known == kind).unwrap_or_else(|| {
                kinds.push(kind);
                kinds.len() - 1
            })
        })
        .collect();
    (group_of, kinds.len())
}
