//! Batches of the sorting POMDP, many at once.
//!
//! Randoms are indexed by (batch, object, look): every policy meets the same objects, and the n-th look at an object
//! draws on the same random, whatever happened in between.

mod batch;
mod evaluation;

use std::sync::Arc;

use rayon::prelude::*;

use crate::error::{Result, argument_error};
use crate::index::{Class, Viewpoint};
use crate::model::SortingModel;
use crate::offline::Solution;
use crate::policy::Policy;
use batch::Batch;
pub use evaluation::{Evaluation, Statistics};

/// Batches of an evaluation that is given no number of them.
pub const DEFAULT_BATCHES: usize = 1000;
/// Decisions per batch, likewise; ten in the paper.
pub const DEFAULT_BATCH_SIZE: usize = 10;
/// Looks at one object after which it is decided, likewise.
pub const DEFAULT_MAX_LOOKS: usize = 60;
/// Impossible labels of one object in a row after which it is decided.
pub const MAX_IMPOSSIBLE_LABELS: usize = 3;
/// Batches, and objects of a batch, are fewer than this: together they number a stream of randoms.
const LIMIT: usize = 1 << 31;

/// Where the true classes of a batch come from.
#[derive(Debug, Clone, PartialEq)]
pub enum TrueClasses {
    /// The arrival prior of the model that draws labels.
    Arrival,
    /// Uniformly from these classes.
    UniformlyFrom(Vec<Class>),
    /// Given: a row of `batch_size + H - 1` classes per batch.
    Given(Vec<Vec<Class>>),
}

/// What to simulate.
#[derive(Debug, Clone)]
pub struct EvaluationConfig {
    /// Number of batches.
    pub batches: usize,
    /// Decisions per batch.
    pub batch_size: usize,
    /// Seed of classes and labels.
    pub seed: u64,
    /// Whether the belt ends with the batch, and the beliefs that the policy is asked with tell how many objects are left.
    pub belt_ends: bool,
    /// Where the camera stands when a batch starts.
    pub viewpoint: Viewpoint,
    /// The objects.
    pub true_classes: TrueClasses,
    /// An object looked at this often is decided as its most likely class.
    pub max_looks: usize,
    /// What the policy's regret is measured against.
    pub reference: Option<Arc<Solution>>,
}

impl Default for EvaluationConfig {
    fn default() -> Self {
        Self {
            batches: DEFAULT_BATCHES,
            batch_size: DEFAULT_BATCH_SIZE,
            seed: 0,
            belt_ends: false,
            viewpoint: Viewpoint(0),
            true_classes: TrueClasses::Arrival,
            max_looks: DEFAULT_MAX_LOOKS,
            reference: None,
        }
    }
}

/// Simulate a policy: `model` updates the belief and gives the rewards, `truth` draws classes and labels.
///
/// # Errors
/// [`crate::Error::Argument`] for arguments that do not fit; whatever the policy returns, and an error for an illegal action.
pub fn evaluate(
    model: &SortingModel,
    truth: &SortingModel,
    policy: &dyn Policy,
    config: &EvaluationConfig,
) -> Result<Evaluation> {
    check(model, truth, config)?;
    let outcomes: Result<Vec<_>> = (0..config.batches)
        .into_par_iter()
        .map(|batch| Batch::new(model, truth, config, batch).run(policy))
        .collect();
    Ok(Evaluation::of(outcomes?))
}

fn check(model: &SortingModel, truth: &SortingModel, config: &EvaluationConfig) -> Result<()> {
    model.check_viewpoint(config.viewpoint)?;
    for (name, value) in
        [("batches", config.batches), ("batch_size", config.batch_size), ("max_looks", config.max_looks)]
    {
        if value == 0 || value >= LIMIT {
            return argument_error(format!("{name} = {value}; give at least 1, and less than {LIMIT}"));
        }
    }
    if let Some(reference) = &config.reference {
        reference.check_solves(model)?;
        if config.belt_ends {
            return argument_error(
                "a reference values belts that never end, and belt_ends has the policy plan for one that does; \
                 leave one of them out",
            );
        }
    }
    let shape =
        |m: &SortingModel| (m.position_count(), m.viewpoint_count(), m.class_count(), m.label_count());
    if shape(model) != shape(truth) {
        return argument_error(format!(
            "truth has {:?} positions, viewpoints, classes and labels, the model {:?}; they must agree",
            shape(truth),
            shape(model)
        ));
    }
    let objects = config.batch_size + model.position_count() - 1;
    match &config.true_classes {
        TrueClasses::Arrival => Ok(()),
        TrueClasses::UniformlyFrom(classes) if classes.is_empty() => {
            argument_error("true_classes is empty; list at least one label to draw from")
        }
        TrueClasses::UniformlyFrom(classes) => classes.iter().try_for_each(|&class| model.check_class(class)),
        TrueClasses::Given(rows) => {
            if rows.len() != config.batches || rows.iter().any(|row| row.len() != objects) {
                return argument_error(format!(
                    "true_classes must have shape ({}, {objects}): a row per batch, and batch_size + H - 1 objects a row",
                    config.batches
                ));
            }
            rows.iter().flatten().try_for_each(|&class| model.check_class(class))
        }
    }
}

#[cfg(test)]
mod tests;
