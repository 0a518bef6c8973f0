//! `LookAhead`.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use beltsort_core::{DEFAULT_SCENARIOS, DespotConfig, LookAhead, SortingModel};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::belief::PyBelief;
use crate::convert::{self, Whole, count};
use crate::display::{displayed, immutable};
use crate::errors::to_python;
use crate::interrupt::interruptible;
use crate::keywords;
use crate::model::PySortingModel;
use crate::names::Named;
use crate::policies::act;

/// Planner steps of a look-ahead, if not given.
pub const DEFAULT_LOOK_AHEAD_DEPTH: usize = 1;

/// Compare all actions a fixed number of steps ahead, with the leaf values of `Despot`.
///
/// A baseline for the search: no trials, no bounds. Labels that no scenario gives follow the one-object
/// policy.
///
/// Parameters
/// ----------
/// model : SortingModel
///     The problem; its one-object plans are found here, which takes a moment.
/// depth : int, default 1
///     Planner steps to look ahead, 1 to 4. The tree grows with the power of it.
/// scenarios : int, default 500
///     As for `Despot`.
/// seed : int
///     As for `Despot`.
///
/// Raises
/// ------
/// ArgumentError
///     For another depth, or no scenarios.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> beltsort.LookAhead(model, depth=2).act(beltsort.Belief(model), 0)
/// Move(viewpoint=0)
#[pyclass(frozen, name = "LookAhead", module = "beltsort")]
pub struct PyLookAhead {
    pub policy: LookAhead,
    pub model: Arc<SortingModel>,
    depth: usize,
    config: DespotConfig,
}

#[pymethods]
impl PyLookAhead {
    #[new]
    #[pyo3(signature = (model, depth=DEFAULT_LOOK_AHEAD_DEPTH as Whole, *, scenarios=DEFAULT_SCENARIOS as Whole, seed=0,
                        **unknown),
           text_signature = "(model, depth=..., *, scenarios=..., seed=0)")]
    fn new(
        py: Python<'_>,
        model: &PySortingModel,
        depth: Whole,
        scenarios: Whole,
        seed: Whole,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        keywords::refuse(unknown, "LookAhead")?;
        let (depth, scenarios) = (count("depth", depth)?, count("scenarios", scenarios)?);
        let config = DespotConfig { scenarios, seed: convert::seed(seed)?, ..DespotConfig::default() };
        let stop = AtomicBool::new(false);
        let policy = interruptible(py, &stop, || LookAhead::new_until(&model.0, depth, config, &stop))?
            .map_err(to_python)?;
        Ok(Self { policy, model: Arc::clone(&model.0), depth, config })
    }

    /// Return the action with the highest value.
    ///
    /// Parameters
    /// ----------
    /// belief : Belief
    ///     What is known of the objects; made for the policy's model, or an equal one.
    /// viewpoint : int or str
    ///     Where the camera stands: index or name.
    ///
    /// Returns
    /// -------
    /// Move or Decide
    ///     The action.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a belief of another model or an unknown viewpoint.
    fn act(&self, py: Python<'_>, belief: PyBelief, viewpoint: Named) -> PyResult<Py<PyAny>> {
        act(py, &self.policy, &self.model, &belief, viewpoint)
    }

    /// The model that the policy was made for.
    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }

    /// What the policy was made with, as keywords of the constructor: depth, scenarios, seed.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let settings = PyDict::new(py);
        settings.set_item("depth", self.depth)?;
        settings.set_item("scenarios", self.config.scenarios)?;
        settings.set_item("seed", self.config.seed)?;
        Ok(settings)
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((PySortingModel,), Bound<'py, PyDict>)> {
        Ok(((self.model(),), self.settings(py)?))
    }
}

displayed!(PyLookAhead);
immutable!(PyLookAhead);
