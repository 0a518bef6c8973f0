//! A belt that moves while the camera looks: its model and belief, policies, simulation, and planning.

mod action;
mod belief;
mod belt;
mod file;
mod planning;
mod policy;
mod simulate;
mod spec;
mod state;
mod timing;

pub use action::MovingAction;
pub use belief::MovingBelief;
pub use belt::MovingBelt;
pub use planning::{
    BudgetedMovingSearch, DEFAULT_MOVING_DEPTH, DEFAULT_MOVING_SCENARIOS, DEFAULT_OPTIMISM, MovingConfig,
    MovingPlan, MovingSearch,
};
pub use policy::{LookRule, MovingPolicy, MovingThreshold};
pub use simulate::{DEFAULT_MOVING_OBJECTS, DEFAULT_RUNS, MovingOutcome, MovingRuns, evaluate_moving};
pub use spec::{Drive, MovingSpec};

#[cfg(test)]
mod tests;
