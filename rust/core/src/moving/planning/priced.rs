//! An upper bound of the value of a belt that never stops: every object has a camera of its own, and pays its share.
//!
//! Objects are tied together only by the camera. Let each of them be looked at as suits it alone, and let it pay the
//! share `lambda_n >= 0` of each of its looks, where n is how many ticks it has left when the look begins. At any
//! tick the objects of a belt have the ticks left `n_0, n_0 + T, n_0 + 2 T, ...`, with T ticks between two of them, so shares
//! that sum to at most 1 over each residue class by T never charge more than a look costs. With the values W of
//! [`super::deadline`] under these shares, and the arrival prior a,
//!
//! `V(b, v) <= sum_j W_{n_j}(v, b_j) + sum_{n_i <= N} W_{n_i}(v, a) + sum_{n_i > N} discount^(n_i - N) max_u W_N(u, a)`,
//!
//! over the undecided objects j on the belt and those i to come; N is the horizon, the visible ticks and the longest look.
//!
//! *Proof.* Call the right side U. Bellman's operator is monotone, and applied again and again, with the finitely many decisions
//! that take no time counted as one action, it converges to V. So it suffices that each action earns at most U if U is what follows.
//!
//! * *Look* from k for d ticks. Labels of different objects are independent, so that each object that is still there
//!   afterwards has `W_n(v, b) >= -lambda_n cost + discount^d E_z W_{n-d}(k, b^z)`, and the shares of the cost sum to
//!   at most the cost. An object that passes the exit meanwhile is covered by waiting: `W_n >= -discount^n missed`. One with
//!   n above N is not seen by the look, since n - d exceeds the visible ticks, and if it has n - d < N left afterwards,
//!   waiting gives `max_u W_N(u, a) >= W_N(k, a) >= discount^(N-n+d) W_{n-d}(k, a)`.
//! * *Wait* is the same without a cost.
//! * *Decide*: `W_n >= reward` for the object itself, and the others wait meanwhile. Decided objects leave shares unused.
//!
//! The bound is convex in the shares; minus the expected discounted cost of the looks that an object takes with n ticks left is a
//! subgradient. Multiplicative steps on each residue class (exponentiated gradient, Kivinen & Warmuth 1997) lower it. The bound
//! of every set of shares is valid at every belief, so the least of several is too.

use std::sync::Arc;

use super::deadline::{DeadlineProblem, DeadlineValues};
use crate::index::Viewpoint;
use crate::moving::state::State;
use crate::offline::Combination;

/// Steps in which shares are improved.
const STEPS: usize = 24;
/// Length of the first step: the log of how much it raises the share that is used most.
const FIRST_STEP: f64 = 1.0;
/// Share, before improvement, of an object that is not seen yet, against that of one that is.
const UNSEEN_SHARE: f64 = 0.05;

/// Bounds for several sets of shares.
#[derive(Debug, Clone)]
pub(crate) struct PricedBound {
    problem: Arc<DeadlineProblem>,
    sets: Vec<Priced>,
}

/// Shares, and what follows from them.
#[derive(Debug, Clone)]
struct Priced {
    shares: Vec<f64>,
    values: DeadlineValues,
    /// Of an unseen object with n ticks left, entry n, per group.
    unseen: Vec<Vec<f64>>,
}

impl PricedBound {
    /// The bounds of equal shares and of improved ones.
    pub(crate) fn new(problem: Arc<DeadlineProblem>) -> Self {
        let uniform = Priced::new(&problem, shares(&problem, 0.0));
        let improved = improved(&problem);
        Self { problem, sets: vec![uniform, improved] }
    }

    /// The bound of equal shares alone, and that of improved ones alone.
    #[cfg(test)]
    pub(crate) fn each(&self) -> [Self; 2] {
        [0, 1].map(|set| Self { problem: Arc::clone(&self.problem), sets: vec![self.sets[set].clone()] })
    }

    /// The problem of one object.
    pub(crate) fn problem(&self) -> &DeadlineProblem {
        &self.problem
    }

    /// The shares of an object with n ticks left, entry n, of the improved set.
    pub(crate) fn shares(&self) -> &[f64] {
        &self.sets[self.sets.len() - 1].shares
    }

    /// Upper bound of V at a state.
    pub(crate) fn value(&self, state: &State, viewpoint: Viewpoint) -> f64 {
        let mut sums = self.to_come(state, viewpoint);
        for (n, belief) in state.undecided(self.problem.timing()) {
            let located = self.problem.locate(belief);
            sums.iter_mut().zip(self.located(n, viewpoint, &located)).for_each(|(sum, part)| *sum += part);
        }
        least(&sums)
    }

    /// What an object whose belief was located adds to the bound of each set.
    pub(crate) fn located<'a>(
        &'a self,
        n: usize,
        viewpoint: Viewpoint,
        located: &'a Combination,
    ) -> impl Iterator<Item = f64> + 'a {
        let group = self.problem.group(viewpoint);
        self.sets.iter().map(move |set| self.problem.at(&set.values, n, group, located))
    }

    /// What the objects to come add to the bound of each set, with the camera at a viewpoint.
    pub(crate) fn to_come(&self, state: &State, viewpoint: Viewpoint) -> Vec<f64> {
        self.sets.iter().map(|set| set.to_come(&self.problem, state, self.problem.group(viewpoint))).collect()
    }
}

/// The least bound.
pub(crate) fn least(sums: &[f64]) -> f64 {
    sums.iter().copied().fold(f64::INFINITY, f64::min)
}

impl Priced {
    fn new(problem: &DeadlineProblem, shares: Vec<f64>) -> Self {
        let values = problem.values(&shares);
        let arrival = problem.locate(problem.arrival());
        let of_groups =
            |n| (0..problem.group_count()).map(|group| problem.at(&values, n, group, &arrival)).collect();
        let unseen = (0..=problem.horizon()).map(of_groups).collect();
        Self { shares, values, unseen }
    }

    fn to_come(&self, problem: &DeadlineProblem, state: &State, group: usize) -> f64 {
        let (timing, horizon) = (problem.timing(), problem.horizon());
        let (mut n, mut left, mut sum) = (state.first_to_come(timing), state.to_come, 0.0);
        while n <= horizon && left != Some(0) {
            sum += self.unseen[n][group];
            n += timing.ticks_per_place;
            left = left.map(|objects| objects - 1);
        }
        let power = |ticks: usize| problem.discount().powi(i32::try_from(ticks).unwrap_or(i32::MAX));
        let ratio = power(timing.ticks_per_place);
        let objects = left.map_or(0.0, |objects| power(objects.saturating_mul(timing.ticks_per_place)));
        let most = self.unseen[horizon].iter().copied().fold(f64::NEG_INFINITY, f64::max);
        sum + most * power(n.saturating_sub(horizon)) * (1.0 - objects) / (1.0 - ratio)
    }
}

/// Equal shares of the objects at places; those that are still to come may have a part of one.
fn shares(problem: &DeadlineProblem, unseen: f64) -> Vec<f64> {
    let visible = problem.timing().visible();
    let share = |n: usize| {
        if n == 0 {
            0.0
        } else if n <= visible {
            1.0
        } else {
            unseen
        }
    };
    let mut shares: Vec<f64> = (0..=problem.horizon()).map(share).collect();
    normalise(problem, &mut shares);
    shares
}

/// Shares that sum to 1 over the objects of each residue class.
fn normalise(problem: &DeadlineProblem, shares: &mut [f64]) {
    let period = problem.timing().ticks_per_place;
    for first in 1..=period.min(shares.len() - 1) {
        let sum: f64 = shares[first..].iter().step_by(period).sum();
        shares[first..].iter_mut().step_by(period).for_each(|share| *share /= sum);
    }
}

/// The best shares met on the way from equal ones, for a belt of unseen objects.
fn improved(problem: &DeadlineProblem) -> Priced {
    let period = problem.timing().ticks_per_place;
    let start = State::unseen(problem.timing(), problem.arrival());
    let mut priced = Priced::new(problem, shares(problem, UNSEEN_SHARE));
    let mut best = (priced.start_value(problem, &start), priced.clone());
    for step in 0..STEPS {
        let usage = problem.usage(&priced.values, &priced.shares, priced.starts(problem));
        let length = FIRST_STEP / (1.0 + step as f64).sqrt();
        let mut next = priced.shares.clone();
        for first in 1..=period {
            let most = usage[first..].iter().step_by(period).copied().fold(0.0, f64::max);
            if most > 0.0 {
                for n in (first..next.len()).step_by(period) {
                    next[n] *= (length * usage[n] / most).exp();
                }
            }
        }
        normalise(problem, &mut next);
        priced = Priced::new(problem, next);
        let value = priced.start_value(problem, &start);
        if value < best.0 {
            best = (value, priced.clone());
        }
    }
    best.1
}

impl Priced {
    /// The bound of a belt of unseen objects, from the first viewpoint group.
    fn start_value(&self, problem: &DeadlineProblem, start: &State) -> f64 {
        let timing = problem.timing();
        let visible = (1..=timing.places).map(|place| &self.unseen[place * timing.ticks_per_place]);
        let group = 0;
        visible.map(|values| values[group]).sum::<f64>() + self.to_come(problem, start, 0)
    }

    /// Where the objects of such a belt start: with their discounted number as weight.
    fn starts(&self, problem: &DeadlineProblem) -> Vec<Vec<f64>> {
        let (timing, horizon) = (problem.timing(), problem.horizon());
        let mut starts = problem.no_starts();
        let arrival = problem.locate(problem.arrival());
        let points = starts[0].len() / problem.group_count();
        let mut add = |n: usize, group: usize, weight: f64| {
            for (point, p) in &arrival {
                starts[n][group * points + *point as usize] += weight * p;
            }
        };
        (1..=timing.places).for_each(|place| add(place * timing.ticks_per_place, 0, 1.0));
        let best = (0..problem.group_count())
            .max_by(|a, b| self.unseen[horizon][*a].total_cmp(&self.unseen[horizon][*b]));
        let ratio = problem.discount().powi(i32::try_from(timing.ticks_per_place).unwrap_or(i32::MAX));
        add(horizon, best.unwrap_or(0), 1.0 / (1.0 - ratio));
        starts
    }
}
