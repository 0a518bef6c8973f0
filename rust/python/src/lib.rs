//! The Python bindings of `beltsort-core`: one file per public type, no logic.

// Python shows these docs: they are numpydoc, not Markdown.
#![allow(clippy::doc_markdown, clippy::doc_link_with_quotes)]

mod actions;
mod belief;
mod budget;
mod clusters;
mod convert;
mod defaults;
mod despot;
mod display;
mod errors;
mod evaluate;
mod evaluation;
mod interrupt;
mod keywords;
mod look_ahead;
mod lzf;
mod model;
mod moving_actions;
mod moving_belief;
mod moving_belt;
mod moving_evaluation;
mod moving_plan;
mod moving_planner;
mod moving_threshold;
mod names;
mod one_object;
mod plan;
mod plan_tree;
mod policies;
mod solution;
mod user_policy;
mod vfh;

use pyo3::prelude::*;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    errors::register(module)?;
    module.add_class::<actions::Move>()?;
    module.add_class::<actions::Decide>()?;
    module.add_class::<model::PySortingModel>()?;
    module.add_class::<belief::PyBelief>()?;
    module.add_class::<despot::PyDespot>()?;
    module.add_class::<plan::PyPlan>()?;
    module.add_class::<solution::PySolution>()?;
    module.add_function(wrap_pyfunction!(solution::solve, module)?)?;
    module.add_class::<policies::PyThreshold>()?;
    module.add_class::<policies::PyInformationGain>()?;
    module.add_class::<look_ahead::PyLookAhead>()?;
    module.add_class::<one_object::PyOneObject>()?;
    module.add_class::<moving_actions::Wait>()?;
    module.add_class::<moving_actions::DecideAt>()?;
    module.add_class::<moving_belt::PyMovingBelt>()?;
    module.add_class::<moving_belief::PyMovingBelief>()?;
    module.add_class::<moving_threshold::PyMovingThreshold>()?;
    module.add_class::<moving_planner::PyMovingPlanner>()?;
    module.add_class::<moving_plan::PyMovingPlan>()?;
    module.add_class::<moving_evaluation::PyMovingEvaluation>()?;
    module.add_function(wrap_pyfunction!(moving_evaluation::evaluate_moving, module)?)?;
    module.add_class::<evaluation::PyEvaluation>()?;
    module.add_function(wrap_pyfunction!(evaluate::evaluate, module)?)?;
    module.add_function(wrap_pyfunction!(vfh::vfh, module)?)?;
    module.add_function(wrap_pyfunction!(clusters::clusters, module)?)?;
    module.add_function(wrap_pyfunction!(lzf::lzf_decompress, module)?)?;
    defaults::register(module)?;
    module.add("VFH_BINS", beltsort_core::VFH_BINS)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("BUILD_PROFILE", if cfg!(debug_assertions) { "debug" } else { "release" })
}
