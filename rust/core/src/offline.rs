//! The offline reference solution and its certificate: `lower <= V*(b0) <= upper`.
//!
//! Value iteration on a belief grid bounds V* from above everywhere ([`upper`], [`value_iteration`]). Search in the
//! graph of exactly reachable beliefs lowers that bound at the start ([`graph`], [`reach`]). Its policy, continued by
//! itself where the graph ends, is valued exactly and so bounds V* from below ([`controller`]). For models too large for
//! such grids prices bound V* from above, position by position ([`prices`]). Each bound is proved,
//! not estimated, at any time.

mod alpha;
mod certificate;
mod controller;
mod difference;
mod evaluation;
mod graph;
mod neighbourhoods;
mod objects;
mod prices;
mod reach;
mod saved;
mod simplex_grid;
mod sparse;
mod stages;
mod upper;
mod value_iteration;
mod watch;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use crate::belief::Belief;
use crate::bounds;
use crate::error::{Result, argument_error};
use crate::index::Viewpoint;
use crate::model::{Action, SortingModel};
use crate::one_object::OneObjectPolicy;
use crate::policy::Policy;
use crate::remaining::Remaining;
use alpha::AlphaVectors;
use certificate::Source;
pub(crate) use certificate::{Certificate, ScanBounds};
use prices::PricedBound;
pub(crate) use prices::{Faces, ObjectModel, Rows};
pub(crate) use simplex_grid::Combination;
use upper::GridBound;
use watch::{Progress, Watch};

/// Wall-clock time of a solution that is given none, seconds.
pub const DEFAULT_SOLVE_SECONDS: f64 = 60.0;
/// Label vectors of a scan that can be enumerated.
const MOST_LABELS: u64 = 4096;
/// What rounding and the merging of nearly equal beliefs may move a bound by, as a part of `r_max`.
const SLACK: f64 = 1e-7;

/// Bounds at any belief.
#[derive(Debug, Clone)]
struct LeafBounds {
    policy: OneObjectPolicy,
    /// For models that [`upper`] is proved for.
    grid: Option<Arc<GridBound>>,
    /// For the others.
    prices: Option<Arc<PricedBound>>,
    /// Values of policies, of models with a grid.
    alphas: Option<AlphaVectors>,
}

impl LeafBounds {
    fn bounds(&self, model: &SortingModel, belief: &[f64], viewpoint: Viewpoint) -> (f64, f64) {
        let lower = self.policy.value(model, (belief, Remaining::ENDLESS), viewpoint);
        let lower = self.alphas.as_ref().map_or(lower, |alphas| alphas.value(model, belief).max(lower));
        (lower, self.upper(model, belief, viewpoint))
    }

    fn upper(&self, model: &SortingModel, belief: &[f64], viewpoint: Viewpoint) -> f64 {
        let closed = bounds::upper(model, (belief, Remaining::ENDLESS), viewpoint);
        let grid = self.grid.as_ref().map_or(closed, |grid| grid.value(belief).min(closed));
        self.prices.as_ref().map_or(grid, |prices| prices.value(belief, viewpoint).min(grid))
    }
}

/// Certified bounds of the value, and a policy.
#[derive(Debug, Clone)]
pub struct Solution {
    model: SortingModel,
    leaves: LeafBounds,
    /// `lower <= V*(b0)` at the arrival prior, viewpoint 0: the value of a policy that can be executed.
    pub lower: f64,
    /// `V*(b0) <= upper`.
    pub upper: f64,
    /// Wall-clock time spent.
    pub elapsed: Duration,
}

impl Solution {
    /// Solve a model for about `time`, or until the gap is closed, or until `stop` is set.
    ///
    /// For one or two positions and viewpoints that are all alike the bounds are tight. For other models the upper one
    /// is a Lagrangian relaxation by prices, and the lower one from the one-object policy; where label vectors can be enumerated (4096
    /// per scan), a search narrows the gap.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if the time is 0; [`crate::Error::Model`] for a model beyond the paper's.
    pub fn solve(
        model: &SortingModel,
        time: Duration,
        stop: &AtomicBool,
        progress: Progress<'_>,
    ) -> Result<Self> {
        model.check_plain()?;
        if time.is_zero() {
            return argument_error(format!(
                "seconds = 0; give a time above 0, {DEFAULT_SOLVE_SECONDS} for example"
            ));
        }
        let arrival = Belief::new(model).as_slice().to_vec();
        let policy = OneObjectPolicy::solve_until(model, stop);
        let mut leaves = LeafBounds { policy, grid: None, prices: None, alphas: None };
        let watch = Watch::new(time, stop, progress, leaves.bounds(model, &arrival, Viewpoint(0)));
        if all_alike(model) && stages::grid_fits(model) {
            leaves.grid = Some(Arc::new(stages::tightened_grid(model, &watch)));
        } else {
            leaves.prices = Some(Arc::new(PricedBound::improved(model, &watch, stages::GRID_UNTIL)));
        }
        if enumerable(model) {
            leaves.alphas = stages::searched(model, &leaves, &arrival, &watch);
        }
        leaves.grid = leaves.grid.map(|grid| stages::thinned(model, grid));
        let slack = SLACK * model.reward_scale();
        let (lower, upper) = watch.bounds();
        Ok(Self {
            model: model.clone(),
            leaves,
            lower: lower - slack,
            upper: upper + slack,
            elapsed: watch.elapsed(),
        })
    }

    /// Bounds of V* at any belief, from the grid and the policies found; at the arrival prior also from the search.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if belief or viewpoint do not fit the model.
    pub fn bounds(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<(f64, f64)> {
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        let (lower, upper) = self.leaves.bounds(&self.model, belief.as_slice(), viewpoint);
        let slack = SLACK * self.model.reward_scale();
        let (lower, upper) = (lower - slack, upper + slack);
        let alike = self.leaves.policy.group(viewpoint) == self.leaves.policy.group(Viewpoint(0));
        if alike && belief.as_slice() == Belief::new(&self.model).as_slice() {
            return Ok((lower.max(self.lower), upper.min(self.upper)));
        }
        Ok((lower, upper))
    }

    /// Whether [`Self::regret`] can value actions.
    #[must_use]
    pub fn values_actions(&self) -> bool {
        self.leaves.grid.is_some()
    }

    /// What an action loses against the best one, both valued one exact step ahead of the upper bound; not negative.
    ///
    /// Where the bound is tight, so is this: `V* - V` of a policy is the expected discounted sum of what its actions
    /// lose.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if belief or viewpoint do not fit the model, or its upper bound is the closed form,
    /// which says nothing about actions.
    pub fn regret(&self, belief: &Belief, viewpoint: Viewpoint, action: Action) -> Result<f64> {
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        let Some(grid) = &self.leaves.grid else {
            return argument_error(
                "this solution cannot value actions: it is of a model with more than two positions, or with viewpoints \
                 that differ in their moves; `compare` bounds what whole policies lose instead",
            );
        };
        let belief = belief.as_slice();
        let best = grid.look_ahead(&self.model, belief, viewpoint).1;
        Ok((best - grid.action_value(&self.model, belief, viewpoint, action)).max(0.0))
    }

    /// The policy for one object after the other, which the solution starts from.
    pub(crate) fn one_object(&self) -> &OneObjectPolicy {
        &self.leaves.policy
    }

    /// The upper bound, where it is more than the closed form.
    pub(crate) fn certificate(&self) -> Option<Certificate> {
        let grid = self.leaves.grid.clone().map(Source::Grid);
        grid.or_else(|| self.leaves.prices.clone().map(Source::Prices)).map(Certificate)
    }

    /// The model solved.
    #[must_use]
    pub fn model(&self) -> &SortingModel {
        &self.model
    }
}

impl Policy for Solution {
    /// The action that is best one exact step ahead of the upper bound.
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        let (known, belief) = (&self.leaves, belief.as_slice());
        let grid = known.grid.as_ref().map(|grid| grid.look_ahead(&self.model, belief, viewpoint).0);
        let priced = || known.prices.as_ref().map(|prices| prices.look_ahead(belief, viewpoint).0);
        let one_object = || known.policy.action(&self.model, (belief, Remaining::ENDLESS), viewpoint);
        Ok(grid.or_else(priced).unwrap_or_else(one_object))
    }
}

/// Whether the label vectors of a scan can be enumerated.
fn enumerable(model: &SortingModel) -> bool {
    let positions = u32::try_from(model.position_count()).unwrap_or(u32::MAX);
    (model.label_count() as u64).checked_pow(positions).is_some_and(|labels| labels <= MOST_LABELS)
}

/// Whether the proofs of [`upper`] and [`controller`] cover a model: at most two positions, viewpoints all alike.
fn all_alike(model: &SortingModel) -> bool {
    let moves = model.legal_moves(Viewpoint(0));
    let cost = |from| moves.iter().map(move |&to| model.motion_cost(from, to).to_bits());
    let alike = |k| model.legal_moves(k) == moves && cost(k).eq(cost(Viewpoint(0)));
    model.position_count() <= 2 && model.viewpoints().all(alike)
}

#[cfg(test)]
mod tests;
