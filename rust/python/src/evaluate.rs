//! `evaluate`.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use beltsort_core as core;
use beltsort_core::{EvaluationConfig, Policy, SortingModel, TrueClasses};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::ThreadPool;

use crate::budget::thread_pool;
use crate::convert::{self, Whole, count};
use crate::despot::PyDespot;
use crate::errors::{ArgumentError, to_python};
use crate::evaluation::PyEvaluation;
use crate::interrupt::{Stoppable, interruptible};
use crate::keywords;
use crate::look_ahead::PyLookAhead;
use crate::model::PySortingModel;
use crate::names::{Named, rows_of_classes};
use crate::one_object::PyOneObject;
use crate::policies::{PyInformationGain, PyThreshold};
use crate::solution::PySolution;
use crate::user_policy::UserPolicy;

/// What a policy may be.
const EXPECTED: &str = "Despot, LookAhead, Threshold, InformationGain, OneObject, or an object whose act(belief, viewpoint) \
                        returns beltsort.Move or beltsort.Decide";

/// Simulate batches of the sorting POMDP.
///
/// Randoms are indexed by (batch, object, look): every policy meets the same objects, and the n-th look at an
/// object draws on the same random. The result depends on neither `threads` nor the machine, unless the
/// policy does (a planner with a time budget does).
///
/// Parameters
/// ----------
/// model : SortingModel
///     Updates the belief, gives the rewards, and says whether a scan follows each decision. Such a scan
///     counts for `max_looks`, but is no step.
/// policy : Policy
///     `Despot`, `LookAhead`, `Threshold`, `InformationGain`, `OneObject`, or any object with a method
///     ``act(belief, viewpoint)`` that
///     returns a `Move` or a `Decide`. Such an object is asked from one thread, and its exceptions pass
///     through unchanged.
/// batches : int, default 1000
///     Number of batches. Standard errors shrink with its square root only.
/// batch_size : int, default 10
///     Decisions per batch; each batch starts from the arrival prior.
/// seed : int
///     Seed of classes and labels. A seed that a policy was tuned on flatters it.
/// threads : int, optional
///     Threads to use; all cores if missing. More than that gain nothing.
/// viewpoint : int or str
///     Where the camera stands when a batch starts.
/// true_classes : array_like of int or str, optional
///     A list of classes to draw from uniformly, or the class of every object, shape (batches, batch_size + H
///     - 1). The arrival prior of `truth` if missing.
/// truth : SortingModel, optional
///     Draws classes and labels, repeated ones by its own `repeat`; `model` if missing. Its H, K and L must
///     be those of `model`.
/// max_looks : int, default 60
///     An object looked at this often gets the decision with the largest expected reward. Too large, and a
///     policy that never decides never ends.
/// reference : Solution, optional
///     What the actions are held against: its upper bound, one exact step ahead, says what each of them loses
///     (`Evaluation.regrets`). For one or two positions, viewpoints that are all alike
///     (`Solution.values_actions`), and belts that never end.
/// belt_ends : bool
///     Whether the belt ends with the batch, and the beliefs that the policy is asked with tell how many
///     objects are left (`Belief.remaining`); `Despot`, `LookAhead` and `OneObject` take it into account.
///
/// Returns
/// -------
/// Evaluation
///     One outcome per batch.
///
/// Raises
/// ------
/// ArgumentError
///     For a count below 1, or an argument that does not fit the model.
/// PolicyError
///     If the policy names no legal action.
///
/// Examples
/// --------
/// >>> import beltsort
/// >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[1.0, 0.0], [0.0, 1.0]]]])
/// >>> result = beltsort.evaluate(model, beltsort.Threshold(model, 0.9), batches=3)
/// >>> result.correct
/// array([10, 10, 10], dtype=uint64)
/// >>> result.summary()["steps"]
/// {'mean': 20.0, 'standard_error': 0.0}
#[pyfunction]
#[pyo3(signature = (model, policy, *, batches=core::DEFAULT_BATCHES as Whole,
                    batch_size=core::DEFAULT_BATCH_SIZE as Whole, seed=0, threads=None, viewpoint=Named::Index(0),
                    true_classes=None, truth=None, max_looks=core::DEFAULT_MAX_LOOKS as Whole, reference=None, belt_ends=false,
                    **unknown),
       text_signature = "(model, policy, *, batches=..., batch_size=..., seed=0, threads=None, viewpoint=0, \
                         true_classes=None, truth=None, max_looks=..., reference=None, belt_ends=False)")]
#[allow(clippy::too_many_arguments)] // the public contract
pub fn evaluate(
    py: Python<'_>,
    model: &PySortingModel,
    policy: &Bound<'_, PyAny>,
    batches: Whole,
    batch_size: Whole,
    seed: Whole,
    threads: Option<Whole>,
    viewpoint: Named,
    true_classes: Option<&Bound<'_, PyAny>>,
    truth: Option<&PySortingModel>,
    max_looks: Whole,
    reference: Option<&PySolution>,
    belt_ends: bool,
    unknown: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyEvaluation> {
    keywords::refuse(unknown, "evaluate")?;
    let config = EvaluationConfig {
        batches: count("batches", batches)?,
        batch_size: count("batch_size", batch_size)?,
        seed: convert::seed(seed)?,
        belt_ends,
        viewpoint: viewpoint.viewpoint(&model.0)?,
        true_classes: true_classes.map_or(Ok(TrueClasses::Arrival), |value| classes(&model.0, value))?,
        max_looks: count("max_looks", max_looks)?,
        reference: reference.map(|reference| Arc::clone(&reference.solution)),
    };
    let truth = truth.unwrap_or(model);
    let drawn_from_model = truth.0 == model.0 && config.true_classes == TrueClasses::Arrival;
    let pool = threads.map(thread_pool).transpose()?;
    let run = |policy: &dyn Policy, pool: Option<&ThreadPool>| {
        let stop = AtomicBool::new(false);
        let evaluate = || core::evaluate(&model.0, &truth.0, &Stoppable { policy, stop: &stop }, &config);
        interruptible(py, &stop, || match pool {
            Some(pool) => pool.install(evaluate),
            None => evaluate(),
        })
    };
    let pool = pool.as_ref();
    let evaluation = if let Ok(despot) = policy.cast::<PyDespot>() {
        run(&despot.get().planner, pool)?.map_err(to_python)
    } else if let Ok(solution) = policy.cast::<PySolution>() {
        run(&*solution.get().solution, pool)?.map_err(to_python)
    } else if let Ok(threshold) = policy.cast::<PyThreshold>() {
        run(&threshold.get().policy, pool)?.map_err(to_python)
    } else if let Ok(gain) = policy.cast::<PyInformationGain>() {
        run(&gain.get().policy, pool)?.map_err(to_python)
    } else if let Ok(look_ahead) = policy.cast::<PyLookAhead>() {
        run(&look_ahead.get().policy, pool)?.map_err(to_python)
    } else if let Ok(one) = policy.cast::<PyOneObject>() {
        run(&one.get().policy, pool)?.map_err(to_python)
    } else {
        let user = UserPolicy::new(policy, &model.0, EXPECTED)?;
        // A user's policy may keep state: its batches run one after the other.
        run(&user, Some(&thread_pool(1)?))?.map_err(|error| user.raised().unwrap_or_else(|| to_python(error)))
    }?;
    let with_bonuses = model.0.spec().information_gain > 0.0;
    let (bins, classes) = (model.0.bin_count(), model.0.class_count());
    Ok(PyEvaluation { evaluation, bins, classes, drawn_from_model, with_bonuses })
}

/// A list of classes to draw from, or an array with a row per batch.
fn classes(model: &SortingModel, value: &Bound<'_, PyAny>) -> PyResult<TrueClasses> {
    if let Ok(classes) = value.extract::<Vec<Named>>() {
        let classes = classes.iter().map(|class| class.class(model)).collect::<PyResult<_>>()?;
        return Ok(TrueClasses::UniformlyFrom(classes));
    }
    if let Some(rows) = rows_of_classes(model, value)? {
        return Ok(TrueClasses::Given(rows));
    }
    convert::classes("true_classes", value).map(TrueClasses::Given).map_err(|reason| {
        ArgumentError::new_err(format!(
            "{reason}; true_classes is a list of labels to draw from, or labels of shape \
             (batches, batch_size + H - 1)"
        ))
    })
}
