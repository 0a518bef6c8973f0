//! The last label of each position from each viewpoint, since the belt last moved.
//!
//! It is observed, not hidden: with it the posterior stays a product over positions. Only what the model can repeat is
//! remembered, so that equal memories are equal states, and a model that repeats nothing pays nothing.

use crate::error::{Result, argument_error};
use crate::model::SortingModel;

/// Last labels; see [`SortingModel::likelihood`].
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub(crate) struct Memory {
    /// Entry `position * K + viewpoint`; no entries for a model that never repeats.
    labels: Vec<Option<usize>>,
}

impl Memory {
    /// Nothing seen yet.
    pub(crate) fn new(model: &SortingModel) -> Self {
        Self { labels: vec![None; Self::entries(model)] }
    }

    /// The last labels as rows `[position][viewpoint]`.
    pub(super) fn from_rows(model: &SortingModel, rows: &[Vec<Option<usize>>]) -> Result<Self> {
        let (h, k) = (model.position_count(), model.viewpoint_count());
        if rows.len() != h || rows.iter().any(|row| row.len() != k) {
            return argument_error(format!(
                "last_labels have {} rows of lengths {:?}; expected shape ({h}, {k}), one entry per position and \
                 viewpoint, none where there is no label",
                rows.len(),
                rows.iter().map(Vec::len).collect::<Vec<_>>()
            ));
        }
        let mut memory = Self::new(model);
        for (position, row) in rows.iter().enumerate() {
            for (viewpoint, label) in row.iter().enumerate() {
                let Some(label) = *label else { continue };
                model.check_label(label)?;
                memory.remember(model, position, viewpoint, label);
            }
        }
        Ok(memory)
    }

    /// The last label of a position from a viewpoint.
    #[inline(always)]
    pub(crate) fn last(&self, model: &SortingModel, position: usize, viewpoint: usize) -> Option<usize> {
        self.labels.get(position * model.viewpoint_count() + viewpoint).copied().flatten()
    }

    /// Take note of a label, if the model can repeat it.
    pub(crate) fn remember(&mut self, model: &SortingModel, position: usize, viewpoint: usize, label: usize) {
        if model.repeat(position, viewpoint) > 0.0
            && let Some(last) = self.labels.get_mut(position * model.viewpoint_count() + viewpoint)
        {
            *last = Some(label);
        }
    }

    /// The belt moves: every object changes its position, and no look is a second one.
    pub(crate) fn clear(&mut self) {
        self.labels.fill(None);
    }

    /// Whether this is the memory of such a model.
    pub(super) fn fits(&self, model: &SortingModel) -> bool {
        self.labels.len() == Self::entries(model)
    }

    fn entries(model: &SortingModel) -> usize {
        if model.ever_repeats() { model.position_count() * model.viewpoint_count() } else { 0 }
    }
}
