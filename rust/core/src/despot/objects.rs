//! What is known about single objects, each thing worked out once.
//!
//! The belief at a node is a product over objects, and what is known about one of them follows from its own labels
//! alone. Many nodes share it: of two objects there are 16^d histories of labels at depth d, of each only 4^d.

use rayon::prelude::*;

use crate::belief::{Belief, Memory};
use crate::bounds::{Look, Sighting};
use crate::model::SortingModel;
use crate::one_object::{OneObjectPolicy, Weighed};
use crate::remaining::Remaining;
use crate::tree::{Object, id};

/// Looks worth a task of their own.
const PER_TASK: usize = 16;
const ABSENT: u32 = u32::MAX;

/// The looks that a search has needed so far; an [`Object`] is a label of one of them.
#[derive(Debug, Default)]
pub(crate) struct Objects {
    positions: usize,
    viewpoints: usize,
    classes: usize,
    /// The first is none: its labels stand for the objects at the root's positions, and for an unseen one.
    looks: Vec<Look>,
    /// The object of each look but the first, and how it is seen; behind those of `looks` at hand lie older ones.
    taken: Vec<(Object, Sighting)>,
    /// The row of an object at a position, by [`Objects::at`]; [`ABSENT`] where no look at it has been required yet:
    /// most labels of most looks are never followed.
    rows: Vec<u32>,
    /// Rows: the look from each viewpoint; [`ABSENT`] where there is none yet.
    index: Vec<u32>,
    /// The last labels at the root.
    memory: Memory,
    /// Objects left to decide at the root.
    remaining: Remaining,
}

impl Objects {
    /// Start a search from a belief.
    pub(super) fn restart(&mut self, model: &SortingModel, policy: &OneObjectPolicy, belief: &Belief) {
        (self.positions, self.viewpoints) = (model.position_count(), model.viewpoint_count());
        self.classes = model.class_count();
        self.memory.clone_from(belief.memory());
        self.remaining = belief.horizon();
        self.taken.clear();
        self.index.clear();
        self.rows.clear();
        self.rows.resize((self.positions + 1) * self.positions, ABSENT);
        if self.looks.is_empty() {
            self.looks.push(Look::default());
        }
        let at_root = belief.as_slice().chunks_exact(self.classes);
        self.looks[0].pretend(model, policy, at_root.chain([model.arrival().as_slice()]));
    }

    /// The objects at the root, the belt end's first.
    pub(super) fn at_root(&self) -> impl Iterator<Item = Object> + use<> {
        (0..self.remaining.visible(self.positions)).map(|position| Object { look: 0, label: id(position) })
    }

    /// The belt advances.
    pub(super) fn shift(&self, objects: &mut Vec<Object>, remaining: Remaining) {
        objects.remove(0);
        if remaining.after(1).visible(self.positions) > objects.len() {
            objects.push(Object { look: 0, label: id(self.positions) });
        }
    }

    /// Have the looks that a scan takes, once they are worked out.
    pub(super) fn require(&mut self, model: &SortingModel, objects: &[Object], viewpoint: usize) {
        for (position, object) in objects.iter().enumerate() {
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
                self.rows.resize(self.rows.len() + self.classes * self.positions, ABSENT);
            }
        }
    }

    /// Work out the looks from number `first` on.
    pub(super) fn work_out(
        &mut self,
        model: &SortingModel,
        policy: &OneObjectPolicy,
        first: usize,
        parallel: bool,
    ) {
        self.looks.resize_with(self.looks.len().max(self.taken.len() + 1), Look::default);
        let ends = self.remaining.ends();
        let (known, new) = self.looks.split_at_mut(first);
        let taken = &self.taken[first - 1..];
        let take = |weighed: &mut Weighed, (look, (object, sighting)): (&mut Look, &(Object, Sighting))| {
            let distribution = known[object.look as usize].posterior(object.label as usize);
            look.take(model, policy, distribution, (*sighting, ends), weighed);
        };
        if parallel {
            new[..taken.len()]
                .par_iter_mut()
                .zip(taken)
                .with_min_len(PER_TASK)
                .for_each_init(Weighed::default, take);
        } else {
            let mut weighed = Weighed::default();
            new.iter_mut().zip(taken).for_each(|look| take(&mut weighed, look));
        }
    }

    /// Number of looks.
    pub(super) fn count(&self) -> usize {
        1 + self.taken.len()
    }

    /// The object after the label of a look.
    #[inline(always)]
    pub(super) fn after(
        &self,
        object: Object,
        (position, viewpoint): (usize, usize),
        label: usize,
    ) -> Object {
        Object { look: self.index[self.key(object, position, viewpoint)], label: id(label) }
    }

    /// The looks that a scan takes, and how they see their objects.
    #[inline(always)]
    pub(super) fn looks(
        &self,
        objects: &[Object],
        viewpoint: usize,
    ) -> impl DoubleEndedIterator<Item = &Look> + Clone {
        objects.iter().enumerate().map(move |(position, object)| {
            &self.looks[self.index[self.key(*object, position, viewpoint)] as usize]
        })
    }

    /// How a look of a scan sees its object.
    #[inline(always)]
    pub(super) fn sighting(&self, object: Object, position: usize, viewpoint: usize) -> Sighting {
        self.taken[self.index[self.key(object, position, viewpoint)] as usize - 1].1
    }

    /// The sighting that a label came from; the object is no first one.
    #[inline(always)]
    pub(super) fn told_by(&self, object: Object) -> Sighting {
        self.taken[object.look as usize - 1].1
    }

    /// The distribution of an object.
    #[inline(always)]
    pub(super) fn distribution(&self, object: Object) -> &[f64] {
        self.looks[object.look as usize].posterior(object.label as usize)
    }

    /// The most likely class of an object, and its probability.
    #[inline(always)]
    pub(super) fn most_likely(&self, object: Object) -> (usize, f64) {
        self.looks[object.look as usize].most_likely(object.label as usize)
    }

    /// The label that an object last gave from a viewpoint since it came to a position, if the model can repeat it.
    fn last_label(
        &self,
        model: &SortingModel,
        mut object: Object,
        position: usize,
        viewpoint: usize,
    ) -> Option<usize> {
        if model.repeat(position, viewpoint) == 0.0 {
            return None;
        }
        while object.look > 0 {
            let (before, sighting) = self.taken[object.look as usize - 1];
            if sighting.position != position {
                return None;
            }
            if sighting.viewpoint == viewpoint {
                return Some(object.label as usize);
            }
            object = before;
        }
        let still_there = object.label as usize == position;
        still_there.then(|| self.memory.last(model, position, viewpoint)).flatten()
    }

    /// Where a look at an object that has a row is indexed.
    #[inline(always)]
    fn key(&self, object: Object, position: usize, viewpoint: usize) -> usize {
        self.rows[self.at(object, position)] as usize * self.viewpoints + viewpoint
    }

    /// Objects are numbered label by label, look by look.
    #[inline(always)]
    fn at(&self, object: Object, position: usize) -> usize {
        let (look, label) = (object.look as usize, object.label as usize);
        let first = if look == 0 { 0 } else { self.positions + 1 + (look - 1) * self.classes };
        (first + label) * self.positions + position
    }
}
