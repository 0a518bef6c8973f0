//! A model with the durations and prices of a moving belt.

use std::sync::Arc;

use super::spec::{Drive, MovingSpec};
use super::timing::{NEVER, Timing};
use crate::error::{Error, Result, argument_error, model_error};
use crate::index::Viewpoint;
use crate::model::{ScalarOrMatrix, SortingModel};

/// Most ticks from the last place to the exit, and of an action; values are kept for each of them.
const MOST_TICKS: usize = 500;

/// A sorting model on a belt that moves while the camera looks.
///
/// Time runs in ticks. An object is seen at H places and decided while it is in reach. On a belt of constant speed it costs
/// `missed` if it passes the exit undecided. The model's discount is per tick.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingBelt {
    model: Arc<SortingModel>,
    spec: MovingSpec,
    missed: Vec<f64>,
    timing: Timing,
}

impl MovingBelt {
    /// Check durations and prices.
    ///
    /// # Errors
    /// [`Error::Model`] for a model with `repeat`, `observe_after_decision` or `information_gain`;
    /// [`Error::Argument`] for durations or prices that make no sense.
    pub fn new(model: impl Into<Arc<SortingModel>>, spec: MovingSpec) -> Result<Self> {
        let model = model.into();
        check_model(&model)?;
        let missed = spec.missed.clone().unwrap_or_else(|| MovingSpec::default_missed(&model));
        let timing = timing(&model, &spec, &missed)?;
        Ok(Self { model, spec, missed, timing })
    }

    /// Classes, tables and rewards.
    #[must_use]
    pub fn model(&self) -> &Arc<SortingModel> {
        &self.model
    }

    /// Durations and prices as given.
    #[must_use]
    pub fn spec(&self) -> &MovingSpec {
        &self.spec
    }

    /// Price of an object that passes the exit undecided, per class.
    #[must_use]
    pub fn missed(&self) -> &[f64] {
        &self.missed
    }

    /// Ticks of a look, which moves the camera and scans; both viewpoints must exist.
    #[must_use]
    pub fn look_ticks(&self, from: Viewpoint, to: Viewpoint) -> usize {
        self.timing.look(from, to)
    }

    /// Ticks of a decision: those of the advance if the belt advances on decisions.
    #[must_use]
    pub fn decision_ticks(&self) -> usize {
        self.timing.sort_ticks
    }

    pub(super) fn timing(&self) -> &Timing {
        &self.timing
    }
}

/// Refuse what belief and planner have no arithmetic for.
fn check_model(model: &SortingModel) -> Result<()> {
    let beyond = [
        ("repeat", model.ever_repeats()),
        ("observe_after_decision", model.observes_after_decision()),
        ("information_gain", model.spec().information_gain > 0.0),
    ];
    match beyond.iter().find(|(_, used)| *used) {
        Some((key, _)) => model_error(format!(
            "{key} is set, which a moving belt does not support; leave it out, or write dependent looks as modes"
        )),
        None => Ok(()),
    }
}

/// Durations and prices, checked against the model.
fn timing(model: &SortingModel, spec: &MovingSpec, missed: &[f64]) -> Result<Timing> {
    let (places, viewpoints) = (model.position_count(), model.viewpoint_count());
    let (ticks_per_place, sort_ticks) = drive(spec, places)?;
    if !(1..=places).contains(&spec.reach) {
        return argument_error(format!(
            "reach = {}; give 1 to {places}, the places that are seen",
            spec.reach
        ));
    }
    let move_ticks = move_ticks(&spec.move_ticks, viewpoints)?;
    let longest = move_ticks.iter().copied().max().unwrap_or(0).saturating_add(spec.scan_ticks);
    if longest.max(sort_ticks) > MOST_TICKS {
        return argument_error(format!(
            "an action takes {} ticks; {MOST_TICKS} at most: use a longer tick",
            longest.max(sort_ticks)
        ));
    }
    let right = |price: &f64| price.is_finite() && *price >= 0.0;
    if missed.len() != model.class_count() || !missed.iter().all(right) {
        return argument_error(format!(
            "missed = {missed:?}; give a price for each of the {} classes, finite and not negative",
            model.class_count()
        ));
    }
    if let Some(seconds) = spec.seconds_per_tick
        && !(seconds.is_finite() && seconds > 0.0)
    {
        return argument_error(format!("seconds_per_tick = {seconds}; give a finite time above 0"));
    }
    Ok(Timing {
        ticks_per_place,
        reach: spec.reach,
        sort_ticks,
        missed: model.kinds().map(|kind| missed[model.class_of(kind).0]).collect(),
        places,
        look_ticks: move_ticks.iter().map(|ticks| (ticks + spec.scan_ticks).max(1)).collect(),
        viewpoints,
    })
}

/// Ticks between two advances, and of a decision.
fn drive(spec: &MovingSpec, places: usize) -> Result<(usize, usize)> {
    match spec.drive {
        Drive::Constant { ticks_per_place } => {
            if ticks_per_place == 0 || places.saturating_mul(ticks_per_place) > MOST_TICKS {
                return argument_error(format!(
                    "ticks_per_place = {ticks_per_place}; give at least 1, and no more than {MOST_TICKS} for all {places} \
                     places together: a longer tick makes fewer of them"
                ));
            }
            Ok((ticks_per_place, spec.sort_ticks))
        }
        Drive::OnDecision { advance_ticks } => {
            for (name, value, only) in [("reach", spec.reach, 1), ("sort_ticks", spec.sort_ticks, 0)] {
                if value != only {
                    return argument_error(format!(
                        "{name} = {value}; a belt that advances on decisions has {name} = {only}: it waits with the object to \
                         decide at the exit, and advance_ticks is what a decision takes"
                    ));
                }
            }
            Ok((NEVER, advance_ticks.max(1)))
        }
    }
}

/// Ticks of each move, entry `from * K + to`.
fn move_ticks(given: &ScalarOrMatrix, k: usize) -> Result<Vec<usize>> {
    let entries = match given {
        ScalarOrMatrix::Scalar(ticks) => vec![*ticks; k * k],
        ScalarOrMatrix::Matrix(rows) if rows.len() == k && rows.iter().all(|row| row.len() == k) => {
            rows.iter().flatten().copied().collect()
        }
        ScalarOrMatrix::Matrix(rows) => {
            return argument_error(format!(
                "move_ticks has rows of lengths {:?}; expected shape ({k}, {k}), a number for each pair of viewpoints",
                rows.iter().map(Vec::len).collect::<Vec<_>>()
            ));
        }
    };
    let whole = |ticks: f64| {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a whole number of three digits
        if ticks.fract() == 0.0 && (0.0..=MOST_TICKS as f64).contains(&ticks) {
            return Ok(ticks as usize);
        }
        Err(Error::Argument(format!(
            "move_ticks has the entry {ticks}; give whole numbers of ticks from 0 to {MOST_TICKS}"
        )))
    };
    entries.into_iter().map(whole).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::paper;

    #[test]
    fn what_makes_no_sense_is_refused() {
        let model = Arc::new(paper(50.0));
        let four = MovingSpec::new(Drive::Constant { ticks_per_place: 4 });
        let on_decision = MovingSpec::new(Drive::OnDecision { advance_ticks: 1 });
        let every = |ticks_per_place| MovingSpec::new(Drive::Constant { ticks_per_place });
        let matrix = |entry| ScalarOrMatrix::Matrix(vec![vec![entry; 3]; 3]);
        for (spec, word) in [
            (every(0), "ticks_per_place = 0"),
            (every(251), "ticks_per_place = 251"),
            (MovingSpec { reach: 3, ..four.clone() }, "reach = 3"),
            (
                MovingSpec { move_ticks: ScalarOrMatrix::Matrix(vec![vec![1.0; 2]; 3]), ..four.clone() },
                "shape (3, 3)",
            ),
            (MovingSpec { move_ticks: matrix(0.5), ..four.clone() }, "entry 0.5"),
            (MovingSpec { move_ticks: matrix(-1.0), ..four.clone() }, "entry -1"),
            (MovingSpec { scan_ticks: 500, ..four.clone() }, "501 ticks"),
            (MovingSpec { missed: Some(vec![1.0; 3]), ..four.clone() }, "missed"),
            (MovingSpec { missed: Some(vec![-1.0, 0.0, 0.0, 0.0]), ..four.clone() }, "missed"),
            (MovingSpec { seconds_per_tick: Some(0.0), ..four }, "seconds_per_tick = 0"),
            (MovingSpec { reach: 2, ..on_decision.clone() }, "reach = 2"),
            (MovingSpec { sort_ticks: 1, ..on_decision }, "sort_ticks = 1"),
        ] {
            let error = MovingBelt::new(Arc::clone(&model), spec).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
