//! The Python face of `beltsort-core`: one file per public type, no logic.

mod actions;
mod belief;
mod convert;
mod errors;
mod evaluation;
mod interrupt;
mod model;
mod planner;
mod policies;

use pyo3::prelude::*;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    errors::register(module)?;
    module.add_class::<actions::Move>()?;
    module.add_class::<actions::Decide>()?;
    module.add_class::<model::PySortingModel>()?;
    module.add_class::<belief::PyBelief>()?;
    module.add_class::<planner::PyDespot>()?;
    module.add_class::<planner::PyPlan>()?;
    module.add_class::<policies::PyThreshold>()?;
    module.add_class::<policies::PyInformationGain>()?;
    module.add_class::<evaluation::PyEvaluation>()?;
    module.add_function(wrap_pyfunction!(evaluation::evaluate, module)?)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("BUILD_PROFILE", if cfg!(debug_assertions) { "debug" } else { "release" })
}
