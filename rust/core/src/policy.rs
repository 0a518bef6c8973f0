//! Policies: anything that names the next action for a belief and a viewpoint.

use std::sync::atomic::AtomicBool;

use crate::belief::{Belief, Groups};
use crate::config::NEVER;
use crate::error::{Result, argument_error};
use crate::index::{Bin, Position, Viewpoint};
use crate::model::{Action, SortingModel};
use crate::one_object::OneObjectPolicy;

/// Names the next action.
pub trait Policy: Sync {
    /// The action to take with the camera at `viewpoint`.
    ///
    /// # Errors
    /// Whatever keeps the policy from naming one; the caller passes it on.
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action>;
}

/// Look from one viewpoint until a decision is likely enough to be right.
#[derive(Debug, Clone)]
pub struct Threshold {
    model: SortingModel,
    confidence: f64,
    /// First move from each viewpoint on the way to the one to look from; `None` where no move is legal.
    next_move: Vec<Option<Viewpoint>>,
}

impl Threshold {
    /// Decide once the best decision at the belt end is right with probability `threshold`; look from `viewpoint` until then
    /// (`None`: the one that tells most about an arriving object).
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for a threshold outside (0, 1] or an unknown viewpoint.
    pub fn new(model: &SortingModel, threshold: f64, viewpoint: Option<Viewpoint>) -> Result<Self> {
        check_threshold(threshold)?;
        let arriving = Belief::new(model);
        let gain = |j, v| arriving.information(model, j, v);
        let best = || most_informative(model, 1, model.viewpoints(), gain).unwrap_or_default();
        let target = viewpoint.unwrap_or_else(best);
        model.check_viewpoint(target)?;
        Ok(Self { model: model.clone(), confidence: threshold, next_move: next_moves(model, target) })
    }
}

impl Policy for Threshold {
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        let (bin, p_right) = decision(&self.model, belief);
        Ok(match self.next_move[viewpoint.0] {
            Some(to) if p_right < self.confidence => Action::Move(to),
            _ => Action::Decide(bin),
        })
    }
}

/// What a look is to tell of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// Its class.
    Class,
    /// The bin where it belongs: classes that the same bins are right for are not told apart.
    Bin,
}

/// Look from where most is learnt until a decision is likely enough to be right.
#[derive(Debug, Clone)]
pub struct InformationGain {
    model: SortingModel,
    confidence: f64,
    positions: usize,
    groups: Groups,
}

impl InformationGain {
    /// Decide once the best decision at the belt end is right with probability `threshold`; until then take the move with the
    /// largest expected entropy reduction of the answer to `question`, summed over the first `positions` positions.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for a threshold outside (0, 1] or positions outside 1..=H.
    pub fn new(model: &SortingModel, threshold: f64, positions: usize, question: Question) -> Result<Self> {
        check_threshold(threshold)?;
        if positions == 0 || positions > model.position_count() {
            return argument_error(format!(
                "positions = {positions}; the model has {}: count between 1 and all of them",
                model.position_count()
            ));
        }
        let groups = match question {
            Question::Class => Groups::of_classes(model),
            Question::Bin => Groups::of_bins(model),
        };
        Ok(Self { model: model.clone(), confidence: threshold, positions, groups })
    }
}

impl Policy for InformationGain {
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        let (bin, p_right) = decision(&self.model, belief);
        if p_right >= self.confidence {
            return Ok(Action::Decide(bin));
        }
        let moves = self.model.legal_moves(viewpoint).iter().copied();
        let gain = |j, v| belief.information_about(&self.model, j, v, &self.groups);
        Ok(most_informative(&self.model, self.positions, moves, gain)
            .map_or(Action::Decide(bin), Action::Move))
    }
}

/// The best conditional plan for the object at the belt end, chosen anew at each step: the search's default policy.
#[derive(Debug, Clone)]
pub struct OneObject {
    model: SortingModel,
    plans: OneObjectPolicy,
}

impl OneObject {
    /// Solve the one-object problem; labels are taken as independent, and any bonus is left aside.
    #[must_use]
    pub fn new(model: &SortingModel) -> Self {
        Self::new_until(model, &NEVER)
    }

    /// The same, solved until `stop` is set: with the best plans found by then.
    #[must_use]
    pub fn new_until(model: &SortingModel, stop: &AtomicBool) -> Self {
        Self { model: model.clone(), plans: OneObjectPolicy::solve_until(model, stop) }
    }
}

impl Policy for OneObject {
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        Ok(self.plans.action(&self.model, belief.known(), viewpoint))
    }
}

/// The decision that earns most, and the probability that it is right.
fn decision(model: &SortingModel, belief: &Belief) -> (Bin, f64) {
    let (bin, _) = belief.best_decision(model);
    (bin, model.probability_right(bin, belief.position(Position(0)).as_slice()))
}

fn check_threshold(threshold: f64) -> Result<()> {
    if threshold > 0.0 && threshold <= 1.0 {
        return Ok(());
    }
    argument_error(format!(
        "threshold = {threshold}; it is a probability above 0 and at most 1, 0.94 for example"
    ))
}

/// The viewpoint whose scan is expected to reduce the entropy of the first positions most; the first among equals.
fn most_informative(
    model: &SortingModel,
    positions: usize,
    viewpoints: impl IntoIterator<Item = Viewpoint>,
    gain: impl Fn(Position, Viewpoint) -> f64,
) -> Option<Viewpoint> {
    let gain = |v| model.positions().take(positions).map(|j| gain(j, v)).sum::<f64>();
    viewpoints
        .into_iter()
        .map(|v| (v, gain(v)))
        .fold(None, |best: Option<(Viewpoint, f64)>, next| match best {
            Some(best) if best.1 >= next.1 => Some(best),
            _ => Some(next),
        })
        .map(|(v, _)| v)
}

/// The first move of a shortest path from each viewpoint to `target`; where there is none, the first legal move.
pub(crate) fn next_moves(model: &SortingModel, target: Viewpoint) -> Vec<Option<Viewpoint>> {
    let mut next: Vec<Option<Viewpoint>> = vec![None; model.viewpoint_count()];
    // At the target itself: stay and scan again, if that is legal.
    next[target.0] = model.legal_moves(target).iter().copied().find(|to| *to == target);
    let mut reached = vec![target];
    for index in 0..next.len() {
        let Some(&via) = reached.get(index) else { break };
        for (from, step) in model.viewpoints().zip(&mut next) {
            if from != target && step.is_none() && model.legal_moves(from).contains(&via) {
                *step = Some(via);
                reached.push(from);
            }
        }
    }
    let any = |from| model.legal_moves(from).first().copied();
    model.viewpoints().zip(next).map(|(from, step)| step.or_else(|| any(from))).collect()
}
