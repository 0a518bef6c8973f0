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
//! where looking deeper has found more than it finds on average.
//!
//! Leaves are expanded in batches whose size depends on the trials done alone, so that threads share the work without a
//! say in the result.

mod branch;
mod config;
mod expand;
mod explain;
mod objects;
mod plan;
mod shortfall;
mod stopping;
mod workspace;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use rayon::prelude::*;

use crate::belief::Belief;
use crate::bounds;
use crate::error::Result;
use crate::model::SortingModel;
use crate::one_object::OneObjectPolicy;
use crate::planes;
use crate::reference::{Certificate, Solution};
use crate::remaining::Remaining;
use crate::scenario::Randoms;
use crate::tree::{Child, Place, Values, id, indices};

pub use config::{Budget, DespotConfig};
use expand::{Expansion, Scratch};
pub use explain::{TreeAction, TreeBranch, TreeNode};
pub use plan::Plan;
use shortfall::{Prospect, Shortfall};
use workspace::{Lease, Pool};

/// `xi` of the DESPOT paper: the part of the root's gap that one trial tries to leave.
const TARGET_GAP: f64 = 0.95;
/// Expansions that are worth waking another thread for, and those done by one task.
const WORTH_SHARING: usize = 16;
const PER_TASK: usize = 4;
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
    pub fn plan(&self, belief: &Belief, viewpoint: usize, budget: Budget) -> Result<Plan> {
        self.plan_until(belief, viewpoint, budget, false, &NEVER)
    }

    /// Plan the next action with all threads of the current rayon pool: the same plan, sooner.
    ///
    /// # Errors
    /// As [`Despot::plan`].
    pub fn plan_in_parallel(&self, belief: &Belief, viewpoint: usize, budget: Budget) -> Result<Plan> {
        self.plan_until(belief, viewpoint, budget, true, &NEVER)
    }

    /// Plan until the budget is spent or `stop` is set: what was found up to then.
    ///
    /// # Errors
    /// As [`Despot::plan`].
    pub fn plan_until(
        &self,
        belief: &Belief,
        viewpoint: usize,
        budget: Budget,
        parallel: bool,
        stop: &AtomicBool,
    ) -> Result<Plan> {
        let start = Instant::now();
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        budget.check()?;
        let mut search = Search {
            despot: self,
            space: self.pool.lease(),
            budget,
            stop,
            parallel,
            start,
            begun: start,
            trials: 0,
            scenario_steps: 0,
            nodes: 1,
        };
        let certified_upper = self.certified_upper(belief.known(), viewpoint);
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
        let upper =
            if depth < self.depth { lower.max(scale * upper - self.config.regularization) } else { lower };
        let prospect = Prospect { mass: scale, value: lower, entropy: scale * entropy };
        let estimate = (lower + self.shortfall.at(prospect, remaining)).min(upper);
        Values { lower, upper, estimate }
    }
}

/// One search in progress.
struct Search<'a> {
    despot: &'a Despot,
    space: Lease,
    budget: Budget,
    stop: &'a AtomicBool,
    parallel: bool,
    start: Instant,
    /// When the root was expanded.
    begun: Instant,
    trials: u64,
    scenario_steps: u64,
    /// Beliefs created.
    nodes: u64,
}

impl Search<'_> {
    fn run(&mut self, belief: &Belief, viewpoint: usize) {
        self.begin(belief, viewpoint);
        self.begun = Instant::now();
        while !self.finished() {
            self.choose_leaves();
            if self.space.expansions.is_empty() {
                return;
            }
            self.expand_leaves(|search| !search.out_of_time());
            self.trials += self.attach_expansions();
        }
    }

    /// The root, expanded whatever the budget says.
    fn begin(&mut self, belief: &Belief, viewpoint: usize) {
        let Despot { model, default_policy, randoms, .. } = self.despot;
        let (known, remaining) = (belief.known(), belief.horizon());
        let lower = bounds::lower(model, default_policy, known, viewpoint);
        let upper = bounds::upper(model, known, viewpoint);
        let values = self.despot.leaf((0, 1.0, remaining), lower, 0.0, upper);
        let root = Child { values, probability: 1.0, ..Child::default() };
        randoms.reach(0, self.parallel);
        self.space.restart(self.despot, (belief, viewpoint), root);
        self.space.choose(model, None);
        self.expand_leaves(|_| true);
        self.attach_expansions();
    }

    /// Choose the leaves of the next trials; until they are expanded each counts as settled, so that the others
    /// lie elsewhere.
    fn choose_leaves(&mut self) {
        for _ in 0..self.allowed() {
            let leaf = self.explore();
            if self.space.tree.child(leaf).values.gap() <= 0.0 {
                return;
            }
            self.space.choose(&self.despot.model, leaf);
        }
    }

    /// One trial: follow the most promising action and the most uncertain label down to a leaf.
    fn explore(&self) -> Option<Place> {
        let tree = &self.space.tree;
        let (mut place, mut child) = (None, &tree.root);
        while let Some(node) = child.node {
            let from = &tree.nodes[node as usize];
            let edge = from.most_promising_edge();
            let next = self.most_uncertain(&from.children, indices(&from.edges[edge].children));
            place = Some(Place { node, edge: id(edge), child: id(next) });
            child = &from.children[next];
        }
        place
    }

    /// The child with the largest excess uncertainty: its gap beyond its share of the root's target gap.
    fn most_uncertain(&self, children: &[Child], among: std::ops::Range<usize>) -> usize {
        let target = TARGET_GAP * self.space.tree.root.values.gap();
        let mut best = (among.start, f64::NEG_INFINITY);
        for (index, child) in (among.start..).zip(&children[among]) {
            let excess = child.values.gap() - child.probability * target;
            if excess > best.1 {
                best = (index, excess);
            }
        }
        best.0
    }

    /// Expand the chosen leaves, each on its own; a leaf that there is no more time for stays one.
    fn expand_leaves(&mut self, in_time: impl Fn(&Self) -> bool + Sync) {
        let shared = self.parallel && self.space.expansions.len() >= WORTH_SHARING;
        self.space.prepare(self.despot, shared);
        let mut expansions = std::mem::take(&mut self.space.expansions);
        let mut scratch = std::mem::take(&mut self.space.scratch);
        let per_task = if shared { PER_TASK } else { expansions.len() };
        scratch.resize_with(scratch.len().max(expansions.len().div_ceil(per_task)), Scratch::default);
        let expand = |(expansions, scratch): (&mut [Expansion], &mut Scratch)| {
            for expansion in expansions {
                if in_time(self) {
                    expansion.run(self.despot, &self.space, scratch);
                }
            }
        };
        if shared {
            expansions.par_chunks_mut(per_task).zip(&mut scratch).for_each(expand);
        } else {
            expansions.chunks_mut(per_task).zip(&mut scratch).for_each(expand);
        }
        (self.space.expansions, self.space.scratch) = (expansions, scratch);
    }

    /// Put what was made into the tree and count it; the number of trials done.
    fn attach_expansions(&mut self) -> u64 {
        let mut trials = 0;
        for Expansion { node, .. } in self.space.expansions.iter().filter(|expansion| expansion.done()) {
            let moves = self.despot.model.legal_moves(node.viewpoint).len() as u64;
            trials += 1;
            self.nodes += node.children.len() as u64;
            self.scenario_steps += moves * planes::count(&node.scenarios);
        }
        self.space.attach();
        trials
    }
}

#[cfg(test)]
mod tests;
