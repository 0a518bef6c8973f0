//! The stages of the solver: what is done, in which part of the time.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::LeafBounds;
use super::alpha::{AlphaVectors, joint_kinds};
use super::controller::Controller;
use super::evaluation::policy_value;
use super::graph::{BeliefGraph, MOST_NODES, ROOT};
use super::reach::Reach;
use super::upper::{GridBound, Resolution};
use super::watch::Watch;
use crate::belief::Belief;
use crate::index::Viewpoint;
use crate::model::SortingModel;

/// Parts of the time after which the grid, and the searches, have had their share; the rest is for valuing the
/// policy found.
pub(super) const GRID_UNTIL: f64 = 0.45;
const SEARCH_UNTIL: f64 = 0.85;
/// Intervals per axis of the first grid, fewer where that has too many values for its number of classes.
const COARSEST: u32 = 10;
const MOST_COARSE_VALUES: f64 = 1e7;
/// The factor from one grid to the next.
const REFINEMENT: f64 = 1.25;
/// Finer than this a grid of few dimensions gains nothing more.
const MOST_INTERVALS: f64 = 1000.0;
/// A refinement by less brings less than the search does in its time.
const LEAST_REFINEMENT: f64 = 1.06;
/// Gradings tried on a coarse grid; which is best depends on how sharply decisions are punished.
const GRADINGS: [f64; 5] = [0.0, 0.6, 1.0, 1.4, 1.8];
/// Values of the finest grid, each of 4 bytes, twice.
const MOST_VALUES: f64 = 1e8;
/// Values of a grid to keep, and to save: 36 MB.
const MOST_KEPT: f64 = 9e6;
/// Differences that have settled to this part of `r_max` have converged; refining then gains more.
const TOLERANCE: f64 = 1e-4;
/// Growth of the graph from one policy to the next.
const BETWEEN_POLICIES: usize = 3;
/// The next one waits for the end unless so many times what the last one took is left.
const MOST_SPENT: u32 = 20;
/// Times are foreseen from earlier ones; a stage that needs so many times the one foreseen is still in time.
const MARGIN: f64 = 1.3;
/// A gap, as a part of `r_max`, at which there is nothing left to do.
const GAP_TOLERANCE: f64 = 1e-6;

/// Whether a grid that is worth its name is small enough.
pub(super) fn grid_fits(model: &SortingModel) -> bool {
    (resolution(f64::from(COARSEST), 0.0).values(model) as f64) < MOST_VALUES
}

/// The grid bound, refined from coarse to fine.
pub(super) fn tightened_grid(model: &SortingModel, watch: &Watch<'_>) -> GridBound {
    let arrival = Belief::new(model).as_slice().to_vec();
    let tolerance = TOLERANCE * model.reward_scale();
    let ahead = |bound: &GridBound| bound.look_ahead(model, &arrival, Viewpoint(0)).1;
    let work = |n: f64| resolution(n, 0.0).values(model) as f64;
    let mut best = coarse_grid(model, MOST_COARSE_VALUES, TOLERANCE, || watch.over(GRID_UNTIL));
    let mut intervals = best.resolution.intervals as f64;
    let mut spent = watch.elapsed().as_secs_f64() / GRADINGS.len() as f64;
    loop {
        watch.report_upper(ahead(&best));
        let affordable =
            |n: f64| MARGIN * spent * work(n) / work(intervals) < watch.left(GRID_UNTIL).as_secs_f64();
        let mut finer = (intervals * REFINEMENT).ceil().min(MOST_INTERVALS);
        while finer > intervals * LEAST_REFINEMENT && !(affordable(finer) && work(finer) < MOST_VALUES) {
            finer -= 1.0;
        }
        if finer <= intervals * LEAST_REFINEMENT || watch.over(GRID_UNTIL) {
            return best;
        }
        let began = Instant::now();
        let mut bound = best.refined(model, resolution(finer, best.resolution.grading));
        bound.improve(model, tolerance, || watch.over(GRID_UNTIL));
        if ahead(&bound) < ahead(&best) {
            best = bound;
        }
        (intervals, spent) = (finer, began.elapsed().as_secs_f64());
    }
}

/// Work of finding the posteriors of all points of the coarsest grid between its points, by one look.
pub(super) fn work_of_coarsest(model: &SortingModel) -> f64 {
    // One interval per axis: the points are the kinds.
    (model.label_count() as f64) * (model.kind_count() as f64).powi(3)
}

/// The best graded of coarse grids, of at most so many values times classes, to a tolerance in units of `r_max`.
pub(super) fn coarse_grid(
    model: &SortingModel,
    most_values: f64,
    tolerance: f64,
    stop: impl Fn() -> bool,
) -> GridBound {
    let arrival = Belief::new(model).as_slice().to_vec();
    let ahead = |bound: &GridBound| bound.look_ahead(model, &arrival, Viewpoint(0)).1;
    // Work per value: how many posteriors a look may lead to, and between how many points each lies.
    let entries = (model.label_count() * model.kind_count()) as f64 / model.class_count() as f64;
    let values = |n: f64| resolution(n, 0.0).values(model) as f64 * entries;
    let small = |n: &f64| values(*n) < most_values;
    let intervals = (1..=COARSEST).rev().map(f64::from).find(small).unwrap_or(1.0);
    // Each starts from the best before it, which is a bound on any grid.
    let mut best = GridBound::new(model, resolution(intervals, GRADINGS[0]));
    for (number, grading) in GRADINGS.into_iter().enumerate() {
        if number > 0 && stop() {
            break;
        }
        let mut bound = best.refined(model, resolution(intervals, grading));
        bound.improve(model, tolerance * model.reward_scale(), &stop);
        if number == 0 || ahead(&bound) < ahead(&best) {
            best = bound;
        }
    }
    best
}

/// The bound on a grid of a size to keep.
pub(super) fn thinned(model: &SortingModel, grid: Arc<GridBound>) -> Arc<GridBound> {
    let mut kept = grid.resolution;
    while kept.values(model) as f64 > MOST_KEPT {
        kept.intervals -= 1;
    }
    if kept == grid.resolution { grid } else { Arc::new(grid.refined(model, kept)) }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small whole number
pub(super) fn resolution(intervals: f64, grading: f64) -> Resolution {
    Resolution { intervals: intervals as usize, grading }
}

/// The belief graph, grown from the arrival prior in the rest of the time, and a policy from it now and then.
///
/// Returns the policies found; none for models without a grid.
pub(super) fn searched(
    model: &SortingModel,
    leaves: &LeafBounds,
    arrival: &[f64],
    watch: &Watch<'_>,
) -> Option<AlphaVectors> {
    let mut graph = BeliefGraph::new(model, leaves, arrival, Viewpoint(0));
    let mut known =
        leaves.grid.is_some().then(|| AlphaVectors::chained(model, &leaves.policy, &[arrival.to_vec()]));
    let most_nodes = MOST_NODES / joint_kinds(model).div_ceil(16);
    let (mut valued, mut spent) = (0, Duration::ZERO);
    loop {
        let reach = Reach::new(&graph, model.discount());
        let growth = reach.interior.len() as f64 / usize::max(valued, 1) as f64;
        // What is found by searching on could not be valued any more.
        let late = spent.mul_f64(MARGIN * growth) > watch.left(1.0);
        let over = late || watch.over(SEARCH_UNTIL) || graph.size() > most_nodes || reach.leaves.is_empty();
        let due = reach.interior.len() > valued * BETWEEN_POLICIES;
        if over || due && spent * MOST_SPENT < watch.left(SEARCH_UNTIL) {
            let began = Instant::now();
            valued = reach.interior.len();
            let stop = || watch.over(if over { 1.0 } else { SEARCH_UNTIL });
            match &mut known {
                Some(known) => controlled(model, &graph, &reach, known, watch, stop),
                None => watch.report_lower(policy_value(model, &leaves.policy, &graph, &reach, stop)),
            }
            spent = began.elapsed();
        }
        if over || watch.gap() < GAP_TOLERANCE * model.reward_scale() {
            return known;
        }
        reach.grow(&mut graph, || watch.over(SEARCH_UNTIL));
        watch.report_upper(graph.upper(ROOT));
    }
}

/// Improve the graph's policy with the policies known, and these with it, until it no longer gains.
fn controlled(
    model: &SortingModel,
    graph: &BeliefGraph<'_>,
    reach: &Reach,
    known: &mut AlphaVectors,
    watch: &Watch<'_>,
    stop: impl Fn() -> bool,
) {
    if reach.interior.is_empty() {
        return;
    }
    let mut controller = Controller::new(model, graph, reach, known);
    let mut lower = f64::NEG_INFINITY;
    loop {
        controller.evaluate(&stop);
        let improved = controller.value();
        if improved < lower + TOLERANCE * model.reward_scale() {
            return;
        }
        *known = controller.alphas();
        // From the root, too, another node's policy may be the better one.
        watch.report_lower(known.value(model, &graph.belief(ROOT).0));
        lower = improved;
        if stop() {
            return;
        }
        controller.close();
    }
}
