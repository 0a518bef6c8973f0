//! The factored belief: one categorical distribution per belt position (eq. 7-8 of the paper).

use nalgebra::{DMatrix, DVectorView};

use crate::error::{Error, Result, argument_error};
use crate::model::{SortingModel, distribution};

/// `b^j_i`: the probability that the object at position j is of class i.
///
/// Objects are independent and each label depends on its own object only, so the product of these
/// distributions *is* the exact posterior, not an approximation.
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    /// Column j is the distribution of position j, so a position's entries are contiguous: shape (L, H).
    probabilities: DMatrix<f64>,
}

impl Belief {
    /// The arrival prior at every position.
    #[must_use]
    pub fn new(model: &SortingModel) -> Self {
        let arrival = model.arrival();
        Self {
            probabilities: DMatrix::from_fn(model.class_count(), model.position_count(), |c, _| arrival[c]),
        }
    }

    /// A belief of one given distribution per position, `rows[position][class]`.
    ///
    /// # Errors
    /// [`Error::Argument`] if the shape is not (H, L) or a row is no distribution (within 1e-6).
    pub fn from_rows(model: &SortingModel, rows: &[Vec<f64>]) -> Result<Self> {
        let (h, l) = (model.position_count(), model.class_count());
        if rows.len() != h || rows.iter().any(|row| row.len() != l) {
            return argument_error(format!(
                "probabilities have {} rows of lengths {:?}; expected shape ({h}, {l}), one distribution per position",
                rows.len(),
                rows.iter().map(Vec::len).collect::<Vec<_>>()
            ));
        }
        for (j, row) in rows.iter().enumerate() {
            distribution(&format!("probabilities[{j}]"), row).map_err(|e| Error::Argument(e.to_string()))?;
        }
        let mut probabilities = DMatrix::from_fn(l, h, |c, j| rows[j][c]);
        for mut column in probabilities.column_iter_mut() {
            column /= column.sum();
        }
        Ok(Self { probabilities })
    }

    /// The distribution of one position, length L.
    #[must_use]
    pub fn position(&self, position: usize) -> DVectorView<'_, f64> {
        self.probabilities.column(position)
    }

    /// All positions one after the other: entry `position * L + class`.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        self.probabilities.as_slice()
    }

    /// Number of positions H and of classes L.
    #[must_use]
    pub fn shape(&self) -> (usize, usize) {
        (self.probabilities.ncols(), self.probabilities.nrows())
    }

    /// The most likely class at a position (the lowest label among equals) and its probability.
    #[must_use]
    pub fn most_likely(&self, position: usize) -> (usize, f64) {
        most_likely(self.position(position).as_slice())
    }

    /// Probability of each label at each position if the camera scans from `viewpoint`, `(L, H)` with a column
    /// per position: `P(z^j | b, v) = sum_c b^j_c o^j(z | v, c)`.
    ///
    /// # Errors
    /// [`Error::Argument`] if the viewpoint does not exist.
    pub fn label_probabilities(&self, model: &SortingModel, viewpoint: usize) -> Result<DMatrix<f64>> {
        model.check_viewpoint(viewpoint)?;
        let mut predicted = DMatrix::zeros(model.class_count(), model.position_count());
        for (j, mut column) in predicted.column_iter_mut().enumerate() {
            column.copy_from(&model.table(j, viewpoint).tr_mul(&self.position(j)));
        }
        Ok(predicted)
    }

    /// Bayes' rule for one scan (eq. 7): `b^j_c` becomes proportional to `b^j_c o^j(z^j | v, c)`.
    ///
    /// `labels` holds one entry per position, `None` where nothing was seen.
    ///
    /// # Errors
    /// [`Error::Argument`] for a wrong number of labels, a label or viewpoint out of range;
    /// [`Error::ImpossibleObservation`] for a label of probability zero. The belief is then unchanged.
    pub fn observe(
        &mut self,
        model: &SortingModel,
        viewpoint: usize,
        labels: &[Option<usize>],
    ) -> Result<()> {
        model.check_viewpoint(viewpoint)?;
        if labels.len() != model.position_count() {
            return argument_error(format!(
                "{} labels for {} positions; give one label (or none) per position, the belt end first",
                labels.len(),
                model.position_count()
            ));
        }
        let mut posterior = self.probabilities.clone();
        for (j, label) in labels.iter().enumerate() {
            let Some(z) = *label else { continue };
            model.check_label(z)?;
            let mut column = posterior.column_mut(j);
            column.component_mul_assign(&model.table(j, viewpoint).column(z));
            let total = column.sum();
            if total < f64::MIN_POSITIVE {
                return Err(Error::ImpossibleObservation {
                    position: j,
                    viewpoint: model.spec().viewpoints[viewpoint].clone(),
                    label: model.spec().classes[z].clone(),
                });
            }
            column /= total;
        }
        self.probabilities = posterior;
        Ok(())
    }

    /// The belt advances (eq. 8): beliefs shift by one position, the last starts from the arrival prior.
    pub fn advance(&mut self, model: &SortingModel) {
        let last = self.probabilities.ncols() - 1;
        for j in 0..last {
            let next = self.probabilities.column(j + 1).clone_owned();
            self.probabilities.set_column(j, &next);
        }
        self.probabilities.set_column(last, model.arrival());
    }

    /// Check that this belief has the model's shape.
    ///
    /// # Errors
    /// [`Error::Argument`] naming both shapes.
    pub fn check_fits(&self, model: &SortingModel) -> Result<()> {
        let expected = (model.position_count(), model.class_count());
        if self.shape() == expected {
            return Ok(());
        }
        argument_error(format!(
            "the belief has shape {:?} (positions, classes), the model {expected:?}; make it with Belief(model)",
            self.shape()
        ))
    }
}

/// The largest entry of a distribution (the first among equals) and its index.
pub(crate) fn most_likely(distribution: &[f64]) -> (usize, f64) {
    let mut best = (0, distribution[0]);
    for (label, &p) in distribution.iter().enumerate().skip(1) {
        if p > best.1 {
            best = (label, p);
        }
    }
    best
}

#[cfg(test)]
mod tests;
