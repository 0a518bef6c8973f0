//! What can be done on a moving belt.

use crate::index::{Bin, Position, Viewpoint};

/// An action on a moving belt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MovingAction {
    /// Move the camera and scan.
    Look(Viewpoint),
    /// Let a tick pass.
    Wait,
    /// Sort an object in reach.
    Decide {
        /// Its place.
        position: Position,
        /// Where it goes.
        bin: Bin,
    },
}

impl MovingAction {
    /// Where the camera stands after the action.
    pub(super) fn viewpoint(self, from: Viewpoint) -> Viewpoint {
        match self {
            Self::Look(to) => to,
            _ => from,
        }
    }
}
