//! Planning and belief arithmetic of beltsort: sorting objects from a conveyor belt by active perception.
//!
//! Follows "Sorting objects from a conveyor belt using active perception with a POMDP model" (Mezei, Tamás,
//! Buşoniu, ECC 2019); equation numbers in these docs are that paper's.

mod belief;
mod bounds;
mod despot;
mod error;
mod model;
mod one_object;
mod planes;
mod policy;
mod reference;
mod sampling;
mod scenario;
mod simulate;
#[cfg(test)]
mod testing;
mod tree;

pub use belief::Belief;
pub use despot::{Budget, Despot, DespotConfig, Plan, TreeAction, TreeBranch, TreeNode};
pub use error::{Error, Result};
pub use model::{Action, ModelSpec, ScalarOrMatrix, SortingModel, Tables};
pub use one_object::OneObjectPolicy;
pub use policy::{BudgetedDespot, InformationGain, OneObject, Policy, Threshold};
pub use reference::Solution;
pub use simulate::{Evaluation, EvaluationConfig, Statistics, TrueClasses, evaluate};
