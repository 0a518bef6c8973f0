//! From coarse to fine: prices are optimised, the points refined where objects go, and so on while there is time.

use std::time::{Duration, Instant};

use super::super::watch::Watch;
use super::bundle::Bundle;
use super::faces::Faces;
use super::object::ObjectModel;
use super::points::Points;
use super::problem::{Policy, Prices, Problem, Values};
use super::shared::{Mode, Shared};
use super::usage::Occupancy;
use crate::index::{Position, Viewpoint};
use crate::model::SortingModel;
use crate::one_object::dot;

/// Up to so many states, faces are the whole simplex; with more, faces of [`FEW`] states and nodes.
const ALL_STATES: usize = 5;
const FEW: usize = 3;
/// Intervals per axis of the first grids.
const COARSE: [usize; 6] = [200, 200, 30, 12, 8, 6];
/// Intervals of faces when they are not the whole simplex.
const FACE_INTERVALS: usize = 8;
/// How much finer grids are towards certainty.
pub(super) const GRADING: f64 = 0.6;
/// Readings of the clock, fewer where a sweep over all modes costs more than this many products.
const CLOCK: usize = 4;
const MOST_PRODUCTS: usize = 10_000_000;
/// Growth of intervals, and of the number of nodes, from one stage to the next.
const REFINEMENT: f64 = 1.5;
const NODE_GROWTH: f64 = 2.0;
/// Nodes that a stage brings at least.
const FEWEST_NODES: usize = 100;
/// Points of a grid; weights of the rows of all nodes.
const MOST_POINTS: usize = 400_000;
const MOST_WEIGHTS: usize = 30_000_000;
/// Convergence tolerances as parts of the largest reward: of values, while prices are optimised and when they are proved.
const TOLERANCE: f64 = 1e-3;
const PROOF_TOLERANCE: f64 = 1e-4;
/// Squared differences of visits that are none but for rounding.
const AGREEMENT: f64 = 1e-12;
/// Prices are optimal if the next step is foreseen to gain less, as a part of the bound.
const PRICE_TOLERANCE: f64 = 1e-4;
/// Refining is over if it gains less, as a part of the bound.
const LEAST_GAIN: f64 = 2e-4;
/// Most price steps of a stage: on a grid, and where nodes are still few.
const MOST_STEPS: usize = 150;
const FEW_STEPS: usize = 15;
/// The first step is foreseen to gain this part of the bound.
const FIRST_GAIN: f64 = 0.05;
/// The proof's part in the time of a stage.
const PROOF: f64 = 0.25;
/// A stage that needs so many times the time foreseen is still in time.
const MARGIN: f64 = 1.5;

/// The work on one bound.
pub(super) struct Improvement<'a, 'w> {
    watch: &'a Watch<'w>,
    /// Part of the watch's time to spend.
    until: f64,
    shared: Shared,
    points: Points,
    prices: Prices,
    values: Values,
    policy: Policy,
    occupancy: Occupancy,
    /// Of the last bundle.
    step: Option<f64>,
    intervals: usize,
    scale: f64,
    start: Mode,
}

impl<'a, 'w> Improvement<'a, 'w> {
    /// Coarse points; every position pays an equal share for camera and belt.
    pub(super) fn new(model: &SortingModel, watch: &'a Watch<'w>, until: f64) -> Self {
        let object = ObjectModel::new(model);
        let states = object.states();
        let whole = states <= ALL_STATES;
        let (size, intervals) = if whole { (states, COARSE[states]) } else { (FEW, FACE_INTERVALS) };
        let faces = Faces::new(&object.arrival, size, intervals, GRADING);
        let products = faces.len() * object.positions() * object.viewpoints() * states;
        let clock = (MOST_PRODUCTS / products).clamp(1, CLOCK);
        let shared = Shared::new(model, clock);
        let positions = object.positions();
        let prices = vec![shared.earned.iter().map(|earned| earned / positions as f64).collect(); positions];
        let points = Points::new(object, faces);
        let problem = Problem { points: &points, shared: &shared, prices: &prices };
        let (values, occupancy) = (problem.constant(0.0), Occupancy::none(&problem));
        let start = shared.start(Viewpoint(0));
        let scale = model.reward_scale();
        let policy = Policy::new();
        Self {
            watch,
            until,
            shared,
            points,
            prices,
            values,
            policy,
            occupancy,
            step: None,
            intervals,
            scale,
            start,
        }
    }

    /// The best points found, with their values.
    pub(super) fn run(mut self) -> (Points, Shared, Values) {
        let mut foreseen = Duration::ZERO;
        let (mut least, mut best): (f64, Option<(Points, Values)>) = (f64::INFINITY, None);
        loop {
            let began = Instant::now();
            // What is left may still do for a proof on finer points at the prices found.
            let late = self.late(foreseen);
            if !late {
                self.optimise_prices();
            }
            let (upper, values) = self.proved();
            self.watch.report_upper(upper);
            let gained = least - upper;
            if upper < least || best.is_none() {
                (least, best) = (upper, Some((self.points.clone(), values)));
            }
            foreseen = began.elapsed().mul_f64(self.growth());
            let done = self.points.whole() && gained < LEAST_GAIN * least.abs();
            if late || done || self.late(foreseen.mul_f64(PROOF)) || !self.refine() {
                break;
            }
        }
        let (points, values) = best.unwrap_or((self.points, self.values));
        (points, self.shared, values)
    }

    /// Whether what takes the time foreseen would come too late.
    fn late(&self, foreseen: Duration) -> bool {
        self.watch.over(self.until) || foreseen.mul_f64(MARGIN) > self.watch.left(self.until)
    }

    fn problem(&self) -> Problem<'_> {
        Problem { points: &self.points, shared: &self.shared, prices: &self.prices }
    }

    /// Work of the next stage, in units of the last one's.
    fn growth(&self) -> f64 {
        if self.points.whole() {
            REFINEMENT.powf(self.points.object.states() as f64 - 1.0)
        } else {
            NODE_GROWTH
        }
    }

    /// The bound at the start under other prices, and its subgradient.
    fn evaluate(&mut self, prices: Prices) -> (f64, Vec<f64>) {
        let problem = Problem { points: &self.points, shared: &self.shared, prices: &prices };
        let stop = || self.watch.over(self.until);
        self.policy = problem.iterate(&mut self.values, TOLERANCE * self.scale, stop);
        self.occupancy.renew(&problem, &self.policy, self.start);
        let usage = self.occupancy.usage(&problem, &self.policy);
        (problem.objective(&self.values, self.start), consensus(&usage))
    }

    fn optimise_prices(&mut self) {
        let choices = self.shared.choices();
        let (value, slope) = self.evaluate(self.prices.clone());
        let square = dot(&slope, &slope);
        // All positions agree, as one position by itself always does.
        if square < AGREEMENT {
            return;
        }
        let step = self.step.unwrap_or(FIRST_GAIN * value.abs() / square);
        let mut bundle = Bundle::new(self.prices.concat(), value, slope, step);
        let steps = if self.points.whole() { MOST_STEPS } else { FEW_STEPS };
        for _ in 0..steps {
            let next = bundle.next();
            if self.watch.over(self.until) || bundle.foreseen() < PRICE_TOLERANCE * bundle.value().abs() {
                break;
            }
            let (value, slope) = self.evaluate(next.chunks(choices).map(<[f64]>::to_vec).collect());
            bundle.learn(next, value, slope);
        }
        self.step = Some(bundle.step());
        self.prices = bundle.centre().chunks(choices).map(<[f64]>::to_vec).collect();
    }

    /// Values that are proved, and the bound at the start.
    fn proved(&mut self) -> (f64, Values) {
        let prices = self.prices.clone();
        let problem = Problem { points: &self.points, shared: &self.shared, prices: &prices };
        let stop = || self.watch.over(self.until);
        self.policy = problem.iterate(&mut self.values, PROOF_TOLERANCE * self.scale, stop);
        self.occupancy.renew(&problem, &self.policy, self.start);
        let mut values = self.values.clone();
        problem.certify(&mut values);
        (problem.objective(&values, self.start), values)
    }

    /// More nodes, and finer faces where they are the whole simplex. Whether there are any.
    fn refine(&mut self) -> bool {
        let beliefs = self.wanted();
        let points = if self.points.whole() {
            let object = &self.points.object;
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small whole number
            let intervals = (self.intervals as f64 * REFINEMENT).ceil() as usize;
            let faces = Faces::new(&object.arrival, object.states(), intervals, GRADING);
            if faces.len() > MOST_POINTS {
                return false;
            }
            self.intervals = intervals;
            self.points.refined(faces, beliefs)
        } else {
            if beliefs.is_empty() || self.points.node_weights() > MOST_WEIGHTS {
                return false;
            }
            self.points.grown(beliefs)
        };
        let problem = Problem { points: &points, ..self.problem() };
        let values = problem.interpolated(&self.points, &self.values);
        self.occupancy = Occupancy::none(&problem);
        (self.points, self.values) = (points, values);
        true
    }

    /// Beliefs that objects come to and at which interpolation costs most: half as many as there are nodes, or a few.
    fn wanted(&self) -> Vec<(Position, Vec<f64>)> {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // far below 2^52
        let most = FEWEST_NODES + ((NODE_GROWTH - 1.0) * self.points.node_count() as f64) as usize;
        let mut found = self.occupancy.departures(&self.problem(), &self.policy);
        let excess = |(place, belief, visits): &(_, Vec<f64>, f64)| {
            visits * self.problem().interpolation_excess(&self.values, *place, belief)
        };
        let excesses: Vec<f64> = found.iter().map(excess).collect();
        let mut order: Vec<usize> = (0..found.len()).collect();
        order.sort_by(|a, b| excesses[*b].total_cmp(&excesses[*a]));
        order.truncate(most);
        order.into_iter().map(|i| (found[i].0.1, std::mem::take(&mut found[i].1))).collect()
    }
}

/// How often each position wants each choice beyond the average of all positions.
fn consensus(usage: &[Vec<f64>]) -> Vec<f64> {
    let positions = usage.len() as f64;
    let average = |choice: usize| usage.iter().map(|row| row[choice]).sum::<f64>() / positions;
    let averages: Vec<f64> = (0..usage[0].len()).map(average).collect();
    usage.iter().flat_map(|row| row.iter().zip(&averages).map(|(own, average)| own - average)).collect()
}
