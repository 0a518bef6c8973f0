//! When a search ends, and how many leaves it chooses at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::Budget;

/// Leaves chosen before any of them is expanded: work for the threads, and a little less well informed each. As many
/// as this part of the trials done, within limits; never a matter of threads.
const BATCH: (u64, std::ops::Range<u64>) = (4, 8..256);

/// The time and the trials that a search has.
pub(super) struct Clock<'a> {
    budget: Budget,
    stop: &'a AtomicBool,
    start: Instant,
    /// When the root was expanded.
    begun: Instant,
}

impl<'a> Clock<'a> {
    /// A clock that starts now.
    pub(super) fn started(budget: Budget, stop: &'a AtomicBool) -> Self {
        let now = Instant::now();
        Self { budget, stop, start: now, begun: now }
    }

    /// The root has been expanded.
    pub(super) fn begin(&mut self) {
        self.begun = Instant::now();
    }

    /// Time since the start.
    pub(super) fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// Whether nothing more may be begun.
    pub(super) fn out_of_time(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
            || matches!(self.budget, Budget::Time(time) if self.start.elapsed() >= time)
    }

    /// Trials that end in time if they take as long as those so far; as many as you like as long as there are none.
    fn trials_within(&self, time: Duration, trials: u64) -> u64 {
        if trials == 0 {
            return u64::MAX;
        }
        let left = time.saturating_sub(self.start.elapsed());
        let trials = trials as f64 * left.div_duration_f64(self.begun.elapsed());
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // not negative; as many as fit
        let trials = trials as u64;
        trials
    }

    /// Trials that the budget still allows for after those done and those under way, at most a batch.
    pub(super) fn allowed(&self, trials: u64, under_way: u64) -> usize {
        let batch = (trials / BATCH.0).clamp(BATCH.1.start, BATCH.1.end);
        let left = match self.budget {
            _ if self.out_of_time() => 0,
            Budget::Trials(budget) => budget - trials,
            Budget::Time(time) => self.trials_within(time, trials),
        };
        usize::try_from(batch.min(left.saturating_sub(under_way))).unwrap_or(usize::MAX)
    }
}
