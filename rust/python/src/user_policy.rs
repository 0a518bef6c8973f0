//! Policies that are Python objects.

use std::sync::{Arc, Mutex};

use beltsort_core::{Action, Belief, Error, Policy, Result, SortingModel, Viewpoint};
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::actions;
use crate::belief::PyBelief;
use crate::errors::PolicyError;
use crate::model::PySortingModel;

/// Any Python object with a method `act(belief, viewpoint)`.
pub struct UserPolicy {
    object: Py<PyAny>,
    model: Arc<SortingModel>,
    /// The exception that the object raised, for the caller to see.
    failure: Mutex<Option<PyErr>>,
}

impl UserPolicy {
    pub fn new(object: &Bound<'_, PyAny>, model: &PySortingModel) -> PyResult<Self> {
        if let Ok(class) = object.cast::<PyType>() {
            let name = class.name()?;
            return Err(PolicyError::new_err(format!(
                "policy is the class {name}, expected an object of it: give {name}(model), or what its constructor takes"
            )));
        }
        if !object.hasattr("act")? {
            return Err(PolicyError::new_err(format!(
                "policy = {} has no method act; give Despot, LookAhead, Threshold, InformationGain, OneObject, or an object whose \
                 act(belief, viewpoint) returns beltsort.Move or beltsort.Decide",
                object.repr()?
            )));
        }
        Ok(Self { object: object.clone().unbind(), model: Arc::clone(&model.0), failure: Mutex::new(None) })
    }

    /// The exception that ended the evaluation, if the object raised one.
    pub fn raised(self) -> Option<PyErr> {
        self.failure.into_inner().ok().flatten()
    }
}

impl Policy for UserPolicy {
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        Python::attach(|py| {
            let belief = PyBelief { belief: belief.clone(), model: Arc::clone(&self.model) };
            let action = self.object.bind(py).call_method1("act", (belief, viewpoint.0))?;
            actions::from_python(&action)
        })
        .map_err(|raised: PyErr| {
            let message = raised.to_string();
            if let Ok(mut failure) = self.failure.lock() {
                *failure = Some(raised);
            }
            Error::Policy(message)
        })
    }
}
