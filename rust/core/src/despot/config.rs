//! How to search, and for how long.

use std::time::Duration;

use crate::error::{Result, argument_error};
use crate::model::SortingModel;

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
    pub(super) fn check(self) -> Result<()> {
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
        Self { scenarios: 500, seed: 0, regularization: 0.0, depth: None }
    }
}

impl DespotConfig {
    pub(super) fn check(&self, model: &SortingModel) -> Result<()> {
        if !(1..=MOST_SCENARIOS).contains(&self.scenarios) {
            return argument_error(format!(
                "scenarios = {}; give between 1 and {MOST_SCENARIOS}, 500 for example",
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
        let positions = u32::try_from(model.position_count()).unwrap_or(u32::MAX);
        if (model.class_count() as u64).checked_pow(positions).is_none() {
            return argument_error(format!(
                "{} classes at {} positions give more label vectors than 64 bits can number; plan for fewer positions",
                model.class_count(),
                model.position_count()
            ));
        }
        Ok(())
    }

    pub(super) fn depth_for(&self, model: &SortingModel) -> usize {
        let far = (NEGLIGIBLE.ln() / model.discount().ln()).ceil().clamp(1.0, DEEPEST as f64);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped
        self.depth.unwrap_or(far as usize)
    }
}
