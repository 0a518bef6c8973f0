//! What planning may cost: time or trials, and threads.

use std::panic::resume_unwind;
use std::thread;
use std::time::Duration;

use beltsort_core::Budget;
use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::convert::Whole;
use crate::errors::ArgumentError;

/// The budget of a planner that was given none.
pub const DEFAULT: Budget = Budget::Time(Duration::from_millis(10));

/// Plans up to here end before anyone could wish to interrupt them.
const SHORT: Duration = Duration::from_millis(100);
const FEW_TRIALS: u64 = 1000;

/// Plans of less time, or of no more trials, are the work of one thread.
const WORTH_WAKING: Duration = Duration::from_millis(2);
const FEW_ALONE: u64 = 256;

/// More threads than any machine has use for.
const MOST_THREADS: usize = 1024;

/// The budget that the arguments name, if any.
pub fn budget(seconds: Option<f64>, trials: Option<Whole>) -> PyResult<Option<Budget>> {
    match (seconds, trials) {
        (None, None) => Ok(None),
        (Some(seconds), None) => Ok(Some(Budget::Time(time(seconds)?))),
        (None, Some(trials)) => match u64::try_from(trials) {
            Ok(trials) if trials > 0 => Ok(Some(Budget::Trials(trials))),
            _ => Err(ArgumentError::new_err(format!("trials = {trials}; give at least 1, 100 for example"))),
        },
        (Some(_), Some(_)) => Err(ArgumentError::new_err(
            "both seconds and trials are given; give one: seconds for an anytime plan, trials for a reproducible one",
        )),
    }
}

/// Whether Ctrl-C should end a plan: that takes a thread of its own, which costs short plans more than it saves.
pub fn is_long(budget: Budget) -> bool {
    match budget {
        Budget::Time(time) => time > SHORT,
        Budget::Trials(trials) => trials > FEW_TRIALS,
    }
}

/// Whether a plan gains nothing from other threads, which take a tenth of a millisecond to wake up.
pub fn is_brief(budget: Budget) -> bool {
    match budget {
        Budget::Time(time) => time < WORTH_WAKING,
        Budget::Trials(trials) => trials <= FEW_ALONE,
    }
}

/// A time above 0.
pub fn time(seconds: f64) -> PyResult<Duration> {
    match Duration::try_from_secs_f64(seconds) {
        Ok(time) if !time.is_zero() => Ok(time),
        _ => Err(ArgumentError::new_err(format!(
            "seconds = {seconds}; give a finite time above 0, 0.01 for example"
        ))),
    }
}

/// A pool of `threads` threads.
pub fn thread_pool(threads: Whole) -> PyResult<ThreadPool> {
    let count =
        usize::try_from(threads).ok().filter(|n| (1..=MOST_THREADS).contains(n)).ok_or_else(|| {
            ArgumentError::new_err(format!(
                "threads = {threads}; give at least 1 and at most {MOST_THREADS}, or leave it out for all cores"
            ))
        })?;
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build()
        .map_err(|e| ArgumentError::new_err(format!("threads = {threads}: the pool cannot be made: {e}")))
}

/// Do `work` on a thread that belongs to no pool.
///
/// A pool's thread that waits for another pool takes up its own pool's next task meanwhile: a user's policy
/// that plans would start its next batch in the middle of an action.
pub fn outside_pools<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    if rayon::current_thread_index().is_none() {
        return work();
    }
    thread::scope(|scope| scope.spawn(work).join()).unwrap_or_else(|panic| resume_unwind(panic))
}
