//! What a scan tells: `P(z | j, v, c)`, given what the last scan from there told.
//!
//! Two looks from one viewpoint at one object that has not moved share pose and view, so they agree far more often
//! than independence says. With probability `repeat` the second only returns the label of the first:
//!
//! `P(z' | z, v, c) = repeat [z' = z] + (1 - repeat) P(z' | v, c)`.

use super::SortingModel;

impl SortingModel {
    /// Probability that a second look from `viewpoint` at `position` only repeats its label.
    #[must_use]
    #[inline(always)]
    pub fn repeat(&self, position: usize, viewpoint: usize) -> f64 {
        self.repeat[(position, viewpoint)]
    }

    /// Whether any look may repeat an earlier one.
    #[must_use]
    pub fn ever_repeats(&self) -> bool {
        self.repeat.iter().any(|repeat| *repeat > 0.0)
    }

    /// `P(label | class)` at a position seen from a viewpoint, `last` being the label that it gave from there before.
    #[must_use]
    pub fn likelihood(
        &self,
        position: usize,
        viewpoint: usize,
        last: Option<usize>,
        label: usize,
        class: usize,
    ) -> f64 {
        let (repeated, fresh) = self.mixture(position, viewpoint, last, label);
        repeated + fresh * self.table(position, viewpoint)[(class, label)]
    }

    /// The likelihood of `label` for one class after the other.
    #[inline(always)]
    pub fn likelihoods(
        &self,
        position: usize,
        viewpoint: usize,
        last: Option<usize>,
        label: usize,
    ) -> impl Iterator<Item = f64> + Clone + '_ {
        let (repeated, fresh) = self.mixture(position, viewpoint, last, label);
        let l = self.class_count();
        // Tables lie column by column.
        let column = &self.table(position, viewpoint).as_slice()[label * l..][..l];
        column.iter().map(move |p| repeated + fresh * p)
    }

    /// The distribution of the label that an object of `class` gives.
    pub fn label_distribution(
        &self,
        position: usize,
        viewpoint: usize,
        last: Option<usize>,
        class: usize,
    ) -> impl Iterator<Item = f64> + '_ {
        (0..self.class_count()).map(move |label| self.likelihood(position, viewpoint, last, label, class))
    }

    /// What a label owes to the one before it, and the weight of the table.
    #[inline(always)]
    fn mixture(&self, position: usize, viewpoint: usize, last: Option<usize>, label: usize) -> (f64, f64) {
        match last {
            None => (0.0, 1.0),
            Some(last) => {
                let repeat = self.repeat(position, viewpoint);
                (if last == label { repeat } else { 0.0 }, 1.0 - repeat)
            }
        }
    }
}
