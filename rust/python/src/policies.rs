//! The simple policies, and how any of them is asked.

use std::sync::Arc;

use beltsort_core::{InformationGain, Policy, Question, SortingModel, Threshold};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::actions;
use crate::belief::PyBelief;
use crate::convert::{Whole, count};
use crate::display::{displayed, immutable};
use crate::errors::{ArgumentError, to_python};
use crate::keywords;
use crate::model::PySortingModel;
use crate::names::Named;

/// Positions whose information counts, if not given.
pub const DEFAULT_INFORMATION_POSITIONS: usize = 1;

/// Look from one viewpoint until the best decision is likely enough to be right.
///
/// The best decision is the one with the largest expected reward; it is right if no bin is worth more for the
/// object's class. Where the bins are the classes, it is the most likely class. A manual bin, which is right
/// for no class, is never chosen while a move is legal.
///
/// Parameters
/// ----------
/// model : SortingModel
///     The problem.
/// threshold : float
///     Decide once the best decision at the belt end is right with this probability, above 0 and at most 1.
///     Too near 1, and no decision may ever be reached: `max_looks` of `evaluate` then forces one.
/// viewpoint : int or str, optional
///     Index or name of the viewpoint to look from, reached by the fewest moves; if missing, the one whose
///     scan tells most about an object that has just arrived.
///
/// Raises
/// ------
/// ArgumentError
///     For a threshold outside (0, 1] or an unknown viewpoint.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> policy = beltsort.Threshold(model, 0.75)
/// >>> policy.act(beltsort.Belief(model, [[0.25, 0.75]]), 0)
/// Decide(label=1)
#[pyclass(frozen, name = "Threshold", module = "beltsort")]
pub struct PyThreshold {
    pub policy: Threshold,
    pub model: Arc<SortingModel>,
    threshold: f64,
    viewpoint: Option<usize>,
}

#[pymethods]
impl PyThreshold {
    #[new]
    #[pyo3(signature = (model, threshold=None, viewpoint=None, **unknown), text_signature = "(model, threshold, viewpoint=None)")]
    fn new(
        model: &PySortingModel,
        threshold: Option<f64>,
        viewpoint: Option<Named>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        keywords::refuse(unknown, "Threshold")?;
        let threshold = keywords::required(threshold, "Threshold", "threshold")?;
        let viewpoint = viewpoint.map(|viewpoint| viewpoint.viewpoint(&model.0)).transpose()?;
        let policy = Threshold::new(&model.0, threshold, viewpoint).map_err(to_python)?;
        let viewpoint = viewpoint.map(|viewpoint| viewpoint.0);
        Ok(Self { policy, model: Arc::clone(&model.0), threshold, viewpoint })
    }

    /// Decide at the threshold, move below it.
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
    ///     The action; a decision too where no move is legal.
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

    /// What the policy was made with, as keywords of the constructor: threshold, viewpoint.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let settings = PyDict::new(py);
        settings.set_item("threshold", self.threshold)?;
        settings.set_item("viewpoint", self.viewpoint)?;
        Ok(settings)
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((PySortingModel,), Bound<'py, PyDict>)> {
        Ok(((self.model(),), self.settings(py)?))
    }
}

/// Look from where most is learnt until the best decision is likely enough to be right.
///
/// Decisions are those of `Threshold`.
///
/// Parameters
/// ----------
/// model : SortingModel
///     The problem.
/// threshold : float
///     As for `Threshold`.
/// positions : int, default 1
///     The gain of a look is the expected drop of an entropy, summed over this many positions from the belt
///     end, 1 to H. With many, objects far from their decision outvote the one at the belt end.
/// about : {"class", "bin"}, default "class"
///     What the entropy is of: the object's class, or the bin where it belongs, so that classes with the same
///     right bins are not told apart. In the paper's model both are the same.
///
/// Raises
/// ------
/// ArgumentError
///     For a threshold outside (0, 1], positions outside 1 to H, or another word.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> blind, sharp = [[0.5, 0.5], [0.5, 0.5]], [[0.9, 0.1], [0.1, 0.9]]
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["below", "front"], [[blind, sharp]])
/// >>> beltsort.InformationGain(model, 0.95).act(beltsort.Belief(model), 0)
/// Move(viewpoint=1)
#[pyclass(frozen, name = "InformationGain", module = "beltsort")]
pub struct PyInformationGain {
    pub policy: InformationGain,
    pub model: Arc<SortingModel>,
    threshold: f64,
    positions: usize,
    about: String,
}

#[pymethods]
impl PyInformationGain {
    #[new]
    #[pyo3(signature = (model, threshold=None, positions=DEFAULT_INFORMATION_POSITIONS as Whole, *, about="class", **unknown),
           text_signature = "(model, threshold, positions=..., *, about='class')")]
    fn new(
        model: &PySortingModel,
        threshold: Option<f64>,
        positions: Whole,
        about: &str,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        keywords::refuse(unknown, "InformationGain")?;
        let threshold = keywords::required(threshold, "InformationGain", "threshold")?;
        let positions = count("positions", positions)?;
        let question = match about {
            "class" => Question::Class,
            "bin" => Question::Bin,
            _ => {
                return Err(ArgumentError::new_err(format!(
                    "about = {about:?}, expected \"class\" or \"bin\": what a look is to tell of an object"
                )));
            }
        };
        let policy = InformationGain::new(&model.0, threshold, positions, question).map_err(to_python)?;
        Ok(Self { policy, model: Arc::clone(&model.0), threshold, positions, about: about.into() })
    }

    /// Decide at the threshold, move below it.
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
    ///     The action; a decision too where no move is legal.
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

    /// What the policy was made with, as keywords of the constructor: threshold, positions, about.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let settings = PyDict::new(py);
        settings.set_item("threshold", self.threshold)?;
        settings.set_item("positions", self.positions)?;
        settings.set_item("about", &self.about)?;
        Ok(settings)
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((PySortingModel,), Bound<'py, PyDict>)> {
        Ok(((self.model(),), self.settings(py)?))
    }
}

displayed!(PyThreshold, PyInformationGain);
immutable!(PyThreshold, PyInformationGain);

/// The action of a policy of the core, by Python's arguments.
pub fn act(
    py: Python<'_>,
    policy: &dyn Policy,
    model: &Arc<SortingModel>,
    belief: &PyBelief,
    viewpoint: Named,
) -> PyResult<Py<PyAny>> {
    belief.check_is_of(model)?;
    let action = policy.act(&belief.belief, viewpoint.viewpoint(model)?).map_err(to_python)?;
    actions::to_python(py, action)
}
