//! `SortingModel`: constructor, files, changed models. What the model consists of is in `parts`.

mod parts;

use std::path::PathBuf;
use std::sync::Arc;

use beltsort_core::{DEFAULT_DISCOUNT, DEFAULT_R_MAX, DEFAULT_R_MIN, ModelSpec, SortingModel};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{self, Given, Whole, count, scalar_or_matrix, tables};
use crate::display::{displayed, immutable};
use crate::errors::{ModelError, to_python};
use crate::keywords;

#[doc = include_str!("model.txt")]
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]], r_min=20)
/// >>> model.p_obs.shape
/// (1, 1, 2, 2)
/// >>> beltsort.SortingModel.from_json(model.to_json()) == model
/// True
#[pyclass(frozen, eq, name = "SortingModel", module = "beltsort")]
#[derive(Clone, PartialEq)]
pub struct PySortingModel(pub Arc<SortingModel>);

impl PySortingModel {
    fn checked(spec: ModelSpec) -> PyResult<Self> {
        Ok(Self(Arc::new(SortingModel::new(spec).map_err(to_python)?)))
    }
}

fn optional<T>(key: &str, value: Option<Given<T>>) -> PyResult<Option<T>> {
    value.map(|value| value.of(key)).transpose()
}

#[pymethods]
impl PySortingModel {
    #[new]
    #[pyo3(signature = (classes, viewpoints, p_obs, *, labels=None, bins=None, reward=None, modes=None,
                        r_max=None, r_min=None, motion_cost=None, discount=Given::Right(DEFAULT_DISCOUNT), arrival=None, travel=None, observe_after_decision=Given::Right(false), repeat=None,
                        information_gain=Given::Right(0.0), empty=None, label_rule=None, counts=None, smoothing=None, note=Given::Right(String::new()),
                        **unknown),
           text_signature = "(classes, viewpoints, p_obs, *, labels=None, bins=None, reward=None, modes=None, r_max=None, \
                             r_min=None, motion_cost=None, discount=..., arrival=None, travel=None, \
                             observe_after_decision=..., repeat=None, information_gain=..., empty=None, label_rule=None, \
                             counts=None, smoothing=None, note=...)")]
    #[allow(clippy::too_many_arguments)] // the keys of a model file
    fn new(
        classes: Given<Vec<String>>,
        viewpoints: Given<Vec<String>>,
        p_obs: &Bound<'_, PyAny>,
        labels: Option<Given<Vec<String>>>,
        bins: Option<Given<Vec<String>>>,
        reward: Option<&Bound<'_, PyAny>>,
        modes: Option<Given<Vec<Vec<f64>>>>,
        r_max: Option<Given<f64>>,
        r_min: Option<Given<f64>>,
        motion_cost: Option<&Bound<'_, PyAny>>,
        discount: Given<f64>,
        arrival: Option<Given<Vec<f64>>>,
        travel: Option<Given<Vec<Vec<Whole>>>>,
        observe_after_decision: Given<bool>,
        repeat: Option<&Bound<'_, PyAny>>,
        information_gain: Given<f64>,
        empty: Option<Given<String>>,
        label_rule: Option<Given<Bound<'_, PyDict>>>,
        counts: Option<&Bound<'_, PyAny>>,
        smoothing: Option<&Bound<'_, PyAny>>,
        note: Given<String>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        keywords::refuse(unknown, "SortingModel")?;
        let mut spec =
            ModelSpec::new(classes.of("classes")?, viewpoints.of("viewpoints")?, tables("p_obs", p_obs)?);
        let (r_max, r_min) = (optional("r_max", r_max)?, optional("r_min", r_min)?);
        if let Some(cost) = motion_cost {
            spec.motion_cost = scalar_or_matrix("motion_cost", cost)?;
        }
        if let (Some(_), Some((key, value))) =
            (reward, r_max.map(|r| ("r_max", r)).or(r_min.map(|r| ("r_min", r))))
        {
            return Err(ModelError::new_err(format!(
                "reward and {key} = {value} are both given, but reward says what every class is worth in every bin; leave \
                 {key} out"
            )));
        }
        spec.labels = optional("labels", labels)?;
        spec.bins = optional("bins", bins)?;
        spec.reward =
            reward.map(|value| convert::rows("reward", value)).transpose().map_err(ModelError::new_err)?;
        spec.modes = optional("modes", modes)?;
        spec.r_max = r_max.unwrap_or(DEFAULT_R_MAX);
        spec.r_min = r_min.unwrap_or(DEFAULT_R_MIN);
        spec.discount = discount.of("discount")?;
        spec.arrival = optional("arrival", arrival)?;
        spec.travel = optional("travel", travel)?.map(convert::travel).transpose()?;
        spec.observe_after_decision = observe_after_decision.of("observe_after_decision")?;
        spec.repeat = repeat.map(|value| scalar_or_matrix("repeat", value)).transpose()?;
        spec.information_gain = information_gain.of("information_gain")?;
        spec.empty = optional("empty", empty)?;
        spec.label_rule = optional("label_rule", label_rule)?.as_ref().map(convert::json).transpose()?;
        spec.counts = counts.map(convert::counts).transpose()?;
        spec.smoothing = smoothing.map(convert::smoothing).transpose()?;
        spec.note = note.of("note")?;
        Self::checked(spec)
    }

    /// Read a model file.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     A JSON file with the constructor's parameters as keys.
    ///
    /// Returns
    /// -------
    /// SortingModel
    ///     The model.
    ///
    /// Raises
    /// ------
    /// ModelError
    ///     If the file cannot be read, is not JSON, has an unknown key, lacks one, or holds no sorting model.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Self::checked(ModelSpec::load(&path).map_err(to_python)?)
    }

    /// Read the text of a model file.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     JSON.
    ///
    /// Returns
    /// -------
    /// SortingModel
    ///     The model.
    ///
    /// Raises
    /// ------
    /// ModelError
    ///     As `load`.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        Self::checked(ModelSpec::from_json(text).map_err(to_python)?)
    }

    /// Return the model file as text, JSON.
    fn to_json(&self) -> PyResult<String> {
        self.0.spec().to_json().map_err(to_python)
    }

    /// Write a model file; `load` gives an equal model back.
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
        self.0.spec().save(&path).map_err(to_python)
    }

    /// Write the model as a flat POMDP in Cassandra's format, which other solvers read.
    ///
    /// A state is the class (with its mode) at every position, with the viewpoint in front unless all
    /// viewpoints are alike in legal moves and their costs and no scan follows a decision: N^H or K N^H
    /// states. The actions are the K moves and B decisions; the observations are the Z^H label vectors, and
    /// ``nothing`` after a decision that no scan follows. Such a file has no forbidden actions: a move that
    /// `travel` forbids costs (r_max + r_min) / (1 - discount), so that it never pays. The camera starts at
    /// viewpoint 0.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     Where to write; an existing file is replaced.
    ///
    /// Raises
    /// ------
    /// ModelError
    ///     For more than two million pairs of state and observation, for `repeat` or `information_gain` above
    ///     0 (such states hold no labels, such rewards no beliefs), or if the file cannot be written.
    ///
    /// References
    /// ----------
    /// Cassandra, "POMDP file format", http://www.pomdp.org/code/pomdp-file-spec.html
    fn to_pomdp(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.0.to_pomdp(&path)).map_err(to_python)
    }

    /// Return the same model with the first belt positions only.
    ///
    /// Parameters
    /// ----------
    /// positions : int
    ///     How many to keep, 1 to H.
    ///
    /// Returns
    /// -------
    /// SortingModel
    ///     The smaller model.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For less than 1 or more than H.
    fn with_positions(&self, positions: Whole) -> PyResult<Self> {
        let positions = count("positions", positions)?;
        Ok(Self(Arc::new(self.0.with_positions(positions).map_err(to_python)?)))
    }

    /// Return the same model with other settings.
    ///
    /// Parameters
    /// ----------
    /// **changes
    ///     Parameters of the constructor. A new `p_obs` comes without the `counts` and `smoothing` of the old
    ///     one unless they are given too.
    ///
    /// Returns
    /// -------
    /// SortingModel
    ///     The changed model.
    ///
    /// Raises
    /// ------
    /// TypeError
    ///     For a parameter that the constructor does not have.
    /// ModelError
    ///     As the constructor.
    ///
    /// Examples
    /// --------
    /// >>> from beltsort.models import paper
    /// >>> paper().replace(r_min=500).r_min
    /// 500.0
    #[pyo3(signature = (**changes))]
    fn replace<'py>(
        &self,
        py: Python<'py>,
        changes: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let settings = py.import("json")?.call_method1("loads", (self.to_json()?,))?.cast_into::<PyDict>()?;
        if let Some(changes) = changes {
            if changes.contains("p_obs")? {
                settings.call_method1("pop", ("counts", py.None()))?;
                settings.call_method1("pop", ("smoothing", py.None()))?;
            }
            settings.update(changes.as_mapping())?;
        }
        py.get_type::<Self>().call((), Some(&settings))
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (String,))> {
        let from_json = py.get_type::<Self>().getattr("from_json")?.unbind();
        Ok((from_json, (self.to_json()?,)))
    }
}

displayed!(PySortingModel);
immutable!(PySortingModel);
