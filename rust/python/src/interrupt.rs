//! Long work that Ctrl-C can end.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use beltsort_core::{Action, Belief, Error, Policy, Result, Viewpoint};
use pyo3::prelude::*;

const SIGNAL_POLL: Duration = Duration::from_millis(50);

/// A policy that refuses to go on once `stop` is set.
pub struct Stoppable<'a> {
    pub policy: &'a dyn Policy,
    pub stop: &'a AtomicBool,
}

impl Policy for Stoppable<'_> {
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Error::Policy("interrupted".into()));
        }
        self.policy.act(belief, viewpoint)
    }
}

/// Do `work` on another thread with the GIL released, while this one handles Python's signals; a handler's
/// exception sets `stop` and is returned once the work has ended.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    stop: &AtomicBool,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    py.detach(|| {
        thread::scope(|scope| {
            let (alive, ended) = channel::<()>();
            let worker = scope.spawn(move || {
                let result = work();
                drop(alive);
                result
            });
            let mut signals = Ok(());
            while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(SIGNAL_POLL) {
                if signals.is_ok() {
                    signals = Python::attach(handle_signals);
                    stop.store(signals.is_err(), Ordering::Relaxed);
                }
            }
            let result = worker.join().unwrap_or_else(|panic| resume_unwind(panic));
            signals.map(|()| result)
        })
    })
}

fn handle_signals(py: Python<'_>) -> PyResult<()> {
    py.check_signals()
}
