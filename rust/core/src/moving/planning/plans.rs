//! Conditional plans for one object with a deadline: what the default policy executes.
//!
//! A plan for an object with n ticks left is known exactly by two functions of the true kind c: the expected discounted
//! reward `G(c)` of its looks and its decision, and when the camera is free again, `D_{t,s}(c) = discount^t P(free after t
//! ticks, at viewpoint group s | c)`. Executing it from belief b and continuing with value `F(t, s)` is worth
//! `sum_c b(c) (G(c) + sum_{t,s} D_{t,s}(c) F(t, s))`, whatever the continuation.
//!
//! A plan may decide ahead: the bin is chosen while the object is still out of reach, and the camera goes on. The decision
//! is then made before the first action that begins in reach, at most one look (but a tick) late; plans count a
//! gain as if it were that late, and a loss as if it were not late at all. So values stay lower bounds.
//!
//! Plans come from point-based backups at beliefs that looks reach; values of other plans than the best are not lost,
//! since every plan of a set can be executed.

use std::sync::atomic::AtomicBool;

use crate::belief::condition;
use crate::index::{Bin, Viewpoint};
use crate::model::{Look, SortingModel};
use crate::moving::timing::Timing;
use crate::one_object::{dot, reachable_beliefs};

/// Beliefs at which plans are made.
const POINTS: usize = 60;
/// Plans are chosen as if each further object were worth this part of the largest reward, once for each.
const FOLLOWERS: [f64; 2] = [0.0, 1.5];

/// A conditional plan.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DeadlinePlan {
    /// `G(c)`.
    pub gain: Vec<f64>,
    /// `D_{t,s}(c)`, entry `(t * S + s) * N + c`.
    pub free: Vec<f64>,
    /// `sum_{t,s} D_{t,s}(c)`.
    freed: Vec<f64>,
}

/// Plans by ticks left and viewpoint group.
#[derive(Debug, Clone)]
pub(crate) struct DeadlinePlans {
    groups: usize,
    plans: Vec<Vec<DeadlinePlan>>,
}

impl DeadlinePlans {
    /// Make plans for every number of ticks that a visible object may have left.
    pub(crate) fn new(model: &SortingModel, timing: &Timing, stop: &AtomicBool) -> Self {
        let (group_of, groups) = timing.groups(model);
        let all = reachable_beliefs(model, stop);
        let every = all.len().div_ceil(POINTS);
        let points = all.into_iter().step_by(every).collect();
        let mut making = Making { model, timing, group_of, groups, points, plans: vec![Vec::new(); groups] };
        for n in 1..=timing.visible() {
            for group in 0..groups {
                let plans = making.plans_with(n, group);
                making.plans.push(plans);
            }
        }
        Self { groups, plans: making.plans }
    }

    /// The plan that is best for a belief if what follows it is worth `next` at any time.
    pub(crate) fn best(&self, n: usize, group: usize, belief: &[f64], next: f64) -> &DeadlinePlan {
        best(&self.plans[n * self.groups + group], belief, next)
    }
}

impl DeadlinePlan {
    fn new(gain: Vec<f64>, free: Vec<f64>) -> Self {
        let mut freed = vec![0.0; gain.len()];
        for part in free.chunks_exact(gain.len()) {
            freed.iter_mut().zip(part).for_each(|(sum, d)| *sum += d);
        }
        Self { gain, free, freed }
    }

    fn worth(&self, belief: &[f64], next: f64) -> f64 {
        dot(&self.gain, belief) + next * dot(&self.freed, belief)
    }

    /// Value from a belief where `next(t, s)` follows once the camera is free.
    pub(crate) fn value(&self, belief: &[f64], groups: usize, next: impl Fn(usize, usize) -> f64) -> f64 {
        let mut value = dot(&self.gain, belief);
        for (index, free) in self.free.chunks_exact(belief.len()).enumerate() {
            let weight = dot(free, belief);
            if weight > 0.0 {
                value += weight * next(index / groups, index % groups);
            }
        }
        value
    }
}

fn best<'a>(plans: &'a [DeadlinePlan], belief: &[f64], next: f64) -> &'a DeadlinePlan {
    let mut best = (&plans[0], f64::NEG_INFINITY);
    for plan in plans {
        let worth = plan.worth(belief, next);
        if worth > best.1 {
            best = (plan, worth);
        }
    }
    best.0
}

/// Backward recursion over the ticks left.
struct Making<'a> {
    model: &'a SortingModel,
    timing: &'a Timing,
    group_of: Vec<usize>,
    groups: usize,
    points: Vec<Vec<f64>>,
    /// Entry `n * S + group`.
    plans: Vec<Vec<DeadlinePlan>>,
}

impl Making<'_> {
    fn plans_with(&self, n: usize, group: usize) -> Vec<DeadlinePlan> {
        let mut plans: Vec<DeadlinePlan> = Vec::new();
        for belief in &self.points {
            for followers in FOLLOWERS {
                let next = followers * self.model.reward_scale();
                let candidates = self.candidates(n, group, belief, next);
                let best = best(&candidates, belief, next);
                if !plans.contains(best) {
                    plans.push(best.clone());
                }
            }
        }
        plans
    }

    fn candidates(&self, n: usize, group: usize, belief: &[f64], next: f64) -> Vec<DeadlinePlan> {
        let mut candidates = vec![self.leave(n, group)];
        candidates.extend(self.decide(n, group, self.model.best_decision(belief).0));
        if n > 1 {
            let waited = best(&self.plans[(n - 1) * self.groups + group], belief, next);
            candidates.push(self.after(0.0, 1, |kind, sum| sum(waited, kind, 1.0)));
        }
        let from = Viewpoint(self.group_of.iter().position(|g| *g == group).unwrap_or(0));
        for &to in self.model.legal_moves(from) {
            let ticks = self.timing.look(from, to);
            if ticks < n {
                candidates.push(self.look(n - ticks, (from, to), ticks, belief, next));
            }
        }
        candidates
    }

    fn leave(&self, n: usize, group: usize) -> DeadlinePlan {
        let gain = self.timing.missed.iter().map(|price| -price * self.discount(n)).collect();
        DeadlinePlan::new(gain, self.free_after(0, group))
    }

    /// Decide, now or ahead; none where that is not possible in time.
    fn decide(&self, n: usize, group: usize, bin: Bin) -> Option<DeadlinePlan> {
        let wait = self.timing.until_reach(n);
        let late = if wait == 0 { 0 } else { self.timing.longest_look() - 1 };
        if wait > 0 && (self.timing.sort_ticks > 0 || wait + late >= n) {
            return None;
        }
        let gain = |kind| {
            let reward = self.model.reward(bin, kind);
            reward * self.discount(if reward < 0.0 { wait } else { wait + late })
        };
        let free = self.free_after(self.timing.sort_ticks, group);
        Some(DeadlinePlan::new(self.model.kinds().map(gain).collect(), free))
    }

    fn look(
        &self,
        left: usize,
        (from, to): (Viewpoint, Viewpoint),
        ticks: usize,
        belief: &[f64],
        next: f64,
    ) -> DeadlinePlan {
        let cost = self.model.motion_cost(from, to);
        let plans = &self.plans[left * self.groups + self.group_of[to.0]];
        let Some(place) = self.timing.place(left) else {
            let unseen = best(plans, belief, next);
            return self.after(cost, ticks, |kind, sum| sum(unseen, kind, 1.0));
        };
        let look = Look::first(place, to);
        let chosen: Vec<_> = self
            .model
            .labels()
            .map(|label| {
                let mut posterior = belief.to_vec();
                condition(&mut posterior, self.model.likelihoods(look, label));
                (label, best(plans, &posterior, next))
            })
            .collect();
        self.after(cost, ticks, |kind, sum| {
            for (label, plan) in &chosen {
                let p = self.model.table(place, to)[(kind, label.0)];
                sum(plan, kind, p);
            }
        })
    }

    /// A plan that costs something, takes some ticks, and goes on with others: `mix` adds them with their probabilities.
    fn after(
        &self,
        cost: f64,
        ticks: usize,
        mix: impl Fn(usize, &mut dyn FnMut(&DeadlinePlan, usize, f64)),
    ) -> DeadlinePlan {
        let kinds = self.model.kind_count();
        let (discount, skipped) = (self.discount(ticks), ticks * self.groups * kinds);
        let (mut gain, mut free) = (vec![-cost; kinds], Vec::new());
        for kind in 0..kinds {
            mix(kind, &mut |plan, kind, p| {
                gain[kind] += discount * p * plan.gain[kind];
                if free.len() < skipped + plan.free.len() {
                    free.resize(skipped + plan.free.len(), 0.0);
                }
                for (index, part) in plan.free.chunks_exact(kinds).enumerate() {
                    free[skipped + index * kinds + kind] += discount * p * part[kind];
                }
            });
        }
        DeadlinePlan::new(gain, free)
    }

    /// The camera is free after some ticks, for certain.
    fn free_after(&self, ticks: usize, group: usize) -> Vec<f64> {
        let kinds = self.model.kind_count();
        let mut free = vec![0.0; (ticks + 1) * self.groups * kinds];
        free[(ticks * self.groups + group) * kinds..][..kinds].fill(self.discount(ticks));
        free
    }

    fn discount(&self, ticks: usize) -> f64 {
        self.model.discount().powi(i32::try_from(ticks).unwrap_or(i32::MAX))
    }
}
