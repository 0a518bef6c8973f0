//! Where in the scenarios the scan is that an action brings.

use crate::bounds::Sighting;
use crate::index::Viewpoint;
use crate::model::Step;
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
    /// The scan that a step from a node brings, if any.
    pub(super) fn of(node: &Node, step: Step) -> Option<Self> {
        let decisions = node.decisions + usize::from(step.advances());
        let remaining = step.remaining;
        step.scan.map(|viewpoint| Self { depth: node.depth, decisions, viewpoint, remaining })
    }

    /// One of its looks.
    #[inline(always)]
    pub(super) fn look(&self, look: Sighting) -> LookPoint {
        LookPoint { depth: self.depth, decisions: self.decisions, look }
    }
}
