//! What a model consists of, as properties of `SortingModel`.

use beltsort_core::{Bin, Class, Kind, Position, Smoothing, Viewpoint};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray4};
use pyo3::prelude::*;

use super::PySortingModel;
use crate::convert::read_only;

#[pymethods]
impl PySortingModel {
    /// Names of the classes, list of length L.
    #[getter]
    fn classes(&self) -> Vec<String> {
        self.0.spec().classes.clone()
    }

    /// Names of the viewpoints, list of length K.
    #[getter]
    fn viewpoints(&self) -> Vec<String> {
        self.0.spec().viewpoints.clone()
    }

    /// H, the number of belt positions that one scan sees.
    #[getter]
    fn positions(&self) -> usize {
        self.0.position_count()
    }

    /// Names of the labels that a look may yield, list of length Z; the classes unless given.
    #[getter]
    fn labels(&self) -> Vec<String> {
        self.0.label_names().to_vec()
    }

    /// Names of the bins of decisions, list of length B; the classes unless given.
    #[getter]
    fn bins(&self) -> Vec<String> {
        self.0.bin_names().to_vec()
    }

    /// Worth of putting class c into bin b, float64 of shape (B, L), ``[bin, class]``.
    ///
    /// Without `reward` it follows from `r_max` and `r_min`.
    #[getter]
    fn reward<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let kind = |class| Kind(self.0.kinds_of(Class(class)).start);
        let shape = (self.0.bin_count(), self.0.class_count());
        Array2::from_shape_fn(shape, |(b, c)| self.0.reward(Bin(b), kind(c))).into_pyarray(py)
    }

    /// Weights of the modes of each class, a list per class; each sums to 1.
    #[getter]
    fn modes(&self) -> Vec<Vec<f64>> {
        let weights = |class| self.0.kinds_of(class).map(|kind| self.0.mode_weight(Kind(kind))).collect();
        self.0.classes().map(weights).collect()
    }

    /// Observation tables as given, read-only float64 of shape (H, K, N, Z).
    ///
    /// N and Z are L unless the model has `modes` or `labels`.
    #[getter]
    fn p_obs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray4<f64>>> {
        read_only(py, &self.0.spec().p_obs)
    }

    /// The label counts behind `p_obs`, read-only uint64 of shape (H, K, N, Z), or None.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray4<u64>>>> {
        self.0.spec().counts.as_ref().map(|counts| read_only(py, counts)).transpose()
    }

    /// Reward of a right decision; of a model with `reward` its largest entry.
    #[getter]
    fn r_max(&self) -> f64 {
        self.0.most_reward()
    }

    /// Penalty of a wrong decision, above 0.
    ///
    /// Of a model with `reward` its smallest entry, with the other sign.
    #[getter]
    fn r_min(&self) -> f64 {
        -self.0.least_reward()
    }

    /// `gamma`, per planner step.
    #[getter]
    fn discount(&self) -> f64 {
        self.0.discount()
    }

    /// The pseudo-counts that were added to `counts`.
    ///
    /// A number, read-only float64 of shape (H, K, N, Z), or None.
    #[getter]
    fn smoothing<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let value = |smoothing: &Smoothing| match smoothing {
            Smoothing::Scalar(number) => Ok(number.into_pyobject(py)?.into_any()),
            Smoothing::Tables(tables) => read_only(py, tables).map(Bound::into_any),
        };
        self.0.spec().smoothing.as_ref().map(value).transpose()
    }

    /// Free text.
    #[getter]
    fn note(&self) -> &str {
        &self.0.spec().note
    }

    /// Prior of the class of an arriving object, float64 of shape (L,); sums to 1.
    #[getter]
    fn arrival<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.class_probabilities(self.0.arrival().as_slice()).collect::<Vec<_>>().into_pyarray(py)
    }

    /// Cost of each move, float64 of shape (K, K), ``[start, end]``.
    #[getter]
    fn motion_cost<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let k = self.0.viewpoint_count();
        Array2::from_shape_fn((k, k), |(from, to)| self.0.motion_cost(Viewpoint(from), Viewpoint(to)))
            .into_pyarray(py)
    }

    /// The viewpoints that one move reaches, one ascending list per viewpoint.
    #[getter]
    fn travel(&self) -> Vec<Vec<usize>> {
        let reached = |from| self.0.legal_moves(from).iter().map(|to| to.0).collect();
        self.0.viewpoints().map(reached).collect()
    }

    /// Whether a scan follows each decision.
    #[getter]
    fn observe_after_decision(&self) -> bool {
        self.0.observes_after_decision()
    }

    /// Probability that a second look only repeats the last label, float64 of shape (H, K).
    #[getter]
    fn repeat<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let shape = (self.0.position_count(), self.0.viewpoint_count());
        Array2::from_shape_fn(shape, |(j, v)| self.0.repeat(Position(j), Viewpoint(v))).into_pyarray(py)
    }

    /// `alpha`, reward per nat of entropy that a scan is expected to remove.
    #[getter]
    fn information_gain(&self) -> f64 {
        self.0.spec().information_gain
    }

    /// The class that stands for an empty cup, or None.
    #[getter]
    fn empty(&self) -> Option<&str> {
        self.0.spec().empty.as_deref()
    }

    /// How perception makes a label of what a classifier returns, a new dict, or None.
    ///
    /// Kept beside the tables that were counted with it; planning does not use it.
    #[getter]
    fn label_rule<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let read = |rule: &serde_json::Value| py.import("json")?.call_method1("loads", (rule.to_string(),));
        self.0.spec().label_rule.as_ref().map(read).transpose()
    }
}
