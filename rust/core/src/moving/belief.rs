//! What is known of the objects on a moving belt, and its clock.

use super::belt::MovingBelt;
use super::state::State;
use super::timing::Timing;
use crate::belief::{Belief, condition, evidence};
use crate::error::{Error, Result, argument_error};
use crate::index::{Label, Position, Viewpoint};
use crate::model::{Look, SortingModel};

/// The kinds' distribution at each place, which objects are decided, and the ticks since the belt last advanced.
///
/// Everything but the kinds is known, and each label depends on its own object only: the product of the rows is the exact
/// posterior.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingBelief {
    state: State,
}

impl MovingBelief {
    /// A belt full of unseen objects which has just advanced. `objects` counts all that will pass, those at the places
    /// included; `None` for a belt that never ends.
    #[must_use]
    pub fn new(belt: &MovingBelt, objects: Option<usize>) -> Self {
        let mut state = State::unseen(belt.timing(), belt.model().arrival().as_slice());
        let places = belt.timing().places;
        if let Some(objects) = objects {
            state.decided.iter_mut().skip(objects).for_each(|decided| *decided = true);
        }
        state.to_come = objects.map(|objects| objects.saturating_sub(places));
        Self { state }
    }

    /// A belief from its parts: a row per place as for [`Belief::from_rows`], whether each object is decided or missing, the
    /// ticks since the belt last advanced, and the objects that have not come to a place yet.
    ///
    /// # Errors
    /// [`Error::Argument`] for rows that are no distributions, another number of places, or an offset that is too large.
    pub fn from_parts(
        belt: &MovingBelt,
        rows: &[Vec<f64>],
        decided: Vec<bool>,
        offset: usize,
        to_come: Option<usize>,
    ) -> Result<Self> {
        let model = belt.model();
        let rows = Belief::from_rows(model, rows)?;
        let rows = rows.as_slice().chunks_exact(model.kind_count()).map(<[f64]>::to_vec).collect();
        let belief = Self { state: State { rows, decided, offset, to_come } };
        belief.check_fits(belt.timing(), model)?;
        Ok(belief)
    }

    /// Refuse to be asked about by a policy of another shape.
    pub(super) fn check_fits(&self, timing: &Timing, model: &SortingModel) -> Result<()> {
        let State { rows, decided, offset, .. } = &self.state;
        let places = timing.places;
        if rows.len() != places || decided.len() != places {
            return argument_error(format!(
                "the belief has {} places and says of {} whether they are decided; the belt has {places} places: give one \
                 entry for each",
                rows.len(),
                decided.len()
            ));
        }
        if rows.iter().any(|row| row.len() != model.kind_count()) {
            return argument_error(format!(
                "the belief has other kinds than the model, which has {}; make it of the policy's belt",
                model.kind_count()
            ));
        }
        if *offset >= timing.ticks_per_place {
            return argument_error(format!(
                "offset = {offset}; the belt advances every {} ticks: give 0 to {}",
                timing.ticks_per_place,
                timing.ticks_per_place - 1
            ));
        }
        Ok(())
    }

    /// The distribution of the kind at one place, length N.
    #[must_use]
    pub fn position(&self, position: Position) -> &[f64] {
        &self.state.rows[position.0]
    }

    /// Per place, the exit's first: whether its object is decided, or there is none.
    #[must_use]
    pub fn decided(&self) -> &[bool] {
        &self.state.decided
    }

    /// Ticks since the belt last advanced; since the last decision if it advances on decisions.
    #[must_use]
    pub fn offset(&self) -> usize {
        self.state.offset
    }

    /// Objects that have not come to a place yet; `None` for a belt that never ends.
    #[must_use]
    pub fn to_come(&self) -> Option<usize> {
        self.state.to_come
    }

    /// Whether nothing is left to decide, now or later.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.state.is_over()
    }

    /// Ticks until the object at a place passes the exit; none if the belt advances on decisions.
    #[must_use]
    pub fn ticks_left(&self, belt: &MovingBelt, position: Position) -> Option<usize> {
        let timing = belt.timing();
        (!timing.advances_on_decisions()).then(|| self.state.ticks_left(timing, position.0))
    }

    /// Bayes' rule for one scan (eq. 7): a label per place, `None` where nothing was seen. Labels of decided objects are
    /// ignored.
    ///
    /// # Errors
    /// [`Error::Argument`] for a wrong number of labels, a label or viewpoint that does not exist;
    /// [`Error::ImpossibleObservation`] for a label of probability zero. The belief is then unchanged.
    pub fn observe(
        &mut self,
        belt: &MovingBelt,
        viewpoint: Viewpoint,
        labels: &[Option<Label>],
    ) -> Result<()> {
        let model = belt.model();
        model.check_viewpoint(viewpoint)?;
        if labels.len() != belt.timing().places {
            return argument_error(format!(
                "{} labels for {} places; give one label (or none) per place, the exit's first",
                labels.len(),
                belt.timing().places
            ));
        }
        let mut rows = self.state.rows.clone();
        for (position, label) in model.positions().zip(labels) {
            let Some(label) = *label else { continue };
            model.check_label(label)?;
            if self.state.decided[position.0] {
                continue;
            }
            let look = Look::first(position, viewpoint);
            if condition(&mut rows[position.0], model.likelihoods(look, label)) == 0.0 {
                return Err(Error::ImpossibleObservation {
                    position,
                    viewpoint: model.viewpoint_name(viewpoint).to_owned(),
                    label: model.label_name(label).to_owned(),
                });
            }
        }
        self.state.rows = rows;
        Ok(())
    }

    /// Probability of a label of the object at a place, seen from a viewpoint; both must exist.
    #[must_use]
    pub fn label_probability(
        &self,
        belt: &MovingBelt,
        position: Position,
        viewpoint: Viewpoint,
        label: Label,
    ) -> f64 {
        let likelihoods = belt.model().likelihoods(Look::first(position, viewpoint), label);
        evidence(self.position(position), likelihoods)
    }

    /// Mark the object at a place as decided. It stays where it is, unless the belt advances on decisions: then what is known
    /// moves on by one place (eq. 8). Let the [ticks of a decision](MovingBelt::decision_ticks) pass afterwards.
    ///
    /// # Errors
    /// [`Error::Argument`] if it is out of reach or decided already. The belief is then unchanged.
    pub fn decide(&mut self, belt: &MovingBelt, position: Position) -> Result<()> {
        let reach = belt.timing().reach;
        if position.0 >= reach {
            return argument_error(format!(
                "the object at index {position} of the places is out of reach, which is {reach} from the exit; wait"
            ));
        }
        if self.state.decided[position.0] {
            return argument_error(format!(
                "the object at index {position} of the places is decided already; choose an undecided one"
            ));
        }
        self.state.decide(belt.timing(), belt.model().arrival().as_slice(), position);
        Ok(())
    }

    /// Let time pass (eq. 8 at each advance of the belt); what the objects that pass the exit undecided are expected to
    /// cost, discounted to now.
    pub fn advance_time(&mut self, belt: &MovingBelt, ticks: usize) -> f64 {
        self.state.pass(belt.timing(), belt.model(), ticks)
    }

    pub(super) fn state(&self) -> &State {
        &self.state
    }
}
