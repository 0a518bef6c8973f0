//! The sorting POMDP: sets, observation tables, rewards and travel (eq. 1-6 of the paper).

mod file;
mod likelihood;
mod pomdp;
mod rewards;
mod sets;
mod spec;
mod step;
mod validate;

use std::fmt;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

pub(crate) use file::{read, write};
pub use likelihood::Look;
pub(crate) use spec::MOVING_BELT;
pub use spec::{
    DEFAULT_DISCOUNT, DEFAULT_R_MAX, DEFAULT_R_MIN, ModelSpec, ScalarOrMatrix, Smoothing, Tables,
};
pub(crate) use step::{Step, shift};
pub(crate) use validate::distribution;

use crate::error::{Result, argument_error, model_error};
use crate::index::{Bin, Position, Viewpoint};
use rewards::Rewards;

/// One planner step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Action {
    /// `m_k`: move the camera to a viewpoint and scan.
    Move(Viewpoint),
    /// `d_i`: sort the object at the belt end into this bin; the belt advances.
    Decide(Bin),
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Move(viewpoint) => write!(f, "Move({viewpoint})"),
            Self::Decide(bin) => write!(f, "Decide({bin})"),
        }
    }
}

/// A checked sorting model, ready for arithmetic.
///
/// State: the kind of the object at each of H positions, that is its class and its mode, and the camera's viewpoint. In
/// the paper's model each class has one mode. `o^j(z | p', c)` of the paper is [`SortingModel::table`].
#[derive(Debug, Clone, PartialEq)]
pub struct SortingModel {
    spec: ModelSpec,
    /// Normalised tables, index `position * K + viewpoint`; rows are kinds, columns labels.
    tables: Vec<DMatrix<f64>>,
    /// The first kind of each class, and behind them the number of kinds.
    first_kinds: Vec<usize>,
    arrival: DVector<f64>,
    rewards: Rewards,
    motion_cost: DMatrix<f64>,
    /// Shape (H, K).
    repeat: DMatrix<f64>,
    /// Where one move leads from each viewpoint, ascending.
    travel: Vec<Vec<Viewpoint>>,
}

impl SortingModel {
    /// Check a written-down model.
    ///
    /// # Errors
    /// [`crate::Error::Model`] naming the first value that does not fit, what was expected, and the remedy.
    pub fn new(spec: ModelSpec) -> Result<Self> {
        validate::validate(&spec)?;
        let (h, k, l) = (spec.p_obs.len(), spec.viewpoints.len(), spec.classes.len());
        let tables = spec.p_obs.iter().flatten().map(|rows| normalised_table(rows)).collect();
        let classes = match &spec.arrival {
            Some(prior) => normalised(prior),
            None => DVector::from_element(l, 1.0 / l as f64),
        };
        let first_kinds = first_kinds(&spec);
        let arrival = match &spec.modes {
            None => classes,
            Some(modes) => arriving_kinds(&classes, modes),
        };
        let rewards = Rewards::new(&spec);
        let motion_cost = spec.motion_cost.expand(k, k);
        let repeat = spec.repeat.as_ref().map_or_else(|| DMatrix::zeros(h, k), |repeat| repeat.expand(h, k));
        let travel = match &spec.travel {
            Some(lists) => lists.iter().map(|list| sorted(list)).collect(),
            None => vec![(0..k).map(Viewpoint).collect(); k],
        };
        Ok(Self { spec, tables, first_kinds, arrival, rewards, motion_cost, repeat, travel })
    }

    /// The model as it was written down.
    #[must_use]
    pub fn spec(&self) -> &ModelSpec {
        &self.spec
    }

    /// Observation table of a position seen from a viewpoint: rows are kinds, columns labels; shape (N, Z).
    #[must_use]
    pub fn table(&self, position: Position, viewpoint: Viewpoint) -> &DMatrix<f64> {
        &self.tables[position.0 * self.viewpoint_count() + viewpoint.0]
    }

    /// Prior of the kind of an arriving object, length N.
    #[must_use]
    pub fn arrival(&self) -> &DVector<f64> {
        &self.arrival
    }

    /// Discount per planner step.
    #[must_use]
    pub fn discount(&self) -> f64 {
        self.spec.discount
    }

    /// Cost of the move between two viewpoints.
    #[must_use]
    pub fn motion_cost(&self, from: Viewpoint, to: Viewpoint) -> f64 {
        self.motion_cost[(from.0, to.0)]
    }

    /// The viewpoints that one move from `viewpoint` reaches, ascending.
    #[must_use]
    pub fn legal_moves(&self, viewpoint: Viewpoint) -> &[Viewpoint] {
        &self.travel[viewpoint.0]
    }

    /// Whether a scan from where the camera stands follows every decision, within the same step.
    #[must_use]
    pub fn observes_after_decision(&self) -> bool {
        self.spec.observe_after_decision
    }

    /// Refuse what goes beyond the paper's model, for those whose proofs do not cover it.
    ///
    /// # Errors
    /// [`crate::Error::Model`] naming the key.
    pub(crate) fn check_plain(&self) -> Result<()> {
        let beyond = [
            ("repeat", self.ever_repeats()),
            ("observe_after_decision", self.spec.observe_after_decision),
            ("information_gain", self.spec.information_gain > 0.0),
        ];
        match beyond.iter().find(|(_, used)| *used) {
            Some((key, _)) => model_error(format!(
                "{key} is set, which solve has no proof for; leave it out, or plan with Despot, Threshold or \
                 InformationGain"
            )),
            None => Ok(()),
        }
    }

    /// The same model with the first `positions` belt positions only.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] unless `positions` lies between 1 and H.
    pub fn with_positions(&self, positions: usize) -> Result<Self> {
        if positions == 0 || positions > self.position_count() {
            return argument_error(format!(
                "positions = {positions}; the model has {}: keep between 1 and all of them",
                self.position_count()
            ));
        }
        let mut spec = self.spec.clone();
        spec.p_obs.truncate(positions);
        if let Some(counts) = &mut spec.counts {
            counts.truncate(positions);
        }
        if let Some(Smoothing::Tables(tables)) = &mut spec.smoothing {
            tables.truncate(positions);
        }
        if let Some(ScalarOrMatrix::Matrix(rows)) = &mut spec.repeat {
            rows.truncate(positions);
        }
        Self::new(spec)
    }
}

#[cfg(test)]
mod tests;

fn normalised_table(rows: &[Vec<f64>]) -> DMatrix<f64> {
    let mut table = DMatrix::from_fn(rows.len(), rows[0].len(), |n, z| rows[n][z]);
    for mut row in table.row_iter_mut() {
        row /= row.sum();
    }
    table
}

/// The first kind of each class, and behind them the number of kinds.
fn first_kinds(spec: &ModelSpec) -> Vec<usize> {
    let modes = |class: usize| spec.modes.as_ref().map_or(1, |modes| modes[class].len());
    let mut first = vec![0];
    for class in 0..spec.classes.len() {
        first.push(first[class] + modes(class));
    }
    first
}

/// The prior of an arriving object's kind: of its class, times the weight of its mode.
fn arriving_kinds(classes: &DVector<f64>, modes: &[Vec<f64>]) -> DVector<f64> {
    let of_class = |(p, weights): (&f64, &Vec<f64>)| normalised(weights) * *p;
    let kinds: Vec<f64> =
        classes.iter().zip(modes).flat_map(|pair| of_class(pair).data.as_vec().clone()).collect();
    DVector::from_vec(kinds)
}

fn normalised(prior: &[f64]) -> DVector<f64> {
    let prior = DVector::from_column_slice(prior);
    &prior / prior.sum()
}

fn sorted(list: &[usize]) -> Vec<Viewpoint> {
    let mut list: Vec<_> = list.iter().copied().map(Viewpoint).collect();
    list.sort_unstable();
    list
}
