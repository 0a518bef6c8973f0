//! Where in the scenarios the scan is that an action brings.

use crate::bounds::Sighting;
use crate::index::Viewpoint;
use crate::model::{Action, SortingModel};
use crate::remaining::Remaining;
use crate::scenario::LookPoint;
use crate::tree::Node;

/// Where in the scenarios a scan is taken.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scan {
    /// Planner steps before it.
    pub depth: usize,
    /// Decisions before it.
    pub decisions: usize,
    /// Where the camera stands.
    pub viewpoint: Viewpoint,
    /// Objects left to decide.
    pub remaining: Remaining,
}

impl Scan {
    /// The scan that an action at a node brings, if any.
    pub(super) fn of(model: &SortingModel, node: &Node, action: Action) -> Option<Self> {
        let &Node { depth, decisions, viewpoint, remaining, .. } = node;
        match action {
            Action::Move(viewpoint) => Some(Self { depth, decisions, viewpoint, remaining }),
            Action::Decide(_) if model.observes_after_decision() && !remaining.after(1).is_over() => {
                Some(Self { depth, decisions: decisions + 1, viewpoint, remaining: remaining.after(1) })
            }
            Action::Decide(_) => None,
        }
    }

    /// One of its looks.
    #[inline(always)]
    pub(super) fn look(&self, look: Sighting) -> LookPoint {
        LookPoint { depth: self.depth, decisions: self.decisions, look }
    }
}
