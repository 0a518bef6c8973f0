//! Long work that Ctrl-C can end.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use beltsort_core::{
    Action, Belief, Error, MovingAction, MovingBelief, MovingPolicy, Policy, Result, Viewpoint,
};
use pyo3::prelude::*;

const SIGNAL_POLL: Duration = Duration::from_millis(50);

/// A policy that refuses to go on once `stop` is set.
pub struct Stoppable<'a, P: ?Sized> {
    pub policy: &'a P,
    pub stop: &'a AtomicBool,
}

impl<P: ?Sized> Stoppable<'_, P> {
    fn check(&self) -> Result<()> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Error::Policy("interrupted".into()));
        }
        Ok(())
    }
}

impl Policy for Stoppable<'_, dyn Policy + '_> {
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        self.check()?;
        self.policy.act(belief, viewpoint)
    }
}

impl MovingPolicy for Stoppable<'_, dyn MovingPolicy + '_> {
    fn act(&self, belief: &MovingBelief, viewpoint: Viewpoint) -> Result<MovingAction> {
        self.check()?;
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
    interruptible_by(py, stop, |_| Ok(false), work)
}

/// The same; besides, `stop` is set once `poll` returns true, and what `poll` raises is handled like a signal.
pub fn interruptible_by<T: Send>(
    py: Python<'_>,
    stop: &AtomicBool,
    poll: impl Fn(Python<'_>) -> PyResult<bool> + Sync,
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
                    let polled = Python::attach(|py| py.check_signals().and_then(|()| poll(py)));
                    if !matches!(polled, Ok(false)) {
                        stop.store(true, Ordering::Relaxed);
                    }
                    signals = polled.map(drop);
                }
            }
            let result = worker.join().unwrap_or_else(|panic| resume_unwind(panic));
            signals.map(|()| result)
        })
    })
}
