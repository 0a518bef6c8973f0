//! The planner's face: durations as written down, questions about a belief, and their checks.

use std::sync::atomic::AtomicBool;

use super::deadline::Kinds;
use super::search::{MovingConfig, MovingPlan, Searching};
use super::state::State;
use super::timing::Timing;
use crate::belief::Belief;
use crate::config::{Budget, NEVER};
use crate::error::{Result, argument_error, model_error};
use crate::index::{Class, Viewpoint};
use crate::model::SortingModel;

/// Most ticks from the last place to the exit; values are kept for each of them.
const MOST_TICKS: usize = 500;

/// Durations of a belt that moves on by one place every so many ticks, whatever is decided.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MovingTimes {
    /// Ticks between two advances of the belt.
    pub ticks_per_place: usize,
    /// Places, from the exit, at which objects can be decided.
    pub reach: usize,
    /// Ticks of the camera's move between two viewpoints, shape (K, K); without a scan, and 0 counts as 1.
    pub move_ticks: Vec<Vec<usize>>,
    /// Ticks of a scan.
    pub scan_ticks: usize,
    /// Ticks of a decision, in which the camera waits.
    pub sort_ticks: usize,
}

impl MovingTimes {
    /// Prices of objects that pass the exit undecided, if none are given: 0 for the class of empty cups, the largest reward
    /// for the others.
    #[must_use]
    pub fn default_missed(model: &SortingModel) -> Vec<f64> {
        let spec = model.spec();
        let empty = |class: &String| spec.empty.as_ref() == Some(class);
        spec.classes.iter().map(|class| if empty(class) { 0.0 } else { model.most_reward() }).collect()
    }
}

/// What a plan is asked about besides the belief.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct MovingSituation {
    /// Places whose object is decided already, or that are empty.
    pub decided: Vec<usize>,
    /// Ticks since the belt last advanced.
    pub offset: usize,
    /// Objects that have not come to a place yet; `None` for a belt that never ends.
    pub to_come: Option<usize>,
}

/// The recommended planner for a belt that never stops.
#[derive(Debug, Clone)]
pub struct MovingSearch {
    searching: Searching,
}

impl MovingSearch {
    /// Prepare to plan: the default policy and the bound are made here. `missed[class]` is the price of an object that
    /// passes the exit undecided.
    ///
    /// # Errors
    /// [`crate::Error::Model`] for a model with `repeat`, `observe_after_decision` or `information_gain`;
    /// [`crate::Error::Argument`] for times, prices or settings that make no sense.
    pub fn new(
        model: &SortingModel,
        times: &MovingTimes,
        missed: &[f64],
        config: MovingConfig,
    ) -> Result<Self> {
        Self::new_until(model, times, missed, config, &NEVER)
    }

    /// The same, prepared until `stop` is set: with what was found by then.
    ///
    /// # Errors
    /// As [`MovingSearch::new`].
    pub fn new_until(
        model: &SortingModel,
        times: &MovingTimes,
        missed: &[f64],
        config: MovingConfig,
        stop: &AtomicBool,
    ) -> Result<Self> {
        check_model(model)?;
        let timing = checked(model, times, missed)?;
        Ok(Self { searching: Searching::new(model, &timing, config, stop)? })
    }

    /// The model planned for.
    #[must_use]
    pub fn model(&self) -> &SortingModel {
        &self.searching.model
    }

    /// The settings.
    #[must_use]
    pub fn config(&self) -> MovingConfig {
        self.searching.config
    }

    /// Plan the next action until the budget is spent or `stop` is set. With a budget of trials the plan is a pure function of
    /// the arguments.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if belief, situation or viewpoint do not fit, nothing is left to decide, or the budget is zero.
    pub fn plan_until(
        &self,
        belief: &Belief,
        situation: &MovingSituation,
        viewpoint: Viewpoint,
        budget: Budget,
        stop: &AtomicBool,
    ) -> Result<MovingPlan> {
        let state = self.state(belief, situation, viewpoint)?;
        self.searching.search(&state, viewpoint, budget, stop)
    }

    /// Bounds of the value: what the default policy earns, and the priced bound.
    ///
    /// # Errors
    /// As [`MovingSearch::plan_until`].
    pub fn bounds(
        &self,
        belief: &Belief,
        situation: &MovingSituation,
        viewpoint: Viewpoint,
    ) -> Result<(f64, f64)> {
        let state = self.state(belief, situation, viewpoint)?;
        let Searching { serving, bound, .. } = &self.searching;
        Ok((serving.value(&state, viewpoint), bound.value(&state, viewpoint)))
    }

    /// By ticks left until the exit, from 1: the least probability of a class from which on deciding at once is optimal for one
    /// object alone, the other classes in their proportions at arrival; `None` out of reach, or where it never is.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if class or viewpoint do not exist.
    pub fn thresholds(&self, class: Class, viewpoint: Viewpoint) -> Result<Vec<Option<f64>>> {
        let model = &self.searching.model;
        model.check_class(class)?;
        model.check_viewpoint(viewpoint)?;
        let problem = self.searching.bound.problem();
        let values = problem.values(&vec![1.0; problem.horizon() + 1]);
        let (kinds, group) = (Kinds::towards(model, class), problem.group(viewpoint));
        let at = |n| problem.threshold(&values, n, group, &kinds);
        Ok((1..=problem.timing().visible()).map(at).collect())
    }

    /// The share of a look's cost that an object pays, by ticks left from 1, under the improved prices.
    #[must_use]
    pub fn shares(&self) -> &[f64] {
        &self.searching.bound.shares()[1..]
    }

    fn state(&self, belief: &Belief, situation: &MovingSituation, viewpoint: Viewpoint) -> Result<State> {
        let (model, timing) = (self.model(), self.searching.timing());
        belief.check_fits(model)?;
        model.check_viewpoint(viewpoint)?;
        if belief.remaining().is_some() {
            return argument_error("the belief has remaining, which counts decisions; give to_come instead");
        }
        if situation.offset >= timing.ticks_per_place {
            return argument_error(format!(
                "offset = {}; the belt advances every {} ticks: give 0 to {}",
                situation.offset,
                timing.ticks_per_place,
                timing.ticks_per_place - 1
            ));
        }
        let mut decided = vec![false; timing.places];
        for place in &situation.decided {
            let Some(entry) = decided.get_mut(*place) else {
                return argument_error(format!(
                    "decided names place {place}; there are {}, from 0",
                    timing.places
                ));
            };
            *entry = true;
        }
        let rows = belief.as_slice().chunks_exact(model.kind_count()).map(<[f64]>::to_vec).collect();
        Ok(State { rows, decided, offset: situation.offset, to_come: situation.to_come })
    }
}

/// Refuse what the planner has no arithmetic for.
pub(crate) fn check_model(model: &SortingModel) -> Result<()> {
    let beyond = [
        ("repeat", model.ever_repeats()),
        ("observe_after_decision", model.observes_after_decision()),
        ("information_gain", model.spec().information_gain > 0.0),
    ];
    match beyond.iter().find(|(_, used)| *used) {
        Some((key, _)) => model_error(format!(
            "{key} is set, which planning for a belt that never stops does not support; leave it out, or write dependent looks \
             as modes"
        )),
        None => Ok(()),
    }
}

/// The times, checked against the model.
pub(crate) fn checked(model: &SortingModel, times: &MovingTimes, missed: &[f64]) -> Result<Timing> {
    let (places, k) = (model.position_count(), model.viewpoint_count());
    if times.ticks_per_place == 0 || places.saturating_mul(times.ticks_per_place) > MOST_TICKS {
        return argument_error(format!(
            "ticks_per_place = {}; give at least 1, and no more than {MOST_TICKS} for all {places} places together: a longer \
             tick makes fewer of them",
            times.ticks_per_place
        ));
    }
    if !(1..=places).contains(&times.reach) {
        return argument_error(format!(
            "reach = {}; give 1 to {places}, the places that are seen",
            times.reach
        ));
    }
    if times.move_ticks.len() != k || times.move_ticks.iter().any(|row| row.len() != k) {
        return argument_error(format!(
            "move_ticks; expected shape ({k}, {k}), a number for each pair of viewpoints"
        ));
    }
    let longest =
        times.move_ticks.iter().flatten().copied().max().unwrap_or(0).saturating_add(times.scan_ticks);
    if longest.max(times.sort_ticks) > MOST_TICKS {
        return argument_error(format!(
            "an action takes {} ticks; {MOST_TICKS} at most: use a longer tick",
            longest.max(times.sort_ticks)
        ));
    }
    let right = |price: &f64| price.is_finite() && *price >= 0.0;
    if missed.len() != model.class_count() || !missed.iter().all(right) {
        return argument_error(format!(
            "missed = {missed:?}; give a price for each of the {} classes, finite and not negative",
            model.class_count()
        ));
    }
    let look = |ticks: &usize| (ticks + times.scan_ticks).max(1);
    Ok(Timing {
        ticks_per_place: times.ticks_per_place,
        reach: times.reach,
        sort_ticks: times.sort_ticks,
        missed: model.kinds().map(|kind| missed[model.class_of(kind).0]).collect(),
        places,
        look_ticks: times.move_ticks.iter().flatten().map(look).collect(),
        viewpoints: k,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::paper;

    fn times() -> MovingTimes {
        MovingTimes {
            ticks_per_place: 4,
            reach: 1,
            move_ticks: vec![vec![1; 3]; 3],
            scan_ticks: 0,
            sort_ticks: 0,
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let model = paper(50.0);
        let refused = |times: MovingTimes, missed: &[f64]| {
            MovingSearch::new(&model, &times, missed, MovingConfig::default()).unwrap_err().to_string()
        };
        let missed = [10.0; 4];
        for (change, word) in [
            (MovingTimes { ticks_per_place: 0, ..times() }, "ticks_per_place"),
            (MovingTimes { ticks_per_place: 251, ..times() }, "ticks_per_place"),
            (MovingTimes { reach: 3, ..times() }, "reach"),
            (MovingTimes { move_ticks: vec![vec![1; 2]; 3], ..times() }, "move_ticks"),
            (MovingTimes { scan_ticks: 500, ..times() }, "ticks"),
        ] {
            let error = refused(change, &missed);
            assert!(error.contains(word), "{error}");
        }
        assert!(refused(times(), &missed[..3]).contains("missed"));
        assert!(refused(times(), &[-1.0, 0.0, 0.0, 0.0]).contains("missed"));
        let config = MovingConfig { optimism: 2.0, ..MovingConfig::default() };
        let error = MovingSearch::new(&model, &times(), &missed, config).unwrap_err().to_string();
        assert!(error.contains("optimism"), "{error}");
    }

    #[test]
    fn a_question_has_to_fit_the_belt() {
        let model = paper(50.0);
        let search = MovingSearch::new(&model, &times(), &[10.0; 4], MovingConfig::default()).unwrap();
        let belief = Belief::new(&model);
        let refused = |belief: &Belief, situation| {
            search.bounds(belief, &situation, Viewpoint(0)).unwrap_err().to_string()
        };
        let late = MovingSituation { offset: 4, ..MovingSituation::default() };
        assert!(refused(&belief, late).contains("offset"));
        let beyond = MovingSituation { decided: vec![2], ..MovingSituation::default() };
        assert!(refused(&belief, beyond).contains("decided"));
        let ending = belief.clone().with_remaining(Some(3));
        assert!(refused(&ending, MovingSituation::default()).contains("to_come"));
        let (lower, upper) = search.bounds(&belief, &MovingSituation::default(), Viewpoint(0)).unwrap();
        assert!(lower < upper);
    }
}
