//! Policies that are Python objects.

use std::sync::{Arc, Mutex};

use beltsort_core::{
    Action, Belief, Error, MovingAction, MovingBelief, MovingBelt, MovingPolicy, Policy, Result,
    SortingModel, Viewpoint,
};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::belief::PyBelief;
use crate::errors::PolicyError;
use crate::moving_belief::PyMovingBelief;
use crate::{actions, moving_actions};

/// Any Python object with a method `act(belief, viewpoint)`, asked with beliefs about a problem: a model, or a moving belt.
pub struct UserPolicy<P> {
    object: Py<PyAny>,
    problem: Arc<P>,
    /// The exception that the object raised, for the caller to see.
    failure: Mutex<Option<PyErr>>,
}

impl<P> UserPolicy<P> {
    /// `expected` names the policies of beltsort, and what `act` returns.
    pub fn new(object: &Bound<'_, PyAny>, problem: &Arc<P>, expected: &str) -> PyResult<Self> {
        if let Ok(class) = object.cast::<PyType>() {
            let name = class.name()?;
            return Err(PolicyError::new_err(format!(
                "policy is the class {name}, expected an object of it: give {name}(model), or what its constructor takes"
            )));
        }
        if !object.hasattr("act")? {
            return Err(PolicyError::new_err(format!(
                "policy = {} has no method act; give {expected}",
                object.repr()?
            )));
        }
        Ok(Self { object: object.clone().unbind(), problem: Arc::clone(problem), failure: Mutex::new(None) })
    }

    /// The exception that ended the evaluation, if the object raised one.
    pub fn raised(self) -> Option<PyErr> {
        self.failure.into_inner().ok().flatten()
    }

    fn ask<'py, A>(
        &self,
        py: Python<'py>,
        belief: impl IntoPyObjectExt<'py>,
        viewpoint: Viewpoint,
        action: fn(&Bound<'_, PyAny>) -> PyResult<A>,
    ) -> Result<A> {
        let asked = belief
            .into_bound_py_any(py)
            .and_then(|belief| action(&self.object.bind(py).call_method1("act", (belief, viewpoint.0))?));
        asked.map_err(|raised: PyErr| {
            let message = raised.to_string();
            if let Ok(mut failure) = self.failure.lock() {
                *failure = Some(raised);
            }
            Error::Policy(message)
        })
    }
}

impl Policy for UserPolicy<SortingModel> {
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        Python::attach(|py| {
            let belief = PyBelief { belief: belief.clone(), model: Arc::clone(&self.problem) };
            self.ask(py, belief, viewpoint, actions::from_python)
        })
    }
}

impl MovingPolicy for UserPolicy<MovingBelt> {
    fn act(&self, belief: &MovingBelief, viewpoint: Viewpoint) -> Result<MovingAction> {
        Python::attach(|py| {
            let belief = PyMovingBelief { belief: belief.clone(), belt: Arc::clone(&self.problem) };
            self.ask(py, belief, viewpoint, moving_actions::from_python)
        })
    }
}
