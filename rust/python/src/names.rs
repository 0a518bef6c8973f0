//! Viewpoints, classes and labels as Python gives them, by index or by name: the one place where names become indices.

use beltsort_core::{Class, Label, SortingModel, Viewpoint};
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::convert::{Whole, index};
use crate::errors::to_python;

/// A member of one of the model's sets.
pub enum Named {
    Index(Whole),
    Name(String),
}

impl<'py> FromPyObject<'_, 'py> for Named {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match object.cast::<PyString>() {
            Ok(name) => Ok(Self::Name(name.to_cow()?.into_owned())),
            Err(_) => object.extract().map(Self::Index),
        }
    }
}

impl Named {
    /// The viewpoint; whether the model has one of this index is said by the core.
    pub fn viewpoint(&self, model: &SortingModel) -> PyResult<Viewpoint> {
        match self {
            Self::Index(value) => index("viewpoint", *value).map(Viewpoint),
            Self::Name(name) => model.viewpoint_named(name).map_err(to_python),
        }
    }

    /// The class; whether the model has one of this index is said by the core.
    pub fn class(&self, model: &SortingModel) -> PyResult<Class> {
        match self {
            Self::Index(value) => index("true class", *value).map(Class),
            Self::Name(name) => model.class_named(name).map_err(to_python),
        }
    }

    /// The label; whether the model has one of this index is said by the core.
    pub fn label(&self, model: &SortingModel) -> PyResult<Label> {
        match self {
            Self::Index(value) => index("label", *value).map(Label),
            Self::Name(name) => model.label_named(name).map_err(to_python),
        }
    }

    fn is_name(&self) -> bool {
        matches!(self, Self::Name(_))
    }
}

/// Classes of all objects, a row per batch, if any of them is given by name.
pub fn rows_of_classes(model: &SortingModel, value: &Bound<'_, PyAny>) -> PyResult<Option<Vec<Vec<Class>>>> {
    let Ok(rows) = value.extract::<Vec<Vec<Named>>>() else { return Ok(None) };
    if !rows.iter().flatten().any(Named::is_name) {
        return Ok(None);
    }
    let row = |row: &Vec<Named>| row.iter().map(|class| class.class(model)).collect();
    rows.iter().map(row).collect::<PyResult<_>>().map(Some)
}
