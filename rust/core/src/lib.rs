//! Planning and belief arithmetic of beltsort: sorting objects from a conveyor belt by active perception.
//!
//! Follows "Sorting objects from a conveyor belt using active perception with a POMDP model" (Mezei, Tamás,
//! Buşoniu, ECC 2019); equation numbers in these docs are that paper's.
//!
//! # What each choice of the search is worth
//!
//! Mean loss of value per planner step (the best value of an action less that of the one taken, both one step ahead of
//! a certified upper bound), on the paper's instance with H = 2 and `r_min` = 50: batches of ten objects, simulation
//! seed 5. The sum of discounted losses is at most 20 times as large. The first four rows are measured against a grid
//! of 22 intervals (300 batches, the two steps 100), DESPOT against `solve` (150 batches, 512 scenarios, batches of 32
//! leaves); each choice was changed in the source.
//!
//! | planner | loss per step |
//! |---|---|
//! | one-object policy, chosen anew at each step | 0.0093 ± 0.0004 |
//! | one step ahead of its value | 0.0043 ± 0.0003 |
//! | two steps ahead, every label vector | 0.0007 ± 0.0001 |
//! | one step ahead of a coarse grid bound (12 intervals) | 0.0018 ± 0.0001 |
//! | DESPOT, estimates with a constant shortfall: 1, 10, 50, 1000 trials | 0.0042, 0.0026, 0.0012, 0.0005 (± 0.0001 to 0.0004) |
//! | the same, one-object plans thinned to 72 of 287 (as now): 50, 200 trials | 0.0012, 0.0012 (± 0.0001) |
//!
//! With more positions the estimate decides. Discounted return of a batch of ten, a random model with H = 4, L = 4,
//! K = 3 (diagonals about 0.6), 400 batches, simulation seed 7, batches of 32 leaves; standard error 0.3, of differences between planners 0.25:
//!
//! | estimate at a leaf | 20 trials | 100 trials | 400 trials |
//! |---|---|---|---|
//! | default value plus a constant | 32.77 | 32.30 | 32.22 |
//! | linear in the default value, fitted to the greedy policy's own visits | 32.68 | 32.49 | 31.78 |
//! | linear, fitted at beliefs such as searches meet (as now) | 32.76 | 32.86 | 32.94 |
//!
//! In a large tree it matters which upper bound cuts the estimates. The same on another such model, simulation seed 8,
//! 400, 200 and 100 batches; standard error 0.3, 0.4 and 0.55, of the last row's difference to the one above 0.36:
//!
//! | estimates are cut by an upper bound | 150 trials | 1500 trials | 15,000 trials |
//! |---|---|---|---|
//! | of the sampled problem | 32.83 | 33.31 | 30.74 |
//! | of V* (as now) | 32.83 | 33.30 | 33.44 |
//! | the action is chosen by the lower bound | | 32.21 | 32.64 |
//!
//! Objects that differ only in the order of their labels are one object, and decisions are valued by plans weighed
//! before: the same plans with 1.02 to 1.05 (`r_min` = 5), 1.08 to 1.2 (50) and 1.2 to 1.3 (500) times as many
//! expansions per second (the paper's instance, 512 scenarios, 100 to 1000 trials, one core).

mod belief;
mod bounds;
mod cloud;
mod despot;
mod error;
mod index;
mod model;
mod offline;
mod one_object;
mod planes;
mod policy;
mod remaining;
mod sampling;
mod scenario;
mod simulate;
#[cfg(test)]
mod testing;
mod tree;

pub use belief::Belief;
pub use cloud::{Distances, VFH_BINS, VfhOptions, clusters, lzf_decompress, vfh};
pub use despot::{Budget, BudgetedDespot, Despot, DespotConfig, Plan, TreeAction, TreeBranch, TreeNode};
pub use error::{Error, Result};
pub use index::{Class, Label, Position, Viewpoint};
pub use model::{Action, Look, ModelSpec, ScalarOrMatrix, SortingModel, Tables};
pub use offline::Solution;
pub use one_object::OneObjectPolicy;
pub use policy::{InformationGain, OneObject, Policy, Threshold};
pub use simulate::{Evaluation, EvaluationConfig, Statistics, TrueClasses, evaluate};
