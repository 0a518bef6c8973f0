//! The one place where errors of the core become Python exceptions.

use beltsort_core::Error;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

pyo3::create_exception!(
    beltsort,
    BeltsortError,
    PyException,
    "Every error that beltsort raises on purpose descends from this one."
);
pyo3::create_exception!(beltsort, ModelError, BeltsortError, "A model that is not a sorting POMDP.");
pyo3::create_exception!(
    beltsort,
    ArgumentError,
    BeltsortError,
    "An argument that does not fit the model or has no meaning."
);
pyo3::create_exception!(
    beltsort,
    ImpossibleObservationError,
    BeltsortError,
    "A label that has probability zero under the belief, which is left unchanged."
);
pyo3::create_exception!(beltsort, PolicyError, BeltsortError, "A policy that named no legal action.");

/// The exception for an error of the core.
pub fn to_python(error: Error) -> PyErr {
    let message = error.to_string();
    match error {
        Error::Model(_) => ModelError::new_err(message),
        Error::Argument(_) => ArgumentError::new_err(message),
        Error::ImpossibleObservation { .. } => ImpossibleObservationError::new_err(message),
        Error::Policy(_) => PolicyError::new_err(message),
    }
}

/// Add the exceptions to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("BeltsortError", py.get_type::<BeltsortError>())?;
    module.add("ModelError", py.get_type::<ModelError>())?;
    module.add("ArgumentError", py.get_type::<ArgumentError>())?;
    module.add("ImpossibleObservationError", py.get_type::<ImpossibleObservationError>())?;
    module.add("PolicyError", py.get_type::<PolicyError>())
}
