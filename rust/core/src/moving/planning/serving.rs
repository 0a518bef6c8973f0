//! The default policy: objects are served one after the other, the most urgent first, each by a plan of its own.
//!
//! What is learnt about the objects behind the one that is served is not used, so the value is a lower bound of V: the
//! labels that a plan ignores are independent of those it uses. With `F_j(t, s)` the value of object j and those behind it
//! from tick t on, the camera in group s,
//!
//! `F_j(t, s) = sum_c b_j(c) (G(c) + sum_{u,r} D_{u,r}(c) F_{j+1}(t + u, r))`
//!
//! for the plan chosen with `n_j - t` ticks left. Behind the objects on the belt come unseen ones, whose values by ticks left
//! and number are tables of the same recursion.

use std::sync::atomic::{AtomicBool, Ordering};

use super::plans::{DeadlinePlan, DeadlinePlans};
use crate::index::Viewpoint;
use crate::model::SortingModel;
use crate::moving::state::State;
use crate::moving::timing::Timing;
use crate::one_object::dot;

/// Tables of unseen objects, at most; the last is that of a belt that never ends.
const MOST_TABLES: usize = 2000;
/// Change of a table below which it is that of an endless belt, in units of rewards.
const TOLERANCE: f64 = 1e-10;

/// The policy, and what unseen objects are worth under it.
#[derive(Debug, Clone)]
pub(crate) struct Serving {
    timing: Timing,
    plans: DeadlinePlans,
    group_of: Vec<usize>,
    groups: usize,
    discount: f64,
    arrival: Vec<f64>,
    /// Per number of objects: values by ticks left of the first, entry `n * S + group`.
    unseen: Vec<Vec<f64>>,
}

/// An undecided object whose label may turn out in several ways.
#[derive(Debug, Clone)]
pub(crate) struct Served {
    /// Ticks left.
    pub left: usize,
    /// Probability and belief of each outcome.
    pub outcomes: Vec<(f64, Vec<f64>)>,
}

/// What a plan does from some tick on.
#[derive(Debug, Clone)]
struct Part {
    earned: f64,
    /// When the camera is free, where, and with which discounted probability.
    free: Vec<(usize, usize, f64)>,
}

/// Values of the policy for all outcomes.
#[derive(Debug)]
pub(crate) struct ServedValues {
    groups: usize,
    /// Per object and outcome, entry `t * S + group`.
    parts: Vec<Vec<Vec<Part>>>,
    /// What comes behind all of them, entry `t * S + group`.
    behind: Vec<f64>,
    expected: f64,
    group: usize,
}

impl Serving {
    /// Make plans, and value what is still to come.
    pub(crate) fn new(model: &SortingModel, timing: &Timing, stop: &AtomicBool) -> Self {
        let (group_of, groups) = timing.groups(model);
        let entries = (timing.visible() + 1) * groups;
        let mut serving = Self {
            timing: timing.clone(),
            plans: DeadlinePlans::new(model, timing, stop),
            group_of,
            groups,
            discount: model.discount(),
            arrival: model.arrival().as_slice().to_vec(),
            unseen: vec![vec![0.0; entries]],
        };
        loop {
            let count = serving.unseen.len();
            let mut table = vec![0.0; entries];
            for n in 1..=timing.visible() {
                for group in 0..groups {
                    let plan =
                        serving.plan(n, group, &serving.arrival, serving.behind(n, 0, group, count - 1));
                    let next = |t: usize, s: usize| serving.behind(n, t, s, count - 1);
                    table[n * groups + group] = plan.value(&serving.arrival, groups, next);
                }
            }
            let last = &serving.unseen[count - 1];
            let change = table.iter().zip(last).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            serving.unseen.push(table);
            if change < TOLERANCE || count >= MOST_TABLES || stop.load(Ordering::Relaxed) {
                return serving;
            }
        }
    }

    /// Value of the policy at a state.
    pub(crate) fn value(&self, state: &State, viewpoint: Viewpoint) -> f64 {
        self.evaluate(&served(state, &self.timing), state, viewpoint).expected
    }

    /// Value of the policy where the objects on the belt have outcomes that are not known yet: each plan is chosen by its own
    /// object's outcome and for what is expected of those behind.
    pub(crate) fn evaluate(&self, objects: &[Served], state: &State, viewpoint: Viewpoint) -> ServedValues {
        let (groups, group) = (self.groups, self.group_of[viewpoint.0]);
        let mut latest = vec![0];
        for object in objects {
            let before = latest[latest.len() - 1];
            latest.push(before.max(object.left + self.timing.sort_ticks));
        }
        let first = state.first_to_come(&self.timing);
        let to_come = state.to_come.unwrap_or(usize::MAX);
        let times = (0..=latest[objects.len()]).flat_map(|t| (0..groups).map(move |s| (t, s)));
        let behind: Vec<f64> = times.map(|(t, s)| self.unseen_from(first, t, s, to_come)).collect();
        let mut next = behind.clone();
        let mut parts = Vec::with_capacity(objects.len());
        for (object, last) in objects.iter().zip(&latest).rev() {
            let mut values = vec![0.0; (last + 1) * groups];
            let mut of_object = Vec::with_capacity(object.outcomes.len());
            for (p, belief) in &object.outcomes {
                let part =
                    |entry: usize| self.part(object.left, belief, (entry / groups, entry % groups), &next);
                let of_outcome: Vec<Part> = (0..values.len()).map(part).collect();
                for (value, part) in values.iter_mut().zip(&of_outcome) {
                    *value += p * part.value(&next, groups);
                }
                of_object.push(of_outcome);
            }
            parts.push(of_object);
            next = values;
        }
        parts.reverse();
        ServedValues { groups, parts, behind, expected: next[group], group }
    }

    /// What the plan for an object does from a tick on.
    fn part(&self, left: usize, belief: &[f64], (t, s): (usize, usize), next: &[f64]) -> Part {
        if t >= left {
            let late = i32::try_from(t - left).unwrap_or(i32::MAX);
            let earned = -dot(belief, &self.timing.missed) * self.discount.powi(-late);
            return Part { earned, free: vec![(t, s, 1.0)] };
        }
        let plan = self.plan(left - t, s, belief, next[t * self.groups + s]);
        let weights = plan.free.chunks_exact(belief.len()).map(|free| dot(free, belief));
        let free = weights
            .enumerate()
            .filter(|(_, weight)| *weight > 0.0)
            .map(|(index, weight)| (t + index / self.groups, index % self.groups, weight));
        Part { earned: dot(&plan.gain, belief), free: free.collect() }
    }

    fn plan(&self, n: usize, group: usize, belief: &[f64], next: f64) -> &DeadlinePlan {
        self.plans.best(n, group, belief, next)
    }

    /// Value of so many unseen objects `t` ticks from now, behind one that has `n` ticks left now.
    fn behind(&self, n: usize, t: usize, s: usize, count: usize) -> f64 {
        self.unseen_from(n + self.timing.ticks_per_place, t, s, count)
    }

    /// Value at tick `t` of so many unseen objects, of which the first has `left` ticks left at tick 0.
    fn unseen_from(&self, left: usize, t: usize, s: usize, count: usize) -> f64 {
        if count == 0 {
            return 0.0;
        }
        let power = |exponent: usize| i32::try_from(exponent).unwrap_or(i32::MAX);
        if t >= left {
            let missed = dot(&self.arrival, &self.timing.missed) * self.discount.powi(-power(t - left));
            let next = if count == usize::MAX { count } else { count - 1 };
            return self.behind(left, t, s, next) - missed;
        }
        let (n, visible) = (left - t, self.timing.visible());
        let table = &self.unseen[count.min(self.unseen.len() - 1)];
        table[n.min(visible) * self.groups + s] * self.discount.powi(power(n.saturating_sub(visible)))
    }
}

impl Part {
    fn value(&self, next: &[f64], groups: usize) -> f64 {
        self.free.iter().fold(self.earned, |sum, (t, s, weight)| sum + weight * next[t * groups + s])
    }
}

impl ServedValues {
    /// Expectation over all outcomes.
    pub(crate) fn expected(&self) -> f64 {
        self.expected
    }

    /// Value for one outcome of each object, with the plans that were chosen by them.
    pub(crate) fn of(&self, outcomes: &[usize]) -> f64 {
        let mut next = self.behind.clone();
        for (parts, outcome) in self.parts.iter().zip(outcomes).rev() {
            next = parts[*outcome].iter().map(|part| part.value(&next, self.groups)).collect();
        }
        next[self.group]
    }
}

/// The undecided objects of a state, as they are known.
fn served(state: &State, timing: &Timing) -> Vec<Served> {
    let known = |(left, belief): (usize, &[f64])| Served { left, outcomes: vec![(1.0, belief.to_vec())] };
    state.undecided(timing).map(known).collect()
}
