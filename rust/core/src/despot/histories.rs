//! Which labels an object has given from where, whatever their order.
//!
//! Labels are independent given the class, so objects that differ only in the order of their labels have one
//! distribution; `d` labels come in up to `d!` orders. A history is known by its Zobrist key: the sum of random
//! numbers, one per label of each viewpoint at each position. Two histories share a key with probability `2^-64`.

use rand::RngExt;
use rustc_hash::FxHashMap;

use crate::model::{Look, SortingModel};
use crate::sampling::{Purpose, stream};
use crate::tree::{Object, id};

/// The histories that a search has met so far.
#[derive(Debug, Default)]
pub(super) struct Histories {
    viewpoints: usize,
    classes: usize,
    /// Where looks repeat one another their order matters: there every object is taken for itself.
    ordered: bool,
    /// How many objects a search starts with.
    origins: usize,
    /// A random number per origin, then per label of each viewpoint at each position.
    marks: Vec<u64>,
    /// By the objects' numbers.
    keys: Vec<u64>,
    /// The object that was first known by each history.
    first: FxHashMap<u64, Object>,
    /// After each label of each look the first object with its history: `(look - 1) * L + z`.
    same: Vec<Object>,
}

impl Histories {
    /// Start a search: objects of which nothing is known but where they were, the last of them unseen.
    pub(super) fn restart(&mut self, model: &SortingModel) {
        (self.viewpoints, self.classes) = (model.viewpoint_count(), model.class_count());
        self.ordered = model.ever_repeats();
        self.origins = model.position_count() + 1;
        let labels = model.position_count() * self.viewpoints * self.classes;
        if self.marks.len() != self.origins + labels {
            let mut rng = stream(0, Purpose::History, 0);
            self.marks = (0..self.origins + labels).map(|_| rng.random()).collect();
        }
        self.keys.clear();
        self.keys.extend(&self.marks[..self.origins]);
        self.first.clear();
        self.same.clear();
    }

    /// Objects are numbered label by label, look by look.
    #[inline(always)]
    pub(super) fn number(&self, object: Object) -> usize {
        let (look, label) = (object.look as usize, object.label as usize);
        let first = if look == 0 { 0 } else { self.origins + (look - 1) * self.classes };
        first + label
    }

    /// The first object with the history of one after a label of a look.
    #[inline(always)]
    pub(super) fn after(&self, look: usize, label: usize) -> Object {
        self.same[(look - 1) * self.classes + label]
    }

    /// Know the objects after the labels of the next look, by its number, which is at this object.
    pub(super) fn add(&mut self, object: Object, number: usize, Look { position, viewpoint, .. }: Look) {
        let before = self.keys[self.number(object)];
        let mark = self.origins + (position.0 * self.viewpoints + viewpoint.0) * self.classes;
        for label in 0..self.classes {
            let own = Object { look: id(number), label: id(label) };
            let key = before.wrapping_add(self.marks[mark + label]);
            self.keys.push(key);
            self.same.push(if self.ordered { own } else { *self.first.entry(key).or_insert(own) });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::{Position, Viewpoint};
    use crate::model::ScalarOrMatrix;
    use crate::testing::paper;

    /// The objects after the given looks (position, viewpoint, label) at an origin, look by look.
    fn after(
        histories: &mut Histories,
        looks: &mut usize,
        origin: usize,
        seen: &[(usize, usize, usize)],
    ) -> Object {
        let mut object = Object { look: 0, label: id(origin) };
        for (position, viewpoint, label) in seen {
            *looks += 1;
            histories.add(object, *looks, Look::first(Position(*position), Viewpoint(*viewpoint)));
            object = histories.after(*looks, *label);
        }
        object
    }

    #[test]
    fn objects_are_one_if_they_gave_the_same_labels_in_whatever_order() {
        let (mut histories, mut looks) = (Histories::default(), 0);
        histories.restart(&paper(50.0));
        let mut after = |origin, seen: &[_]| after(&mut histories, &mut looks, origin, seen);
        let object = after(0, &[(0, 0, 1), (0, 2, 3), (0, 0, 1), (0, 1, 0)]);
        assert_eq!(after(0, &[(0, 1, 0), (0, 0, 1), (0, 0, 1), (0, 2, 3)]), object);
        for (origin, seen) in [
            (1, [(0, 0, 1), (0, 2, 3), (0, 0, 1), (0, 1, 0)]),
            (0, [(0, 0, 1), (0, 2, 3), (0, 2, 3), (0, 1, 0)]),
            (0, [(1, 0, 1), (0, 2, 3), (0, 0, 1), (0, 1, 0)]),
            (0, [(0, 0, 1), (0, 2, 3), (0, 0, 2), (0, 1, 0)]),
        ] {
            assert_ne!(after(origin, &seen), object);
        }
    }

    #[test]
    fn where_looks_repeat_one_another_their_order_matters() {
        let mut spec = paper(50.0).spec().clone();
        spec.repeat = Some(ScalarOrMatrix::Scalar(0.5));
        let (mut histories, mut looks) = (Histories::default(), 0);
        histories.restart(&SortingModel::new(spec).unwrap());
        let object = after(&mut histories, &mut looks, 0, &[(0, 0, 1), (0, 1, 2)]);
        assert_ne!(after(&mut histories, &mut looks, 0, &[(0, 1, 2), (0, 0, 1)]), object);
    }
}
