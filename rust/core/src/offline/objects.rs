//! What is known of single objects, each belief once, with where every look at it leads.
//!
//! A belief about all visible objects is a product, so it is a short list of these; few of them make up many.

use std::collections::HashMap;
use std::ops::Range;

use super::upper::{GridBound, posteriors};
use crate::index::{Position, Viewpoint};
use crate::model::{Look, SortingModel};

/// Beliefs that agree to this much count as equal; it moves a value by less than [`super::SLACK`].
const RESOLUTION: f64 = 1e-11;
/// No look yet.
const NONE: u32 = u32::MAX;

/// A belief about one object.
pub(super) type ObjectId = u32;

/// An arriving one.
pub(super) const ARRIVING: ObjectId = 0;

/// All of them.
pub(super) struct Objects<'a> {
    model: &'a SortingModel,
    grid: Option<&'a GridBound>,
    /// N probabilities each.
    beliefs: Vec<f64>,
    /// N grid points and weights each, if there is a grid.
    located: Vec<(u32, f64)>,
    /// Where the outcomes of a look begin: per object, position and viewpoint.
    looks: Vec<u32>,
    /// Next object and probability of each label: Z per look.
    outcomes: Vec<(ObjectId, f64)>,
    known: HashMap<Box<[u64]>, ObjectId>,
}

impl<'a> Objects<'a> {
    pub(super) fn new(model: &'a SortingModel, grid: Option<&'a GridBound>) -> Self {
        let mut objects = Self {
            model,
            grid,
            beliefs: Vec::new(),
            located: Vec::new(),
            looks: Vec::new(),
            outcomes: Vec::new(),
            known: HashMap::new(),
        };
        let arriving = objects.id(model.arrival().as_slice());
        debug_assert_eq!(arriving, ARRIVING);
        objects
    }

    /// The object of a belief, new or known.
    pub(super) fn id(&mut self, belief: &[f64]) -> ObjectId {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a probability over 1e-11
        let key: Box<[u64]> = belief.iter().map(|b| (b / RESOLUTION).round() as u64).collect();
        // Fewer than nodes of the graph: see `super::graph::MOST_NODES`.
        #[allow(clippy::cast_possible_truncation)]
        let new = (self.beliefs.len() / belief.len()) as ObjectId;
        let id = *self.known.entry(key).or_insert(new);
        if id == new {
            self.beliefs.extend(belief);
            let looks = self.model.position_count() * self.model.viewpoint_count();
            self.looks.resize(self.looks.len() + looks, NONE);
            if let Some(grid) = self.grid {
                self.located.extend(grid.axis.grid.locate(belief));
                self.located.resize(self.beliefs.len(), (0, 0.0));
            }
        }
        id
    }

    pub(super) fn belief(&self, object: ObjectId) -> &[f64] {
        let n = self.model.kind_count();
        &self.beliefs[object as usize * n..][..n]
    }

    /// Its place on the grid.
    pub(super) fn located(&self, object: ObjectId) -> &[(u32, f64)] {
        let n = self.model.kind_count();
        &self.located[object as usize * n..][..n]
    }

    /// Next object and probability of each label.
    pub(super) fn outcomes(&self, look: Range<usize>) -> &[(ObjectId, f64)] {
        &self.outcomes[look]
    }

    /// Where the outcomes of looking at an object are.
    pub(super) fn look(
        &mut self,
        object: ObjectId,
        position: Position,
        viewpoint: Viewpoint,
    ) -> Range<usize> {
        let index = (object as usize * self.model.position_count() + position.0)
            * self.model.viewpoint_count()
            + viewpoint.0;
        if self.looks[index] == NONE {
            let seen: Vec<_> = posteriors(self.model, Look::first(position, viewpoint), self.belief(object))
                .into_iter()
                .map(|(p, posterior)| (self.id(&posterior), p))
                .collect();
            let start = self.outcomes.len();
            self.outcomes.extend(seen);
            // Z times the number of looks, which is bounded like that of objects.
            #[allow(clippy::cast_possible_truncation)]
            let start = start as u32;
            self.looks[index] = start;
        }
        let start = self.looks[index] as usize;
        start..start + self.model.label_count()
    }
}
