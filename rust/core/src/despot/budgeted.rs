//! The planner as a policy.

use super::{Budget, Despot};
use crate::belief::Belief;
use crate::error::Result;
use crate::index::Viewpoint;
use crate::model::Action;
use crate::policy::Policy;

/// A DESPOT planner with a fixed budget per step.
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
