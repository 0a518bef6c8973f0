//! Keywords that a signature does not have.
//!
//! A constructor or function takes them as `**unknown` and refuses them here, since `PyO3`'s own error suggests no name.
//! Its `text_signature` leaves `unknown` out.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

const MODULE: &str = "beltsort.util.naming";

/// Raise a `TypeError` with the nearest parameter of `owner`, a name in `beltsort`, if there is an unknown keyword.
pub fn refuse(unknown: Option<&Bound<'_, PyDict>>, owner: &str) -> PyResult<()> {
    let Some(unknown) = unknown else { return Ok(()) };
    let message = unknown.py().import(MODULE)?.call_method1("unknown_keyword", (owner, unknown))?;
    Err(PyTypeError::new_err(message.extract::<String>()?))
}

/// The value of a parameter that has no default. The signature gives it one, so that a misspelt keyword is refused
/// before a missing one.
pub fn required<T>(value: Option<T>, owner: &str, parameter: &str) -> PyResult<T> {
    value.ok_or_else(|| {
        PyTypeError::new_err(format!("{owner} needs the argument {parameter:?}; give it a value"))
    })
}
