//! `MovingBelt`.

use std::path::PathBuf;
use std::sync::Arc;

use beltsort_core::{Drive, MovingBelt, MovingSpec, ScalarOrMatrix, Viewpoint};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{Whole, count, index, scalar_or_matrix};
use crate::display::immutable;
use crate::errors::to_python;
use crate::keywords;
use crate::model::PySortingModel;
use crate::moving_belief::PyMovingBelief;

/// A sorting model on a belt that moves while the camera looks.
///
/// Time runs in ticks. A belt of constant speed carries every object one place further every
/// `ticks_per_place`, whatever is decided; an object that passes the exit undecided costs `missed`. With
/// `advance_ticks` in its place the belt stands, and advances by one place after each decision on the object
/// nearest to the exit, as in the paper. An object is seen at the H places of the model's tables and decided
/// while it is in reach. A look moves the camera and scans at the end of its ticks, at least one; its cost is
/// the model's. The model's discount is per tick.
///
/// Parameters
/// ----------
/// model : SortingModel
///     Classes, tables and rewards. `repeat`, `observe_after_decision` and `information_gain` are refused.
/// ticks_per_place : int, optional
///     Ticks between two advances of a belt of constant speed.
/// advance_ticks : int, optional
///     Ticks of a decision and the advance after it, at least one; in place of `ticks_per_place`.
/// reach : int, default 1
///     Places, from the exit, at which objects can be decided.
/// move_ticks : int or array of shape (K, K), default 1
///     Ticks of the camera's moves, ``[start, end]``.
/// scan_ticks : int, default 0
///     Ticks of a scan.
/// sort_ticks : int, default 0
///     Ticks of a decision, in which the camera waits.
/// missed : sequence of L floats, optional
///     Price of an object that passes the exit undecided, per class, not negative; if missing, 0 for the
///     model's `empty` class, and the largest reward for the others.
/// seconds_per_tick : float, optional
///     How long a tick lasts; reports use it.
///
/// Raises
/// ------
/// ArgumentError
///     For durations or prices that make no sense.
/// ModelError
///     For a model with keys that are not supported.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> belt = beltsort.MovingBelt(model, ticks_per_place=4, seconds_per_tick=0.5)
/// >>> belt.look_ticks.tolist(), belt.missed.tolist()
/// ([[1]], [10.0, 10.0])
/// >>> beltsort.MovingBelt.from_json(belt.to_json()) == belt
/// True
#[pyclass(frozen, eq, name = "MovingBelt", module = "beltsort")]
#[derive(Clone, PartialEq)]
pub struct PyMovingBelt(pub Arc<MovingBelt>);

#[pymethods]
impl PyMovingBelt {
    #[new]
    #[pyo3(signature = (model, *, ticks_per_place=None, advance_ticks=None, reach=1, move_ticks=None, scan_ticks=0,
                        sort_ticks=0, missed=None, seconds_per_tick=None, **unknown),
           text_signature = "(model, *, ticks_per_place=None, advance_ticks=None, reach=1, move_ticks=1, scan_ticks=0, \
                             sort_ticks=0, missed=None, seconds_per_tick=None)")]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn new(
        model: &PySortingModel,
        ticks_per_place: Option<Whole>,
        advance_ticks: Option<Whole>,
        reach: Whole,
        move_ticks: Option<&Bound<'_, PyAny>>,
        scan_ticks: Whole,
        sort_ticks: Whole,
        missed: Option<Vec<f64>>,
        seconds_per_tick: Option<f64>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        keywords::refuse(unknown, "MovingBelt")?;
        let ticks_per_place = ticks_per_place.map(|ticks| count("ticks_per_place", ticks)).transpose()?;
        let advance_ticks = advance_ticks.map(|ticks| count("advance_ticks", ticks)).transpose()?;
        let plain = MovingSpec::new(Drive::of(ticks_per_place, advance_ticks).map_err(to_python)?);
        let move_ticks = move_ticks.map(|ticks| scalar_or_matrix("move_ticks", ticks)).transpose()?;
        let spec = MovingSpec {
            reach: count("reach", reach)?,
            move_ticks: move_ticks.unwrap_or(plain.move_ticks),
            scan_ticks: index("scan_ticks", scan_ticks)?,
            sort_ticks: index("sort_ticks", sort_ticks)?,
            missed,
            seconds_per_tick,
            ..plain
        };
        Ok(Self(Arc::new(MovingBelt::new(Arc::clone(&model.0), spec).map_err(to_python)?)))
    }

    /// Read the file of a moving belt.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     A model file with one more key, ``moving_belt``: an object with the constructor's keywords.
    ///
    /// Returns
    /// -------
    /// MovingBelt
    ///     The belt.
    ///
    /// Raises
    /// ------
    /// ModelError
    ///     If the file cannot be read, is not JSON, has an unknown key, or lacks one.
    /// ArgumentError
    ///     As the constructor.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Ok(Self(Arc::new(MovingBelt::load(&path).map_err(to_python)?)))
    }

    /// Read the text of the file of a moving belt.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     JSON.
    ///
    /// Returns
    /// -------
    /// MovingBelt
    ///     The belt.
    ///
    /// Raises
    /// ------
    /// ModelError, ArgumentError
    ///     As `load`.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        Ok(Self(Arc::new(MovingBelt::from_json(text).map_err(to_python)?)))
    }

    /// Return the file as text, JSON.
    fn to_json(&self) -> PyResult<String> {
        self.0.to_json().map_err(to_python)
    }

    /// Write the file; `load` gives an equal belt back.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     Where to write; an existing file is replaced.
    ///
    /// Raises
    /// ------
    /// ModelError
    ///     If the file cannot be written.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        self.0.save(&path).map_err(to_python)
    }

    /// Return the belief of a belt full of unseen objects that has just advanced.
    ///
    /// Parameters
    /// ----------
    /// objects : int, optional
    ///     How many objects will pass, those at the places included; if missing, the belt never ends.
    ///
    /// Returns
    /// -------
    /// MovingBelief
    ///     The belief.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a negative number.
    #[pyo3(signature = (objects=None))]
    fn belief(&self, objects: Option<Whole>) -> PyResult<PyMovingBelief> {
        PyMovingBelief::unseen(&self.0, objects)
    }

    /// The model: classes, tables and rewards.
    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(self.0.model()))
    }

    /// Ticks between two advances; None if the belt advances on decisions.
    #[getter]
    fn ticks_per_place(&self) -> Option<usize> {
        match self.0.spec().drive {
            Drive::Constant { ticks_per_place } => Some(ticks_per_place),
            Drive::OnDecision { .. } => None,
        }
    }

    /// Ticks of a decision and the advance after it; None for a belt of constant speed.
    #[getter]
    fn advance_ticks(&self) -> Option<usize> {
        match self.0.spec().drive {
            Drive::Constant { .. } => None,
            Drive::OnDecision { advance_ticks } => Some(advance_ticks),
        }
    }

    /// Places, from the exit, at which objects can be decided.
    #[getter]
    fn reach(&self) -> usize {
        self.0.spec().reach
    }

    /// Ticks of each look, its move and its scan; uint64 of shape (K, K), ``[start, end]``.
    #[getter]
    fn look_ticks<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u64>> {
        let k = self.0.model().viewpoint_count();
        Array2::from_shape_fn((k, k), |(from, to)| self.0.look_ticks(Viewpoint(from), Viewpoint(to)) as u64)
            .into_pyarray(py)
    }

    /// Ticks of a decision: `sort_ticks`, or those of the advance.
    #[getter]
    fn decision_ticks(&self) -> usize {
        self.0.decision_ticks()
    }

    /// Price of an object that passes the exit undecided, float64 of shape (L,).
    #[getter]
    fn missed<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.missed().to_vec().into_pyarray(py)
    }

    /// How long a tick lasts, in seconds, or None.
    #[getter]
    fn seconds_per_tick(&self) -> Option<f64> {
        self.0.spec().seconds_per_tick
    }

    /// What the belt was made with besides the model, as keywords of the constructor.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let spec = self.0.spec();
        let settings = PyDict::new(py);
        settings.set_item("ticks_per_place", self.ticks_per_place())?;
        settings.set_item("advance_ticks", self.advance_ticks())?;
        settings.set_item("reach", spec.reach)?;
        match &spec.move_ticks {
            ScalarOrMatrix::Scalar(ticks) => settings.set_item("move_ticks", ticks)?,
            ScalarOrMatrix::Matrix(rows) => settings.set_item("move_ticks", rows.clone())?,
        }
        settings.set_item("scan_ticks", spec.scan_ticks)?;
        settings.set_item("sort_ticks", spec.sort_ticks)?;
        settings.set_item("missed", spec.missed.clone())?;
        settings.set_item("seconds_per_tick", spec.seconds_per_tick)?;
        Ok(settings)
    }

    fn __repr__(&self) -> String {
        let drive = match self.0.spec().drive {
            Drive::Constant { ticks_per_place } => format!("ticks_per_place={ticks_per_place}"),
            Drive::OnDecision { advance_ticks } => format!("advance_ticks={advance_ticks}"),
        };
        let model = self.0.model();
        format!(
            "MovingBelt({} classes, {} viewpoints, {} places, {drive}, reach={})",
            model.class_count(),
            model.viewpoint_count(),
            model.position_count(),
            self.reach()
        )
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((PySortingModel,), Bound<'py, PyDict>)> {
        Ok(((self.model(),), self.settings(py)?))
    }
}

immutable!(PyMovingBelt);
