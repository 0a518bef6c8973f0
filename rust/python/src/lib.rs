//! The Python face of `beltsort-core`.

use pyo3::prelude::*;

pyo3::create_exception!(_core, BeltsortError, pyo3::exceptions::PyException, "Every error that beltsort raises on purpose descends from this one.");

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("BeltsortError", module.py().get_type::<BeltsortError>())
}
