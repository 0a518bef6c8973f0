//! Time, and who is told of what it brings.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Told of the bounds at the arrival prior, `(lower, upper)`, while they improve.
pub type Progress<'a> = &'a mut (dyn FnMut(f64, f64) + Send);

/// Shared by all that works on a solution.
pub(super) struct Watch<'a> {
    start: Instant,
    time: Duration,
    stop: &'a AtomicBool,
    told: Mutex<Told<'a>>,
}

struct Told<'a> {
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
        Self { start: Instant::now(), time, stop, told: Mutex::new(Told { progress, bounds }) }
    }

    pub(super) fn report_lower(&self, lower: f64) {
        self.report(lower, f64::INFINITY);
    }

    pub(super) fn report_upper(&self, upper: f64) {
        self.report(f64::NEG_INFINITY, upper);
    }

    fn report(&self, lower: f64, upper: f64) {
        let mut told = self.told();
        told.bounds = (told.bounds.0.max(lower), told.bounds.1.min(upper));
        let (lower, upper) = told.bounds;
        (told.progress)(lower, upper);
    }

    /// The best proved so far at the arrival prior.
    pub(super) fn bounds(&self) -> (f64, f64) {
        self.told().bounds
    }

    pub(super) fn gap(&self) -> f64 {
        let (lower, upper) = self.bounds();
        upper - lower
    }

    fn told(&self) -> MutexGuard<'_, Told<'a>> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner)
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
