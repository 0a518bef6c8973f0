//! The likelihood of a label, `P(z | j, v, n)`, given the last label from the same viewpoint.
//!
//! Two looks from one viewpoint at one object that has not moved share pose and view, so they agree far more often
//! than independence says. With probability `repeat` the second only returns the label of the first:
//!
//! `P(z' | z, v, c) = repeat [z' = z] + (1 - repeat) P(z' | v, c)`.

use super::SortingModel;
use crate::index::{Kind, Label, Position, Viewpoint};

/// One look at one object, before its label is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// Belt position of the object.
    pub position: Position,
    /// Where the camera stands.
    pub viewpoint: Viewpoint,
    /// The label that the object gave from there before, if the model can repeat it.
    pub last: Option<Label>,
}

impl Look {
    /// A look at an object that has given no label from there.
    #[must_use]
    #[inline(always)]
    pub fn first(position: Position, viewpoint: Viewpoint) -> Self {
        Self { position, viewpoint, last: None }
    }
}

impl SortingModel {
    /// Probability that a second look from `viewpoint` at `position` only repeats its label.
    #[must_use]
    #[inline(always)]
    pub fn repeat(&self, position: Position, viewpoint: Viewpoint) -> f64 {
        self.repeat[(position.0, viewpoint.0)]
    }

    /// Whether any look may repeat an earlier one.
    #[must_use]
    pub fn ever_repeats(&self) -> bool {
        self.repeat.iter().any(|repeat| *repeat > 0.0)
    }

    /// `P(label | kind)` of a look.
    #[must_use]
    pub fn likelihood(&self, look: Look, label: Label, kind: Kind) -> f64 {
        let (repeated, fresh) = self.mixture(look, label);
        repeated + fresh * self.table(look.position, look.viewpoint)[(kind.0, label.0)]
    }

    /// The likelihood of `label` for one kind after the other.
    #[inline(always)]
    pub fn likelihoods(&self, look: Look, label: Label) -> impl Iterator<Item = f64> + Clone + '_ {
        let (repeated, fresh) = self.mixture(look, label);
        let n = self.kind_count();
        // Tables lie column by column.
        let column = &self.table(look.position, look.viewpoint).as_slice()[label.0 * n..][..n];
        column.iter().map(move |p| repeated + fresh * p)
    }

    /// The distribution of the label that an object of a kind gives.
    pub fn label_distribution(&self, look: Look, kind: Kind) -> impl Iterator<Item = f64> + '_ {
        self.labels().map(move |label| self.likelihood(look, label, kind))
    }

    /// Probability that the label only repeats the one before it, and the weight of the table.
    #[inline(always)]
    fn mixture(&self, look: Look, label: Label) -> (f64, f64) {
        match look.last {
            None => (0.0, 1.0),
            Some(last) => {
                let repeat = self.repeat(look.position, look.viewpoint);
                (if last == label { repeat } else { 0.0 }, 1.0 - repeat)
            }
        }
    }
}
