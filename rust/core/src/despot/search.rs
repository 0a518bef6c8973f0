//! One search: leaves are chosen, expanded and attached, batch by batch.

use rayon::prelude::*;

use super::Despot;
use super::expand::{Expansion, Scratch};
use super::frontier::Frontier;
use super::objects::Objects;
use super::stopping::Clock;
use super::workspace::{Lease, Workspace};
use crate::belief::Belief;
use crate::bounds;
use crate::index::Viewpoint;
use crate::tree::{Child, Place};

/// Expansions that are worth waking another thread for, and those done by one task.
const WORTH_SHARING: usize = 16;
const PER_TASK: usize = 4;
/// Trials after which a batch is chosen while the one before it is still being expanded: by then it is small beside what
/// is known already. Never a matter of threads.
const OVERLAPPING: u64 = 256;

/// A search in progress.
pub(super) struct Search<'a> {
    pub despot: &'a Despot,
    pub space: Lease,
    pub clock: Clock<'a>,
    pub parallel: bool,
}

impl Search<'_> {
    /// Search until the budget is spent, or nothing is left to find.
    pub(super) fn run(&mut self, belief: &Belief, viewpoint: Viewpoint) {
        self.begin(belief, viewpoint);
        self.clock.begin();
        self.go_on();
        while !self.space.frontier.chosen.is_empty() {
            self.expand_chosen();
            if self.space.frontier.chosen.is_empty() {
                self.go_on();
            }
        }
    }

    /// The root, expanded whatever the budget says; on a belt that ends also the belief after a decision. There leaves are
    /// valued without a shortfall, and one that no scan leads to would be underrated beside those behind a scan.
    fn begin(&mut self, belief: &Belief, viewpoint: Viewpoint) {
        let Despot { model, default_policy, randoms, .. } = self.despot;
        let (known, remaining) = (belief.known(), belief.horizon());
        let lower = bounds::lower(model, default_policy, known, viewpoint);
        let upper = bounds::upper(model, known, viewpoint);
        let values = self.despot.leaf((0, 1.0, remaining), lower, 0.0, upper);
        let root = Child { values, probability: 1.0, ..Child::default() };
        randoms.reach(0, self.parallel);
        self.space.restart(self.despot, (belief, viewpoint), root);
        self.expand_now(None);
        let decided = self.space.frontier.after_decision().filter(|_| remaining.ends());
        if decided.is_some() {
            self.expand_now(decided);
        }
    }

    fn expand_now(&mut self, leaf: Option<Place>) {
        let Workspace { frontier, knowledge, scratch, .. } = &mut *self.space;
        frontier.choose(self.despot, leaf);
        knowledge.prepare(self.despot, &mut frontier.chosen, false);
        frontier.expanded.append(&mut frontier.chosen);
        expand((self.despot, knowledge.objects()), &mut frontier.expanded, scratch, false, || true);
        frontier.attach(self.despot);
    }

    /// Put what was found into the tree, and choose the leaves of the next batch.
    fn go_on(&mut self) {
        attach_and_choose(&mut self.space.frontier, self.despot, &self.clock, 0);
    }

    /// Expand the chosen leaves; meanwhile, once the tree is large, go on with the batch before.
    fn expand_chosen(&mut self) {
        let (despot, clock) = (self.despot, &self.clock);
        let Workspace { frontier, knowledge, scratch, .. } = &mut *self.space;
        if clock.out_of_time() {
            return frontier.expanded.append(&mut frontier.chosen);
        }
        let shared = self.parallel && frontier.chosen.len() >= WORTH_SHARING;
        let mut batch = std::mem::take(&mut frontier.chosen);
        let under_way = batch.len();
        let overlapping = frontier.tally.trials >= OVERLAPPING;
        let mut expand_batch = || {
            knowledge.prepare(despot, &mut batch, shared);
            expand((despot, knowledge.objects()), &mut batch, scratch, shared, || !clock.out_of_time());
        };
        let mut go_on = || {
            if overlapping {
                attach_and_choose(frontier, despot, clock, under_way);
            }
        };
        if shared {
            rayon::join(expand_batch, go_on);
        } else {
            expand_batch();
            go_on();
        }
        frontier.expanded.append(&mut batch);
    }
}

/// Put what was found into the tree, and choose leaves while so many others are being expanded.
fn attach_and_choose(frontier: &mut Frontier, despot: &Despot, clock: &Clock<'_>, under_way: usize) {
    frontier.attach(despot);
    let trials = clock.allowed(frontier.tally.trials, under_way as u64);
    frontier.choose_leaves(despot, trials);
}

/// Expand leaves, each on its own; a leaf that there is no more time for stays one.
fn expand(
    (despot, known): (&Despot, Objects<'_>),
    batch: &mut [Expansion],
    scratch: &mut Vec<Scratch>,
    shared: bool,
    in_time: impl Fn() -> bool + Sync,
) {
    let per_task = if shared { PER_TASK } else { batch.len() };
    scratch.resize_with(scratch.len().max(batch.len().div_ceil(per_task)), Scratch::default);
    let expand = |(expansions, scratch): (&mut [Expansion], &mut Scratch)| {
        for expansion in expansions.iter_mut().filter(|_| in_time()) {
            expansion.run(despot, known, scratch);
        }
    };
    if shared {
        batch.par_chunks_mut(per_task).zip(scratch).for_each(expand);
    } else {
        batch.chunks_mut(per_task).zip(scratch).for_each(expand);
    }
}
