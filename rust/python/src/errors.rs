//! The one place where errors of the core become Python exceptions.

use beltsort_core::Error;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{IntoPyDict, PyType};

pyo3::create_exception!(
    beltsort,
    BeltsortError,
    PyException,
    "Every error that beltsort raises on purpose descends from this one."
);
pyo3::create_exception!(
    beltsort,
    ImpossibleObservationError,
    BeltsortError,
    "A label that has probability zero under the belief, which is left unchanged."
);
pyo3::create_exception!(beltsort, PolicyError, BeltsortError, "A policy that named no legal action.");

/// An exception that is a `BeltsortError` and a `ValueError`: the macro takes one base only.
macro_rules! value_error {
    ($name:ident, $doc:literal) => {
        pub struct $name;

        impl $name {
            fn type_object(py: Python<'_>) -> PyResult<&Bound<'_, PyType>> {
                static TYPE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
                let made = TYPE.get_or_try_init(py, || {
                    let bases = (py.get_type::<BeltsortError>(), py.get_type::<PyValueError>());
                    let body = [("__doc__", $doc), ("__module__", "beltsort")].into_py_dict(py)?;
                    let made = py.get_type::<PyType>().call1((stringify!($name), bases, body))?;
                    PyResult::Ok(made.cast_into::<PyType>()?.unbind())
                })?;
                Ok(made.bind(py))
            }

            pub fn new_err(message: impl Into<String>) -> PyErr {
                let message = message.into();
                Python::attach(|py| match Self::type_object(py) {
                    Ok(made) => PyErr::from_type(made.clone(), (message,)),
                    Err(error) => error,
                })
            }
        }
    };
}

value_error!(ModelError, "A model that is not a sorting POMDP.");
value_error!(ArgumentError, "An argument that does not fit the model or has no meaning.");

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
    module.add("ModelError", ModelError::type_object(py)?)?;
    module.add("ArgumentError", ArgumentError::type_object(py)?)?;
    module.add("ImpossibleObservationError", py.get_type::<ImpossibleObservationError>())?;
    module.add("PolicyError", py.get_type::<PolicyError>())
}
