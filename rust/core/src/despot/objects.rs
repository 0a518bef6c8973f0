//! What is known about single objects, each thing worked out once.

use rayon::prelude::*;

use super::Despot;
use super::sightings::Sightings;
use crate::belief::Belief;
use crate::bounds::{Look, Sighting};
use crate::model::SortingModel;
use crate::one_object::{OneObjectPolicy, Weighed};
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
        self.looks[0].pretend(model, default_policy, at_root.chain([model.arrival().as_slice()]));
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
        let taken = sightings.taken_from(self.count);
        self.looks.resize_with(self.looks.len().max(self.count + taken.len()), Look::default);
        let (known, new) = self.looks.split_at_mut(self.count);
        let ends = sightings.remaining().ends();
        let take = |weighed: &mut Weighed, (look, (object, sighting)): (&mut Look, &(Object, Sighting))| {
            let distribution = known[object.look as usize].posterior(object.label as usize);
            look.take(model, policy, distribution, (*sighting, ends), weighed);
        };
        self.count += taken.len();
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
        viewpoint: usize,
    ) -> impl DoubleEndedIterator<Item = &'a Look> + Clone {
        objects.iter().enumerate().map(move |(position, object)| {
            &self.findings.looks[self.sightings.look(*object, (position, viewpoint))]
        })
    }

    /// The scenarios in which a look gives a label.
    #[inline(always)]
    pub(super) fn label(self, at: LookPoint, label: usize) -> &'a [u64] {
        self.findings.labels.label(at, label)
    }

    /// The distribution of an object.
    #[inline(always)]
    pub(super) fn distribution(self, object: Object) -> &'a [f64] {
        self.findings.looks[object.look as usize].posterior(object.label as usize)
    }

    /// The most likely class of an object, and its probability.
    #[inline(always)]
    pub(super) fn most_likely(self, object: Object) -> (usize, f64) {
        self.findings.looks[object.look as usize].most_likely(object.label as usize)
    }
}
