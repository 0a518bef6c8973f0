//! `MovingBelief`.

use std::sync::Arc;

use beltsort_core::{Class, MovingBelief, MovingBelt, Position};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::convert::{Whole, index, rows};
use crate::errors::{ArgumentError, to_python};
use crate::keywords;
use crate::moving_belt::PyMovingBelt;
use crate::names::Named;

/// What is known of the objects on a moving belt, and its clock.
///
/// Each label depends on its own object only, and everything but the kinds (class and mode) is known, so the
/// product of the rows is the exact posterior. It changes in place; `copy` it to keep one.
///
/// Parameters
/// ----------
/// belt : MovingBelt
///     Gives shape, tables, arrival prior and durations.
/// kinds : array_like, shape (H, L) or (H, N), optional
///     One distribution over the classes, or the kinds, per place, the one nearest to the exit first; the
///     arrival prior at every place if missing.
/// decided : sequence of H bools, optional
///     Whether the object at each place is decided already, or there is none; none is if missing.
/// offset : int, default 0
///     Ticks since the belt last advanced, below `ticks_per_place`.
/// to_come : int, optional
///     Objects that have not come to a place yet; if missing, the belt never ends.
///
/// Raises
/// ------
/// ArgumentError
///     For another shape, a row that is no distribution, or numbers out of range.
///
/// References
/// ----------
/// Mezei, Tamás & Buşoniu, ECC 2019, eq. 7 (`observe`) and eq. 8 (`advance_time`).
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
/// >>> belief = belt.belief(objects=3)
/// >>> belief.advance_time(1)
/// 0.0
/// >>> belief.observe("front", ["bolt"])
/// >>> belief
/// MovingBelief([[0.200, 0.800]], decided=[False], offset=1, to_come=2)
#[pyclass(eq, name = "MovingBelief", module = "beltsort", from_py_object)]
#[derive(Clone, PartialEq)]
pub struct PyMovingBelief {
    pub belief: MovingBelief,
    pub belt: Arc<MovingBelt>,
}

impl PyMovingBelief {
    /// A belt full of unseen objects.
    pub fn unseen(belt: &Arc<MovingBelt>, objects: Option<Whole>) -> PyResult<Self> {
        let objects = objects.map(|objects| number("objects", objects)).transpose()?;
        Ok(Self { belief: MovingBelief::new(belt, objects), belt: Arc::clone(belt) })
    }

    /// Refuse to be asked about another belt than this belief was made for.
    pub fn check_is_of(&self, belt: &Arc<MovingBelt>) -> PyResult<()> {
        if Arc::ptr_eq(&self.belt, belt) || self.belt == *belt {
            return Ok(());
        }
        Err(ArgumentError::new_err(
            "the belief is of another belt than the policy; make it with policy.belt.belief()",
        ))
    }

    fn place(&self, position: Whole) -> PyResult<Position> {
        let position = Position(index("position", position)?);
        self.belt.model().check_position(position).map_err(to_python)?;
        Ok(position)
    }
}

#[pymethods]
impl PyMovingBelief {
    #[new]
    #[pyo3(signature = (belt, *, kinds=None, decided=None, offset=0, to_come=None, **unknown),
           text_signature = "(belt, *, kinds=None, decided=None, offset=0, to_come=None)")]
    fn new(
        belt: &PyMovingBelt,
        kinds: Option<&Bound<'_, PyAny>>,
        decided: Option<Vec<bool>>,
        offset: Whole,
        to_come: Option<Whole>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        keywords::refuse(unknown, "MovingBelief")?;
        let model = belt.0.model();
        let kinds = match kinds {
            None => vec![model.arrival().as_slice().to_vec(); model.position_count()],
            Some(value) => rows("kinds", value).map_err(ArgumentError::new_err)?,
        };
        let decided = decided.unwrap_or_else(|| vec![false; model.position_count()]);
        let to_come = to_come.map(|objects| number("to_come", objects)).transpose()?;
        let belief = MovingBelief::from_parts(&belt.0, &kinds, decided, number("offset", offset)?, to_come);
        Ok(Self { belief: belief.map_err(to_python)?, belt: Arc::clone(&belt.0) })
    }

    /// The belt that this belief was made for.
    #[getter]
    fn belt(&self) -> PyMovingBelt {
        PyMovingBelt(Arc::clone(&self.belt))
    }

    /// Probability that the object at place j is of class i, float64 of shape (H, L); a copy.
    #[getter]
    fn probabilities<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let model = self.belt.model();
        let entry = |(j, c)| model.class_probability(Class(c), self.belief.position(Position(j)));
        Array2::from_shape_fn((model.position_count(), model.class_count()), entry).into_pyarray(py)
    }

    /// Probability that the object at place j is of kind n, float64 of shape (H, N); a copy.
    #[getter]
    fn kinds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let model = self.belt.model();
        let entry = |(j, n): (usize, usize)| self.belief.position(Position(j))[n];
        Array2::from_shape_fn((model.position_count(), model.kind_count()), entry).into_pyarray(py)
    }

    /// Whether the object at each place is decided, or there is none; list of length H.
    #[getter]
    fn decided(&self) -> Vec<bool> {
        self.belief.decided().to_vec()
    }

    /// Ticks since the belt last advanced; since the last decision if it advances on decisions.
    #[getter]
    fn offset(&self) -> usize {
        self.belief.offset()
    }

    /// Objects that have not come to a place yet; None for a belt that never ends.
    #[getter]
    fn to_come(&self) -> Option<usize> {
        self.belief.to_come()
    }

    /// Whether nothing is left to decide, now or later.
    #[getter]
    fn is_over(&self) -> bool {
        self.belief.is_over()
    }

    /// Return the ticks until the object at a place passes the exit.
    ///
    /// Parameters
    /// ----------
    /// position : int
    ///     Index of the place, 0 nearest to the exit.
    ///
    /// Returns
    /// -------
    /// int or None
    ///     At least 1; None if the belt advances on decisions.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     If there is no such place.
    fn ticks_left(&self, position: Whole) -> PyResult<Option<usize>> {
        Ok(self.belief.ticks_left(&self.belt, self.place(position)?))
    }

    /// Return the most likely class at a place (the lowest label among equals) and its probability.
    ///
    /// Parameters
    /// ----------
    /// position : int
    ///     Index of the place, 0 nearest to the exit.
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
    ///     If there is no such place.
    fn most_likely(&self, position: Whole) -> PyResult<(usize, f64)> {
        let (class, p) = self.belt.model().most_likely_class(self.belief.position(self.place(position)?));
        Ok((class.0, p))
    }

    /// Return the bin where the object at a place is worth most, and the expected reward.
    ///
    /// Parameters
    /// ----------
    /// position : int
    ///     Index of the place, 0 nearest to the exit.
    ///
    /// Returns
    /// -------
    /// label : int
    ///     Index of the bin.
    /// reward : float
    ///     Expected reward of putting the object there.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     If there is no such place.
    fn best_decision(&self, position: Whole) -> PyResult<(usize, f64)> {
        let (bin, reward) = self.belt.model().best_decision(self.belief.position(self.place(position)?));
        Ok((bin.0, reward))
    }

    /// Update the belief by the labels of one scan, with Bayes' rule.
    ///
    /// Parameters
    /// ----------
    /// viewpoint : int or str
    ///     Index or name of the viewpoint that the scan was taken from.
    /// labels : sequence of int, str or None, length H
    ///     The label of each place, index or name, the one nearest to the exit first; None where nothing was
    ///     seen. Labels of decided objects are ignored.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For another number of labels, or a label or viewpoint that the model has not.
    /// ImpossibleObservationError
    ///     For a label of probability 0. The belief is then unchanged.
    fn observe(&mut self, viewpoint: Named, labels: Vec<Option<Named>>) -> PyResult<()> {
        let model = self.belt.model();
        let viewpoint = viewpoint.viewpoint(model)?;
        let label = |label: Option<Named>| label.map(|label| label.label(model)).transpose();
        let labels = labels.into_iter().map(label).collect::<PyResult<Vec<_>>>()?;
        self.belief.observe(&self.belt, viewpoint, &labels).map_err(to_python)
    }

    /// Mark the object at a place as decided.
    ///
    /// It stays where it is, unless the belt advances on decisions: then all that is known moves on by one
    /// place. Let the belt's `decision_ticks` pass afterwards.
    ///
    /// Parameters
    /// ----------
    /// position : int
    ///     Index of the place, 0 nearest to the exit.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     If it is out of reach, or decided already. The belief is then unchanged.
    fn decide(&mut self, position: Whole) -> PyResult<()> {
        let position = self.place(position)?;
        self.belief.decide(&self.belt, position).map_err(to_python)
    }

    /// Let time pass.
    ///
    /// At each advance of the belt every place takes over what is known of the one behind it, and the last
    /// one the arrival prior.
    ///
    /// Parameters
    /// ----------
    /// ticks : int
    ///     How many ticks pass.
    ///
    /// Returns
    /// -------
    /// float
    ///     Expected price of the objects that passed the exit undecided, discounted to the beginning.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a negative number, or more than 4,294,967,295.
    fn advance_time(&mut self, ticks: Whole) -> PyResult<f64> {
        let ticks = u32::try_from(ticks).map_err(|_| {
            ArgumentError::new_err(format!("ticks = {ticks}; give a number from 0 to {}", u32::MAX))
        })?;
        Ok(self.belief.advance_time(&self.belt, ticks as usize))
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

    fn __repr__(&self) -> String {
        let model = self.belt.model();
        let row = |j: Position| {
            let entries = model.class_probabilities(self.belief.position(j));
            format!("[{}]", entries.map(|p| format!("{p:.3}")).collect::<Vec<_>>().join(", "))
        };
        let word = |decided: &bool| if *decided { "True" } else { "False" };
        format!(
            "MovingBelief([{}], decided=[{}], offset={}, to_come={})",
            model.positions().map(row).collect::<Vec<_>>().join(", "),
            self.belief.decided().iter().map(word).collect::<Vec<_>>().join(", "),
            self.offset(),
            self.to_come().map_or("None".into(), |objects| objects.to_string())
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, BeliefRecord<'py>)> {
        let (belief, py) = (slf.borrow(), slf.py());
        let record = (belief.belt(), belief.kinds(py), belief.decided(), belief.offset(), belief.to_come());
        Ok((slf.get_type().getattr("_restored")?, record))
    }

    #[classmethod]
    fn _restored(
        class: &Bound<'_, PyType>,
        belt: &PyMovingBelt,
        kinds: &Bound<'_, PyAny>,
        decided: Vec<bool>,
        offset: Whole,
        to_come: Option<Whole>,
    ) -> PyResult<Self> {
        let _ = class;
        Self::new(belt, Some(kinds), Some(decided), offset, to_come, None)
    }
}

/// The arguments of the constructor that give an equal belief.
type BeliefRecord<'py> = (PyMovingBelt, Bound<'py, PyArray2<f64>>, Vec<bool>, usize, Option<usize>);

/// A number of ticks or objects, which may be 0.
fn number(name: &str, value: Whole) -> PyResult<usize> {
    usize::try_from(value)
        .map_err(|_| ArgumentError::new_err(format!("{name} = {value}; give a whole number, 0 or more")))
}
