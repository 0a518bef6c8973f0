//! The recommended planner: a search in a tree of exact beliefs, in which scenarios choose the branches.
//!
//! It descends from DESPOT (Ye, Somani, Hsu & Lee, "DESPOT: Online POMDP planning with regularization", JAIR 58, 2017), of
//! which it keeps the sampled scenarios, the anytime search guided by bounds and excess uncertainty, and a default policy
//! at the leaves. What differs makes use of the sorting problem's structure:
//!
//! * All decisions lead to the same next belief, so one `Decide`, with the most likely label, stands for all.
//! * The belief at a node is exact. Scenarios choose *which* label vectors get a branch, nothing else: a branch weighs its
//!   exact probability `P(z | b, v)`, and rewards are expectations under the exact belief.
//! * The probability of labels that no scenario gives is not dropped: they follow the default policy, one conditional
//!   plan per object, chosen by the object's label (`outcomes`).
//! * No regularisation: the sampled problem's optimum is the value of a policy that can be executed, so the lower
//!   bound never exceeds V*, and there is nothing to overfit that a price per node would prevent.
//! * The action is chosen by an estimate: the lower bound plus what the default policy is expected to fall short of the
//!   optimum by (`shortfall`). Estimates are cut by upper bounds of V* alone; the sampled problem's upper bound falls
//!   below V* where scenarios run out.

mod expand;
mod explain;
mod look_ahead;
mod outcomes;
mod plan;
mod shortfall;
mod tree;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::belief::Belief;
use crate::bounds;
use crate::config::{Budget, Clock, DespotConfig, NEVER};
use crate::error::{Result, argument_error};
use crate::index::Viewpoint;
use crate::model::{Action, SortingModel};
use crate::offline::{Certificate, Solution};
use crate::one_object::OneObjectPolicy;
use crate::plan::Plan;
use crate::policy::Policy;
use crate::remaining::Remaining;
use crate::scenario::{Randoms, Scenarios};

pub(crate) use explain::Searched;
pub use explain::{TreeAction, TreeBranch, TreeNode};
pub use look_ahead::LookAhead;
use shortfall::{Features, Shortfall};
pub(crate) use tree::{Child, Edge, Node, Place, Tree, Values, first_best};

/// `xi` of the DESPOT paper: the part of the root's gap that one trial tries to leave.
pub(crate) const TARGET_GAP: f64 = 0.95;
/// Tolerance of the search: it ends once the root's bounds are closer than this, in units of `r_max`.
pub(crate) const GAP_TOLERANCE: f64 = 1e-10;

/// The planner: a model, its default policy and the settings of the search.
#[derive(Debug, Clone)]
pub struct BeliefSearch {
    model: Arc<SortingModel>,
    default_policy: OneObjectPolicy,
    config: DespotConfig,
    /// Planner steps to look ahead.
    depth: usize,
    shortfall: Shortfall,
    /// Upper bounds of V* at leaves, and of the plans.
    certificate: Option<Certificate>,
    randoms: Arc<Randoms>,
}

impl BeliefSearch {
    /// Prepare to plan: solves the one-object problem.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for no scenarios or more than a million, a regularisation, or depth 0.
    pub fn new(model: &SortingModel, config: DespotConfig) -> Result<Self> {
        Self::new_until(model, None, config, &NEVER)
    }

    /// Prepare to plan with what a solution knows: at once, and with certificates as tight as its bounds.
    ///
    /// # Errors
    /// As [`BeliefSearch::new`], and for the solution of another model.
    pub fn with_solution(model: &SortingModel, solution: &Solution, config: DespotConfig) -> Result<Self> {
        Self::new_until(model, Some(solution), config, &NEVER)
    }

    /// Prepare to plan, with or without a solution, until `stop` is set: then with a default policy and estimates as good
    /// as they were by then.
    ///
    /// # Errors
    /// As [`BeliefSearch::with_solution`].
    pub fn new_until(
        model: &SortingModel,
        solution: Option<&Solution>,
        config: DespotConfig,
        stop: &AtomicBool,
    ) -> Result<Self> {
        check(config)?;
        let (default_policy, certificate) = if let Some(solution) = solution {
            solution.check_solves(model)?;
            (solution.one_object().clone(), solution.certificate())
        } else {
            (OneObjectPolicy::solve_until(model, stop), Certificate::coarse(model, stop))
        };
        let depth = config.depth_for(model);
        Ok(Self {
            shortfall: Shortfall::fitted(model, &default_policy, certificate.as_ref(), stop),
            certificate,
            model: Arc::new(model.clone()),
            default_policy,
            depth,
            randoms: Arc::new(Randoms::new(config.seed, config.scenarios, model.position_count(), depth)),
            config,
        })
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

    /// Plan the next action. With a budget of trials the plan is a pure function of the arguments.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if belief or viewpoint do not fit the model, or the budget is zero.
    pub fn plan(&self, belief: &Belief, viewpoint: Viewpoint, budget: Budget) -> Result<Plan> {
        self.plan_until(belief, viewpoint, budget, &NEVER)
    }

    /// Plan until the budget is spent or `stop` is set: what was found up to then.
    ///
    /// # Errors
    /// As [`BeliefSearch::plan`].
    pub fn plan_until(
        &self,
        belief: &Belief,
        viewpoint: Viewpoint,
        budget: Budget,
        stop: &AtomicBool,
    ) -> Result<Plan> {
        budget.check()?;
        let mut clock = Clock::started(budget, stop);
        let mut search = Search::new(self, belief, viewpoint)?;
        search.expand_root();
        while let Some(leaf) = search.leaf_of_next_trial().filter(|_| clock.allows_another()) {
            search.expand(Some(leaf));
            clock.count();
        }
        Ok(search.into_plan(&clock))
    }

    /// The certificate, where it covers a belief: it is one of endless belts.
    fn certificate_for(&self, belief: &Belief) -> Option<&Certificate> {
        self.certificate.as_ref().filter(|_| belief.objects_left() == Remaining::ENDLESS)
    }

    /// Upper bound of V* at a belief.
    fn upper(&self, belief: &Belief, viewpoint: Viewpoint) -> f64 {
        let model = &self.model;
        let closed = bounds::upper(model, belief.known(), viewpoint);
        let value = |bound: &Certificate| bound.value(model, belief.as_slice(), viewpoint);
        self.certificate_for(belief).map_or(closed, |bound| value(bound).min(closed))
    }

    /// Values of a leaf at a depth: the default policy's value, the estimate, and at most an upper bound of V*.
    fn leaf(&self, depth: usize, belief: &Belief, features: Features, certified: f64) -> Values {
        let lower = features.value;
        let upper = if depth < self.depth { lower.max(certified) } else { lower };
        let estimate = (lower + self.shortfall.at(features, belief.objects_left())).min(certified);
        Values { lower, upper, estimate, certified }
    }
}

fn check(config: DespotConfig) -> Result<()> {
    config.check()?;
    if config.regularization > 0.0 {
        return argument_error(format!(
            "regularization = {}; the search over exact beliefs has nothing to regularise: leave it out, or plan with \
             scenarios alone, as published",
            config.regularization
        ));
    }
    Ok(())
}

/// One search.
struct Search<'a> {
    planner: &'a BeliefSearch,
    /// Belief and viewpoint at the root.
    belief: &'a Belief,
    viewpoint: Viewpoint,
    tree: Tree,
    scenarios: Scenarios<'a>,
    nodes_created: u64,
    /// (scenario, move) pairs simulated at expanded nodes.
    scenario_steps: u64,
}

impl<'a> Search<'a> {
    fn new(planner: &'a BeliefSearch, belief: &'a Belief, viewpoint: Viewpoint) -> Result<Self> {
        let model = &planner.model;
        belief.check_fits(model)?;
        model.check_viewpoint(viewpoint)?;
        let value = bounds::lower(model, &planner.default_policy, belief.known(), viewpoint);
        let upper = planner.upper(belief, viewpoint);
        let values =
            planner.leaf(0, belief, Features { mass: 1.0, value, entropy: 0.0, bound: upper - value }, upper);
        let tree = Tree { root: Child { values, probability: 1.0, node: None }, nodes: Vec::new() };
        let scenarios = Scenarios::sampled((model, &planner.randoms), belief, planner.depth, false);
        Ok(Self { planner, belief, viewpoint, tree, scenarios, nodes_created: 1, scenario_steps: 0 })
    }

    /// Expand the root, whatever the budget says; on a belt that ends also the belief after a decision. There leaves are
    /// valued without a shortfall, and one that no scan leads to would be underrated beside those behind a scan.
    fn expand_root(&mut self) {
        self.expand(None);
        let decision = Place { node: 0, edge: 0, child: 0 };
        let edge = &self.tree.nodes[0].edges[0];
        let leaf_follows = edge.labels.is_empty() && edge.children[0].values.gap() > 0.0;
        if self.belief.objects_left().ends() && leaf_follows {
            self.expand(Some(decision));
        }
    }

    /// The leaf to expand next; none if that would change nothing.
    fn leaf_of_next_trial(&self) -> Option<Place> {
        let (gap, model) = (self.tree.root.values.gap(), &self.planner.model);
        if gap < GAP_TOLERANCE * model.reward_scale() {
            return None;
        }
        let leaf = self.tree.explore(TARGET_GAP * gap);
        leaf.filter(|leaf| self.tree.child(Some(*leaf)).values.gap() > 0.0)
    }
}

/// The planner with a fixed budget per step, as a policy.
#[derive(Debug, Clone)]
pub struct BudgetedSearch {
    /// The planner.
    pub search: BeliefSearch,
    /// Its budget per planner step.
    pub budget: Budget,
}

impl Policy for BudgetedSearch {
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        Ok(self.search.plan(belief, viewpoint, self.budget)?.action)
    }
}

#[cfg(test)]
mod tests;
