//! The sets of the model (eq. 1-2): their sizes, their members, and checks that an index is one.

use super::SortingModel;
use crate::error::{Result, argument_error};
use crate::index::{Bin, Class, Kind, Label, Position, Viewpoint};
use crate::names::index_of;

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

    /// N, the number of kinds: of the modes of all classes.
    #[must_use]
    #[inline(always)]
    pub fn kind_count(&self) -> usize {
        self.arrival.len()
    }

    /// Z, the number of labels that one look may yield.
    #[must_use]
    #[inline(always)]
    pub fn label_count(&self) -> usize {
        self.label_names().len()
    }

    /// B, the number of bins that a decision chooses from.
    #[must_use]
    pub fn bin_count(&self) -> usize {
        self.bin_names().len()
    }

    /// Whether some class has several modes.
    #[must_use]
    #[inline(always)]
    pub fn has_modes(&self) -> bool {
        self.kind_count() != self.class_count()
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

    /// The kinds, ordered by class.
    pub fn kinds(&self) -> impl DoubleEndedIterator<Item = Kind> + Clone + use<> {
        (0..self.kind_count()).map(Kind)
    }

    /// The kinds of one class, by their numbers.
    #[must_use]
    #[inline(always)]
    pub fn kinds_of(&self, class: Class) -> std::ops::Range<usize> {
        self.first_kinds[class.0]..self.first_kinds[class.0 + 1]
    }

    /// The class of a kind.
    #[must_use]
    pub fn class_of(&self, kind: Kind) -> Class {
        Class(self.first_kinds.partition_point(|first| *first <= kind.0) - 1)
    }

    /// Weight of a kind's mode among those of its class: how likely an arriving object of the class has it.
    #[must_use]
    pub fn mode_weight(&self, kind: Kind) -> f64 {
        let class = self.class_of(kind);
        let Some(modes) = &self.spec.modes else { return 1.0 };
        let weights = &modes[class.0];
        weights[kind.0 - self.first_kinds[class.0]] / weights.iter().sum::<f64>()
    }

    /// The bins.
    pub fn bins(&self) -> impl DoubleEndedIterator<Item = Bin> + Clone + use<> {
        (0..self.bin_count()).map(Bin)
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
        let last = self.position_count() - 1;
        argument_error(format!("index {position} of a position is out of range: 0, the belt end, to {last}"))
    }

    /// Check that a viewpoint exists.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] naming the valid range.
    pub fn check_viewpoint(&self, viewpoint: Viewpoint) -> Result<()> {
        check_named("viewpoint", viewpoint.0, &self.spec.viewpoints)
    }

    /// Check that a class exists.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] naming the valid range.
    pub fn check_class(&self, class: Class) -> Result<()> {
        check_named("class", class.0, &self.spec.classes)
    }

    /// Check that a bin exists.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] naming the valid range.
    pub fn check_bin(&self, bin: Bin) -> Result<()> {
        check_named(if self.spec.bins.is_some() { "bin" } else { "label" }, bin.0, self.bin_names())
    }

    /// Check that a label exists.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] naming the valid range.
    pub fn check_label(&self, label: Label) -> Result<()> {
        check_named("label", label.0, self.label_names())
    }

    /// The viewpoint of a name.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] naming the nearest viewpoint, and all.
    pub fn viewpoint_named(&self, name: &str) -> Result<Viewpoint> {
        index_of("viewpoint", name, &self.spec.viewpoints).map(Viewpoint)
    }

    /// The class of a name.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] naming the nearest class, and all.
    pub fn class_named(&self, name: &str) -> Result<Class> {
        index_of("class", name, &self.spec.classes).map(Class)
    }

    /// The label of a name.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] naming the nearest label, and all.
    pub fn label_named(&self, name: &str) -> Result<Label> {
        index_of("label", name, self.label_names()).map(Label)
    }

    /// The name of a viewpoint, which must exist.
    pub(crate) fn viewpoint_name(&self, viewpoint: Viewpoint) -> &str {
        &self.spec.viewpoints[viewpoint.0]
    }

    /// The name of a label, which must exist.
    pub(crate) fn label_name(&self, label: Label) -> &str {
        &self.label_names()[label.0]
    }

    /// Names of the labels: those given, or the classes.
    #[must_use]
    pub fn label_names(&self) -> &[String] {
        self.spec.labels.as_ref().unwrap_or(&self.spec.classes)
    }

    /// Names of the bins: those given, or the classes.
    #[must_use]
    pub fn bin_names(&self) -> &[String] {
        self.spec.bins.as_ref().unwrap_or(&self.spec.classes)
    }
}

fn check_named(what: &str, index: usize, names: &[String]) -> Result<()> {
    if index < names.len() {
        return Ok(());
    }
    argument_error(format!("{what} {index} is out of range: 0 to {} ({})", names.len() - 1, names.join(", ")))
}
