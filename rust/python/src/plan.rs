//! `Plan`.

use std::sync::Arc;

use beltsort_core::{Plan, SortingModel};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::actions;
use crate::convert::{Whole, from_json, to_json};
use crate::display::{displayed, immutable};
use crate::errors::ArgumentError;
use crate::model::PySortingModel;
use crate::plan_tree;

/// What a search found. Values are expected discounted rewards, in the unit of `r_max` and `r_min`.
///
/// `values` are estimates: the search's lower bound, plus what the default policy is expected to fall short
/// of the best one by wherever the search has not looked. The action is chosen by them. `lower` and `upper`
/// bound the search's own problem, and its `upper` may lie below the estimates; `certified_lower` and
/// `certified_upper` bound the optimal value of the model itself. Of DESPOT as published (variant
/// "scenarios") `values` are lower bounds in the sampled, regularised problem.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> plan = beltsort.Despot(model, trials=10).plan(beltsort.Belief(model))
/// >>> plan.lower < plan.values[plan.action] < plan.upper
/// True
/// >>> [action["action"] for action in plan.tree(depth=1)["actions"]]
/// [{'decide': 0}, {'move': 0}]
#[pyclass(frozen, name = "Plan", module = "beltsort")]
pub struct PyPlan {
    pub plan: Plan,
    pub model: Arc<SortingModel>,
}

#[pymethods]
impl PyPlan {
    /// The action to take, `Move` or `Decide`.
    #[getter]
    fn action(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        actions::to_python(py, self.plan.action)
    }

    /// Estimated value of every legal action: dict of `Move` or `Decide` to float.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = PyDict::new(py);
        for (action, value) in &self.plan.values {
            values.set_item(actions::to_python(py, *action)?, value)?;
        }
        Ok(values)
    }

    /// Lower bound of the optimum of the search's own (sampled, regularised) problem.
    #[getter]
    fn lower(&self) -> f64 {
        self.plan.lower
    }

    /// Upper bound of the same optimum.
    #[getter]
    fn upper(&self) -> f64 {
        self.plan.upper
    }

    /// Lower bound of V*, the optimal value of the model itself, or None.
    ///
    /// It is what a policy that can be executed earns from here; None if the model repeats looks, and of
    /// DESPOT as published.
    #[getter]
    fn certified_lower(&self) -> Option<f64> {
        self.plan.certified_lower
    }

    /// Upper bound of V*.
    #[getter]
    fn certified_upper(&self) -> f64 {
        self.plan.certified_upper
    }

    /// Trials done; fewer than allowed if the sampled problem was solved before.
    #[getter]
    fn trials(&self) -> u64 {
        self.plan.trials
    }

    /// Wall-clock time spent, in seconds.
    #[getter]
    fn seconds(&self) -> f64 {
        self.plan.elapsed.as_secs_f64()
    }

    /// (scenario, move) pairs simulated at expanded nodes.
    #[getter]
    fn scenario_steps(&self) -> u64 {
        self.plan.scenario_steps
    }

    /// Belief nodes whose actions were all generated.
    #[getter]
    fn expansions(&self) -> u64 {
        self.plan.expansions
    }

    /// Belief nodes created.
    #[getter]
    fn nodes(&self) -> u64 {
        self.plan.nodes
    }

    /// Return the searched tree as plain data, ready for JSON: why the action was chosen.
    ///
    /// Parameters
    /// ----------
    /// depth : int
    ///     Planner steps below the root, 0 to 1000. With K moves and H positions, every step multiplies the
    ///     tree by up to K L^H.
    ///
    /// Returns
    /// -------
    /// dict
    ///     A belief of the tree: `viewpoint`; `belief`, H lists of L probabilities; `value`, `lower` and
    ///     `upper` as seen from there; `scenarios` that come there, None where the search has not been; and
    ///     `actions`, a list that is empty where the search has not been and at the last step asked for. Each
    ///     is a dict of `action` (``{"move": viewpoint}`` or ``{"decide": label}``; of all decisions the best
    ///     one stands for all), `value`, `lower`, `upper` and `branches`, the likeliest first. Each of these
    ///     is a dict of `probability`, `labels` (one per position, or None without a scan) and `node`, the
    ///     belief after it; labels that no scenario gives are missing.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a depth below 0 or above 1000, or a plan of `Despot(variant="scenarios")`, which keeps no
    ///     tree.
    #[pyo3(signature = (depth=plan_tree::DEFAULT_DEPTH as Whole))]
    fn tree<'py>(&self, py: Python<'py>, depth: Whole) -> PyResult<Bound<'py, PyDict>> {
        let tree = self.plan.tree(plan_tree::depth(depth)?).ok_or_else(|| {
            ArgumentError::new_err(
                "DESPOT as published keeps no tree, nor does a plan that was pickled; plan anew with \
                 variant=\"beliefs\" to see one",
            )
        })?;
        plan_tree::to_python(py, &tree)
    }

    /// The model planned for.
    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }

    /// All but the tree, whose nodes are many and belong to the search.
    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (PySortingModel, String))> {
        let restored = py.get_type::<Self>().getattr("_restored")?.unbind();
        Ok((restored, (self.model(), to_json(&self.plan)?)))
    }

    #[staticmethod]
    fn _restored(model: &PySortingModel, plan: &str) -> PyResult<Self> {
        Ok(Self { plan: from_json(plan)?, model: Arc::clone(&model.0) })
    }
}

displayed!(PyPlan);
immutable!(PyPlan);
