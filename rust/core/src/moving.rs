//! A belt that never stops: its model and belief, policies, simulation, and planning.

mod belief;
mod belt;
mod planning;
mod policy;
mod simulate;

pub use belief::MovingBelief;
pub use belt::MovingBelt;
pub use planning::{
    DEFAULT_MOVING_DEPTH, DEFAULT_MOVING_SCENARIOS, DEFAULT_OPTIMISM, MovingAction, MovingConfig, MovingPlan,
    MovingSearch, MovingSituation, MovingTimes,
};
pub use policy::{LookRule, MovingPolicy, MovingThreshold};
pub use simulate::{MovingOutcome, MovingRuns, evaluate_moving};

#[cfg(test)]
mod tests;
