//! DESPOT as published: Ye, Somani, Hsu & Lee, "DESPOT: Online POMDP planning with regularization" (JAIR 58, 2017),
//! the anytime, regularised one (AR-DESPOT).
//!
//! The search knows only its scenarios, drawn from the exact belief at the root: rewards are averages over the
//! scenarios of a node, and a branch weighs its share of them, `|Phi_b'| / |Phi_b|`. [`crate::BeliefSearch`] is another
//! planner, with exact beliefs.
//!
//! | paper | here |
//! |---|---|
//! | scenario `phi`, simulative model `g(s, a, phi)` | [`Scenarios`], [`Step`] |
//! | node `b` with `Phi_b`, `l_0`, `l`, `mu`, `U`, `Delta` | [`node::Node`]; its values are weighted by `gamma^Delta(b) \|Phi_b\| / K` as there |
//! | Algorithm 1, BUILD-DESPOT | [`Search::build_despot`]; lines 1-3 are [`Search::begin`] |
//! | Algorithm 2, EXPLORE | [`Search::explore`] |
//! | its line 3, expand `b` | [`Search::make_children`]; `U`, `L_0`, `mu`, `l` of a new node: [`Search::initialise`] |
//! | its lines 4 and 5, `a*` and `z*` | [`Search::most_promising`], [`Search::most_uncertain`] |
//! | weighted excess uncertainty `E(b)` | [`Search::excess_uncertainty`] |
//! | Algorithm 3, MAKE-DEFAULT | [`Search::make_default`]; at depth D by [`Search::initialise`] |
//! | Algorithm 4, PRUNE; its line 3, blocked nodes | [`Search::prune`]; [`Search::is_blocked`] |
//! | Algorithm 5, BACKUP | [`Search::backup`] |
//! | `L_0`, roll-out of the default policy; `U_0`, fully observable | [`Bounds::default_policy`]; [`Bounds::upper`] |
//!
//! What is not in the paper:
//!
//! * All decisions lead to the same scenarios, so inside the search there is one, for the class most frequent among
//!   them. That is the only use made of the problem's structure.
//! * The default policy's roll-outs are not simulated: it is valued in closed form on the class histograms of a node's
//!   scenarios, objects that have still to arrive by the model alone. So only expansions count as scenario steps.
//! * A set of scenarios is a bit plane of which only words with any bits are kept; an observation branch is an AND
//!   with the plane of a label, a class histogram counts bits. Most nodes have only few scenarios, which are gone
//!   through [one by one](groups::FEW) instead, and most new ones a single scenario, whose value is looked up.
//! * The root is expanded whatever the budget, so that every legal action has a value.
//! * The first trials are those of Algorithm 1. Later ones come in [batches](batch) that threads share, with a virtual loss
//!   as in HyP-DESPOT (Cai, Luo, Hsu & Lee, RSS 2018). The size of a batch depends on the trials done alone: a plan is
//!   bit by bit the same for any number of threads.

mod batch;
mod bounds;
mod groups;
mod node;
mod plan;
mod step;
mod tree;

use crate::belief::Belief;
use crate::index::{Position, Viewpoint};
use crate::model::{Action, SortingModel};
use crate::planes;
use crate::remaining::Remaining;
use crate::sampling::Thresholds;
use crate::scenario::Scenarios;
use bounds::{Bounds, Histogram};
use node::{EdgeId, Node, NodeId, Place, ROOT, Values, Word};
pub use plan::{BudgetedDespot, Despot};
use step::{Buffers, MakeChildren, Scratch, Step, count};
use tree::{Tree, first_best};

/// `xi`: the part of the root's gap that one trial tries to leave.
const XI: f64 = 0.95;
/// `epsilon_0`: the root's gap at which the search ends, in units of `r_max`.
const EPSILON: f64 = 1e-10;
/// Trials that are made one by one, and then one more at once for so many more.
const ALONE: u64 = 16;
/// Trials made at once at most.
const MOST_AT_ONCE: u64 = 64;

/// A search in progress; what it grows is a [`Tree`].
struct Search<'a> {
    model: &'a SortingModel,
    bounds: &'a Bounds,
    thresholds: &'a Thresholds,
    scenarios: Scenarios<'a>,
    /// Objects left to decide at the root.
    remaining: Remaining,
    /// `lambda`: price of a policy node.
    lambda: f64,
    /// `D`: nodes as deep as this are leaves.
    depth: usize,
    /// Discount down to each depth.
    discounts: &'a [f64],
    parallel: bool,
    out_of_time: &'a (dyn Fn() -> bool + Sync),
}

impl Search<'_> {
    /// BUILD-DESPOT: trials until the root's bounds meet, or the budget is spent; how many.
    fn build_despot(&self, despot: &mut Tree, branches: &mut Vec<Tree>, trials: u64) -> u64 {
        let mut done = 0;
        while !self.is_settled(despot) && done < trials && !(self.out_of_time)() {
            let at_once = (done / ALONE).clamp(1, MOST_AT_ONCE).min(trials - done);
            match self.make_trials(despot, branches, at_once) {
                0 => break,
                more => done += more,
            }
        }
        done
    }

    /// Whether the root's bounds have met.
    fn is_settled(&self, despot: &Tree) -> bool {
        despot[ROOT].gap() <= EPSILON * self.model.reward_scale()
    }

    /// The root with all its scenarios, and its actions.
    fn begin(&self, despot: &mut Tree, belief: &Belief, viewpoint: Viewpoint) {
        let fresh = self.model.viewpoints().all(|v| belief.last_label(self.model, Position(0), v).is_none());
        let all: Vec<Word> = (0..).zip(planes::first(self.scenarios.count())).collect();
        let place = Place { viewpoint, fresh, ..Place::default() };
        despot.restart(self.model, belief, place);
        let root = Node { count: count(&all), ..Node::default() };
        despot.add_node(self.initialise(root, &place, &all, &mut Buffers::default()), &all);
        self.make_children(despot, ROOT);
    }

    /// EXPLORE: down to where no uncertainty is in excess; or to a leaf only, if nothing may `grow`.
    fn explore(&self, despot: &mut Tree, target: f64, grow: bool) -> NodeId {
        let mut b = ROOT;
        while self.excess_uncertainty(&despot[b], target) > 0.0 && !self.prune(despot, b) {
            if despot[b].is_leaf() {
                if !grow {
                    break;
                }
                self.make_children(despot, b);
            }
            let a = Self::most_promising(despot, b);
            let Some(next) = a.and_then(|a| self.most_uncertain(despot, a, target)) else { break };
            b = next;
        }
        b
    }

    /// `a*`: the action with the highest upper bound.
    fn most_promising(despot: &Tree, b: NodeId) -> Option<EdgeId> {
        first_best(despot[b].edges(), |a| despot[a].values.upper)
    }

    /// `z*`: the child with the largest excess uncertainty.
    fn most_uncertain(&self, despot: &Tree, a: EdgeId, target: f64) -> Option<NodeId> {
        first_best(despot[a].children(), |child| self.excess_uncertainty(&despot[child], target))
    }

    /// `E(b)`: the gap beyond the share of the root's that the scenarios of `b` have in the target.
    fn excess_uncertainty(&self, b: &Node, target: f64) -> f64 {
        b.gap() - f64::from(b.count) / self.scenarios.count() as f64 * target
    }

    /// PRUNE: make blocked nodes default, from `b` upwards; whether there were any.
    fn prune(&self, despot: &mut Tree, b: NodeId) -> bool {
        let mut x = Some(b);
        while let Some(blocked) = x.filter(|x| self.is_blocked(despot, *x)) {
            Self::make_default(&mut despot[blocked]);
            self.backup(despot, blocked);
            despot.tally.pruned += 1;
            x = despot.parent(blocked);
        }
        x != Some(b)
    }

    /// Whether somewhere above, no policy that comes here gains more than its nodes down to here cost.
    fn is_blocked(&self, despot: &Tree, x: NodeId) -> bool {
        let gains = despot.path(x).map(|above| above.values.utility - above.default);
        let gains = gains.chain(despot.above.iter().copied());
        self.lambda > 0.0 && gains.zip(1_u32..).any(|(gain, nodes)| gain <= self.lambda * f64::from(nodes))
    }

    /// MAKE-DEFAULT: below `b`, only the default policy.
    fn make_default(b: &mut Node) {
        b.values = Values::all(b.default);
        b.settled = true;
    }

    /// BACKUP: Bellman's equation for `l`, `mu` and `U` on the path from `b` to the root.
    fn backup(&self, despot: &mut Tree, mut b: NodeId) {
        while let Some(a) = despot.edge_into(b) {
            self.sum_children(despot, a);
            b = despot[a].from;
            Self::take_best(despot, b);
        }
    }

    /// Values of an action: its reward and those of its children.
    fn sum_children(&self, despot: &mut Tree, a: EdgeId) {
        let reward = despot[a].reward;
        let start = Values { lower: reward - self.lambda, upper: reward - self.lambda, utility: reward };
        despot[a].values = despot[a].children().fold(start, |sum, child| sum.plus(despot[child].values));
    }

    /// Values of a node: those of its best action, or the default policy's.
    fn take_best(despot: &mut Tree, b: NodeId) {
        if !despot[b].settled {
            let default = Values::all(despot[b].default);
            despot[b].values = despot[b].edges().fold(default, |best, a| best.max(despot[a].values));
        }
    }

    /// Expand `b`, compiled for the CPU at hand.
    fn make_children(&self, despot: &mut Tree, b: NodeId) {
        pulp::Arch::new().dispatch(MakeChildren { search: self, despot, b });
    }

    /// Each action is simulated in all scenarios of `b`.
    #[inline(always)]
    fn simulate_actions(&self, despot: &mut Tree, b: NodeId) {
        let (node, place, mut scratch) = (despot[b], despot.place(b), std::mem::take(&mut despot.scratch));
        scratch.set.clear();
        scratch.set.extend_from_slice(despot.scenarios(b));
        let (bin, earned) = self.best_decision(&node, &place, &mut scratch);
        let weight = self.weight(&node, &place);
        let moves = self.model.legal_moves(place.viewpoint).iter().map(|to| Action::Move(*to));
        for action in std::iter::once(Action::Decide(bin)).chain(moves) {
            let (first, a) = (despot.size(), despot.next_edge());
            let step = Step::of(self.model, &place, action, self.remaining.after(place.decisions));
            let child = Node { parent: a, ..Node::default() };
            if let Some(scanned) = step.scanned {
                self.observe(despot, (b, &step.to, scanned), &mut scratch);
                let Scratch { groups, buffers, .. } = &mut scratch;
                for (labels, scenarios, count) in groups.iter() {
                    let child = Node { count, labels, ..child };
                    despot.add_node(self.initialise(child, &step.to, scenarios, buffers), scenarios);
                }
            } else {
                let child = Node { count: node.count, ..child };
                despot.add_node_like(self.initialise(child, &step.to, &scratch.set, &mut scratch.buffers), b);
            }
            let reward = match action {
                Action::Decide(_) => earned,
                Action::Move(to) => -self.model.motion_cost(place.viewpoint, to),
            };
            despot.add_edge(b, (action, step.to), weight * reward, first);
            self.sum_children(despot, a);
            despot.tally.scenario_steps += u64::from(node.count);
        }
        (despot.scratch, despot.tally.expansions) = (scratch, despot.tally.expansions + 1);
        Self::take_best(despot, b);
    }

    /// `L_0` and `U_0` of a new node, and the values they give.
    #[inline(always)]
    fn initialise(&self, node: Node, at: &Place, scenarios: &[Word], buffers: &mut Buffers) -> Node {
        let (weight, remaining) = (self.weight(&node, at), self.remaining.after(at.decisions));
        let default = weight * self.default_value((node.count, at), scenarios, buffers);
        let utility = if at.depth < self.depth { weight * self.bounds.upper(remaining) } else { default };
        let upper = default.max(utility - self.lambda);
        Node { default, values: Values { lower: default, upper, utility }, ..node }
    }
}

#[cfg(test)]
mod tests;
