//! `Belief`.

use std::sync::Arc;

use beltsort_core::{Belief, Class, Position, SortingModel, Viewpoint};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::convert::{Whole, index, labels_or_none, rows};
use crate::display::displayed;
use crate::errors::{ArgumentError, to_python};
use crate::keywords;
use crate::model::PySortingModel;
use crate::names::Named;

/// The factored belief: one distribution over the N kinds (class and mode) per belt position.
///
/// Objects are independent and each label depends on its own object only, so the product of these
/// distributions is the exact posterior. Where the model's `repeat` is above 0, the last label of each
/// position from each viewpoint belongs to the belief. It changes in place; `copy` it to keep one.
///
/// Parameters
/// ----------
/// model : SortingModel
///     Gives the shape, the observation tables and the arrival prior.
/// probabilities : array_like, shape (H, L) or (H, N), optional
///     One distribution over the classes, or the kinds, per position, the belt end first. Rows may miss 1 by
///     1e-6 and are normalised; those that miss it by rounding only are kept to the last bit. The arrival
///     prior at every position if missing. A probability of 0 is for ever: no label can raise it.
/// last_labels : array_like of int, shape (H, K), optional
///     Last labels since the belt moved, -1 for none, which is what is taken if missing. With both arguments
///     a belief is rebuilt from its record. Labels that the model cannot repeat are forgotten.
/// remaining : int, optional
///     Objects left to decide, the one at the belt end included; missing for a belt that never ends. Planners
///     that take it into account (`Despot`, `LookAhead`, `OneObject`) look longer at the last objects, which
///     delay no others.
///
/// Raises
/// ------
/// ArgumentError
///     If `probabilities` or `last_labels` has another shape, a row is no distribution, the model has no
///     such label, or `remaining` is below 0.
///
/// References
/// ----------
/// Mezei, Tamás & Buşoniu, ECC 2019, eq. 7 (`observe`) and eq. 8 (`advance`).
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> belief = beltsort.Belief(model)
/// >>> belief.observe("front", ["bolt"])
/// >>> belief
/// Belief
///   position    nut   bolt
///   1         0.200  0.800
/// >>> belief.most_likely(0)
/// (1, 0.8)
#[pyclass(eq, name = "Belief", module = "beltsort", from_py_object)]
#[derive(Clone, PartialEq)]
pub struct PyBelief {
    pub belief: Belief,
    pub model: Arc<SortingModel>,
}

impl PyBelief {
    /// Refuse to be asked about another model than this belief was made for.
    pub fn check_is_of(&self, model: &Arc<SortingModel>) -> PyResult<()> {
        if Arc::ptr_eq(&self.model, model) || self.model == *model {
            return Ok(());
        }
        Err(ArgumentError::new_err(
            "the belief is of another model than the policy; make it with Belief(policy.model)",
        ))
    }

    fn class_probability(&self, position: Position, class: Class) -> f64 {
        self.model.class_probability(class, self.belief.position(position).as_slice())
    }

    /// The label that a position last gave from a viewpoint; -1 for none, as numpy has no None among
    /// integers.
    fn last_label(&self, position: Position, viewpoint: Viewpoint) -> i64 {
        let label = self.belief.last_label(&self.model, position, viewpoint);
        label.and_then(|label| i64::try_from(label.0).ok()).unwrap_or(-1)
    }
}

#[pymethods]
impl PyBelief {
    #[new]
    #[pyo3(signature = (model, probabilities=None, last_labels=None, remaining=None, **unknown),
           text_signature = "(model, probabilities=None, last_labels=None, remaining=None)")]
    fn new(
        model: &PySortingModel,
        probabilities: Option<&Bound<'_, PyAny>>,
        last_labels: Option<&Bound<'_, PyAny>>,
        remaining: Option<Whole>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        keywords::refuse(unknown, "Belief")?;
        let mut belief = match probabilities {
            None => Belief::new(&model.0),
            Some(value) => {
                Belief::from_rows(&model.0, &rows("probabilities", value).map_err(ArgumentError::new_err)?)
                    .map_err(to_python)?
            }
        };
        if let Some(value) = last_labels {
            let rows = labels_or_none("last_labels", value).map_err(ArgumentError::new_err)?;
            belief = belief.with_last_labels(&model.0, &rows).map_err(to_python)?;
        }
        let remaining = remaining.map(objects_left).transpose()?;
        Ok(Self { belief: belief.with_remaining(remaining), model: Arc::clone(&model.0) })
    }

    /// The model that this belief was made for.
    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }

    /// `b^j_i`: probability that the object at position j is of class i, float64 (H, L); a copy.
    #[getter]
    fn probabilities<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let shape = (self.model.position_count(), self.model.class_count());
        Array2::from_shape_fn(shape, |(j, c)| self.class_probability(Position(j), Class(c))).into_pyarray(py)
    }

    /// Probability that the object at position j is of kind n, float64 of shape (H, N); a copy.
    ///
    /// The kinds are the modes of the first class, then those of the second, and so on; without `modes` they
    /// are the classes.
    #[getter]
    fn kinds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        Array2::from_shape_fn(self.belief.shape(), |(j, n)| self.belief.position(Position(j))[n])
            .into_pyarray(py)
    }

    /// Last label of each position from each viewpoint since the belt moved, int64 (H, K); a copy.
    ///
    /// -1 where there is none, or where the model's `repeat` is 0.
    #[getter]
    fn last_labels<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<i64>> {
        let shape = (self.model.position_count(), self.model.viewpoint_count());
        Array2::from_shape_fn(shape, |(j, v)| self.last_label(Position(j), Viewpoint(v))).into_pyarray(py)
    }

    /// Objects left to decide, the one at the belt end included; None for a belt that never ends.
    #[getter]
    fn remaining(&self) -> Option<usize> {
        self.belief.remaining()
    }

    /// Return the probability of each label at each position if the camera scanned from a viewpoint.
    ///
    /// Parameters
    /// ----------
    /// viewpoint : int or str
    ///     Index or name of the viewpoint.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray
    ///     float64 of shape (H, Z): `sum_n b[j, n] P(z | j, viewpoint, n)` for position j and label z, where
    ///     b are the `kinds` and P is `p_obs`, mixed with the last label by the model's `repeat`.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     If the model has no such viewpoint.
    fn label_probabilities<'py>(
        &self,
        py: Python<'py>,
        viewpoint: Named,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let viewpoint = viewpoint.viewpoint(&self.model)?;
        let predicted = self.belief.label_probabilities(&self.model, viewpoint).map_err(to_python)?;
        Ok(Array2::from_shape_fn((predicted.ncols(), predicted.nrows()), |(j, z)| predicted[(z, j)])
            .into_pyarray(py))
    }

    /// Update the belief by the labels of one scan, with Bayes' rule.
    ///
    /// `b[j, n]` becomes proportional to `b[j, n] P(labels[j] | j, viewpoint, n)`, where b are the `kinds`
    /// and P is `p_obs`, mixed with the last label by the model's `repeat`.
    ///
    /// Parameters
    /// ----------
    /// viewpoint : int or str
    ///     Index or name of the viewpoint that the scan was taken from.
    /// labels : sequence of int, str or None, length H
    ///     The label of each position, index or name, the belt end first: the class that it was taken for,
    ///     unless the model has `labels`; None where nothing was seen.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For another number of labels, or a label or viewpoint that the model has not.
    /// ImpossibleObservationError
    ///     For a label of probability 0. The belief is then unchanged.
    ///
    /// References
    /// ----------
    /// Mezei, Tamás & Buşoniu, ECC 2019, eq. 7.
    fn observe(&mut self, viewpoint: Named, labels: Vec<Option<Named>>) -> PyResult<()> {
        let viewpoint = viewpoint.viewpoint(&self.model)?;
        let label = |label: Option<Named>| label.map(|label| label.label(&self.model)).transpose();
        let labels = labels.into_iter().map(label).collect::<PyResult<Vec<_>>>()?;
        self.belief.observe(&self.model, viewpoint, &labels).map_err(to_python)
    }

    /// Advance the belt by one position.
    ///
    /// Each position takes over the distribution behind it, the last one the arrival prior. Last labels are
    /// forgotten, and one object less is left.
    ///
    /// References
    /// ----------
    /// Mezei, Tamás & Buşoniu, ECC 2019, eq. 8.
    fn advance(&mut self) {
        self.belief.advance(&self.model);
    }

    /// Return the most likely class at a position (the lowest label among equals) and its probability.
    ///
    /// Parameters
    /// ----------
    /// position : int
    ///     Index of a belt position, 0 at the belt end.
    ///
    /// Returns
    /// -------
    /// label : int
    ///     Index of the class.
    /// probability : float
    ///     Its probability.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     If the model has no such position.
    fn most_likely(&self, position: Whole) -> PyResult<(usize, f64)> {
        let position = Position(index("position", position)?);
        self.model.check_position(position).map_err(to_python)?;
        let (class, probability) = self.belief.most_likely(&self.model, position);
        Ok((class.0, probability))
    }

    /// Return an independent belief, equal to this one.
    fn copy(&self) -> Self {
        self.clone()
    }

    fn __copy__(&self) -> Self {
        self.clone()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.clone()
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyType>, BeliefRecord<'py>) {
        let (belief, py) = (slf.borrow(), slf.py());
        let memory = belief.model.ever_repeats().then(|| belief.last_labels(py));
        (slf.get_type(), (belief.model(), belief.kinds(py), memory, belief.remaining()))
    }
}

displayed!(PyBelief);

/// The arguments of the constructor that give an equal belief.
type BeliefRecord<'py> =
    (PySortingModel, Bound<'py, PyArray2<f64>>, Option<Bound<'py, PyArray2<i64>>>, Option<usize>);

fn objects_left(value: Whole) -> PyResult<usize> {
    usize::try_from(value).map_err(|_| {
        ArgumentError::new_err(format!(
            "remaining = {value}; give the number of objects left, 0 or more, or None for a belt that never ends"
        ))
    })
}
