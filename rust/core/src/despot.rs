//! DESPOT: online planning in a tree that is determinised by scenarios.
//!
//! Follows Ye, Somani, Hsu & Lee, "DESPOT: Online POMDP planning with regularization" (JAIR 58, 2017), with the
//! structure of the sorting problem put to use:
//!
//! * All decisions lead to the same next belief, so inside the search there is one `Decide`, with the most likely
//!   label: L + K actions become K + 1.
//! * The belief at a node is known exactly. Scenarios only choose *which* label vectors get a branch; a branch
//!   weighs its exact probability `P(z | b, v)` and rewards are expectations under the exact belief.
//! * The mass of labels that no scenario gives is not dropped: it follows the default policy (one-object plans
//!   chosen per label, [`crate::bounds::Foresight`]).
//!
//! The optimum of this problem is the value of a policy that can be executed; so with regularisation 0 the
//! search's lower bound never exceeds V*.
//!
//! The action is chosen by a third value, an estimate: the lower bound plus what the default policy is expected to
//! fall short by ([`shortfall`]). Lower bounds rise where the search has looked deeper; estimates do so only
//! where looking deeper has found more than it finds on average. They are cut by upper bounds of V* alone: that of the
//! sampled problem falls below V* wherever scenarios run out, first where most was searched.
//!
//! Leaves are expanded in batches whose size depends on the trials done alone, and a batch is chosen while the one before
//! it is being expanded, however many threads there are: so they share the work without a say in the result.

mod branch;
mod budgeted;
mod config;
mod expand;
mod explain;
mod frontier;
mod histories;
mod objects;
mod plan;
mod scan;
mod search;
mod shortfall;
mod sightings;
mod stopping;
mod workspace;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::belief::Belief;
use crate::error::Result;
use crate::index::Viewpoint;
use crate::model::SortingModel;
use crate::offline::{Certificate, Solution};
use crate::one_object::OneObjectPolicy;
use crate::remaining::Remaining;
use crate::scenario::Randoms;
use crate::tree::Values;

pub use budgeted::BudgetedDespot;
pub use config::{Budget, DespotConfig};
pub use explain::{TreeAction, TreeBranch, TreeNode};
pub use plan::Plan;
use search::Search;
use shortfall::{Prospect, Shortfall};
use stopping::Clock;
use workspace::Pool;

/// A search that nobody stops.
static NEVER: AtomicBool = AtomicBool::new(false);

/// The planner: a model, its default policy and the settings of the search. A clone shares memory, not plans.
#[derive(Debug, Clone)]
pub struct Despot {
    model: Arc<SortingModel>,
    default_policy: OneObjectPolicy,
    config: DespotConfig,
    /// Planner steps to look ahead.
    depth: usize,
    /// Discount down to each depth.
    discounts: Vec<f64>,
    shortfall: Shortfall,
    /// For plans' certificates; the search has bounds of its own.
    certificate: Option<Certificate>,
    randoms: Arc<Randoms>,
    pool: Pool,
}

impl Despot {
    /// Prepare to plan: solves the one-object problem.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for no scenarios or more than a million, a negative or infinite regularisation,
    /// depth 0, or so many label vectors (L^H) that they cannot be numbered.
    pub fn new(model: &SortingModel, config: DespotConfig) -> Result<Self> {
        config.check(model)?;
        Ok(Self::prepared(model, OneObjectPolicy::solve(model), Certificate::coarse(model), config))
    }

    /// Prepare to plan with what a solution knows: at once, and with certificates as tight as its bounds.
    ///
    /// # Errors
    /// As [`Despot::new`], and for the solution of another model.
    pub fn with_solution(model: &SortingModel, solution: &Solution, config: DespotConfig) -> Result<Self> {
        config.check(model)?;
        solution.check_solves(model)?;
        Ok(Self::prepared(model, solution.one_object().clone(), solution.certificate(), config))
    }

    fn prepared(
        model: &SortingModel,
        default_policy: OneObjectPolicy,
        certificate: Option<Certificate>,
        config: DespotConfig,
    ) -> Self {
        let depth = config.depth_for(model);
        let power = |previous: &f64| Some(previous * model.discount());
        Self {
            shortfall: Shortfall::fitted(model, &default_policy),
            certificate,
            model: Arc::new(model.clone()),
            default_policy,
            depth,
            discounts: std::iter::successors(Some(1.0), power).take(depth + 2).collect(),
            randoms: Arc::new(Randoms::new(config.seed, config.scenarios, model.position_count(), depth)),
            config,
            pool: Pool::default(),
        }
    }

    /// The model planned for.
    #[must_use]
    pub fn model(&self) -> &SortingModel {
        &self.model
    }

    /// The settings.
    #[must_use]
    pub fn config(&self) -> &DespotConfig {
        &self.config
    }

    /// Plan the next action on this thread.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if belief or viewpoint do not fit the model, or the budget is zero.
    pub fn plan(&self, belief: &Belief, viewpoint: Viewpoint, budget: Budget) -> Result<Plan> {
        self.plan_until(belief, viewpoint, budget, false, &NEVER)
    }

    /// Plan the next action with all threads of the current rayon pool: the same plan, sooner.
    ///
    /// # Errors
    /// As [`Despot::plan`].
    pub fn plan_in_parallel(&self, belief: &Belief, viewpoint: Viewpoint, budget: Budget) -> Result<Plan> {
        self.plan_until(belief, viewpoint, budget, true, &NEVER)
    }

    /// Plan until the budget is spent or `stop` is set: what was found up to then.
    ///
    /// # Errors
    /// As [`Despot::plan`].
    pub fn plan_until(
        &self,
        belief: &Belief,
        viewpoint: Viewpoint,
        budget: Budget,
        parallel: bool,
        stop: &AtomicBool,
    ) -> Result<Plan> {
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        budget.check()?;
        let clock = Clock::started(budget, stop);
        let certified_upper = self.certified_upper(belief.known(), viewpoint);
        let mut search = Search { despot: self, space: self.pool.lease(), clock, parallel };
        search.run(belief, viewpoint);
        Ok(search.into_plan(certified_upper))
    }

    /// The factor between a belief's own values and the scaled ones of the tree.
    #[inline(always)]
    fn scale(&self, depth: usize, probability: f64) -> f64 {
        probability * self.discounts[depth]
    }

    /// Values of a leaf from unscaled ones: the default policy's, or at best the upper bound after one policy node.
    #[inline(always)]
    fn leaf(
        &self,
        (depth, probability, remaining): (usize, f64, Remaining),
        value: f64,
        entropy: f64,
        upper: f64,
    ) -> Values {
        let scale = self.scale(depth, probability);
        let lower = scale * value;
        let certified = scale * upper;
        let upper =
            if depth < self.depth { lower.max(certified - self.config.regularization) } else { lower };
        let prospect = Prospect { mass: scale, value: lower, entropy: scale * entropy };
        let estimate = (lower + self.shortfall.at(prospect, remaining)).min(certified);
        Values { lower, upper, estimate, certified }
    }
}

#[cfg(test)]
mod tests;
