//! What one action does to all scenarios of a node.

use std::ops::Range;

use super::groups::{FEW, Groups};
use super::node::{Node, NodeId, Place, Word};
use super::tree::Tree;
use super::{Histogram, Search};
use crate::index::{Bin, Position};
use crate::model::{Action, Look, SortingModel};
use crate::planes::LANES;
use crate::remaining::Remaining;
use crate::scenario::{LookPoint, Scenarios};

/// A step of the deterministic simulative model: the same for all scenarios but for labels and reward.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    /// Where it leads.
    pub to: Place,
    /// Positions that the scan shows, if there is one.
    pub scanned: Option<usize>,
}

impl Step {
    #[inline(always)]
    pub(super) fn of(model: &SortingModel, from: &Place, action: Action, remaining: Remaining) -> Self {
        let step = model.step(action, from.viewpoint, remaining);
        let repeatable = step.scan.is_some_and(|viewpoint| model.repeat(Position(0), viewpoint) > 0.0);
        let to = Place {
            depth: from.depth + 1,
            decisions: from.decisions + usize::from(step.advances()),
            viewpoint: step.viewpoint,
            fresh: (from.fresh || step.advances()) && !repeatable,
            scanned: step.scan.is_some(),
        };
        Self { to, scanned: step.scan.map(|_| step.remaining.visible(model.position_count())) }
    }
}

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// The scenarios of the node that is expanded.
    pub set: Vec<Word>,
    /// Those of its children.
    pub groups: Groups,
    pub buffers: Buffers,
}

/// Buffers for the default policy's value.
#[derive(Debug, Default)]
pub(super) struct Buffers {
    /// Shares of kinds.
    pub shares: Vec<f64>,
    /// What [`super::Bounds`] makes of them.
    rounds: Vec<f64>,
    /// Scenarios of each kind at each position, bytes.
    counts: Vec<u64>,
}

impl Search<'_> {
    /// `|Phi_b| / K` and the discount down to a node.
    #[inline(always)]
    pub(super) fn weight(&self, node: &Node, at: &Place) -> f64 {
        f64::from(node.count) / self.scenarios.count() as f64 * self.discounts[at.depth]
    }

    /// The decision that earns most on the average over the scenarios, and what it earns.
    #[inline(always)]
    pub(super) fn best_decision(&self, node: &Node, at: &Place, scratch: &mut Scratch) -> (Bin, f64) {
        let Scratch { set, buffers: Buffers { shares, counts, .. }, .. } = scratch;
        kind_shares(&self.scenarios, (set, node.count), at.decisions..at.decisions + 1, (shares, counts));
        self.model.best_decision(shares)
    }

    /// The default policy's value at a node, and its first action.
    #[inline(always)]
    pub(super) fn default_policy(
        &self,
        (count, at): (u32, &Place),
        set: &[Word],
        Buffers { shares, rounds, counts }: &mut Buffers,
    ) -> (f64, Action) {
        let &Place { viewpoint, fresh, decisions, .. } = at;
        let remaining = self.remaining.after(decisions);
        let visible = remaining.visible(self.model.position_count());
        kind_shares(&self.scenarios, (set, count), decisions..decisions + visible, (shares, counts));
        self.bounds.default_policy(&Histogram { shares, remaining, viewpoint, fresh }, rounds)
    }

    /// Its value alone.
    #[inline(always)]
    pub(super) fn default_value(
        &self,
        (count, at): (u32, &Place),
        set: &[Word],
        buffers: &mut Buffers,
    ) -> f64 {
        if let (&[word], 1, false) = (set, count, self.remaining.ends())
            && let Some(values) = self.bounds.certain(at.viewpoint, at.fresh)
        {
            let scenario = members(word).next().unwrap_or_default();
            return values[self.scenarios.joint_kinds(at.decisions)[scenario] as usize];
        }
        self.default_policy((count, at), set, buffers).0
    }

    /// Divide the scenarios of a node by what the scan after a step shows: into the groups.
    #[inline(always)]
    pub(super) fn observe(
        &self,
        tree: &Tree,
        (b, to, scanned): (NodeId, &Place, usize),
        scratch: &mut Scratch,
    ) {
        let Place { depth, decisions, .. } = tree.place(b);
        // No object is where it was after a decision.
        let moved = to.decisions > decisions;
        let looks = self.model.positions().take(scanned).map(|position| {
            let viewpoint = to.viewpoint;
            let last = if moved { None } else { tree.last_label(self.model, b, (position, viewpoint)) };
            LookPoint { depth, decisions: to.decisions, look: Look { position, viewpoint, last } }
        });
        let Scratch { set, groups, .. } = scratch;
        groups.divide((&self.scenarios, self.thresholds), (set, tree[b].count), looks);
        groups.pad(self.model.label_count(), self.model.position_count() - scanned);
    }
}

/// The arguments of [`Search::simulate_actions`]; unlike a closure they are sure to be inlined into the dispatch.
pub(super) struct MakeChildren<'a> {
    pub search: &'a Search<'a>,
    pub despot: &'a mut Tree,
    pub b: NodeId,
}

impl pulp::NullaryFnOnce for MakeChildren<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.search.simulate_actions(self.despot, self.b);
    }
}

/// Scenarios in a set.
#[inline(always)]
pub(super) fn count(set: &[Word]) -> u32 {
    set.iter().map(|(_, bits)| bits.count_ones()).sum()
}

/// The scenarios of a word of a set.
#[inline(always)]
pub(super) fn members((word, mut bits): Word) -> impl Iterator<Item = usize> {
    let first = word as usize * LANES;
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        let member = (bits != 0).then_some(first + lane);
        bits &= bits.wrapping_sub(1);
        member
    })
}

/// The share of each kind among the scenarios of a set, object by object.
#[inline(always)]
fn kind_shares(
    scenarios: &Scenarios<'_>,
    (set, all): (&[Word], u32),
    objects: Range<usize>,
    (shares, counts): (&mut Vec<f64>, &mut Vec<u64>),
) {
    let (kinds, one) = (scenarios.kind_count(), 1.0 / f64::from(all));
    shares.clear();
    shares.resize(objects.len() * kinds, 0.0);
    if all <= FEW {
        let (marks, stride) = (scenarios.marks(objects.start), scenarios.mark_words());
        counts.clear();
        counts.resize(stride, 0);
        for scenario in set.iter().flat_map(|word| members(*word)) {
            let marks = &marks[scenario * stride..][..stride];
            counts.iter_mut().zip(marks).for_each(|(count, mark)| *count += mark);
        }
        let counts = counts.iter().flat_map(|count| count.to_le_bytes());
        shares.iter_mut().zip(counts).for_each(|(share, count)| *share = f64::from(count) * one);
        return;
    }
    for (object, shares) in objects.zip(shares.chunks_exact_mut(kinds)) {
        let planes = scenarios.kinds(object).chunks_exact(scenarios.words());
        for (share, plane) in shares.iter_mut().zip(planes) {
            let of_kind: u32 =
                set.iter().map(|(word, bits)| (bits & plane[*word as usize]).count_ones()).sum();
            *share = f64::from(of_kind) * one;
        }
    }
}
