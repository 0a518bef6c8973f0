//! How to search, and for how long.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::error::{Result, argument_error};
use crate::model::SortingModel;

/// Scenarios of a planner that is given no number of them.
pub const DEFAULT_SCENARIOS: usize = 500;
/// More scenarios than any belief needs; they must fit into memory.
const MOST_SCENARIOS: usize = 1_000_000;
/// The default depth is where discounting leaves this much of a reward.
const NEGLIGIBLE: f64 = 0.01;
/// The deepest search whose looks can be numbered.
const DEEPEST: usize = 1000;

/// How long to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Budget {
    /// A number of trials: the plan is a pure function of model, belief, viewpoint and seed.
    Trials(u64),
    /// A wall-clock time: the plan depends on the machine.
    Time(Duration),
}

impl Budget {
    pub(crate) fn check(self) -> Result<()> {
        match self {
            Self::Trials(0) | Self::Time(Duration::ZERO) => {
                argument_error("the budget is 0; give at least one trial, or a time above 0 seconds")
            }
            _ => Ok(()),
        }
    }
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
    /// Planner steps to look ahead, at most 1000; `None` for as many as matter under the discount.
    pub depth: Option<usize>,
}

impl Default for DespotConfig {
    fn default() -> Self {
        Self { scenarios: DEFAULT_SCENARIOS, seed: 0, regularization: 0.0, depth: None }
    }
}

impl DespotConfig {
    pub(crate) fn check(&self) -> Result<()> {
        if !(1..=MOST_SCENARIOS).contains(&self.scenarios) {
            return argument_error(format!(
                "scenarios = {}; give between 1 and {MOST_SCENARIOS}, {DEFAULT_SCENARIOS} for example",
                self.scenarios
            ));
        }
        if !(self.regularization.is_finite() && self.regularization >= 0.0) {
            return argument_error(format!(
                "regularization = {}; it is a cost per policy node, finite and not negative",
                self.regularization
            ));
        }
        if let Some(depth) = self.depth
            && !(1..=DEEPEST).contains(&depth)
        {
            return argument_error(format!(
                "depth = {depth}; look at least 1 and at most {DEEPEST} steps ahead, or leave depth out"
            ));
        }
        Ok(())
    }

    pub(crate) fn depth_for(&self, model: &SortingModel) -> usize {
        let far = (NEGLIGIBLE.ln() / model.discount().ln()).ceil().clamp(1.0, DEEPEST as f64);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped
        self.depth.unwrap_or(far as usize)
    }
}

/// For work that nobody stops.
pub(crate) static NEVER: AtomicBool = AtomicBool::new(false);

/// The time and the trials that a search has.
pub(crate) struct Clock<'a> {
    budget: Budget,
    stop: &'a AtomicBool,
    start: Instant,
    trials: u64,
    /// When the last trial ended, and the longest one.
    last: Instant,
    longest: Duration,
}

impl<'a> Clock<'a> {
    /// A clock that starts now.
    pub(crate) fn started(budget: Budget, stop: &'a AtomicBool) -> Self {
        let now = Instant::now();
        Self { budget, stop, start: now, trials: 0, last: now, longest: Duration::ZERO }
    }

    /// A trial has been done.
    pub(crate) fn count(&mut self) {
        self.trials += 1;
        let now = Instant::now();
        self.longest = self.longest.max(now - self.last);
        self.last = now;
    }

    /// Whether one more trial may be begun: under a budget of time one that takes as long as the longest so far.
    pub(crate) fn allows_another(&self) -> bool {
        !self.stop.load(Ordering::Relaxed)
            && match self.budget {
                Budget::Trials(trials) => self.trials < trials,
                Budget::Time(time) => self.start.elapsed() + self.longest < time,
            }
    }

    /// Trials done.
    pub(crate) fn trials(&self) -> u64 {
        self.trials
    }

    /// Time since the start.
    pub(crate) fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }
}
