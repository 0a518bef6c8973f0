//! What one action does to all scenarios of a node.

use std::ops::Range;

use super::tree::{EdgeId, Node, NodeId, Tree, Word};
use super::{Histogram, Search};
use crate::index::{Bin, Position, Viewpoint};
use crate::model::{Action, Look, SortingModel};
use crate::remaining::Remaining;
use crate::scenario::{LookPoint, Scenarios};

/// A step of the deterministic simulative model: the same for all scenarios but for labels and reward.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    /// Decisions since the root, this one included.
    pub decisions: usize,
    /// Where the camera stands afterwards.
    pub viewpoint: Viewpoint,
    /// As the next node's.
    pub fresh: bool,
    /// Positions that the scan shows, if there is one.
    pub scanned: Option<usize>,
}

impl Step {
    #[inline(always)]
    pub(super) fn of(model: &SortingModel, node: &Node, action: Action, remaining: Remaining) -> Self {
        let step = model.step(action, node.viewpoint, remaining);
        let repeatable = step.scan.is_some_and(|viewpoint| model.repeat(Position(0), viewpoint) > 0.0);
        Self {
            decisions: node.decisions + usize::from(step.advances()),
            viewpoint: step.viewpoint,
            fresh: (node.fresh || step.advances()) && !repeatable,
            scanned: step.scan.map(|_| step.remaining.visible(model.position_count())),
        }
    }

    /// The node that it leads to, but for labels and scenarios.
    #[inline(always)]
    pub(super) fn child(&self, from: &Node, action: EdgeId) -> Node {
        let Self { decisions, viewpoint, fresh, .. } = *self;
        let depth = from.depth + 1;
        Node { parent: Some(action), depth, decisions, viewpoint, fresh, ..Node::default() }
    }
}

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// The scenarios of the node that is expanded.
    pub set: Vec<Word>,
    /// Those of its children, and the same one label earlier.
    pub groups: [Groups; 2],
    /// Shares of kinds, and what [`super::Bounds`] makes of them.
    pub bounds: [Vec<f64>; 2],
}

impl Search<'_> {
    /// `|Phi_b| / K` and the discount down to a node.
    #[inline(always)]
    pub(super) fn weight(&self, node: &Node) -> f64 {
        f64::from(node.count) / self.scenarios.count() as f64 * self.discounts[node.depth]
    }

    /// The decision that earns most on the average over the scenarios, and what it earns.
    #[inline(always)]
    pub(super) fn best_decision(&self, node: &Node, scratch: &mut Scratch) -> (Bin, f64) {
        let Scratch { set, bounds: [shares, _], .. } = scratch;
        kind_shares(&self.scenarios, (set, node.count), node.decisions..node.decisions + 1, shares);
        self.model.best_decision(shares)
    }

    /// The default policy's value at a node, and its first action.
    #[inline(always)]
    pub(super) fn default_policy(
        &self,
        node: &Node,
        set: &[Word],
        [shares, scratch]: &mut [Vec<f64>; 2],
    ) -> (f64, Action) {
        let &Node { viewpoint, fresh, decisions, count, .. } = node;
        let remaining = self.remaining.after(decisions);
        let visible = remaining.visible(self.model.position_count());
        kind_shares(&self.scenarios, (set, count), decisions..decisions + visible, shares);
        self.bounds.default_policy(&Histogram { shares, remaining, viewpoint, fresh }, scratch)
    }

    /// Divide the scenarios of a node by what the scan after a step shows: into the first groups.
    #[inline(always)]
    pub(super) fn observe(&self, tree: &Tree, (b, step): (NodeId, Step), scratch: &mut Scratch) {
        let (depth, Step { decisions, viewpoint, .. }) = (tree[b].depth, step);
        let Scratch { set, groups: [groups, next], .. } = scratch;
        groups.restart(set);
        let mut unit = 1;
        for position in self.model.positions().take(step.scanned.unwrap_or(0)) {
            // No object is where it was after a decision.
            let moved = decisions > tree[b].decisions;
            let last = if moved { None } else { tree.last_label(self.model, b, (position, viewpoint)) };
            let look = Look { position, viewpoint, last };
            let planes = self.scenarios.labels(LookPoint { depth, decisions, look });
            groups.divide((planes, self.model.label_count()), unit, next);
            std::mem::swap(groups, next);
            unit = unit.wrapping_mul(self.model.label_count() as u64);
        }
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

/// The share of each kind among the scenarios of a set, object by object.
#[inline(always)]
fn kind_shares(
    scenarios: &Scenarios<'_>,
    (set, all): (&[Word], u32),
    objects: Range<usize>,
    shares: &mut Vec<f64>,
) {
    shares.clear();
    let (kinds, one) = (scenarios.kind_count(), 1.0 / f64::from(all));
    for object in objects {
        let planes = scenarios.kinds(object);
        let (mut left, first) = (all, shares.len());
        shares.resize(first + kinds, 0.0);
        for (kind, share) in shares[first..].iter_mut().enumerate() {
            let plane = &planes[kind * scenarios.words()..];
            let of_kind: u32 =
                set.iter().map(|(word, bits)| (bits & plane[*word as usize]).count_ones()).sum();
            *share = f64::from(of_kind) * one;
            left -= of_kind;
            if left == 0 {
                break;
            }
        }
    }
}

/// Sets of scenarios that give the same labels.
#[derive(Debug, Default)]
pub(super) struct Groups {
    /// A buffer that only grows; the groups say what of it counts.
    words: Vec<Word>,
    groups: Vec<Group>,
}

/// Scenarios that have given the same labels.
#[derive(Debug, Clone)]
struct Group {
    /// The labels so far, as digits in base Z.
    labels: u64,
    words: Range<usize>,
    /// Number of scenarios.
    count: u32,
}

impl Groups {
    /// Start with one set and no labels.
    #[inline(always)]
    fn restart(&mut self, set: &[Word]) {
        self.words.clear();
        self.words.extend_from_slice(set);
        self.groups.clear();
        self.groups.push(Group { labels: 0, words: 0..set.len(), count: count(set) });
    }

    /// Divide each group by the next label, given the planes of its `labels`; `unit` is what one counts in the code.
    #[inline(always)]
    fn divide(&self, (planes, labels): (&[u64], usize), unit: u64, into: &mut Self) {
        into.groups.clear();
        let (mut end, words) = (0, planes.len() / labels);
        for Group { labels: code, words: group, count: all } in &self.groups {
            let (group, mut code, mut left) = (&self.words[group.clone()], *code, *all);
            for label in 0..labels {
                let plane = &planes[label * words..][..words];
                if into.words.len() < end + group.len() {
                    into.words.resize(end + group.len(), Word::default());
                }
                let (from, out) = (end, &mut into.words[end..]);
                let mut kept = 0;
                for (word, bits) in group {
                    let bits = bits & plane[*word as usize];
                    out[kept] = (*word, bits);
                    kept += usize::from(bits != 0);
                }
                if kept > 0 {
                    let count = count(&out[..kept]);
                    end += kept;
                    left -= count;
                    into.groups.push(Group { labels: code, words: from..end, count });
                    if left == 0 {
                        break;
                    }
                }
                code = code.wrapping_add(unit);
            }
        }
    }

    /// The groups: labels, scenarios and their number.
    #[inline(always)]
    pub(super) fn iter(&self) -> impl Iterator<Item = (u64, &[Word], u32)> {
        self.groups.iter().map(|group| (group.labels, &self.words[group.words.clone()], group.count))
    }
}
