//! Where the values of one object are known: on faces of its belief simplex, and at beliefs that looks lead to.
//!
//! A look at a *node*, a belief met on the way from the arrival prior, leads to other nodes exactly; only where these
//! end is a belief put together from points of faces. On a face every posterior is.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::super::simplex_grid::{Combination, merged};
use super::faces::Faces;
use super::object::ObjectModel;
use crate::index::{Position, Viewpoint};

/// Beliefs that agree to this much count as equal; it moves a value by less than [`super::super::SLACK`].
const RESOLUTION: f64 = 1e-11;

/// The arrival prior, the first node of every position.
pub(super) const ARRIVAL: usize = 0;

/// Sparse rows of non-negative weights over points.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    /// Row `i` is entries `starts[i]..starts[i + 1]`.
    starts: Vec<usize>,
    points: Vec<u32>,
    weights: Vec<f64>,
}

impl Rows {
    pub(crate) fn new() -> Self {
        Self { starts: vec![0], points: Vec::new(), weights: Vec::new() }
    }

    pub(crate) fn extend(&mut self, rows: impl Iterator<Item = Combination>) {
        for row in rows {
            self.points.extend(row.iter().map(|(point, _)| *point));
            self.weights.extend(row.iter().map(|(_, weight)| *weight));
            self.starts.push(self.points.len());
        }
    }

    fn truncate(&mut self, rows: usize) {
        self.starts.truncate(rows + 1);
        let entries = self.starts[rows];
        self.points.truncate(entries);
        self.weights.truncate(entries);
    }

    pub(crate) fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let entries = self.starts[i]..self.starts[i + 1];
        let points = self.points[entries.clone()].iter().map(|point| *point as usize);
        points.zip(self.weights[entries].iter().copied())
    }

    /// The weighted sum of values.
    #[inline(always)]
    pub(crate) fn average(&self, i: usize, values: &[f64]) -> f64 {
        self.row(i).map(|(point, weight)| weight * values[point]).sum()
    }
}

/// Beliefs that looks lead to at one position.
#[derive(Debug, Clone, Default)]
struct Nodes {
    beliefs: Vec<Vec<f64>>,
    known: FxHashMap<Box<[u64]>, usize>,
}

impl Nodes {
    /// A known belief stays as it is.
    fn insert(&mut self, belief: Vec<f64>) {
        let new = self.beliefs.len();
        let id = *self.known.entry(key(&belief)).or_insert(new);
        if id == new {
            self.beliefs.push(belief);
        }
    }
}

fn key(belief: &[f64]) -> Box<[u64]> {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a probability over 1e-11
    belief.iter().map(|b| (b / RESOLUTION).round() as u64).collect()
}

/// The points of every position, and where each look at each of them leads.
#[derive(Debug, Clone)]
pub(super) struct Points {
    pub object: ObjectModel,
    faces: Faces,
    nodes: Vec<Nodes>,
    /// Per position and viewpoint: what is expected of a look.
    looks: Vec<Rows>,
    /// Per position but the belt end: the same belief one position further.
    shifts: Vec<Rows>,
    /// Worth of deciding at the points of the belt end.
    rewards: Vec<f64>,
}

impl Points {
    /// The points of faces, and the arrival prior.
    pub(super) fn new(object: ObjectModel, faces: Faces) -> Self {
        let positions = object.positions();
        let mut points = Self {
            nodes: vec![Nodes::default(); positions],
            looks: vec![Rows::new(); positions * object.viewpoints()],
            shifts: vec![Rows::new(); positions],
            rewards: Vec::new(),
            object,
            faces,
        };
        for nodes in &mut points.nodes {
            nodes.insert(points.object.arrival.clone());
        }
        points.connect(0);
        points
    }

    /// The same points without knowing where looks lead: enough to interpolate.
    pub(super) fn restored(object: ObjectModel, faces: Faces, beliefs: Vec<Vec<Vec<f64>>>) -> Self {
        let mut points = Self {
            nodes: vec![Nodes::default(); object.positions()],
            looks: Vec::new(),
            shifts: Vec::new(),
            rewards: Vec::new(),
            object,
            faces,
        };
        for (nodes, beliefs) in points.nodes.iter_mut().zip(beliefs) {
            for belief in beliefs {
                nodes.insert(belief);
            }
        }
        points
    }

    /// The faces, and the beliefs of the nodes at each position.
    pub(super) fn parts(&self) -> (&Faces, Vec<Vec<Vec<f64>>>) {
        (&self.faces, self.nodes.iter().map(|nodes| nodes.beliefs.clone()).collect())
    }

    /// Number of points at a position.
    pub(super) fn len(&self, position: Position) -> usize {
        self.faces.len() + self.nodes[position.0].beliefs.len()
    }

    pub(super) fn node_count(&self) -> usize {
        self.nodes.iter().map(|nodes| nodes.beliefs.len()).sum()
    }

    /// The point of a node.
    pub(super) fn node(&self, node: usize) -> usize {
        self.faces.len() + node
    }

    /// Weights in the rows of all nodes.
    pub(super) fn node_weights(&self) -> usize {
        let first = self.faces.len();
        self.looks.iter().map(|rows| rows.points.len() - rows.starts[first]).sum()
    }

    /// Whether the faces are the whole simplex, so that only their grid is coarse.
    pub(super) fn whole(&self) -> bool {
        self.faces.are_whole()
    }

    pub(super) fn belief(&self, position: Position, point: usize) -> Vec<f64> {
        match point.checked_sub(self.faces.len()) {
            Some(node) => self.nodes[position.0].beliefs[node].clone(),
            None => self.faces.belief(point),
        }
    }

    pub(super) fn look(&self, position: Position, viewpoint: Viewpoint) -> &Rows {
        &self.looks[position.0 * self.object.viewpoints() + viewpoint.0]
    }

    pub(super) fn shift(&self, position: Position) -> &Rows {
        &self.shifts[position.0]
    }

    pub(super) fn reward(&self, point: usize) -> f64 {
        self.rewards[point]
    }

    /// Whether a belief is a node of a position.
    pub(super) fn knows(&self, position: Position, belief: &[f64]) -> bool {
        self.nodes[position.0].known.contains_key(&key(belief))
    }

    /// A belief at a position as a combination of points: of itself, if it is a node.
    pub(super) fn locate(&self, position: Position, belief: &[f64]) -> Combination {
        let mut found = Combination::new();
        self.locate_weighted(position, belief, 1.0, &mut found);
        found
    }

    #[allow(clippy::cast_possible_truncation)] // points are far fewer than 2^32
    fn locate_weighted(&self, position: Position, belief: &[f64], weight: f64, found: &mut Combination) {
        match self.nodes[position.0].known.get(&key(belief)) {
            Some(node) => found.push((self.node(*node) as u32, weight)),
            None => self.faces.locate(belief, weight, found),
        }
    }

    /// The same points, and nodes at more beliefs.
    pub(super) fn grown(&self, beliefs: Vec<(Position, Vec<f64>)>) -> Self {
        let mut grown = self.clone();
        for (position, belief) in beliefs {
            grown.nodes[position.0].insert(belief);
        }
        grown.connect(self.faces.len());
        grown
    }

    /// Other faces, the same nodes, and nodes at more beliefs.
    pub(super) fn refined(&self, faces: Faces, beliefs: Vec<(Position, Vec<f64>)>) -> Self {
        let mut refined = Self::new(self.object.clone(), faces);
        let known = (0..).map(Position).zip(&self.nodes);
        let known = known.flat_map(|(position, nodes)| nodes.beliefs.iter().map(move |b| (position, b)));
        for (position, belief) in known.map(|(position, b)| (position, b.clone())).chain(beliefs) {
            refined.nodes[position.0].insert(belief);
        }
        refined.connect(refined.faces.len());
        refined
    }

    /// Find out where looks lead from the points behind the first few, whose rows stay.
    fn connect(&mut self, first: usize) {
        for position in (0..self.object.positions()).map(Position) {
            let rows = first..self.len(position);
            for viewpoint in (0..self.object.viewpoints()).map(Viewpoint) {
                let expected = |point| self.expected(position, viewpoint, point);
                let found: Vec<_> = rows.clone().into_par_iter().map(expected).collect();
                let look = &mut self.looks[position.0 * self.object.viewpoints() + viewpoint.0];
                look.truncate(first);
                look.extend(found.into_iter());
            }
            if position.0 > 0 {
                let further = |point| self.locate(Position(position.0 - 1), &self.belief(position, point));
                let found: Vec<_> = rows.into_par_iter().map(further).collect();
                self.shifts[position.0].truncate(first);
                self.shifts[position.0].extend(found.into_iter());
            }
        }
        self.rewards.truncate(first);
        let rewards =
            (first..self.len(Position(0))).map(|point| self.object.reward(&self.belief(Position(0), point)));
        let rewards: Vec<_> = rewards.collect();
        self.rewards.extend(rewards);
    }

    /// Where a look leads, on average over its labels.
    fn expected(&self, position: Position, viewpoint: Viewpoint, point: usize) -> Combination {
        let belief = self.belief(position, point);
        let mut found = Combination::new();
        for (p, posterior) in self.object.look(position, viewpoint, &belief) {
            self.locate_weighted(position, &posterior, p, &mut found);
        }
        merged(found)
    }
}
