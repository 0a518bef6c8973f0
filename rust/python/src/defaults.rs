//! Default values, as constants for the parts of the package that are written in Python.

use beltsort_core as core;
use pyo3::prelude::*;

use crate::{look_ahead, plan_tree, policies};

/// Add them to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("DEFAULT_BATCHES", core::DEFAULT_BATCHES)?;
    module.add("DEFAULT_BATCH_SIZE", core::DEFAULT_BATCH_SIZE)?;
    module.add("DEFAULT_MAX_LOOKS", core::DEFAULT_MAX_LOOKS)?;
    module.add("MAX_IMPOSSIBLE_LABELS", core::MAX_IMPOSSIBLE_LABELS)?;
    module.add("DEFAULT_SCENARIOS", core::DEFAULT_SCENARIOS)?;
    module.add("DEFAULT_SOLVE_SECONDS", core::DEFAULT_SOLVE_SECONDS)?;
    module.add("DEFAULT_LOOK_AHEAD_DEPTH", look_ahead::DEFAULT_LOOK_AHEAD_DEPTH)?;
    module.add("DEFAULT_INFORMATION_POSITIONS", policies::DEFAULT_INFORMATION_POSITIONS)?;
    module.add("DEFAULT_TREE_DEPTH", plan_tree::DEFAULT_DEPTH)
}
