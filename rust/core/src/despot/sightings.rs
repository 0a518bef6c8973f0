//! Which object was seen from where: every look that a search needs, by its number.
//!
//! The belief at a node is a product over objects, and what is known about one of them follows from its own labels
//! alone. Many nodes share it: of two objects there are 16^d histories of labels at depth d, of each only 4^d. Those
//! that differ in the order of the labels alone are one object: the first that was known.

use super::histories::Histories;
use super::scan::Scan;
use crate::belief::{Belief, Memory};
use crate::bounds::Sighting;
use crate::index::{Label, Position, Viewpoint};
use crate::model::{Action, SortingModel, shift};
use crate::remaining::Remaining;
use crate::tree::{Node, Object, id, seen};

const ABSENT: u32 = u32::MAX;

/// The objects at the root, the belt end's first.
pub(super) fn at_root(model: &SortingModel, remaining: Remaining) -> impl Iterator<Item = Object> + use<> {
    (0..remaining.visible(model.position_count())).map(|position| Object { look: 0, label: id(position) })
}

/// What an action at a node makes of its objects before anything else is seen of them, and the scan that follows.
pub(super) fn act(
    model: &SortingModel,
    (node, action): (&Node, Action),
    objects: &mut Vec<Object>,
) -> Option<Scan> {
    let step = model.step(action, node.viewpoint, node.remaining);
    if step.advances() {
        let positions = model.position_count();
        shift(objects, std::iter::once(Object { look: 0, label: id(positions) }));
        objects.truncate(step.remaining.visible(positions));
    }
    Scan::of(node, step)
}

/// The looks that a search has needed so far; an [`Object`] is a label of one of them.
#[derive(Debug, Default)]
pub(crate) struct Sightings {
    positions: usize,
    viewpoints: usize,
    classes: usize,
    /// The object of each look, and how it is seen. Number 0 is no look: its labels stand for the objects at the root's
    /// positions, and for an unseen one; so look n is entry n - 1.
    taken: Vec<(Object, Sighting)>,
    /// The row of an object at a position, by [`Sightings::at`]; [`ABSENT`] where no look at it has been required yet:
    /// most labels of most looks are never followed.
    rows: Vec<u32>,
    /// Rows: the look from each viewpoint; [`ABSENT`] where there is none yet.
    index: Vec<u32>,
    histories: Histories,
    /// The last labels at the root.
    memory: Memory,
    /// Objects left to decide at the root.
    remaining: Remaining,
}

impl Sightings {
    /// Start a search from a belief.
    pub(super) fn restart(&mut self, model: &SortingModel, belief: &Belief) {
        (self.positions, self.viewpoints) = (model.position_count(), model.viewpoint_count());
        self.classes = model.class_count();
        self.memory.clone_from(belief.memory());
        self.remaining = belief.horizon();
        self.taken.clear();
        self.index.clear();
        self.histories.restart(model);
        self.rows.clear();
        self.rows.resize((self.positions + 1) * self.positions, ABSENT);
    }

    /// Objects left to decide at the root.
    pub(super) fn remaining(&self) -> Remaining {
        self.remaining
    }

    /// The objects after a scan, given the code of its labels.
    pub(super) fn see(&self, model: &SortingModel, scan: &Scan, labels: u64, objects: &mut [Object]) {
        for ((position, label), object) in model.positions().zip(seen(model, labels)).zip(objects) {
            *object = self.after(*object, (position, scan.viewpoint), label);
        }
    }

    /// Have the looks that a scan takes.
    pub(super) fn require(&mut self, model: &SortingModel, objects: &[Object], viewpoint: Viewpoint) {
        for (position, object) in model.positions().zip(objects) {
            let at = self.at(*object, position);
            if self.rows[at] == ABSENT {
                self.rows[at] = id(self.index.len() / self.viewpoints);
                self.index.resize(self.index.len() + self.viewpoints, ABSENT);
            }
            let key = self.key(*object, position, viewpoint);
            if self.index[key] == ABSENT {
                let last = self.last_label(model, *object, position, viewpoint);
                self.taken.push((*object, Sighting { position, viewpoint, last }));
                self.index[key] = id(self.taken.len());
                self.histories.add(*object, self.taken.len(), Sighting { position, viewpoint, last });
                self.rows.resize(self.rows.len() + self.classes * self.positions, ABSENT);
            }
        }
    }

    /// The looks from number `first` on.
    pub(super) fn taken_from(&self, first: usize) -> &[(Object, Sighting)] {
        &self.taken[first - 1..]
    }

    /// The object after the label of a look.
    #[inline(always)]
    pub(super) fn after(
        &self,
        object: Object,
        (position, viewpoint): (Position, Viewpoint),
        label: Label,
    ) -> Object {
        self.after_look(self.look(object, (position, viewpoint)), label.0)
    }

    /// The same, given the look's number.
    #[inline(always)]
    pub(super) fn after_look(&self, look: usize, label: usize) -> Object {
        self.histories.after(look, label)
    }

    /// Number of a look that has been required.
    #[inline(always)]
    pub(super) fn look(&self, object: Object, (position, viewpoint): (Position, Viewpoint)) -> usize {
        self.index[self.key(object, position, viewpoint)] as usize
    }

    /// How a look of a scan sees its object.
    #[inline(always)]
    pub(super) fn sighting(&self, object: Object, position: Position, viewpoint: Viewpoint) -> Sighting {
        self.taken[self.look(object, (position, viewpoint)) - 1].1
    }

    /// The label that an object had given from the same viewpoint before its last one, if the model can repeat it; the
    /// object is no first one.
    #[inline(always)]
    pub(super) fn label_before(&self, object: Object) -> Option<Label> {
        self.taken[object.look as usize - 1].1.last
    }

    /// The label that an object last gave from a viewpoint since it came to a position, if the model can repeat it.
    fn last_label(
        &self,
        model: &SortingModel,
        mut object: Object,
        position: Position,
        viewpoint: Viewpoint,
    ) -> Option<Label> {
        if model.repeat(position, viewpoint) == 0.0 {
            return None;
        }
        while object.look > 0 {
            let (before, sighting) = self.taken[object.look as usize - 1];
            if sighting.position != position {
                return None;
            }
            if sighting.viewpoint == viewpoint {
                return Some(Label(object.label as usize));
            }
            object = before;
        }
        let still_there = object.label as usize == position.0;
        still_there.then(|| self.memory.last(model, position, viewpoint)).flatten()
    }

    /// Where a look at an object that has a row is indexed.
    #[inline(always)]
    fn key(&self, object: Object, position: Position, viewpoint: Viewpoint) -> usize {
        self.rows[self.at(object, position)] as usize * self.viewpoints + viewpoint.0
    }

    #[inline(always)]
    fn at(&self, object: Object, position: Position) -> usize {
        self.histories.number(object) * self.positions + position.0
    }
}
