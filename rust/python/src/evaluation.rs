//! `evaluate` and its result.

use std::sync::{Arc, Mutex};

use beltsort_core as core;
use beltsort_core::{Action, Belief, Error, EvaluationConfig, Policy, SortingModel, TrueClasses};
use numpy::{AllowTypeChange, IntoPyArray, PyArray1, PyArrayLike2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::actions;
use crate::belief::PyBelief;
use crate::convert::index;
use crate::errors::{ArgumentError, to_python};
use crate::model::PySortingModel;
use crate::planner::{PyDespot, thread_pool};
use crate::policies::{PyInformationGain, PyThreshold};

/// Outcomes of simulated batches, one entry per batch.
#[pyclass(frozen, name = "Evaluation", module = "beltsort")]
pub struct PyEvaluation {
    evaluation: core::Evaluation,
    drawn_from_model: bool,
}

#[pymethods]
impl PyEvaluation {
    #[getter]
    fn steps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.evaluation.steps.clone().into_pyarray(py)
    }

    #[getter]
    fn correct<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.evaluation.correct.clone().into_pyarray(py)
    }

    #[getter]
    fn forced<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.evaluation.forced.clone().into_pyarray(py)
    }

    #[getter]
    fn returns<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.evaluation.returns.clone().into_pyarray(py)
    }

    #[getter]
    fn discounted_returns<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.evaluation.discounted_returns.clone().into_pyarray(py)
    }

    #[getter]
    fn expected_discounted_returns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        if !self.drawn_from_model {
            return Err(ArgumentError::new_err(
                "expected_discounted_returns is biased when true_classes or another truth is given: the belief is \
                 then not the probability of being right. Use discounted_returns",
            ));
        }
        Ok(self.evaluation.expected_discounted_returns.clone().into_pyarray(py))
    }

    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let summary = PyDict::new(py);
        for (name, statistics) in self.evaluation.summary(self.drawn_from_model) {
            let entry = PyDict::new(py);
            entry.set_item("mean", statistics.mean)?;
            entry.set_item("standard_error", statistics.standard_error)?;
            summary.set_item(name, entry)?;
        }
        Ok(summary)
    }
}

/// Simulate batches of the sorting POMDP.
#[pyfunction]
#[pyo3(signature = (model, policy, *, batches=1000, batch_size=10, seed=0, threads=None, viewpoint=0,
                    true_classes=None, truth=None, max_looks=60))]
#[allow(clippy::too_many_arguments)] // the public contract
pub fn evaluate(
    py: Python<'_>,
    model: &PySortingModel,
    policy: &Bound<'_, PyAny>,
    batches: i64,
    batch_size: i64,
    seed: u64,
    threads: Option<i64>,
    viewpoint: i64,
    true_classes: Option<&Bound<'_, PyAny>>,
    truth: Option<&PySortingModel>,
    max_looks: i64,
) -> PyResult<PyEvaluation> {
    let config = EvaluationConfig {
        batches: index("batches", batches)?,
        batch_size: index("batch_size", batch_size)?,
        seed,
        viewpoint: index("viewpoint", viewpoint)?,
        true_classes: true_classes.map_or(Ok(TrueClasses::Arrival), classes)?,
        max_looks: index("max_looks", max_looks)?,
    };
    let truth = truth.unwrap_or(model);
    let drawn_from_model = truth.0 == model.0 && config.true_classes == TrueClasses::Arrival;
    let failure = Mutex::new(None);
    let run = |policy: &dyn Policy, threads: Option<i64>| -> PyResult<core::Result<core::Evaluation>> {
        let pool = threads.map(thread_pool).transpose()?;
        Ok(py.detach(|| {
            let evaluate = || core::evaluate(&model.0, &truth.0, policy, &config);
            pool.as_ref().map_or_else(evaluate, |pool| pool.install(evaluate))
        }))
    };
    let evaluation = if let Ok(despot) = policy.cast::<PyDespot>() {
        run(&despot.get().planner, threads)?
    } else if let Ok(threshold) = policy.cast::<PyThreshold>() {
        run(&threshold.get().policy, threads)?
    } else if let Ok(gain) = policy.cast::<PyInformationGain>() {
        run(&gain.get().policy, threads)?
    } else {
        let own =
            UserPolicy { object: policy.clone().unbind(), model: Arc::clone(&model.0), failure: &failure };
        // A user's policy may keep state: its batches run one after the other.
        run(&own, Some(1))?
    };
    let raised = failure.into_inner().ok().flatten();
    let evaluation = evaluation.map_err(|error| raised.unwrap_or_else(|| to_python(error)))?;
    Ok(PyEvaluation { evaluation, drawn_from_model })
}

/// Any Python object with a method `act(belief, viewpoint)`.
struct UserPolicy<'a> {
    object: Py<PyAny>,
    model: Arc<SortingModel>,
    /// The exception that the object raised, for the caller to see.
    failure: &'a Mutex<Option<PyErr>>,
}

impl Policy for UserPolicy<'_> {
    fn act(&self, belief: &Belief, viewpoint: usize) -> core::Result<Action> {
        Python::attach(|py| {
            let belief = PyBelief { belief: belief.clone(), model: Arc::clone(&self.model) };
            let action = self.object.bind(py).call_method1("act", (belief, viewpoint))?;
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

/// A list of labels to draw from, or an array with a row per batch.
fn classes(value: &Bound<'_, PyAny>) -> PyResult<TrueClasses> {
    let to_index = |label: &i64| index("true class", *label);
    if let Ok(labels) = value.extract::<Vec<i64>>() {
        return Ok(TrueClasses::UniformlyFrom(labels.iter().map(to_index).collect::<PyResult<_>>()?));
    }
    let array: PyArrayLike2<'_, i64, AllowTypeChange> = value.extract().map_err(|_| {
        ArgumentError::new_err("true_classes is neither a list of labels nor an integer array of two axes")
    })?;
    let rows = array.as_array();
    let rows = rows.rows().into_iter().map(|row| row.iter().map(to_index).collect());
    Ok(TrueClasses::Given(rows.collect::<PyResult<_>>()?))
}
