//! A model with the durations and prices of a belt that never stops.

use super::planning::{MovingTimes, Timing, check_model, checked};
use crate::error::Result;
use crate::model::SortingModel;

/// A belt that carries every object one place further every `ticks_per_place`, whatever is decided.
///
/// An object is seen at H places, decided while it is in reach, and costs `missed` if it passes the exit undecided. The
/// model's discount is per tick.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingBelt {
    model: SortingModel,
    missed: Vec<f64>,
    timing: Timing,
}

impl MovingBelt {
    /// Check durations and prices; `missed[class]` is the price of an object that passes the exit undecided, `None` for
    /// [`MovingTimes::default_missed`].
    ///
    /// # Errors
    /// [`crate::Error::Model`] for a model with `repeat`, `observe_after_decision` or `information_gain`;
    /// [`crate::Error::Argument`] for times or prices that make no sense.
    pub fn new(model: &SortingModel, times: &MovingTimes, missed: Option<&[f64]>) -> Result<Self> {
        check_model(model)?;
        let missed = missed.map_or_else(|| MovingTimes::default_missed(model), <[f64]>::to_vec);
        let timing = checked(model, times, &missed)?;
        Ok(Self { model: model.clone(), missed, timing })
    }

    /// Classes, tables and rewards.
    #[must_use]
    pub fn model(&self) -> &SortingModel {
        &self.model
    }

    /// Price of an object that passes the exit undecided, per class.
    #[must_use]
    pub fn missed(&self) -> &[f64] {
        &self.missed
    }

    pub(super) fn timing(&self) -> &Timing {
        &self.timing
    }
}
