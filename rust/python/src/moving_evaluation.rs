//! `evaluate_moving` and `MovingEvaluation`.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use beltsort_core as core;
use beltsort_core::{
    DEFAULT_MOVING_OBJECTS, DEFAULT_RUNS, MovingBelt, MovingOutcome, MovingPolicy, MovingRuns,
};
use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::ThreadPool;

use crate::budget::thread_pool;
use crate::convert::{self, Whole, count, from_json, to_json};
use crate::display::immutable;
use crate::errors::to_python;
use crate::interrupt::{Stoppable, interruptible};
use crate::keywords;
use crate::moving_belt::PyMovingBelt;
use crate::moving_planner::PyMovingPlanner;
use crate::moving_threshold::PyMovingThreshold;
use crate::names::Named;
use crate::user_policy::UserPolicy;

/// What a policy may be.
const EXPECTED: &str = "MovingPlanner, MovingThreshold, or an object whose act(belief, viewpoint) returns beltsort.Move, \
                        beltsort.Wait or beltsort.DecideAt";

/// Outcomes of simulated runs of a moving belt: arrays of shape (runs,), in the order of the runs.
///
/// Two policies that were evaluated with the same seed met the same objects: compare them run by run.
#[pyclass(frozen, name = "MovingEvaluation", module = "beltsort")]
pub struct PyMovingEvaluation {
    outcomes: Vec<MovingOutcome>,
    belt: Arc<MovingBelt>,
    objects: usize,
}

impl PyMovingEvaluation {
    fn counts<'py>(&self, py: Python<'py>, of: impl Fn(&MovingOutcome) -> u64) -> Bound<'py, PyArray1<u64>> {
        self.outcomes.iter().map(of).collect::<Vec<_>>().into_pyarray(py)
    }
}

#[pymethods]
impl PyMovingEvaluation {
    /// The belt that was simulated.
    #[getter]
    fn belt(&self) -> PyMovingBelt {
        PyMovingBelt(Arc::clone(&self.belt))
    }

    /// Objects of each run.
    #[getter]
    fn objects(&self) -> usize {
        self.objects
    }

    /// Ticks until the action ended in which the last object was decided or passed the exit; uint64.
    #[getter]
    fn ticks<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.counts(py, |run| run.ticks)
    }

    /// Looks at undecided objects; uint64. A scan of two of them counts twice.
    #[getter]
    fn looks<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.counts(py, |run| run.looks)
    }

    /// Right decisions, into a bin than which none is worth more for the object's class; uint64.
    #[getter]
    fn right<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.counts(py, |run| run.right)
    }

    /// Other decisions; uint64.
    #[getter]
    fn wrong<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.counts(py, |run| run.wrong)
    }

    /// Objects that passed the exit undecided, by true class; uint64 of shape (runs, L).
    #[getter]
    fn missed<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u64>> {
        let shape = (self.outcomes.len(), self.belt.model().class_count());
        Array2::from_shape_fn(shape, |(run, class)| self.outcomes[run].missed[class]).into_pyarray(py)
    }

    /// Decided objects by bin and true class, uint64 of shape (runs, B, L), ``[run, bin, class]``.
    #[getter]
    fn confusion<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<u64>> {
        let (bins, classes) = (self.belt.model().bin_count(), self.belt.model().class_count());
        let entry =
            |(run, bin, class): (usize, usize, usize)| self.outcomes[run].confusion[bin * classes + class];
        Array3::from_shape_fn((self.outcomes.len(), bins, classes), entry).into_pyarray(py)
    }

    /// Sum of rewards; float64.
    #[getter]
    fn returns<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.outcomes.iter().map(|run| run.total).collect::<Vec<_>>().into_pyarray(py)
    }

    /// Sum of rewards, each times `discount` to the power of its tick; float64.
    #[getter]
    fn discounted_returns<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.outcomes.iter().map(|run| run.discounted).collect::<Vec<_>>().into_pyarray(py)
    }

    /// Return estimates over the runs, each with its standard error.
    ///
    /// Returns
    /// -------
    /// planning.moving.MovingStatistics
    ///     Reward per object, discounted return, shares of right, wrong and missed objects, purity and
    ///     recovery per bin, looks per object, ticks, and objects per minute.
    fn statistics<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("beltsort.planning.moving")?.call_method1("moving_statistics", (slf,))
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        Self::statistics(slf)?.str()?.extract()
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (String, PyMovingBelt, usize))> {
        let restored = py.get_type::<Self>().getattr("_restored")?.unbind();
        Ok((restored, (to_json(&self.outcomes)?, self.belt(), self.objects)))
    }

    #[staticmethod]
    fn _restored(outcomes: &str, belt: &PyMovingBelt, objects: usize) -> PyResult<Self> {
        Ok(Self { outcomes: from_json(outcomes)?, belt: Arc::clone(&belt.0), objects })
    }
}

immutable!(PyMovingEvaluation);

/// Simulate runs of a moving belt.
///
/// Randoms are indexed by (run, object, look): every policy meets the same objects, and the n-th look at an
/// object draws on the same random. A run starts with a belt full of unseen objects that has just advanced,
/// and ends once its last object is decided or has passed the exit.
///
/// Parameters
/// ----------
/// belt : MovingBelt
///     Draws classes and labels, updates the belief, and gives rewards and durations.
/// policy : MovingPolicy
///     `MovingPlanner`, `MovingThreshold`, or any object with a method ``act(belief, viewpoint)`` that
///     returns a `Move`, a `Wait` or a `DecideAt`. Such an object is asked from one thread, and its
///     exceptions pass through unchanged.
/// objects : int, default 50
///     Objects of a run.
/// runs : int, default 100
///     Number of runs. Standard errors shrink with its square root only.
/// seed : int
///     Seed of classes and labels. A seed that a policy was tuned on flatters it.
/// threads : int, optional
///     Threads to use; all cores if missing.
/// viewpoint : int or str
///     Where the camera stands when a run starts.
///
/// Returns
/// -------
/// MovingEvaluation
///     One outcome per run.
///
/// Raises
/// ------
/// ArgumentError
///     For a count below 1, or a viewpoint that does not exist.
/// PolicyError
///     If the policy names no legal action, or decides nothing for 10,000 ticks on a belt that waits for it.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[1.0, 0.0], [0.0, 1.0]]]])
/// >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
/// >>> result = beltsort.evaluate_moving(belt, beltsort.MovingThreshold(belt, 0.9), objects=10, runs=3)
/// >>> result.right
/// array([10, 10, 10], dtype=uint64)
/// >>> print(result.statistics().looks_per_object)
/// 1.000 ± 0.000
#[pyfunction]
#[pyo3(signature = (belt, policy, *, objects=DEFAULT_MOVING_OBJECTS as Whole, runs=DEFAULT_RUNS as Whole, seed=0,
                    threads=None, viewpoint=Named::Index(0), **unknown),
       text_signature = "(belt, policy, *, objects=..., runs=..., seed=0, threads=None, viewpoint=0)")]
#[allow(clippy::too_many_arguments)] // the public contract
pub fn evaluate_moving(
    py: Python<'_>,
    belt: &PyMovingBelt,
    policy: &Bound<'_, PyAny>,
    objects: Whole,
    runs: Whole,
    seed: Whole,
    threads: Option<Whole>,
    viewpoint: Named,
    unknown: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyMovingEvaluation> {
    keywords::refuse(unknown, "evaluate_moving")?;
    let config = MovingRuns {
        runs: count("runs", runs)?,
        objects: count("objects", objects)?,
        seed: convert::seed(seed)?,
        viewpoint: viewpoint.viewpoint(belt.0.model())?,
    };
    let pool = threads.map(thread_pool).transpose()?;
    let run = |policy: &dyn MovingPolicy, pool: Option<&ThreadPool>| {
        let stop = AtomicBool::new(false);
        let evaluate = || core::evaluate_moving(&belt.0, &Stoppable { policy, stop: &stop }, &config);
        interruptible(py, &stop, || match pool {
            Some(pool) => pool.install(evaluate),
            None => evaluate(),
        })
    };
    let outcomes = if let Ok(planner) = policy.cast::<PyMovingPlanner>() {
        run(&planner.get().policy, pool.as_ref())?.map_err(to_python)
    } else if let Ok(threshold) = policy.cast::<PyMovingThreshold>() {
        run(&threshold.get().policy, pool.as_ref())?.map_err(to_python)
    } else {
        let user = UserPolicy::new(policy, &belt.0, EXPECTED)?;
        // A user's policy may keep state: its runs are made one after the other.
        run(&user, Some(&thread_pool(1)?))?.map_err(|error| user.raised().unwrap_or_else(|| to_python(error)))
    }?;
    Ok(PyMovingEvaluation { outcomes, belt: Arc::clone(&belt.0), objects: config.objects })
}
