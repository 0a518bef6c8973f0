//! The bound as plain data, to store it.

use serde::{Deserialize, Serialize};

use super::PricedBound;
use super::faces::Faces;
use super::improvement::GRADING;
use super::object::ObjectModel;
use super::points::Points;
use super::problem::Values;
use super::shared::Shared;
use crate::model::SortingModel;

/// What [`PricedBound::restored`] takes, besides the model.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in super::super) struct SavedPrices {
    /// States of a face, and intervals of its grid.
    faces: (usize, usize),
    clock: usize,
    /// Beliefs of the nodes at each position.
    nodes: Vec<Vec<Vec<f64>>>,
    /// A table per mode and position.
    values: Vec<Vec<f64>>,
}

impl PricedBound {
    pub(in super::super) fn to_saved(&self) -> SavedPrices {
        let (faces, nodes) = self.points.parts();
        let (clock, values) = (self.shared.clock(), self.values.tables().to_vec());
        SavedPrices { faces: faces.resolution(), clock, nodes, values }
    }

    /// The bound of a model from what was saved; nothing if that cannot be of this model.
    pub(in super::super) fn restored(model: &SortingModel, saved: SavedPrices) -> Option<Self> {
        let object = ObjectModel::new(model);
        let ((size, intervals), states) = (saved.faces, object.states());
        let of_states = |belief: &Vec<f64>| belief.len() == states;
        let fits = (1..=states).contains(&size)
            && intervals > 0
            && saved.clock > 0
            && saved.nodes.len() == object.positions()
            && saved.nodes.iter().flatten().all(of_states);
        if !fits {
            return None;
        }
        let faces = Faces::new(&object.arrival, size, intervals, GRADING);
        let points = Points::restored(object, faces, saved.nodes);
        let shared = Shared::new(model, saved.clock);
        let values = Values::restored(&points, shared.modes.len(), saved.values)?;
        Some(Self { model: model.clone(), points, shared, values })
    }
}
