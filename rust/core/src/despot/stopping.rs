//! When a search ends, and how many leaves it chooses at once.

use std::sync::atomic::Ordering;
use std::time::Duration;

use super::{Budget, Search};

/// A root gap, as a part of `r_max`, below which the sampled problem counts as solved.
const SOLVED: f64 = 1e-10;
/// Leaves chosen before any of them is expanded: work for the threads, and a little less well informed each. As many
/// as this part of the trials done, within limits; never a matter of threads.
const BATCH: (u64, std::ops::Range<u64>) = (4, 8..256);

impl Search<'_> {
    /// Whether the sampled problem is solved, or the budget spent.
    pub(super) fn finished(&self) -> bool {
        self.space.tree.root.values.gap() < SOLVED * self.despot.model.spec().r_max || self.allowed() == 0
    }

    /// Whether nothing more may be begun.
    pub(super) fn out_of_time(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
            || matches!(self.budget, Budget::Time(time) if self.start.elapsed() >= time)
    }

    /// Trials that end in time if they take as long as those so far; as many as you like as long as there are none.
    fn trials_within(&self, time: Duration) -> u64 {
        if self.trials == 0 {
            return u64::MAX;
        }
        let left = time.saturating_sub(self.start.elapsed());
        let trials = self.trials as f64 * left.div_duration_f64(self.begun.elapsed());
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // not negative; as many as fit
        let trials = trials as u64;
        trials
    }

    /// Trials that the budget still allows for, at most a batch.
    pub(super) fn allowed(&self) -> usize {
        let batch = (self.trials / BATCH.0).clamp(BATCH.1.start, BATCH.1.end);
        let allowed = match self.budget {
            _ if self.out_of_time() => 0,
            Budget::Trials(trials) => batch.min(trials - self.trials),
            Budget::Time(time) => batch.min(self.trials_within(time)),
        };
        usize::try_from(allowed).unwrap_or(usize::MAX)
    }
}
