//! Text and HTML of objects, for the REPL and for notebooks.
//!
//! Both are made by `beltsort.planning.display`, in Python: there is nothing to gain from compiled code, names have to be
//! escaped, and comparisons, which are Python objects, are shown in the same way.

use pyo3::prelude::*;

const MODULE: &str = "beltsort.planning.display";

/// What `repr` returns.
pub fn text(object: &Bound<'_, PyAny>) -> PyResult<String> {
    object.py().import(MODULE)?.call_method1("text", (object,))?.extract()
}

/// What a notebook shows.
pub fn html(object: &Bound<'_, PyAny>) -> PyResult<String> {
    object.py().import(MODULE)?.call_method1("html", (object,))?.extract()
}

/// `repr` and `_repr_html_`.
macro_rules! displayed {
    ($($class:ty),+) => {$(
        #[pyo3::pymethods]
        impl $class {
            fn __repr__(slf: &pyo3::Bound<'_, Self>) -> pyo3::PyResult<String> {
                $crate::display::text(slf.as_any())
            }

            /// Return HTML for notebooks.
            fn _repr_html_(slf: &pyo3::Bound<'_, Self>) -> pyo3::PyResult<String> {
                $crate::display::html(slf.as_any())
            }
        }
    )+};
}

/// A copy of what does not change is the object itself.
macro_rules! immutable {
    ($($class:ty),+) => {$(
        #[pyo3::pymethods]
        impl $class {
            fn __copy__(slf: pyo3::Py<Self>) -> pyo3::Py<Self> {
                slf
            }

            fn __deepcopy__(slf: pyo3::Py<Self>, _memo: &pyo3::Bound<'_, pyo3::PyAny>) -> pyo3::Py<Self> {
                slf
            }
        }
    )+};
}

pub(crate) use {displayed, immutable};
