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

mod expand;
mod plan;

use std::time::{Duration, Instant};

use crate::belief::Belief;
use crate::bounds;
use crate::error::{Result, argument_error};
use crate::model::SortingModel;
use crate::one_object::OneObjectPolicy;
use crate::scenario::Scenarios;
use crate::tree::{Node, Tree};

pub use plan::Plan;

/// `xi` of the DESPOT paper: the part of the root's gap that one trial tries to leave.
const TARGET_GAP: f64 = 0.95;
/// A root gap, as a part of `r_max`, below which the sampled problem counts as solved.
const SOLVED: f64 = 1e-10;
/// More scenarios than any belief needs; they must fit into memory.
const MOST_SCENARIOS: usize = 1_000_000;
/// The default depth is where discounting leaves this much of a reward.
const NEGLIGIBLE: f64 = 0.01;

/// How long to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Budget {
    /// A number of trials: the plan is a pure function of model, belief, viewpoint and seed.
    Trials(u64),
    /// A wall-clock time: the plan depends on the machine.
    Time(Duration),
}

/// Settings of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DespotConfig {
    /// Number of scenarios.
    pub scenarios: usize,
    /// Seed of the scenarios.
    pub seed: u64,
    /// `lambda` of the DESPOT paper: cost of a policy node, in units of reward.
    pub regularization: f64,
    /// Planner steps to look ahead; `None` for as many as matter under the discount.
    pub depth: Option<usize>,
}

impl Default for DespotConfig {
    fn default() -> Self {
        Self { scenarios: 500, seed: 0, regularization: 0.0, depth: None }
    }
}

/// The planner: a model, its default policy and the settings of the search.
#[derive(Debug, Clone)]
pub struct Despot {
    model: SortingModel,
    default_policy: OneObjectPolicy,
    config: DespotConfig,
    depth: usize,
}

impl Despot {
    /// Prepare to plan: solves the one-object problem.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for no scenarios or more than a million, a negative or infinite regularisation,
    /// depth 0, or so many label vectors (L^H) that they cannot be numbered; [`crate::Error::Model`] for a model beyond
    /// the paper's.
    pub fn new(model: &SortingModel, config: DespotConfig) -> Result<Self> {
        model.check_plain()?;
        if !(1..=MOST_SCENARIOS).contains(&config.scenarios) {
            return argument_error(format!(
                "scenarios = {}; give between 1 and {MOST_SCENARIOS}, 500 for example",
                config.scenarios
            ));
        }
        if !(config.regularization.is_finite() && config.regularization >= 0.0) {
            return argument_error(format!(
                "regularization = {}; it is a cost per policy node, finite and not negative",
                config.regularization
            ));
        }
        if config.depth == Some(0) {
            return argument_error("depth = 0; look at least 1 step ahead, or leave depth out");
        }
        if label_vectors(model).is_none() {
            return argument_error(format!(
                "{} classes at {} positions give more label vectors than 64 bits can number; plan for fewer positions",
                model.class_count(),
                model.position_count()
            ));
        }
        let far = (NEGLIGIBLE.ln() / model.discount().ln()).ceil().clamp(1.0, 1000.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped to 1..=1000
        let depth = config.depth.unwrap_or(far as usize);
        Ok(Self { model: model.clone(), default_policy: OneObjectPolicy::solve(model), config, depth })
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

    /// Plan the next action.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if belief or viewpoint do not fit the model, or the budget is zero.
    pub fn plan(&self, belief: &Belief, viewpoint: usize, budget: Budget) -> Result<Plan> {
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        if matches!(budget, Budget::Trials(0) | Budget::Time(Duration::ZERO)) {
            return argument_error("the budget is 0; give at least one trial, or a time above 0 seconds");
        }
        let mut search = Search::new(self, belief, viewpoint);
        search.expand(0);
        while !search.finished(budget) {
            let path = search.explore();
            search.tree.back_up(&path);
            search.trials += 1;
        }
        Ok(search.into_plan())
    }
}

/// L^H, the number of outcomes of a scan, if it can be counted.
fn label_vectors(model: &SortingModel) -> Option<u64> {
    (model.class_count() as u64).checked_pow(u32::try_from(model.position_count()).ok()?)
}

/// One search in progress.
struct Search<'a> {
    despot: &'a Despot,
    scenarios: Scenarios,
    tree: Tree,
    start: Instant,
    trials: u64,
    expansions: u64,
    scenario_steps: u64,
}

impl<'a> Search<'a> {
    fn new(despot: &'a Despot, belief: &Belief, viewpoint: usize) -> Self {
        let start = Instant::now();
        let DespotConfig { scenarios, seed, .. } = despot.config;
        let mut search = Self {
            despot,
            scenarios: Scenarios::sample(belief, scenarios, seed),
            tree: Tree::default(),
            start,
            trials: 0,
            expansions: 0,
            scenario_steps: 0,
        };
        #[allow(clippy::cast_possible_truncation)] // checked in Despot::new
        let all = (0..scenarios as u32).collect();
        let place = NodePlace { depth: 0, decisions: 0, viewpoint, probability: 1.0 };
        let value = bounds::lower(&despot.model, &despot.default_policy, belief.as_slice(), viewpoint);
        let root = search.node(place, belief.as_slice().to_vec(), all, value);
        search.tree.nodes.push(root);
        search
    }

    fn finished(&self, budget: Budget) -> bool {
        self.tree.nodes[0].gap() < SOLVED * self.despot.model.spec().r_max
            || match budget {
                Budget::Trials(trials) => self.trials >= trials,
                Budget::Time(time) => self.start.elapsed() >= time,
            }
    }

    /// One trial: follow the most promising action and the most uncertain label until nothing is left to gain.
    fn explore(&mut self) -> Vec<(usize, usize)> {
        let mut path = Vec::new();
        let mut node = 0;
        loop {
            if self.tree.nodes[node].is_leaf() {
                self.expand(node);
            }
            let edge = self.tree.most_promising_edge(node);
            path.push((node, edge));
            match self.most_uncertain_child(edge) {
                Some(child) => node = child,
                None => return path,
            }
        }
    }

    /// The child with the largest excess uncertainty, if any is above 0 and may be looked into.
    fn most_uncertain_child(&self, edge: usize) -> Option<usize> {
        let root_gap = self.tree.nodes[0].gap();
        let excess = |node: &Node| node.gap() - node.probability * TARGET_GAP * root_gap;
        self.tree.edges[edge]
            .children
            .clone()
            .map(|child| (child, excess(&self.tree.nodes[child])))
            .filter(|(child, excess)| *excess > 0.0 && self.tree.nodes[*child].depth < self.despot.depth)
            .fold(None, |best: Option<(usize, f64)>, next| match best {
                Some(best) if best.1 >= next.1 => Some(best),
                _ => Some(next),
            })
            .map(|(child, _)| child)
    }

    /// A leaf with its initial bounds: the default policy, or at best the upper bound after one policy node.
    fn node(&self, place: NodePlace, belief: Vec<f64>, scenarios: Vec<u32>, default_value: f64) -> Node {
        let Despot { model, config, depth: limit, .. } = self.despot;
        let scale = place.scale(model);
        let default = scale * default_value;
        let upper = if place.depth < *limit {
            default.max(scale * bounds::upper(model, &belief, place.viewpoint) - config.regularization)
        } else {
            default
        };
        let NodePlace { depth, decisions, viewpoint, probability } = place;
        Node {
            depth,
            decisions,
            viewpoint,
            belief,
            scenarios,
            probability,
            default,
            lower: default,
            upper,
            edges: 0..0,
        }
    }
}

/// Where a node stands in the tree.
#[derive(Clone, Copy)]
struct NodePlace {
    depth: usize,
    decisions: usize,
    viewpoint: usize,
    probability: f64,
}

impl NodePlace {
    /// The factor between a node's own values and the scaled ones of the tree.
    fn scale(&self, model: &SortingModel) -> f64 {
        // Depths are at most a few thousand.
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
        let discount = model.discount().powi(self.depth as i32);
        self.probability * discount
    }
}

#[cfg(test)]
mod tests;
