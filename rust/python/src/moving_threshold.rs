//! `MovingThreshold`.

use std::sync::Arc;

use beltsort_core::{LookRule, MovingBelt, MovingPolicy, MovingThreshold};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::display::immutable;
use crate::errors::{ArgumentError, to_python};
use crate::keywords;
use crate::moving_actions;
use crate::moving_belief::PyMovingBelief;
use crate::moving_belt::PyMovingBelt;
use crate::names::Named;

const RULES: [(&str, LookRule); 2] =
    [("most-urgent", LookRule::MostUrgent), ("information-per-tick", LookRule::InformationPerTick)];

/// Decide an object once the best decision is likely enough to be right, or at its last chance.
///
/// The threshold falls linearly from the entry of the last place to the exit: optimal thresholds fall towards
/// a deadline where all places see alike. At its last chance, when it would pass the exit during the next
/// look and the decisions in front of it, an object is decided if that is worth more than missing it. On a
/// belt that advances on decisions the threshold is `high`.
///
/// Parameters
/// ----------
/// belt : MovingBelt
///     Model, durations and prices.
/// high : float
///     Threshold at the entry, above 0 and at most 1.
/// low : float, optional
///     Threshold at the exit, not above `high`; the same if missing.
/// rule : {"most-urgent", "information-per-tick"}, default "most-urgent"
///     Look from where most is learnt about the undecided object nearest to the exit, or from where most is
///     learnt per tick about all undecided objects.
///
/// Raises
/// ------
/// ArgumentError
///     For thresholds out of range, or another rule.
///
/// References
/// ----------
/// Frazier & Yu, "Sequential hypothesis testing under stochastic deadlines", NIPS 2007.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
/// >>> policy = beltsort.MovingThreshold(belt, 0.9)
/// >>> policy.act(belt.belief(), 0)
/// Move(viewpoint=0)
/// >>> policy.act(beltsort.MovingBelief(belt, kinds=[[0.05, 0.95]]), 0)
/// DecideAt(position=0, label=1)
#[pyclass(frozen, name = "MovingThreshold", module = "beltsort")]
pub struct PyMovingThreshold {
    pub policy: MovingThreshold,
    belt: Arc<MovingBelt>,
    high: f64,
    low: f64,
    rule: &'static str,
}

#[pymethods]
impl PyMovingThreshold {
    #[new]
    #[pyo3(signature = (belt, high=None, low=None, rule="most-urgent", **unknown),
           text_signature = "(belt, high, low=None, rule='most-urgent')")]
    fn new(
        belt: &PyMovingBelt,
        high: Option<f64>,
        low: Option<f64>,
        rule: &str,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        keywords::refuse(unknown, "MovingThreshold")?;
        let high = keywords::required(high, "MovingThreshold", "high")?;
        let low = low.unwrap_or(high);
        let Some((rule, found)) = RULES.into_iter().find(|(name, _)| *name == rule) else {
            return Err(ArgumentError::new_err(format!(
                "rule = {rule:?}, expected \"most-urgent\" or \"information-per-tick\": which look comes next"
            )));
        };
        let policy = MovingThreshold::new(&belt.0, high, low, found).map_err(to_python)?;
        Ok(Self { policy, belt: Arc::clone(&belt.0), high, low, rule })
    }

    /// Decide at the threshold or the last chance, look or wait otherwise.
    ///
    /// Parameters
    /// ----------
    /// belief : MovingBelief
    ///     What is known of the objects; made for the policy's belt, or an equal one.
    /// viewpoint : int or str
    ///     Where the camera stands: index or name.
    ///
    /// Returns
    /// -------
    /// Move, Wait or DecideAt
    ///     The action.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a belief of another belt or an unknown viewpoint.
    fn act(&self, py: Python<'_>, belief: PyMovingBelief, viewpoint: Named) -> PyResult<Py<PyAny>> {
        belief.check_is_of(&self.belt)?;
        let viewpoint = viewpoint.viewpoint(self.belt.model())?;
        moving_actions::to_python(py, self.policy.act(&belief.belief, viewpoint).map_err(to_python)?)
    }

    /// The belt that the policy was made for.
    #[getter]
    fn belt(&self) -> PyMovingBelt {
        PyMovingBelt(Arc::clone(&self.belt))
    }

    /// What the policy was made with, as keywords of the constructor: high, low, rule.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let settings = PyDict::new(py);
        settings.set_item("high", self.high)?;
        settings.set_item("low", self.low)?;
        settings.set_item("rule", self.rule)?;
        Ok(settings)
    }

    fn __repr__(&self) -> String {
        format!("MovingThreshold(high={}, low={}, rule={:?})", self.high, self.low, self.rule)
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((PyMovingBelt,), Bound<'py, PyDict>)> {
        Ok(((self.belt(),), self.settings(py)?))
    }
}

immutable!(PyMovingThreshold);
