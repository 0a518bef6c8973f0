//! `solve` and `Solution`.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use beltsort_core::{DEFAULT_SOLVE_SECONDS, Policy, Solution, SortingModel};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::actions;
use crate::belief::PyBelief;
use crate::budget::time;
use crate::display::{displayed, immutable};
use crate::errors::to_python;
use crate::interrupt::interruptible_by;
use crate::keywords;
use crate::model::PySortingModel;
use crate::names::Named;

/// Certified bounds of the optimal value, and a policy: what `solve` returns.
///
/// References
/// ----------
/// Upper bound: value iteration on a grid of beliefs, convex in the belief about each object (Lovejoy,
/// Operations Research 39, 1991). Search and lower bound: a graph of the beliefs reached, whose policy is
/// valued exactly, as finite-state controllers are (Hansen, UAI 1998).
#[pyclass(frozen, name = "Solution", module = "beltsort")]
pub struct PySolution {
    pub solution: Arc<Solution>,
    pub model: Arc<SortingModel>,
}

impl PySolution {
    fn new(solution: Solution) -> Self {
        let model = Arc::new(solution.model().clone());
        Self { solution: Arc::new(solution), model }
    }
}

#[pymethods]
impl PySolution {
    /// Lower bound of V*(b0), the value of an executable policy; b0 is the arrival prior everywhere.
    #[getter]
    fn lower(&self) -> f64 {
        self.solution.lower
    }

    /// Upper bound of V*(b0).
    #[getter]
    fn upper(&self) -> f64 {
        self.solution.upper
    }

    /// Wall-clock time spent, seconds.
    #[getter]
    fn seconds(&self) -> f64 {
        self.solution.elapsed.as_secs_f64()
    }

    /// The model solved.
    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }

    /// Whether it tells what single actions lose, as `evaluate` needs of a reference.
    ///
    /// It does for one or two positions whose viewpoints all have the same moves at the same costs.
    #[getter]
    fn values_actions(&self) -> bool {
        self.solution.values_actions()
    }

    /// Check that this is a solution of a model; remarks and label counts may differ.
    ///
    /// Parameters
    /// ----------
    /// model : SortingModel
    ///     The model.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     If it solves another model; the first difference is named.
    fn check_solves(&self, model: &PySortingModel) -> PyResult<()> {
        self.solution.check_solves(&model.0).map_err(to_python)
    }

    /// Return bounds of V* at any belief.
    ///
    /// At the arrival prior they are those of the search, elsewhere wider.
    ///
    /// Parameters
    /// ----------
    /// belief : Belief
    ///     What is known of the objects.
    /// viewpoint : int or str
    ///     Where the camera stands: index or name.
    ///
    /// Returns
    /// -------
    /// tuple of float
    ///     Lower and upper bound.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a belief of another model or an unknown viewpoint.
    #[pyo3(signature = (belief, viewpoint=Named::Index(0)), text_signature = "($self, belief, viewpoint=0)")]
    fn bounds(&self, belief: PyBelief, viewpoint: Named) -> PyResult<(f64, f64)> {
        belief.check_is_of(&self.model)?;
        self.solution.bounds(&belief.belief, viewpoint.viewpoint(&self.model)?).map_err(to_python)
    }

    /// Return the action that is best one exact step ahead of the upper bound: a solution is a policy.
    ///
    /// Parameters
    /// ----------
    /// belief : Belief
    ///     What is known of the objects.
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
        belief.check_is_of(&self.model)?;
        let viewpoint = viewpoint.viewpoint(&self.model)?;
        let action = py.detach(|| self.solution.act(&belief.belief, viewpoint)).map_err(to_python)?;
        actions::to_python(py, action)
    }

    /// Write the solution to disk, up to 40 MB; `load` reads it.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     Where to write; an existing file is replaced as a whole or not at all.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     If the file cannot be written.
    ///
    /// Examples
    /// --------
    /// >>> import beltsort, pathlib, tempfile
    /// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    /// >>> path = pathlib.Path(tempfile.mkdtemp()) / "nuts.solution"
    /// >>> beltsort.solve(model, seconds=0.2).save(path)
    /// >>> beltsort.Solution.load(path, model).act(beltsort.Belief(model), 0)
    /// Move(viewpoint=0)
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.solution.save(&path)).map_err(to_python)
    }

    /// Read a solution from disk; it answers like the one that was saved.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     A file written by `save`, or by ``beltsort solve MODEL -o FILE``.
    /// model : SortingModel, optional
    ///     The model that it has to be a solution of; remarks and label counts may differ.
    ///
    /// Returns
    /// -------
    /// Solution
    ///     The solution.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     If the file cannot be read, is damaged or of another version, or solves another model than the one
    ///     given; the first difference is named.
    #[staticmethod]
    #[pyo3(signature = (path, model=None))]
    fn load(py: Python<'_>, path: PathBuf, model: Option<&PySortingModel>) -> PyResult<Self> {
        let given = model.map(|model| &*model.0);
        let solution = py.detach(|| Solution::load(&path, given)).map_err(to_python)?;
        Ok(Self::new(solution))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let restored = py.get_type::<Self>().getattr("_restored")?;
        let content = py.detach(|| self.solution.to_bytes()).map_err(to_python)?;
        Ok((restored, (PyBytes::new(py, &content),)))
    }

    #[staticmethod]
    fn _restored(py: Python<'_>, content: &[u8]) -> PyResult<Self> {
        py.detach(|| Solution::from_bytes(content)).map(Self::new).map_err(to_python)
    }
}

displayed!(PySolution);
immutable!(PySolution);

/// Solve a model offline, with a certificate: ``lower <= V*(b0) <= upper``.
///
/// Both bounds hold whenever it ends. They are tight for one or two positions when all viewpoints have the
/// same moves at the same costs. For other models, of any size, the upper bound is a Lagrangian relaxation:
/// each position has a camera of its own, and prices make them agree. The lower bound is then what following
/// one-object plans earns, which may be far below.
///
/// Parameters
/// ----------
/// model : SortingModel
///     The paper's, without `repeat`, `observe_after_decision` and `information_gain`. Where a scan has more
///     than 4096 label vectors (L^H), they are not searched.
/// seconds : float, default 60
///     Wall-clock time; more brings the bounds together. It ends earlier once they meet, and on Ctrl-C with
///     KeyboardInterrupt.
/// progress : callable, optional
///     Called with the bounds ``(lower, upper)`` so far, from another thread. What it raises ends the solver
///     and passes through.
/// stop : callable, optional
///     Called without arguments some twenty times a second; once it returns true, the solver ends and returns
///     what it has: both bounds hold. What it raises passes through.
///
/// Returns
/// -------
/// Solution
///     The bounds, and a policy.
///
/// Raises
/// ------
/// ArgumentError
///     For a time that is not above 0.
/// ModelError
///     For a model beyond the paper's.
///
/// References
/// ----------
/// Adelman & Mersereau, "Relaxations of weakly coupled stochastic dynamic programs", Operations Research 56,
/// 2008.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
/// >>> solution = beltsort.solve(model, seconds=5)
/// >>> f"{solution.lower:.2f} {solution.upper:.2f}"
/// '15.77 15.77'
#[pyfunction]
#[pyo3(signature = (model, *, seconds=DEFAULT_SOLVE_SECONDS, progress=None, stop=None, **unknown),
       text_signature = "(model, *, seconds=..., progress=None, stop=None)")]
pub fn solve(
    py: Python<'_>,
    model: &PySortingModel,
    seconds: f64,
    progress: Option<Py<PyAny>>,
    stop: Option<Py<PyAny>>,
    unknown: Option<&Bound<'_, PyDict>>,
) -> PyResult<PySolution> {
    keywords::refuse(unknown, "solve")?;
    let time = time(seconds)?;
    let asked = stop;
    let stop = AtomicBool::new(false);
    let raised = Mutex::new(None);
    let mut report = |lower: f64, upper: f64| {
        let Some(progress) = &progress else { return };
        if let Err(error) = Python::attach(|py| progress.call1(py, (lower, upper)).map(drop)) {
            stop.store(true, Ordering::Relaxed);
            if let Ok(mut raised) = raised.lock() {
                *raised = Some(error);
            }
        }
    };
    let poll = |py: Python<'_>| asked.as_ref().map_or(Ok(false), |asked| asked.call0(py)?.is_truthy(py));
    let solution = interruptible_by(py, &stop, poll, || Solution::solve(&model.0, time, &stop, &mut report))?;
    if let Some(error) = raised.into_inner().ok().flatten() {
        return Err(error);
    }
    let solution = Arc::new(solution.map_err(to_python)?);
    Ok(PySolution { solution, model: Arc::clone(&model.0) })
}
