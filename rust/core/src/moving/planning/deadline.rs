//! One object with a deadline: look at it, wait, or decide before it passes the exit.
//!
//! With `n` ticks left and the camera at viewpoint v the optimal value of a belief b about the object is
//!
//! * `W_0(v, b) = -sum_c b(c) missed(c)`, and for `n >= 1` the largest of
//! * wait: `discount W_{n-1}(v, b)`,
//! * decide, in reach: `max_i sum_c b(c) R[i, c]`,
//! * look from k, which takes `d < n` ticks: `-lambda_n cost(v, k) + discount^d E_z W_{n-d}(k, b^z)`, in which the label z
//!   comes from the place that the object has reached by then.
//!
//! `lambda_n` is the object's share of the cost of a look; for one object alone it is 1. A look that would last beyond the
//! exit tells nothing about the object, and is no better than waiting. The values are convex in b, so backward recursion on
//! a grid, with linear interpolation between its points, bounds them from above.
//!
//! Where the tables are the same at all places, every place is in reach, and a class is not missed at a gain, `W_n`
//! does not decrease in n: whatever can be done in n ticks can be done with one more left. So the set of
//! beliefs at which deciding is optimal grows as the exit comes nearer, and thresholds fall (Frazier & Yu, "Sequential
//! hypothesis testing under stochastic deadlines", NIPS 2007, have the same for deadlines that are random).

use rayon::prelude::*;

use crate::index::{Class, Position, Viewpoint};
use crate::model::SortingModel;
use crate::moving::timing::Timing;
use crate::offline::{Combination, Faces, ObjectModel, Rows};
use crate::one_object::dot;

/// Up to so many kinds, the grid covers the whole simplex; with more, faces of [`FEW`] kinds.
const ALL_KINDS: usize = 5;
const FEW: usize = 3;
/// Intervals per axis of the grid, by the number of kinds that it covers at once.
const INTERVALS: [usize; 6] = [200, 200, 200, 40, 20, 10];
/// How much finer the grid is towards certainty.
const GRADING: f64 = 0.6;

/// What does not depend on prices: the grid, and where looks lead from its points.
#[derive(Debug, Clone)]
pub(crate) struct DeadlineProblem {
    timing: Timing,
    object: ObjectModel,
    faces: Faces,
    group_of: Vec<usize>,
    groups: usize,
    /// Legal looks of each group: to where, for how much, in how many ticks.
    looks: Vec<Vec<(Viewpoint, f64, usize)>>,
    /// Per place and viewpoint: what is expected of a look, a row per point.
    expected: Vec<Rows>,
    /// Worth of deciding at each point.
    rewards: Vec<f64>,
    /// Worth of passing the exit at each point.
    passed: Vec<f64>,
}

/// Values of one object under prices, per ticks left; entry `group * points + point`.
#[derive(Debug, Clone)]
pub(crate) struct DeadlineValues(Vec<Vec<f64>>);

/// What is best at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Best {
    Wait,
    Decide,
    Look(usize),
}

impl DeadlineProblem {
    /// Lay out the grid.
    pub(crate) fn new(model: &SortingModel, timing: &Timing) -> Self {
        let object = ObjectModel::new(model);
        let size = if object.states() <= ALL_KINDS { object.states() } else { FEW };
        let faces = Faces::new(&object.arrival, size, INTERVALS[size], GRADING);
        let (group_of, groups) = timing.groups(model);
        let from = |group: usize| Viewpoint(group_of.iter().position(|g| *g == group).unwrap_or(0));
        let legal = |from: Viewpoint| {
            let look = |&to: &Viewpoint| (to, model.motion_cost(from, to), timing.look(from, to));
            model.legal_moves(from).iter().map(look).collect()
        };
        let looks = (0..groups).map(|group| legal(from(group))).collect();
        let points: Vec<_> = (0..faces.len()).map(|point| faces.belief(point)).collect();
        let pairs = model.positions().flat_map(|place| model.viewpoints().map(move |v| (place, v)));
        let expected = pairs.map(|(place, v)| expected_looks(&object, &faces, &points, place, v)).collect();
        let rewards = points.iter().map(|belief| object.reward(belief)).collect();
        let passed = points.iter().map(|belief| -dot(belief, &timing.missed)).collect();
        Self { timing: timing.clone(), object, faces, group_of, groups, looks, expected, rewards, passed }
    }

    /// Durations and places.
    pub(crate) fn timing(&self) -> &Timing {
        &self.timing
    }

    /// Discount per tick.
    pub(crate) fn discount(&self) -> f64 {
        self.object.discount
    }

    /// Belief about an object that has not been seen.
    pub(crate) fn arrival(&self) -> &[f64] {
        &self.object.arrival
    }

    /// The most ticks left that values are known for: an object that a look begun now may see on its arrival.
    pub(crate) fn horizon(&self) -> usize {
        self.timing.visible() + self.timing.longest_look()
    }

    /// Number of viewpoint groups.
    pub(crate) fn group_count(&self) -> usize {
        self.groups
    }

    /// Group of a viewpoint.
    pub(crate) fn group(&self, viewpoint: Viewpoint) -> usize {
        self.group_of[viewpoint.0]
    }

    /// A belief as a combination of points.
    pub(crate) fn locate(&self, belief: &[f64]) -> Combination {
        let mut found = Combination::new();
        self.faces.locate(belief, 1.0, &mut found);
        found
    }

    /// Probability and posterior of each label of a look at an object with `n` ticks left.
    pub(crate) fn posteriors(&self, n: usize, viewpoint: Viewpoint, belief: &[f64]) -> Vec<(f64, Vec<f64>)> {
        match self.timing.place(n) {
            Some(place) => self.object.look(place, viewpoint, belief).collect(),
            None => vec![(1.0, belief.to_vec())],
        }
    }

    /// Values where the share of a look's cost is `prices[n]` for an object with `n` ticks left, n up to the horizon.
    pub(crate) fn values(&self, prices: &[f64]) -> DeadlineValues {
        let points = self.faces.len();
        let mut values = DeadlineValues(vec![self.passed.repeat(self.groups)]);
        for (n, price) in prices.iter().enumerate().take(self.horizon() + 1).skip(1) {
            let entries = 0..self.groups * points;
            let best = |entry| self.best(&values, *price, n, (entry / points, entry % points)).1;
            let next = entries.into_par_iter().map(best).collect();
            values.0.push(next);
        }
        values
    }

    /// The best action at a point, the first among equals, and its value.
    fn best(
        &self,
        values: &DeadlineValues,
        price: f64,
        n: usize,
        (group, point): (usize, usize),
    ) -> (Best, f64) {
        let waited = self.discount() * values.0[n - 1][group * self.faces.len() + point];
        let mut best = (Best::Wait, waited);
        if self.timing.in_reach(n) && self.rewards[point] >= best.1 {
            best = (Best::Decide, self.rewards[point]);
        }
        for (index, &(to, cost, ticks)) in self.looks[group].iter().enumerate() {
            if ticks < n {
                let value =
                    self.discounted(ticks) * self.after_look(values, n - ticks, to, point) - price * cost;
                if value > best.1 {
                    best = (Best::Look(index), value);
                }
            }
        }
        best
    }

    fn after_look(&self, values: &DeadlineValues, n: usize, to: Viewpoint, point: usize) -> f64 {
        let from = self.group(to) * self.faces.len();
        let values = &values.0[n][from..][..self.faces.len()];
        self.expected_at(n, to).map_or(values[point], |rows| rows.average(point, values))
    }

    fn expected_at(&self, n: usize, to: Viewpoint) -> Option<&Rows> {
        self.timing.place(n).map(|place| &self.expected[place.0 * self.timing.viewpoints + to.0])
    }

    fn discounted(&self, ticks: usize) -> f64 {
        self.discount().powi(i32::try_from(ticks).unwrap_or(i32::MAX))
    }

    /// Expected discounted cost of the looks with `n` ticks left, entry n, of objects that start at points with weights:
    /// `starts[n]` has entries as values do. It is minus the subgradient of their values by the prices.
    pub(crate) fn usage(
        &self,
        values: &DeadlineValues,
        prices: &[f64],
        mut starts: Vec<Vec<f64>>,
    ) -> Vec<f64> {
        let points = self.faces.len();
        let mut usage = vec![0.0; starts.len()];
        for n in (1..starts.len()).rev() {
            let (before, here) = starts.split_at_mut(n);
            for (entry, &weight) in here[0].iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
                let (group, point) = (entry / points, entry % points);
                match self.best(values, prices[n], n, (group, point)).0 {
                    Best::Wait => before[n - 1][entry] += self.discount() * weight,
                    Best::Decide => {}
                    Best::Look(index) => {
                        let (to, cost, ticks) = self.looks[group][index];
                        usage[n] += weight * cost;
                        let (from, weight) = (self.group(to) * points, self.discounted(ticks) * weight);
                        let after = &mut before[n - ticks][from..][..points];
                        match self.expected_at(n - ticks, to) {
                            None => after[point] += weight,
                            Some(rows) => rows.row(point).for_each(|(to, p)| after[to] += p * weight),
                        }
                    }
                }
            }
        }
        usage
    }

    /// No weight at any point, for [`DeadlineProblem::usage`].
    pub(crate) fn no_starts(&self) -> Vec<Vec<f64>> {
        vec![vec![0.0; self.groups * self.faces.len()]; self.horizon() + 1]
    }

    /// Value with `n` ticks left at a belief that was located.
    pub(crate) fn at(&self, values: &DeadlineValues, n: usize, group: usize, located: &Combination) -> f64 {
        let values = &values.0[n][group * self.faces.len()..];
        located.iter().map(|(point, weight)| weight * values[*point as usize]).sum()
    }

    /// The least probability of a class, the others in their proportions at arrival, from which on deciding at once is
    /// optimal for one object alone with `n` ticks left; none out of reach, or if it never is.
    pub(crate) fn threshold(
        &self,
        values: &DeadlineValues,
        n: usize,
        group: usize,
        kinds: &Kinds,
    ) -> Option<f64> {
        const STEPS: usize = 400;
        if !self.timing.in_reach(n) {
            return None;
        }
        let stops = |step: &usize| {
            let belief = kinds.with_probability(*step as f64 / STEPS as f64);
            let decided = self.object.reward(&belief);
            let on = |&(to, cost, ticks): &(Viewpoint, f64, usize)| {
                let value = |(p, after): (f64, Vec<f64>)| {
                    p * self.at(values, n - ticks, self.group(to), &self.locate(&after))
                };
                let after = |()| self.posteriors(n - ticks, to, &belief).into_iter().map(value).sum::<f64>();
                (ticks < n).then_some(()).map_or(f64::NEG_INFINITY, after) * self.discounted(ticks) - cost
            };
            let waited = self.discount() * self.at(values, n - 1, group, &self.locate(&belief));
            decided >= self.looks[group].iter().map(on).fold(waited, f64::max)
        };
        let first = (kinds.first_step(STEPS)..=STEPS).rev().take_while(stops).last()?;
        Some(first as f64 / STEPS as f64)
    }
}

/// Beliefs about an object between its arrival and the certainty of a class.
#[derive(Debug, Clone)]
pub(crate) struct Kinds {
    arrival: Vec<f64>,
    of_class: std::ops::Range<usize>,
    prior: f64,
}

impl Kinds {
    /// Those on the way to a class.
    pub(crate) fn towards(model: &SortingModel, class: Class) -> Self {
        let arrival = model.arrival().as_slice().to_vec();
        let prior = model.class_probability(class, &arrival);
        Self { arrival, of_class: model.kinds_of(class), prior }
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a probability
    fn first_step(&self, steps: usize) -> usize {
        (self.prior * steps as f64).ceil() as usize
    }

    fn with_probability(&self, p: f64) -> Vec<f64> {
        let part = |kind: usize, prior: f64| {
            let (all, part) =
                if self.of_class.contains(&kind) { (self.prior, p) } else { (1.0 - self.prior, 1.0 - p) };
            if all > 0.0 { prior * part / all } else { 0.0 }
        };
        self.arrival.iter().enumerate().map(|(kind, prior)| part(kind, *prior)).collect()
    }
}

fn expected_looks(
    object: &ObjectModel,
    faces: &Faces,
    points: &[Vec<f64>],
    place: Position,
    viewpoint: Viewpoint,
) -> Rows {
    let mut rows = Rows::new();
    rows.extend(points.iter().map(|belief| {
        let mut row = Combination::new();
        object.look(place, viewpoint, belief).for_each(|(p, after)| faces.locate(&after, p, &mut row));
        row
    }));
    rows
}
