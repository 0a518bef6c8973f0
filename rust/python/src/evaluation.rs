//! `Evaluation`.

use beltsort_core::Evaluation;
use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray1, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{from_json, to_json};
use crate::display::{displayed, immutable};
use crate::errors::ArgumentError;

/// Outcomes of simulated batches: arrays of shape (batches,), in the order of the batches.
///
/// Rewards are in the unit of `r_max` and `r_min`. Two policies that were evaluated with the same seed met
/// the same objects: compare them batch by batch.
#[pyclass(frozen, name = "Evaluation", module = "beltsort")]
pub struct PyEvaluation {
    pub evaluation: Evaluation,
    pub bins: usize,
    pub classes: usize,
    pub drawn_from_model: bool,
    pub with_bonuses: bool,
}

#[pymethods]
impl PyEvaluation {
    /// Planner steps, that is moves and decisions; uint64.
    #[getter]
    fn steps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.evaluation.steps.clone().into_pyarray(py)
    }

    /// Right decisions; uint64, at most `batch_size`.
    ///
    /// A decision is right if no bin is worth more for the object's class.
    #[getter]
    fn correct<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.evaluation.correct.clone().into_pyarray(py)
    }

    /// Confusion matrices of the decisions, uint64 of shape (batches, B, L), ``[batch, bin, class]``.
    ///
    /// Objects by bin and true class.
    #[getter]
    fn confusion<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<u64>> {
        let shape = (self.evaluation.confusion.len(), self.bins, self.classes);
        let entry = |(batch, bin, class): (usize, usize, usize)| {
            self.evaluation.confusion[batch][bin * self.classes + class]
        };
        Array3::from_shape_fn(shape, entry).into_pyarray(py)
    }

    /// Decisions forced by `max_looks`, or by three impossible labels of one object in a row; uint64.
    #[getter]
    fn forced<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.evaluation.forced.clone().into_pyarray(py)
    }

    /// Sum of rewards; float64.
    #[getter]
    fn returns<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.evaluation.returns.clone().into_pyarray(py)
    }

    /// Sum of rewards, each times `discount` to the power of the planner steps before it; float64.
    #[getter]
    fn discounted_returns<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.evaluation.discounted_returns.clone().into_pyarray(py)
    }

    /// As `discounted_returns`, each decision scored by its expected reward under the belief; float64.
    ///
    /// The same mean and a far smaller variance, as long as the model itself draws classes and labels.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     If `true_classes` or another `truth` was given: the mean would be biased.
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

    /// Sum of the bonuses for information; float64. No other property contains them.
    ///
    /// A bonus is `information_gain` times the expected entropy reduction of a scan.
    #[getter]
    fn bonuses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.evaluation.bonuses.clone().into_pyarray(py)
    }

    /// Sum of discounted bonuses; float64.
    #[getter]
    fn discounted_bonuses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.evaluation.discounted_bonuses.clone().into_pyarray(py)
    }

    /// Sum of what the policy's actions lost against the best ones; float64.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     If no `reference` was given.
    #[getter]
    fn regrets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        referred(py, &self.evaluation.regrets)
    }

    /// Sum of discounted regrets; float64.
    ///
    /// Over batches so long that nothing is left behind them, its mean is what the policy's value falls short
    /// of the reference's.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     If no `reference` was given.
    #[getter]
    fn discounted_regrets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        referred(py, &self.evaluation.discounted_regrets)
    }

    /// Return mean and standard error over the batches of every outcome.
    ///
    /// Returns
    /// -------
    /// dict
    ///     For each property above, a dict with the keys ``mean`` and ``standard_error`` (NaN for a single
    ///     batch). `expected_discounted_returns` is left out where it would be biased, bonuses where the
    ///     model's `information_gain` is 0, regrets without a `reference`.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let summary = PyDict::new(py);
        for (name, statistics) in self.evaluation.summary(self.drawn_from_model, self.with_bonuses) {
            let entry = PyDict::new(py);
            entry.set_item("mean", statistics.mean)?;
            entry.set_item("standard_error", statistics.standard_error)?;
            summary.set_item(name, entry)?;
        }
        Ok(summary)
    }

    /// Return the outcomes as a table with a row per batch.
    ///
    /// Returns
    /// -------
    /// pandas.DataFrame
    ///     The columns are the properties that `summary` lists, the index is the number of the batch.
    ///
    /// Raises
    /// ------
    /// MissingExtraError
    ///     If pandas is not installed.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("beltsort.planning.frames")?.call_method1("evaluation_frame", (slf,))
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, EvaluationRecord)> {
        let restored = py.get_type::<Self>().getattr("_restored")?.unbind();
        let outcomes = to_json(&self.evaluation)?;
        Ok((restored, (outcomes, self.bins, self.classes, self.drawn_from_model, self.with_bonuses)))
    }

    #[staticmethod]
    fn _restored(
        outcomes: &str,
        bins: usize,
        classes: usize,
        drawn_from_model: bool,
        with_bonuses: bool,
    ) -> PyResult<Self> {
        Ok(Self { evaluation: from_json(outcomes)?, bins, classes, drawn_from_model, with_bonuses })
    }
}

/// The arguments of `_restored`.
type EvaluationRecord = (String, usize, usize, bool, bool);

displayed!(PyEvaluation);
immutable!(PyEvaluation);

/// Outcomes that only a reference gives.
fn referred<'py>(py: Python<'py>, regrets: &[f64]) -> PyResult<Bound<'py, PyArray1<f64>>> {
    if regrets.is_empty() {
        return Err(ArgumentError::new_err(
            "there are no regrets without a reference: evaluate with reference=beltsort.solve(model)",
        ));
    }
    Ok(regrets.to_vec().into_pyarray(py))
}
