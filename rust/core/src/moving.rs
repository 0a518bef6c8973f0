//! A belt that never stops.

mod planning;

pub use planning::{
    DEFAULT_MOVING_DEPTH, DEFAULT_MOVING_SCENARIOS, DEFAULT_OPTIMISM, MovingAction, MovingConfig, MovingPlan,
    MovingSearch, MovingSituation, MovingTimes,
};
