//! The planner around a search: settings, budgets, and what was found.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use super::node::ROOT;
use super::tree::Tree;
use super::{Bounds, Search};
use crate::belief::Belief;
use crate::config::{Budget, DespotConfig, NEVER};
use crate::error::{Result, argument_error, model_error};
use crate::index::{Bin, Viewpoint};
use crate::model::{Action, SortingModel};
use crate::plan::Plan;
use crate::policy::Policy;
use crate::sampling::Thresholds;
use crate::scenario::{Randoms, Scenarios};

/// Nodes whose memory is kept for the next plan at most.
const MOST_KEPT: usize = 2_000_000;

/// DESPOT as published, with a model and the settings of the search. A clone shares memory, not plans.
#[derive(Debug, Clone)]
pub struct Despot {
    model: Arc<SortingModel>,
    config: DespotConfig,
    depth: usize,
    discounts: Vec<f64>,
    bounds: Arc<Bounds>,
    thresholds: Arc<Thresholds>,
    pub(super) randoms: Arc<Randoms>,
    /// What no search uses at the moment: its memory is used again.
    spaces: Arc<Mutex<Vec<Workspace>>>,
}

/// What a search grows.
#[derive(Debug, Default)]
struct Workspace {
    despot: Tree,
    branches: Vec<Tree>,
}

impl Despot {
    /// Prepare to plan.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for no scenarios or more than a million, a negative regularisation, depth 0, or
    /// so many label vectors (L^H) that they cannot be numbered;
    /// [`crate::Error::Model`] for a bonus for
    /// information, which is no reward of states.
    pub fn new(model: &SortingModel, config: DespotConfig) -> Result<Self> {
        Self::new_until(model, config, &NEVER)
    }

    /// Prepare to plan until `stop` is set: then with a default policy as good as it was by then.
    ///
    /// # Errors
    /// As [`Despot::new`].
    pub fn new_until(model: &SortingModel, config: DespotConfig, stop: &AtomicBool) -> Result<Self> {
        config.check()?;
        if model.spec().information_gain > 0.0 {
            return model_error(
                "information_gain is set, which averages over scenarios cannot tell; leave it out, or plan with exact beliefs",
            );
        }
        let positions = u32::try_from(model.position_count()).unwrap_or(u32::MAX);
        if (model.label_count() as u64).checked_pow(positions).is_none() {
            return argument_error(format!(
                "{} classes at {} positions give more label vectors than 64 bits can number; plan for fewer positions, or with \
                 exact beliefs",
                model.label_count(),
                model.position_count()
            ));
        }
        let depth = config.depth_for(model);
        let power = |previous: &f64| Some(previous * model.discount());
        Ok(Self {
            bounds: Arc::new(Bounds::new(model, stop)),
            thresholds: Arc::new(Thresholds::new(model)),
            randoms: Arc::new(Randoms::new(config.seed, config.scenarios, model.position_count(), depth)),
            discounts: std::iter::successors(Some(1.0), power).take(depth + 1).collect(),
            model: Arc::new(model.clone()),
            config,
            depth,
            spaces: Arc::default(),
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

    /// Plan the next action on this thread.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if belief or viewpoint do not fit the model, or the budget is zero.
    pub fn plan(&self, belief: &Belief, viewpoint: Viewpoint, budget: Budget) -> Result<Plan> {
        self.plan_until(belief, viewpoint, budget, false, &AtomicBool::new(false))
    }

    /// Plan the next action with all threads of the current rayon pool: the same plan, sooner.
    ///
    /// # Errors
    /// As [`Despot::plan`].
    pub fn plan_in_parallel(&self, belief: &Belief, viewpoint: Viewpoint, budget: Budget) -> Result<Plan> {
        self.plan_until(belief, viewpoint, budget, true, &AtomicBool::new(false))
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
        let start = Instant::now();
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        budget.check()?;
        let (trials, time) = match budget {
            Budget::Trials(trials) => (trials, None),
            Budget::Time(time) => (u64::MAX, Some(time)),
        };
        let out_of_time = || stop.load(Ordering::Relaxed) || time.is_some_and(|time| start.elapsed() >= time);
        let search = self.search(belief, parallel, &out_of_time);
        let space = self.spaces.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut space = space.unwrap_or_default();
        search.begin(&mut space.despot, belief, viewpoint);
        let trials = search.build_despot(&mut space.despot, &mut space.branches, trials);
        let certified_upper = crate::bounds::upper(&self.model, belief.known(), viewpoint);
        let plan = search.plan(&mut space.despot, trials, start, certified_upper);
        if space.despot.size() <= MOST_KEPT {
            self.spaces.lock().unwrap_or_else(PoisonError::into_inner).push(space);
        }
        Ok(plan)
    }

    pub(super) fn search<'a>(
        &'a self,
        belief: &'a Belief,
        parallel: bool,
        out_of_time: &'a (dyn Fn() -> bool + Sync),
    ) -> Search<'a> {
        let randoms = (&*self.model, &*self.randoms);
        Search {
            model: &self.model,
            bounds: &self.bounds,
            thresholds: &self.thresholds,
            scenarios: Scenarios::sampled(randoms, belief, self.depth, parallel),
            remaining: belief.objects_left(),
            lambda: self.config.regularization,
            depth: self.depth,
            discounts: &self.discounts,
            parallel,
            out_of_time,
        }
    }
}

impl Search<'_> {
    fn plan(&self, despot: &mut Tree, trials: u64, start: Instant, certified_upper: f64) -> Plan {
        let mut scratch = std::mem::take(&mut despot.scratch);
        let root = despot[ROOT];
        let (_, default) = self.default_policy(
            (root.count, &despot.place(ROOT)),
            despot.scenarios(ROOT),
            &mut scratch.buffers,
        );
        let shares = &scratch.buffers.shares[..self.model.kind_count()];
        let reward = |bin: Bin| self.model.expected_decision_reward(bin, shares);
        let (mut best, mut values) = ((default, root.default), Vec::new());
        for edge in root.edges().map(|edge| despot[edge]) {
            let value = edge.values.lower;
            if value > best.1 {
                best = (edge.action, value);
            }
            match edge.action {
                Action::Move(_) => values.push((edge.action, value)),
                Action::Decide(best_bin) => values.extend(
                    self.model
                        .bins()
                        .map(|bin| (Action::Decide(bin), value + reward(bin) - reward(best_bin))),
                ),
            }
        }
        let tally = despot.tally;
        despot.scratch = scratch;
        Plan {
            action: best.0,
            values,
            lower: root.values.lower,
            upper: root.values.upper,
            trials,
            elapsed: start.elapsed(),
            scenario_steps: tally.scenario_steps,
            expansions: tally.expansions,
            nodes: despot.size() as u64,
            certified_lower: None,
            certified_upper,
            searched: None,
        }
    }
}

/// The planner with a fixed budget per step.
#[derive(Debug, Clone)]
pub struct BudgetedDespot {
    /// The planner.
    pub despot: Despot,
    /// Its budget per planner step.
    pub budget: Budget,
}

impl Policy for BudgetedDespot {
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        Ok(self.despot.plan(belief, viewpoint, self.budget)?.action)
    }
}
