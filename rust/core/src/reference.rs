//! The offline reference solution and its certificate: `lower <= V*(b0) <= upper`.
//!
//! Three anytime stages: value iteration on a belief grid bounds V* from above everywhere ([`upper`]); policy
//! iteration on a policy graph bounds it from below everywhere ([`lower`]); heuristic search in the graph of exactly
//! reachable beliefs closes the gap at the start ([`graph`]). Each bound is proved, not estimated, at any time.

mod graph;
mod lower;
mod simplex_grid;
mod upper;
mod visited;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::belief::Belief;
use crate::bounds;
use crate::error::{Result, argument_error};
use crate::model::{Action, SortingModel};
use crate::one_object::OneObjectPolicy;
use crate::policy::Policy;
use graph::BeliefGraph;
use lower::PolicyGraph;
use upper::{GridBound, Resolution};
use visited::visited_beliefs;

/// Parts of the time after which the grid, and the policy graph, have had their share.
const GRID_UNTIL: f64 = 0.4;
const POLICY_UNTIL: f64 = 0.9;
/// Intervals per axis of the first grid, and the factor from one grid to the next.
const COARSEST: f64 = 6.0;
const REFINEMENT: f64 = 1.25;
/// Gradings tried on a coarse grid; which is best depends on how sharply decisions are punished.
const GRADINGS: [f64; 3] = [0.0, 0.6, 1.0];
/// Values of the finest grid, each of 8 bytes, twice.
const MOST_VALUES: usize = 40_000_000;
/// A sweep that lowers no value by more than this part of `r_max` has converged; refining then gains more.
const TOLERANCE: f64 = 1e-4;
/// Beliefs at which the policy graph has nodes: as many as the time lets it improve often enough.
const BELIEFS_PER_SECOND: f64 = 65.0;
const BELIEFS: (f64, f64) = (200.0, 4000.0);
/// Nodes of the belief graph; each takes about a kilobyte.
const MOST_NODES: usize = 4_000_000;
/// Label vectors of a scan that can be enumerated.
const MOST_LABELS: u64 = 4096;
/// What rounding and the merging of nearly equal beliefs may move a bound by, as a part of `r_max`.
const SLACK: f64 = 1e-7;
/// A gap, as a part of `r_max`, at which there is nothing left to do.
const SOLVED: f64 = 1e-6;

/// Bounds at any belief.
#[derive(Debug, Clone)]
struct LeafBounds {
    policy: OneObjectPolicy,
    /// For models that [`upper`] and [`lower`] are proved for.
    grid: Option<GridBound>,
    policy_graph: Option<PolicyGraph>,
}

impl LeafBounds {
    fn bounds(&self, model: &SortingModel, belief: &[f64], viewpoint: usize) -> (f64, f64) {
        let lower = self.policy.value(model, belief, viewpoint);
        let upper = bounds::upper(model, belief, viewpoint);
        (
            self.policy_graph.as_ref().map_or(lower, |graph| graph.value(model, belief).max(lower)),
            self.grid.as_ref().map_or(upper, |grid| grid.value(belief).min(upper)),
        )
    }
}

/// Certified bounds of the value, and a policy.
#[derive(Debug, Clone)]
pub struct Solution {
    model: SortingModel,
    leaves: LeafBounds,
    /// `lower <= V*(b0)` at the arrival prior, viewpoint 0: the value of a policy that can be executed.
    pub lower: f64,
    /// `V*(b0) <= upper`.
    pub upper: f64,
    /// Wall-clock time spent.
    pub elapsed: Duration,
}

/// Told of the bounds at the arrival prior, `(lower, upper)`, while they improve.
pub type Progress<'a> = &'a mut dyn FnMut(f64, f64);

impl Solution {
    /// Solve a model for about `time`, or until the gap is closed, or until `stop` is set.
    ///
    /// For one or two positions and viewpoints that are all alike the bounds are tight; otherwise the upper one is
    /// the closed form of [`crate::bounds`] and the search alone narrows the gap, slowly.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if the time is 0, or a scan has more than 4096 label vectors; [`crate::Error::Model`]
    /// for a model beyond the paper's.
    pub fn solve(
        model: &SortingModel,
        time: Duration,
        stop: &AtomicBool,
        progress: Progress<'_>,
    ) -> Result<Self> {
        model.check_plain()?;
        check(model, time)?;
        let arrival = Belief::new(model).as_slice().to_vec();
        let policy = OneObjectPolicy::solve(model);
        let mut leaves = LeafBounds { policy, grid: None, policy_graph: None };
        let bounds = leaves.bounds(model, &arrival, 0);
        let mut watch = Watch { start: Instant::now(), time, stop, progress, bounds };
        if all_alike(model) {
            let grid = tightened_grid(model, &mut watch);
            leaves.policy_graph = Some(improved_policy(model, &leaves.policy, &grid, &mut watch));
            leaves.grid = Some(grid);
        }
        search(model, &leaves, &arrival, &mut watch);
        let slack = SLACK * model.spec().r_max;
        let (lower, upper) = (watch.bounds.0 - slack, watch.bounds.1 + slack);
        Ok(Self { model: model.clone(), leaves, lower, upper, elapsed: watch.start.elapsed() })
    }

    /// Bounds of V* at any belief, from the grid and the policy graph.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if belief or viewpoint do not fit the model.
    pub fn bounds(&self, belief: &Belief, viewpoint: usize) -> Result<(f64, f64)> {
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        let (lower, upper) = self.leaves.bounds(&self.model, belief.as_slice(), viewpoint);
        let slack = SLACK * self.model.spec().r_max;
        Ok((lower - slack, upper + slack))
    }

    /// The model solved.
    #[must_use]
    pub fn model(&self) -> &SortingModel {
        &self.model
    }
}

impl Policy for Solution {
    /// The action that is best one exact step ahead of the upper bound; without a grid, the one-object policy's.
    fn act(&self, belief: &Belief, viewpoint: usize) -> Result<Action> {
        belief.check_fits(&self.model)?;
        self.model.check_viewpoint(viewpoint)?;
        let belief = belief.as_slice();
        Ok(match &self.leaves.grid {
            Some(grid) => grid.look_ahead(&self.model, belief, viewpoint).0,
            None => self.leaves.policy.action(&self.model, belief, viewpoint),
        })
    }
}

/// Time, and who is told of what it brings.
struct Watch<'a> {
    start: Instant,
    time: Duration,
    stop: &'a AtomicBool,
    progress: Progress<'a>,
    /// The best proved so far at the arrival prior.
    bounds: (f64, f64),
}

impl Watch<'_> {
    fn report(&mut self, lower: f64, upper: f64) {
        self.bounds = (self.bounds.0.max(lower), self.bounds.1.min(upper));
        (self.progress)(self.bounds.0, self.bounds.1);
    }

    fn over(&self, part: f64) -> bool {
        self.stop.load(Ordering::Relaxed) || self.start.elapsed() >= self.time.mul_f64(part)
    }
}

fn check(model: &SortingModel, time: Duration) -> Result<()> {
    if time.is_zero() {
        return argument_error("seconds = 0; give a time above 0, 60 for example");
    }
    let positions = u32::try_from(model.position_count()).unwrap_or(u32::MAX);
    match (model.class_count() as u64).checked_pow(positions) {
        Some(labels) if labels <= MOST_LABELS => Ok(()),
        _ => argument_error(format!(
            "{} classes at {} positions give more than {MOST_LABELS} label vectors; solve enumerates them: \
             keep fewer positions with with_positions",
            model.class_count(),
            model.position_count()
        )),
    }
}

/// Whether the proofs of [`upper`] and [`lower`] cover a model: at most two positions, viewpoints all alike.
fn all_alike(model: &SortingModel) -> bool {
    let cost =
        |from: usize| model.legal_moves(0).iter().map(move |&to| model.motion_cost(from, to).to_bits());
    let alike = |k: usize| model.legal_moves(k) == model.legal_moves(0) && cost(k).eq(cost(0));
    model.position_count() <= 2 && (0..model.viewpoint_count()).all(alike)
}

/// The grid bound, refined from coarse to fine.
fn tightened_grid(model: &SortingModel, watch: &mut Watch<'_>) -> GridBound {
    let arrival = Belief::new(model).as_slice().to_vec();
    let tolerance = TOLERANCE * model.spec().r_max;
    let coarse = |grading| {
        let mut bound = GridBound::new(model, resolution(COARSEST, grading));
        bound.sweep(model, tolerance, || watch.over(GRID_UNTIL));
        (grading, bound.value(&arrival), bound)
    };
    let [first, others @ ..] = GRADINGS.map(coarse);
    let (grading, _, mut bound) = others.into_iter().fold(first, |a, b| if b.1 < a.1 { b } else { a });
    let mut intervals = COARSEST;
    loop {
        watch.report(f64::NEG_INFINITY, bound.look_ahead(model, &arrival, 0).1);
        intervals = (intervals * REFINEMENT).ceil();
        let finer = resolution(intervals, grading);
        if watch.over(GRID_UNTIL) || finer.values(model) > MOST_VALUES {
            return bound;
        }
        bound = bound.refined(model, finer);
        bound.sweep(model, tolerance, || watch.over(GRID_UNTIL));
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small whole number
fn resolution(intervals: f64, grading: f64) -> Resolution {
    Resolution { intervals: intervals as usize, grading }
}

/// The policy graph at the beliefs that the grid's policy visits, improved until it no longer gains.
fn improved_policy(
    model: &SortingModel,
    start: &OneObjectPolicy,
    grid: &GridBound,
    watch: &mut Watch<'_>,
) -> PolicyGraph {
    let arrival = Belief::new(model).as_slice().to_vec();
    let wanted = (BELIEFS_PER_SECOND * watch.time.as_secs_f64()).clamp(BELIEFS.0, BELIEFS.1);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between the two
    let beliefs = visited_beliefs(model, wanted as usize, |belief| grid.look_ahead(model, belief, 0).0);
    let mut graph = PolicyGraph::new(model, start, &beliefs);
    let mut lower = graph.value(model, &arrival);
    loop {
        watch.report(lower, f64::INFINITY);
        if watch.over(POLICY_UNTIL) {
            return graph;
        }
        graph.improve(model);
        let improved = graph.value(model, &arrival);
        if improved < lower + TOLERANCE * model.spec().r_max {
            return graph;
        }
        lower = improved;
    }
}

/// Search the belief graph from the arrival prior for the rest of the time.
fn search(model: &SortingModel, leaves: &LeafBounds, arrival: &[f64], watch: &mut Watch<'_>) {
    let mut graph = BeliefGraph::new(model, leaves, arrival, 0);
    let mut reported = Instant::now();
    loop {
        let (lower, upper) = graph.bounds();
        let over =
            watch.over(1.0) || graph.size() > MOST_NODES || upper - lower < SOLVED * model.spec().r_max;
        if over || reported.elapsed() > Duration::from_millis(200) {
            watch.report(lower, upper);
            reported = Instant::now();
        }
        if over {
            return;
        }
        graph.trial();
    }
}

#[cfg(test)]
mod tests;
