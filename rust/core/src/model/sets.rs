//! The sets of the model (eq. 1-2): their sizes, their members, and checks that an index is one.

use super::SortingModel;
use crate::error::{Result, argument_error};
use crate::index::{Class, Label, Position, Viewpoint};

impl SortingModel {
    /// H, the number of belt positions seen at once.
    #[must_use]
    pub fn position_count(&self) -> usize {
        self.spec.p_obs.len()
    }

    /// K, the number of viewpoints.
    #[must_use]
    pub fn viewpoint_count(&self) -> usize {
        self.spec.viewpoints.len()
    }

    /// L, the number of classes.
    #[must_use]
    pub fn class_count(&self) -> usize {
        self.spec.classes.len()
    }

    /// The number of labels that one look may yield: one per class.
    #[must_use]
    pub fn label_count(&self) -> usize {
        self.class_count()
    }

    /// The belt positions, the belt end first.
    pub fn positions(&self) -> impl DoubleEndedIterator<Item = Position> + Clone + use<> {
        (0..self.position_count()).map(Position)
    }

    /// The viewpoints.
    pub fn viewpoints(&self) -> impl DoubleEndedIterator<Item = Viewpoint> + Clone + use<> {
        (0..self.viewpoint_count()).map(Viewpoint)
    }

    /// The classes.
    pub fn classes(&self) -> impl DoubleEndedIterator<Item = Class> + Clone + use<> {
        (0..self.class_count()).map(Class)
    }

    /// The labels.
    pub fn labels(&self) -> impl DoubleEndedIterator<Item = Label> + Clone + use<> {
        (0..self.label_count()).map(Label)
    }

    /// Check that a belt position exists.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] naming the valid range.
    pub fn check_position(&self, position: Position) -> Result<()> {
        if position.0 < self.position_count() {
            return Ok(());
        }
        argument_error(format!("position {position} is out of range: 0 to {}", self.position_count() - 1))
    }

    /// Check that a viewpoint exists.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] naming the valid range.
    pub fn check_viewpoint(&self, viewpoint: Viewpoint) -> Result<()> {
        check_named("viewpoint", viewpoint.0, &self.spec.viewpoints)
    }

    /// Check that a class exists; to users it is a label.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] naming the valid range.
    pub fn check_class(&self, class: Class) -> Result<()> {
        check_named("label", class.0, &self.spec.classes)
    }

    /// Check that a label exists.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] naming the valid range.
    pub fn check_label(&self, label: Label) -> Result<()> {
        check_named("label", label.0, &self.spec.classes)
    }

    /// The name of a viewpoint, which must exist.
    pub(crate) fn viewpoint_name(&self, viewpoint: Viewpoint) -> &str {
        &self.spec.viewpoints[viewpoint.0]
    }

    /// The name of a label, which must exist.
    pub(crate) fn label_name(&self, label: Label) -> &str {
        &self.spec.classes[label.0]
    }
}

fn check_named(what: &str, index: usize, names: &[String]) -> Result<()> {
    if index < names.len() {
        return Ok(());
    }
    argument_error(format!("{what} {index} is out of range: 0 to {} ({})", names.len() - 1, names.join(", ")))
}
