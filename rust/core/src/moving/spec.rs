//! A moving belt as it is written down.

use crate::error::{Result, argument_error};
use crate::model::{ScalarOrMatrix, SortingModel};

/// What moves the belt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// One place every so many ticks, whatever is decided.
    Constant {
        /// Ticks between two advances.
        ticks_per_place: usize,
    },
    /// One place after each decision on the object nearest to the exit, as in the paper; otherwise the belt stands.
    OnDecision {
        /// Ticks of the decision and the advance.
        advance_ticks: usize,
    },
}

impl Drive {
    /// The drive with exactly one of two durations.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if both or neither are given.
    pub fn of(ticks_per_place: Option<usize>, advance_ticks: Option<usize>) -> Result<Self> {
        match (ticks_per_place, advance_ticks) {
            (Some(ticks_per_place), None) => Ok(Self::Constant { ticks_per_place }),
            (None, Some(advance_ticks)) => Ok(Self::OnDecision { advance_ticks }),
            (given, _) => argument_error(format!(
                "{} of ticks_per_place and advance_ticks are given; give ticks_per_place for a belt of constant speed, or \
                 advance_ticks for one that advances on decisions",
                if given.is_some() { "both" } else { "neither" }
            )),
        }
    }
}

/// Durations and prices of a moving belt as written down by its user; [`crate::MovingBelt::new`] checks them.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingSpec {
    /// What moves the belt.
    pub drive: Drive,
    /// Places, from the exit, at which objects can be decided; 1 for [`Drive::OnDecision`].
    pub reach: usize,
    /// Ticks of the camera's moves: a whole number, or a (K, K) matrix `[from][to]`. A look takes at least one tick.
    pub move_ticks: ScalarOrMatrix,
    /// Ticks of a scan.
    pub scan_ticks: usize,
    /// Ticks of a decision, in which the camera waits; 0 for [`Drive::OnDecision`], whose advance it waits for.
    pub sort_ticks: usize,
    /// Price of an object that passes the exit undecided, per class; [`MovingSpec::default_missed`] if missing.
    pub missed: Option<Vec<f64>>,
    /// How long a tick lasts, for reports.
    pub seconds_per_tick: Option<f64>,
}

impl MovingSpec {
    /// One place in reach, looks of one tick, decisions that take no time of the camera.
    #[must_use]
    pub fn new(drive: Drive) -> Self {
        Self {
            drive,
            reach: 1,
            move_ticks: ScalarOrMatrix::Scalar(1.0),
            scan_ticks: 0,
            sort_ticks: 0,
            missed: None,
            seconds_per_tick: None,
        }
    }

    /// Prices of objects that pass the exit undecided, if none are given: 0 for the class of empty cups, the largest reward
    /// for the others.
    #[must_use]
    pub fn default_missed(model: &SortingModel) -> Vec<f64> {
        let spec = model.spec();
        let empty = |class: &String| spec.empty.as_ref() == Some(class);
        spec.classes.iter().map(|class| if empty(class) { 0.0 } else { model.most_reward() }).collect()
    }
}
