//! The time that a solver has, and reports of its progress.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Called with the bounds at the arrival prior, `(lower, upper)`, whenever they improve.
pub type Progress<'a> = &'a mut (dyn FnMut(f64, f64) + Send);

/// Shared by all that works on a solution.
pub(super) struct Watch<'a> {
    start: Instant,
    time: Duration,
    stop: &'a AtomicBool,
    progressed: Mutex<Progressed<'a>>,
}

struct Progressed<'a> {
    progress: Progress<'a>,
    /// The best proved so far at the arrival prior.
    bounds: (f64, f64),
}

impl<'a> Watch<'a> {
    pub(super) fn new(
        time: Duration,
        stop: &'a AtomicBool,
        progress: Progress<'a>,
        bounds: (f64, f64),
    ) -> Self {
        Self { start: Instant::now(), time, stop, progressed: Mutex::new(Progressed { progress, bounds }) }
    }

    pub(super) fn report_lower(&self, lower: f64) {
        self.report(lower, f64::INFINITY);
    }

    pub(super) fn report_upper(&self, upper: f64) {
        self.report(f64::NEG_INFINITY, upper);
    }

    fn report(&self, lower: f64, upper: f64) {
        let mut progressed = self.progressed();
        progressed.bounds = (progressed.bounds.0.max(lower), progressed.bounds.1.min(upper));
        let (lower, upper) = progressed.bounds;
        (progressed.progress)(lower, upper);
    }

    /// The best proved so far at the arrival prior.
    pub(super) fn bounds(&self) -> (f64, f64) {
        self.progressed().bounds
    }

    pub(super) fn gap(&self) -> f64 {
        let (lower, upper) = self.bounds();
        upper - lower
    }

    fn progressed(&self) -> MutexGuard<'_, Progressed<'a>> {
        self.progressed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether this part of the time is over.
    pub(super) fn over(&self, part: f64) -> bool {
        self.stop.load(Ordering::Relaxed) || self.start.elapsed() >= self.time.mul_f64(part)
    }

    pub(super) fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// What is left until this part of the time is over.
    pub(super) fn left(&self, part: f64) -> Duration {
        self.time.mul_f64(part).saturating_sub(self.start.elapsed())
    }
}
