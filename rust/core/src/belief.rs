//! The factored belief: one categorical distribution per belt position (eq. 7-8 of the paper).

mod bayes;
mod information;
mod memory;

use nalgebra::{DMatrix, DVectorView};

pub(crate) use bayes::{condition, evidence, joint};
pub(crate) use information::{Groups, class_entropy, information};
pub(crate) use memory::Memory;

use crate::error::{Error, Result, argument_error};
use crate::index::{Bin, Class, Kind, Label, Position, Viewpoint};
use crate::model::{Look, SortingModel, distribution, shift};
use crate::remaining::Remaining;

/// A row that misses 1 by no more than this is a belief's own, written down: it is taken as it is, to the last bit.
const ROUNDING: f64 = 1e-12;

/// `b^j_n`: the probability that the object at position j is of kind n, which is its class in the paper's model.
///
/// Objects are independent and each label depends on its own object only, so the product of these
/// distributions *is* the exact posterior, not an approximation. Where looks repeat, the labels seen since the belt
/// last moved are part of the belief.
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    /// Column j is the distribution of position j, so a position's entries are contiguous: shape (N, H).
    probabilities: DMatrix<f64>,
    memory: Memory,
    remaining: Remaining,
}

impl Belief {
    /// The arrival prior at every position.
    #[must_use]
    pub fn new(model: &SortingModel) -> Self {
        let arrival = model.arrival();
        Self {
            probabilities: DMatrix::from_fn(model.kind_count(), model.position_count(), |n, _| arrival[n]),
            memory: Memory::new(model),
            remaining: Remaining::ENDLESS,
        }
    }

    /// A belief of one given distribution per position, `rows[position][class]` or `rows[position][kind]`. A class's
    /// probability is divided among its modes by their weights.
    ///
    /// # Errors
    /// [`Error::Argument`] if the shape is neither (H, L) nor (H, N) or a row is no distribution (within 1e-6).
    pub fn from_rows(model: &SortingModel, rows: &[Vec<f64>]) -> Result<Self> {
        let (h, l, n) = (model.position_count(), model.class_count(), model.kind_count());
        let of_shape = |entries| rows.len() == h && rows.iter().all(|row| row.len() == entries);
        if !of_shape(l) && !of_shape(n) {
            let kinds =
                if model.has_modes() { format!(" or ({h}, {n}), modes included") } else { String::new() };
            return argument_error(format!(
                "probabilities have {} rows of lengths {:?}; expected shape ({h}, {l}){kinds}, one distribution per position",
                rows.len(),
                rows.iter().map(Vec::len).collect::<Vec<_>>()
            ));
        }
        for (j, row) in rows.iter().enumerate() {
            distribution(&format!("probabilities[{j}]"), row).map_err(|e| Error::Argument(e.to_string()))?;
        }
        let entry = |kind: usize, row: &[f64]| {
            if row.len() == n {
                row[kind]
            } else {
                row[model.class_of(Kind(kind)).0] * model.mode_weight(Kind(kind))
            }
        };
        let mut probabilities = DMatrix::from_fn(n, h, |kind, j| entry(kind, &rows[j]));
        for mut column in probabilities.column_iter_mut() {
            let sum = column.sum();
            if (sum - 1.0).abs() > ROUNDING {
                column /= sum;
            }
        }
        Ok(Self { probabilities, memory: Memory::new(model), remaining: Remaining::ENDLESS })
    }

    /// The same belief after other last labels, `rows[position][viewpoint]`; those that the model cannot repeat are
    /// forgotten.
    ///
    /// # Errors
    /// [`Error::Argument`] if the shape is not (H, K) or a label does not exist.
    pub fn with_last_labels(self, model: &SortingModel, rows: &[Vec<Option<Label>>]) -> Result<Self> {
        Ok(Self { memory: Memory::from_rows(model, rows)?, ..self })
    }

    /// The same belief about a belt with so many objects left to decide, the one at the belt end included; `None` for one
    /// that never ends.
    #[must_use]
    pub fn with_remaining(self, remaining: Option<usize>) -> Self {
        Self { remaining: Remaining(remaining), ..self }
    }

    /// Objects left to decide, the one at the belt end included; `None` for a belt that never ends.
    #[must_use]
    pub fn remaining(&self) -> Option<usize> {
        self.remaining.0
    }

    /// The distribution of the kind at one position, length N.
    #[must_use]
    pub fn position(&self, position: Position) -> DVectorView<'_, f64> {
        self.probabilities.column(position.0)
    }

    /// The label that a position last gave from a viewpoint since the belt moved; `None` too where none is repeated.
    #[must_use]
    pub fn last_label(
        &self,
        model: &SortingModel,
        position: Position,
        viewpoint: Viewpoint,
    ) -> Option<Label> {
        self.memory.last(model, position, viewpoint)
    }

    /// The next look from a viewpoint at the object at a position.
    pub(crate) fn look(&self, model: &SortingModel, position: Position, viewpoint: Viewpoint) -> Look {
        self.memory.look(model, position, viewpoint)
    }

    /// All positions one after the other: entry `position * N + kind`.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        self.probabilities.as_slice()
    }

    /// The same of the positions at which objects are left to decide.
    pub(crate) fn visible(&self) -> &[f64] {
        let (positions, kinds) = self.shape();
        &self.as_slice()[..self.remaining.visible(positions) * kinds]
    }

    /// Number of positions H and of kinds N.
    #[must_use]
    pub fn shape(&self) -> (usize, usize) {
        (self.probabilities.ncols(), self.probabilities.nrows())
    }

    /// The most likely class at a position (the first among equals) and its probability.
    #[must_use]
    pub fn most_likely(&self, model: &SortingModel, position: Position) -> (Class, f64) {
        model.most_likely_class(self.position(position).as_slice())
    }

    /// The decision on the object at the belt end that earns most, and its expected reward.
    #[must_use]
    pub fn best_decision(&self, model: &SortingModel) -> (Bin, f64) {
        model.best_decision(self.position(Position(0)).as_slice())
    }

    /// Probability of each label at each position if the camera scans from `viewpoint`, `(Z, H)` with a column
    /// per position: `P(z^j | b, v) = sum_n b^j_n P(z | j, v, n)`, see [`SortingModel::likelihood`].
    ///
    /// # Errors
    /// [`Error::Argument`] if the viewpoint does not exist.
    pub fn label_probabilities(&self, model: &SortingModel, viewpoint: Viewpoint) -> Result<DMatrix<f64>> {
        model.check_viewpoint(viewpoint)?;
        Ok(DMatrix::from_fn(model.label_count(), model.position_count(), |z, j| {
            self.label_probability(model, self.look(model, Position(j), viewpoint), Label(z))
        }))
    }

    fn label_probability(&self, model: &SortingModel, look: Look, label: Label) -> f64 {
        evidence(self.position(look.position).as_slice(), model.likelihoods(look, label))
    }

    /// Bayes' rule for one scan (eq. 7): `b^j_n` becomes proportional to `b^j_n P(z^j | j, v, n)`.
    ///
    /// `labels` holds one entry per position, `None` where nothing was seen.
    ///
    /// # Errors
    /// [`Error::Argument`] for a wrong number of labels, a label or viewpoint out of range;
    /// [`Error::ImpossibleObservation`] for a label of probability zero. The belief is then unchanged.
    pub fn observe(
        &mut self,
        model: &SortingModel,
        viewpoint: Viewpoint,
        labels: &[Option<Label>],
    ) -> Result<()> {
        model.check_viewpoint(viewpoint)?;
        if labels.len() != model.position_count() {
            return argument_error(format!(
                "{} labels for {} positions; give one label (or none) per position, the belt end first",
                labels.len(),
                model.position_count()
            ));
        }
        let mut posterior = self.clone();
        for (position, label) in model.positions().zip(labels) {
            if let Some(label) = *label {
                model.check_label(label)?;
                posterior.observe_one(model, position, viewpoint, label)?;
            }
        }
        *self = posterior;
        Ok(())
    }

    /// Bayes' rule for the label of one position; its indices must exist.
    ///
    /// # Errors
    /// [`Error::ImpossibleObservation`] for a label of probability zero. The belief is then unchanged.
    pub(crate) fn observe_one(
        &mut self,
        model: &SortingModel,
        position: Position,
        viewpoint: Viewpoint,
        label: Label,
    ) -> Result<()> {
        let look = self.look(model, position, viewpoint);
        let mut column = self.probabilities.column_mut(position.0);
        if condition(column.as_mut_slice(), model.likelihoods(look, label)) == 0.0 {
            return Err(Error::ImpossibleObservation {
                position,
                viewpoint: model.viewpoint_name(viewpoint).to_owned(),
                label: model.label_name(label).to_owned(),
            });
        }
        self.memory.remember(model, position, viewpoint, label);
        Ok(())
    }

    /// The belt advances (eq. 8): beliefs shift by one position, the last starts from the arrival prior. No object is
    /// where it was: last labels are forgotten.
    pub fn advance(&mut self, model: &SortingModel) {
        shift(self.probabilities.as_mut_slice(), model.arrival().as_slice().iter().copied());
        self.memory.clear();
        self.remaining = self.remaining.after(1);
    }

    /// All positions one after the other, and the objects left to decide: what bounds of the value depend on.
    pub(crate) fn known(&self) -> (&[f64], Remaining) {
        (self.as_slice(), self.remaining)
    }

    /// Objects left to decide.
    pub(crate) fn objects_left(&self) -> Remaining {
        self.remaining
    }

    /// Check that this belief has the model's shape, and that there is something to plan for.
    ///
    /// # Errors
    /// [`Error::Argument`] naming both shapes, or that no object is left to decide.
    pub fn check_fits(&self, model: &SortingModel) -> Result<()> {
        if self.remaining.is_over() {
            return argument_error("the belief has remaining = 0: no object is left to decide; stop here");
        }
        let expected = (model.position_count(), model.kind_count());
        if self.shape() == expected && self.memory.fits(model) {
            return Ok(());
        }
        argument_error(format!(
            "the belief has shape {:?} (positions, kinds) or a memory that does not fit the model, which has \
             {expected:?}; make it with Belief(model)",
            self.shape()
        ))
    }
}

/// The most likely entry of a distribution (the first among equals) and its probability.
#[inline(always)]
pub(crate) fn most_likely(distribution: &[f64]) -> (usize, f64) {
    let mut best = (0, distribution[0]);
    for (entry, &p) in distribution.iter().enumerate().skip(1) {
        if p > best.1 {
            best = (entry, p);
        }
    }
    best
}

#[cfg(test)]
mod tests;
