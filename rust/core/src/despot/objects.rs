//! What is known about single objects, each thing worked out once.

use rayon::prelude::*;

use super::Despot;
use super::sightings::Sightings;
use crate::belief::Belief;
use crate::bounds::Look;
use crate::index::{Class, Label, Position, Viewpoint};
use crate::model::SortingModel;
use crate::one_object::{OneObjectPolicy, Weighed};
use crate::remaining::Remaining;
use crate::scenario::{LabelPlanes, LookPoint};
use crate::tree::Object;

/// Looks worth a task of their own.
const PER_TASK: usize = 16;

/// What looks may tell, and the scenarios in which they do.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    /// By the looks' numbers; behind those of this search lie older ones.
    looks: Vec<Look>,
    /// How many of them are of this search.
    count: usize,
    labels: LabelPlanes,
}

impl Findings {
    /// Start a search from a belief.
    pub(super) fn restart(&mut self, despot: &Despot, belief: &Belief) {
        let Despot { model, default_policy, randoms, .. } = despot;
        self.labels.restart(model, randoms, belief.as_slice());
        self.looks.resize_with(self.looks.len().max(1), Look::default);
        self.count = 1;
        let at_root = belief.as_slice().chunks_exact(model.class_count());
        let distributions = at_root.chain([model.arrival().as_slice()]);
        self.looks[0].pretend(model, default_policy, distributions, belief.horizon().ends());
    }

    /// Work out the looks that are new, and in which scenarios those at `points` give which label.
    pub(super) fn work_out(
        &mut self,
        Despot { model, default_policy, randoms, .. }: &Despot,
        sightings: &Sightings,
        points: impl Iterator<Item = LookPoint>,
        parallel: bool,
    ) {
        self.take_looks(model, default_policy, sightings, parallel);
        self.labels.require(model, randoms, points, parallel);
    }

    fn take_looks(
        &mut self,
        model: &SortingModel,
        policy: &OneObjectPolicy,
        sightings: &Sightings,
        parallel: bool,
    ) {
        let first = self.count;
        let taken = sightings.taken_from(first);
        self.looks.resize_with(self.looks.len().max(self.count + taken.len()), Look::default);
        let (known, new) = self.looks.split_at_mut(first);
        let ends = sightings.remaining().ends();
        let take = |weighed: &mut Weighed, (index, look): (usize, &mut Look)| {
            let (object, sighting) = taken[index];
            let distribution = known[object.look as usize].posterior(object.label as usize);
            look.take(model, policy, distribution, (sighting, ends), weighed, |label| {
                let same = sightings.after_look(first + index, label);
                known.get(same.look as usize).map(|look| (look, same.label as usize))
            });
        };
        let new = &mut new[..taken.len()];
        if parallel {
            let new = new.par_iter_mut().enumerate().with_min_len(PER_TASK);
            new.for_each_init(Weighed::default, take);
        } else {
            let mut weighed = Weighed::default();
            new.iter_mut().enumerate().for_each(|look| take(&mut weighed, look));
        }
        self.count += taken.len();
    }
}

/// What is known about objects.
#[derive(Debug, Clone, Copy)]
pub(super) struct Objects<'a> {
    pub sightings: &'a Sightings,
    pub findings: &'a Findings,
}

impl<'a> Objects<'a> {
    /// The looks that a scan takes.
    #[inline(always)]
    pub(super) fn looks(
        self,
        objects: &'a [Object],
        viewpoint: Viewpoint,
    ) -> impl DoubleEndedIterator<Item = &'a Look> + Clone {
        (0..objects.len()).map(Position).zip(objects).map(move |(position, object)| {
            &self.findings.looks[self.sightings.look(*object, (position, viewpoint))]
        })
    }

    /// The scenarios in which a look gives a label.
    #[inline(always)]
    pub(super) fn label(self, at: LookPoint, label: Label) -> &'a [u64] {
        self.findings.labels.label(at, label)
    }

    /// The distribution of an object.
    #[inline(always)]
    pub(super) fn distribution(self, object: Object) -> &'a [f64] {
        self.findings.looks[object.look as usize].posterior(object.label as usize)
    }

    /// Value of executing one plan per object, each chosen now: that of
    /// [`OneObjectPolicy::value`], from the plans that are known to be enough. `worth` is a buffer.
    #[inline(always)]
    pub(super) fn value(
        self,
        policy: &OneObjectPolicy,
        (objects, unseen): (&[Object], Remaining),
        viewpoint: Viewpoint,
        worth: &mut Vec<f64>,
    ) -> f64 {
        let groups = policy.group_count();
        worth.clear();
        worth.extend(policy.values_of_unseen(unseen));
        worth.resize(2 * groups, 0.0);
        for object in objects.iter().rev() {
            let look = &self.findings.looks[object.look as usize];
            let (behind, here) = worth.split_at_mut(groups);
            for (group, here) in here.iter_mut().enumerate() {
                let best = look.best(object.label as usize, group, behind);
                *here = best.map_or(f64::NEG_INFINITY, |(_, value)| value);
            }
            behind.copy_from_slice(here);
        }
        worth[policy.group(viewpoint)]
    }

    /// The most likely class of an object, and its probability.
    #[inline(always)]
    pub(super) fn most_likely(self, object: Object) -> (Class, f64) {
        self.findings.looks[object.look as usize].most_likely(object.label as usize)
    }
}
