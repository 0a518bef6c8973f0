//! The last label of each position from each viewpoint, since the belt last moved.
//!
//! It is observed, not hidden: with it the posterior stays a product over positions. Only what the model can repeat is
//! remembered, so that equal memories are equal states, and a model that repeats nothing pays nothing.

use crate::error::{Result, argument_error};
use crate::index::{Label, Position, Viewpoint};
use crate::model::{Look, SortingModel};

/// Last labels; see [`SortingModel::likelihood`].
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub(crate) struct Memory {
    /// Entry `position * K + viewpoint`; no entries for a model that never repeats.
    labels: Vec<Option<Label>>,
}

impl Memory {
    /// Nothing seen yet.
    pub(crate) fn new(model: &SortingModel) -> Self {
        Self { labels: vec![None; Self::entries(model)] }
    }

    /// The last labels as rows `[position][viewpoint]`.
    pub(super) fn from_rows(model: &SortingModel, rows: &[Vec<Option<Label>>]) -> Result<Self> {
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
        for (position, row) in model.positions().zip(rows) {
            for (viewpoint, label) in model.viewpoints().zip(row) {
                let Some(label) = *label else { continue };
                model.check_label(label)?;
                memory.remember(model, position, viewpoint, label);
            }
        }
        Ok(memory)
    }

    /// The last label of a position from a viewpoint.
    #[inline(always)]
    pub(crate) fn last(
        &self,
        model: &SortingModel,
        position: Position,
        viewpoint: Viewpoint,
    ) -> Option<Label> {
        self.labels.get(Self::entry(model, position, viewpoint)).copied().flatten()
    }

    /// The next look from a viewpoint at the object at a position.
    #[inline(always)]
    pub(crate) fn look(&self, model: &SortingModel, position: Position, viewpoint: Viewpoint) -> Look {
        Look { position, viewpoint, last: self.last(model, position, viewpoint) }
    }

    /// Take note of a label, if the model can repeat it.
    pub(crate) fn remember(
        &mut self,
        model: &SortingModel,
        position: Position,
        viewpoint: Viewpoint,
        label: Label,
    ) {
        if model.repeat(position, viewpoint) > 0.0
            && let Some(last) = self.labels.get_mut(Self::entry(model, position, viewpoint))
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

    #[inline(always)]
    fn entry(model: &SortingModel, position: Position, viewpoint: Viewpoint) -> usize {
        position.0 * model.viewpoint_count() + viewpoint.0
    }

    fn entries(model: &SortingModel) -> usize {
        if model.ever_repeats() { model.position_count() * model.viewpoint_count() } else { 0 }
    }
}
