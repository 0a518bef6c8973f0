//! Planning for a belt that moves at a constant speed.
//!
//! One object with a deadline ([`deadline`]) is the building block: its values under shares of the looks' costs bound the
//! value of the whole belt from above ([`priced`]), and its plans ([`plans`]), executed for one object after the other, are the
//! default policy ([`serving`]). The search ([`search`]) has both at its leaves.

mod deadline;
mod expand;
mod planner;
mod plans;
mod priced;
mod search;
mod serving;

pub use planner::{BudgetedMovingSearch, MovingSearch};
pub use search::{
    DEFAULT_MOVING_DEPTH, DEFAULT_MOVING_SCENARIOS, DEFAULT_OPTIMISM, MovingConfig, MovingPlan,
};

#[cfg(test)]
mod tests;
