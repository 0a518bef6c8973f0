//! Planning and belief arithmetic of beltsort: sorting objects from a conveyor belt by active perception.
//!
//! Follows "Sorting objects from a conveyor belt using active perception with a POMDP model" (Mezei, Tamás,
//! Buşoniu, ECC 2019); equation numbers in these docs are that paper's.

mod belief;
mod bounds;
mod cloud;
mod config;
mod despot;
mod error;
mod index;
mod model;
mod moving;
mod names;
mod offline;
mod one_object;
mod plan;
mod planes;
mod policy;
mod remaining;
mod sampling;
mod scenario;
mod search;
mod simulate;
#[cfg(test)]
mod testing;

pub use belief::Belief;
pub use cloud::{Distances, VFH_BINS, VfhOptions, clusters, lzf_decompress, vfh};
pub use config::{Budget, DEFAULT_SCENARIOS, DespotConfig};
pub use despot::{BudgetedDespot, Despot};
pub use error::{Error, Result};
pub use index::{Bin, Class, Kind, Label, Position, Viewpoint};
pub use model::{
    Action, DEFAULT_DISCOUNT, DEFAULT_R_MAX, DEFAULT_R_MIN, Look, ModelSpec, ScalarOrMatrix, Smoothing,
    SortingModel, Tables,
};
pub use moving::{
    BudgetedMovingSearch, DEFAULT_MOVING_DEPTH, DEFAULT_MOVING_OBJECTS, DEFAULT_MOVING_SCENARIOS,
    DEFAULT_OPTIMISM, DEFAULT_RUNS, Drive, LookRule, MovingAction, MovingBelief, MovingBelt, MovingConfig,
    MovingOutcome, MovingPlan, MovingPolicy, MovingRuns, MovingSearch, MovingSpec, MovingThreshold,
    evaluate_moving,
};
pub use offline::{DEFAULT_SOLVE_SECONDS, Solution};
pub use one_object::OneObjectPolicy;
pub use plan::Plan;
pub use policy::{InformationGain, OneObject, Policy, Question, Threshold};
pub use search::{BeliefSearch, BudgetedSearch, LookAhead, TreeAction, TreeBranch, TreeNode};
pub use simulate::{
    DEFAULT_BATCH_SIZE, DEFAULT_BATCHES, DEFAULT_MAX_LOOKS, Evaluation, EvaluationConfig,
    MAX_IMPOSSIBLE_LABELS, Statistics, TrueClasses, evaluate,
};
