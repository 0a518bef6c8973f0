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
//!   chosen per label, [`crate::bounds::Look`]).
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
mod plan;
mod shortfall;
mod workspace;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use crate::belief::{Belief, Memory, condition, shift};
use crate::bounds;
use crate::error::Result;
use crate::model::{Action, SortingModel};
use crate::one_object::OneObjectPolicy;
use crate::reference::{Certificate, Solution};
use crate::scenario::Randoms;
use crate::tree::{Node, Values, indices};

pub use config::{Budget, DespotConfig};
use expand::Expansion;
pub use explain::{TreeAction, TreeBranch, TreeNode};
pub use plan::Plan;
use shortfall::{Prospect, Shortfall};
use workspace::{Lease, Pool};

/// `xi` of the DESPOT paper: the part of the root's gap that one trial tries to leave.
const TARGET_GAP: f64 = 0.95;
/// A root gap, as a part of `r_max`, below which the sampled problem counts as solved.
const SOLVED: f64 = 1e-10;
/// Leaves chosen before any of them is expanded: work for the threads, and a little less well informed each. As many
/// as this part of the trials done, within limits; never a matter of threads.
const BATCH: (u64, std::ops::Range<u64>) = (4, 8..256);
/// Expansions that are worth waking another thread for, and those done by one task.
const WORTH_SHARING: usize = 64;
const PER_TASK: usize = 8;
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
            trials: 0,
            scenario_steps: 0,
        };
        search.run(belief, viewpoint);
        Ok(search.into_plan())
    }

    /// The factor between a node's own values and the scaled ones of the tree.
    #[inline(always)]
    fn scale(&self, node: &Node) -> f64 {
        node.probability * self.discounts[node.depth]
    }

    /// A leaf, its values unscaled so far: the default policy's, or at best the upper bound after one policy node.
    #[inline(always)]
    fn leaf(&self, mut node: Node, value: f64, entropy: f64, upper: f64) -> (Node, Values) {
        let scale = self.scale(&node);
        let default = scale * value;
        node.default = default;
        let upper = if node.depth < self.depth {
            default.max(scale * upper - self.config.regularization)
        } else {
            default
        };
        let prospect = Prospect { mass: scale, value: default, entropy: scale * entropy };
        let estimate = (default + self.shortfall.at(prospect)).min(upper);
        (node, Values { lower: default, upper, estimate })
    }
}

/// What is known after an action from a node's parent and the labels that lead to the node.
#[inline(always)]
fn follow(model: &SortingModel, belief: &mut [f64], memory: &mut Memory, action: Action, node: &Node) {
    let decided = matches!(action, Action::Decide(_));
    if decided {
        shift(model, belief, memory);
    }
    if !decided || model.observes_after_decision() {
        for (j, z) in node.seen(model).enumerate() {
            condition(model, belief, memory, (j, node.viewpoint, z));
        }
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
    trials: u64,
    scenario_steps: u64,
}

impl Search<'_> {
    fn run(&mut self, belief: &Belief, viewpoint: usize) {
        self.begin(belief, viewpoint);
        while !self.finished() {
            let trials = self.choose_leaves();
            self.expand_leaves(trials, |search| !search.out_of_time());
            self.trials += self.attach_expansions(trials);
        }
    }

    /// The root, expanded whatever the budget says.
    fn begin(&mut self, belief: &Belief, viewpoint: usize) {
        let Despot { model, default_policy, randoms, .. } = self.despot;
        let root = Node { viewpoint, probability: 1.0, ..Node::default() };
        let lower = bounds::lower(model, default_policy, belief.as_slice(), viewpoint);
        let upper = bounds::upper(model, belief.as_slice(), viewpoint);
        let root = self.despot.leaf(root, lower, 0.0, upper);
        randoms.reach(0, self.parallel);
        self.space.restart(model, randoms, belief, root);
        self.space.choose(0, 0);
        self.expand_leaves(1, |_| true);
        self.attach_expansions(1);
    }

    fn finished(&self) -> bool {
        self.space.tree.values[0].gap() < SOLVED * self.despot.model.spec().r_max || self.allowed() == 0
    }

    fn out_of_time(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
            || matches!(self.budget, Budget::Time(time) if self.start.elapsed() >= time)
    }

    /// Trials that the budget still allows for, at most a batch.
    fn allowed(&self) -> usize {
        let batch = (self.trials / BATCH.0).clamp(BATCH.1.start, BATCH.1.end);
        let allowed = match self.budget {
            _ if self.out_of_time() => 0,
            Budget::Trials(trials) => batch.min(trials - self.trials),
            Budget::Time(_) => batch,
        };
        usize::try_from(allowed).unwrap_or(usize::MAX)
    }

    /// Choose the leaves of the next trials; until they are expanded each counts as settled, so that the others
    /// lie elsewhere.
    fn choose_leaves(&mut self) -> usize {
        let allowed = self.allowed();
        for index in 0..allowed {
            if self.space.tree.values[0].gap() <= 0.0 {
                return index;
            }
            let leaf = self.explore();
            self.space.choose(index, leaf);
        }
        allowed
    }

    /// One trial: follow the most promising action and the most uncertain label down to a leaf.
    fn explore(&self) -> usize {
        let tree = &self.space.tree;
        let mut node = 0;
        while !tree.nodes[node].edges.is_empty() {
            node = self.most_uncertain(indices(&tree.most_promising_edge(node).children));
        }
        node
    }

    /// The child with the largest excess uncertainty: its gap beyond its share of the root's target gap.
    fn most_uncertain(&self, children: std::ops::Range<usize>) -> usize {
        let tree = &self.space.tree;
        let target = TARGET_GAP * tree.values[0].gap();
        let excess = |child: usize| tree.values[child].gap() - tree.nodes[child].probability * target;
        let mut best = (children.start, f64::NEG_INFINITY);
        for child in children {
            let excess = excess(child);
            if excess > best.1 {
                best = (child, excess);
            }
        }
        best.0
    }

    /// Expand the chosen leaves, each on its own; a leaf that there is no more time for stays one.
    fn expand_leaves(&mut self, trials: usize, in_time: impl Fn(&Self) -> bool + Sync) {
        let Despot { model, randoms, .. } = self.despot;
        let shared = self.parallel && trials >= WORTH_SHARING;
        self.space.require_labels(model, randoms, trials, shared);
        let mut expansions = std::mem::take(&mut self.space.expansions);
        let expand = |expansion: &mut Expansion| {
            if in_time(self) {
                expansion.run(self.despot, &self.space);
            }
        };
        if shared {
            expansions[..trials].par_iter_mut().with_min_len(PER_TASK).for_each(expand);
        } else {
            expansions[..trials].iter_mut().for_each(expand);
        }
        self.space.expansions = expansions;
    }

    /// Put what was made into the tree, in the order in which it was chosen; the number of trials done.
    fn attach_expansions(&mut self, trials: usize) -> u64 {
        let model = &self.despot.model;
        let mut done = 0;
        for index in 0..trials {
            if let Some(scenarios) = self.space.attach(index) {
                let viewpoint = self.space.tree.nodes[self.space.expansions[index].leaf].viewpoint;
                self.scenario_steps += scenarios * model.legal_moves(viewpoint).len() as u64;
                done += 1;
            }
        }
        done
    }
}

#[cfg(test)]
mod tests;
