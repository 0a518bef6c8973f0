//! Point-based value iteration for the one-object problem (Pineau, Gordon & Thrun 2003).
//!
//! Every plan made here can be executed and is evaluated exactly, so a solution that has not converged is a worse
//! policy but never a wrong bound.

use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::plan_set::{ConditionalPlan, PlanSet};
use super::reachable::reachable_beliefs;
use super::{OneObjectPolicy, dot, viewpoint_groups};
use crate::belief::joint;
use crate::config::NEVER;
use crate::index::{Bin, Kind, Position, Viewpoint};
use crate::model::{Action, Look, SortingModel};

/// Convergence tolerance of the value of n unseen objects in n, in units of `r_max`.
const UNSEEN_TOLERANCE: f64 = 1e-6;
/// Largest number of unseen objects with a value of its own; only a discount close to 1 needs as many.
const MOST_OBJECTS: usize = 2000;

/// Most sweeps of value iteration.
const SWEEPS: usize = 200;
/// Convergence tolerance of value iteration: the largest change of a point's value in one sweep, in units of `r_max`.
const SWEEP_TOLERANCE: f64 = 1e-4;
/// A move worth less than the best plan at a point by more than this, in units of `r_max`, is left out there until the next
/// sweep that tries all moves: every so many sweeps, and before the iteration ends.
const CONTENDING: f64 = 3e-2;
const ALL_MOVES_EVERY: usize = 8;
/// Convergence tolerance of policy iteration: the rise of an unseen object's value in one round, in units of `r_max`.
const ROUND_TOLERANCE: f64 = 1e-6;
/// A plan is pruned if the others lose less than this without it at every point, in units of `r_max`.
const PRUNING_TOLERANCE: f64 = 3e-2;
/// Most rounds of policy iteration; it converges in a few.
const ROUNDS: usize = 100;

/// The moves that contend at a point.
type Moves = Vec<Viewpoint>;

impl OneObjectPolicy {
    /// Solve the one-object problem of a model. Deterministic.
    #[must_use]
    pub fn solve(model: &SortingModel) -> Self {
        Self::solve_until(model, &NEVER)
    }

    /// Solve until `stop` is set: with the plans found by then, none of which is wrong.
    pub(crate) fn solve_until(model: &SortingModel, stop: &AtomicBool) -> Self {
        let points = reachable_beliefs(model, stop);
        let mut policy = Self::deciding_at_once(model);
        let mut values = policy.values_at(&points, stop);
        let mut contending = vec![vec![Vec::new(); points.len()]; policy.group_count()];
        let mut settled = false;
        for sweep in 0..SWEEPS {
            let all_moves = settled || sweep % ALL_MOVES_EVERY == 0;
            if all_moves {
                policy.all_contend(model, &mut contending);
            }
            let groups = contending.iter_mut().enumerate();
            let back_up = |(group, moves): (usize, &mut Vec<Moves>)| {
                policy.backed_up(model, group, &points, moves, stop)
            };
            policy.plans = groups.map(back_up).collect();
            policy.evaluate_arrival(model);
            let before = std::mem::replace(&mut values, policy.values_at(&points, stop));
            let change = before.iter().zip(&values).map(|(a, b)| (a - b).abs() / model.reward_scale());
            settled = change.fold(0.0, f64::max) < SWEEP_TOLERANCE;
            if settled && all_moves || is_set(stop) {
                break;
            }
        }
        policy.thin(model, &points, stop);
        policy.unseen_values = policy.values_on_ending_belts(model);
        policy
    }

    /// Let every legal move contend at every point.
    fn all_contend(&self, model: &SortingModel, contending: &mut [Vec<Moves>]) {
        for (group, points) in contending.iter_mut().enumerate() {
            points.fill(model.legal_moves(self.representative(group)).to_vec());
        }
    }

    /// Value of the best plan at each point, group by group. That of an unseen object alone would not tell whether the
    /// iteration has converged: it pauses where another look pays only together with the one after it. Fewer values once
    /// `stop` is set.
    fn values_at(&self, points: &[Vec<f64>], stop: &AtomicBool) -> Vec<f64> {
        let value = |group, belief| self.best(group, belief, &self.arrival_values).1;
        let groups = 0..self.group_count();
        let all = groups.flat_map(|group| points.iter().map(move |belief| (group, belief)));
        all.take_while(|_| !is_set(stop)).map(|(group, belief)| value(group, belief)).collect()
    }

    /// Prune the plans (see [`PRUNING_TOLERANCE`]): the search evaluates all of them at every leaf.
    fn thin(&mut self, model: &SortingModel, points: &[Vec<f64>], stop: &AtomicBool) {
        for group in 0..self.group_count() {
            let mut kept: Vec<ConditionalPlan> = Vec::new();
            for belief in points.iter().take_while(|_| !is_set(stop)) {
                let value = |plan: &ConditionalPlan| plan.value(belief, &self.arrival_values);
                let (best, worth) = self.best(group, belief, &self.arrival_values);
                if kept.iter().all(|plan| value(plan) < worth - PRUNING_TOLERANCE * model.reward_scale()) {
                    kept.push(best.clone());
                }
            }
            for now in deciding(model, self.group_count(), group) {
                if !kept.contains(&now) {
                    kept.push(now);
                }
            }
            self.plans[group] = PlanSet::new(kept);
        }
        self.evaluate_arrival(model);
    }

    /// The policy that decides every object unseen: the start of the iteration.
    fn deciding_at_once(model: &SortingModel) -> Self {
        let (group_of, groups) = viewpoint_groups(model);
        let plans = (0..groups).map(|s| PlanSet::new(deciding(model, groups, s))).collect();
        let mut policy =
            Self { group_of, plans, arrival_values: vec![0.0; groups], unseen_values: Vec::new() };
        policy.evaluate_arrival(model);
        policy
    }

    /// The best plan at each point after one backup with the moves that contend there; the plans that decide at once always
    /// stay.
    fn backed_up(
        &self,
        model: &SortingModel,
        group: usize,
        points: &[Vec<f64>],
        contending: &mut [Moves],
        stop: &AtomicBool,
    ) -> PlanSet {
        let following = self.plans_by_value();
        let remaining = points.par_iter().zip(contending).take_any_while(|_| !is_set(stop));
        let backups =
            remaining.map(|(belief, moves)| self.backup(model, group, belief, &following, moves, stop));
        let improved: Vec<_> = backups.collect();
        let mut kept = deciding(model, self.group_count(), group);
        let mut known: HashSet<_> = kept.iter().map(ConditionalPlan::bits).collect();
        kept.extend(improved.into_iter().filter(|plan| known.insert(plan.bits())));
        PlanSet::new(kept)
    }

    /// The plans of each group with `G(c) + sum_s D_s(c) W_s` as their gains, and nothing behind them.
    fn plans_by_value(&self) -> Vec<PlanSet> {
        let alone = |plan: &ConditionalPlan| {
            let l = plan.gain.len();
            let discounted = |(s, worth): (usize, &f64)| plan.discount_to.rows(s * l, l) * *worth;
            let continued = self.arrival_values.iter().enumerate().map(discounted);
            let gain = continued.fold(plan.gain.clone(), |sum, part| sum + part);
            ConditionalPlan { action: plan.action, gain, discount_to: DVector::zeros(0) }
        };
        self.plans.iter().map(|set| PlanSet::new(set.plans().iter().map(alone).collect())).collect()
    }

    /// The best of: the plan at hand, deciding now, and moving anywhere and continuing with the best plan per label. Moves
    /// that fall behind no longer contend.
    fn backup(
        &self,
        model: &SortingModel,
        group: usize,
        belief: &[f64],
        following: &[PlanSet],
        contending: &mut Moves,
        stop: &AtomicBool,
    ) -> ConditionalPlan {
        let worth = |plan: &ConditionalPlan| plan.value(belief, &self.arrival_values);
        let from = self.representative(group);
        let (at_hand, _) = self.best(group, belief, &self.arrival_values);
        let now = decide(model, self.group_count(), group, model.best_decision(belief).0);
        let mut best = (at_hand.clone(), worth(at_hand));
        let mut consider = |plan: ConditionalPlan| {
            let value = worth(&plan);
            if value > best.1 {
                best = (plan, value);
            }
            value
        };
        consider(now);
        let moves = contending.iter().take_while(|_| !is_set(stop));
        let values: Vec<f64> =
            moves.map(|&to| consider(self.move_plan(model, from, to, belief, following))).collect();
        let least = best.1 - CONTENDING * model.reward_scale();
        let mut values = values.into_iter();
        contending.retain(|_| values.next().is_some_and(|value| value >= least));
        best.0
    }

    /// Move to a viewpoint, then follow the best plan for each label.
    fn move_plan(
        &self,
        model: &SortingModel,
        from: Viewpoint,
        to: Viewpoint,
        belief: &[f64],
        following: &[PlanSet],
    ) -> ConditionalPlan {
        let (l, target) = (model.kind_count(), self.group(to));
        let look = Look::first(Position(0), to);
        let mut gain = DVector::from_element(l, -model.motion_cost(from, to));
        let mut discount_to = DVector::zeros(self.group_count() * l);
        let mut weighted = Vec::with_capacity(l);
        for z in model.labels() {
            weighted.clear();
            weighted.extend(joint(belief, model.likelihoods(look, z)));
            let next = &self.plans[target].plans()[following[target].best_index(&weighted)];
            for (c, p) in model.likelihoods(look, z).enumerate() {
                let weight = model.discount() * p;
                gain[c] += weight * next.gain[c];
                for s in 0..self.group_count() {
                    discount_to[s * l + c] += weight * next.discount_to[s * l + c];
                }
            }
        }
        ConditionalPlan { action: Action::Move(to), gain, discount_to }
    }

    /// Policy evaluation: `W_s = G_s(arrival) + sum_t D_st(arrival) W_t` for the best plan of each group, solved
    /// exactly, until the best plans no longer change. Values never fall from one round to the next.
    fn evaluate_arrival(&mut self, model: &SortingModel) {
        let arrival = model.arrival().as_slice();
        let groups = self.group_count();
        for round in 0..ROUNDS {
            let chosen: Vec<_> = (0..groups).map(|s| self.best(s, arrival, &self.arrival_values).0).collect();
            let gains = DVector::from_fn(groups, |s, _| dot(arrival, chosen[s].gain.as_slice()));
            let mut system = DMatrix::identity(groups, groups);
            for (s, plan) in chosen.iter().enumerate() {
                for (t, discount) in plan.discounts_at(arrival).enumerate() {
                    system[(s, t)] -= discount;
                }
            }
            // Row sums of D are at most the discount, so the system is diagonally dominant and solvable.
            let Some(solved) = system.lu().solve(&gains) else { return };
            let risen = |(new, old): (&f64, &f64)| *new > old + ROUND_TOLERANCE * model.reward_scale();
            let rise = solved.iter().zip(&self.arrival_values).any(risen);
            self.arrival_values = solved.iter().copied().collect();
            // Round 0 replaces values that may not be those of any policy.
            if round > 0 && !rise {
                return;
            }
        }
    }

    /// Value of 0, 1, 2, ... unseen objects and none behind them, until one more changes next to nothing.
    pub(super) fn values_on_ending_belts(&self, model: &SortingModel) -> Vec<Vec<f64>> {
        let arrival = model.arrival().as_slice();
        let mut values = vec![vec![0.0; self.group_count()]];
        while let Some(last) = values.last().filter(|_| values.len() < MOST_OBJECTS) {
            let next: Vec<f64> = (0..last.len()).map(|s| self.best(s, arrival, last).1).collect();
            let change = next.iter().zip(last).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            values.push(next);
            if change < UNSEEN_TOLERANCE * model.reward_scale() {
                break;
            }
        }
        values
    }
}

fn is_set(stop: &AtomicBool) -> bool {
    stop.load(Ordering::Relaxed)
}

/// The plans that decide at once, one per bin.
fn deciding(model: &SortingModel, groups: usize, group: usize) -> Vec<ConditionalPlan> {
    model.bins().map(|bin| decide(model, groups, group, bin)).collect()
}

fn decide(model: &SortingModel, groups: usize, group: usize, bin: Bin) -> ConditionalPlan {
    let l = model.kind_count();
    let mut discount_to = DVector::zeros(groups * l);
    discount_to.rows_mut(group * l, l).fill(model.discount());
    let gain = DVector::from_fn(l, |n, _| model.reward(bin, Kind(n)));
    ConditionalPlan { action: Action::Decide(bin), gain, discount_to }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::Belief;
    use crate::model::ScalarOrMatrix;
    use crate::remaining::Remaining;
    use crate::testing::{from_weights, paper};

    #[test]
    fn a_model_whose_blind_decisions_are_worth_nothing_is_solved() {
        let mut spec = from_weights(1, 1, 2, &[0.8, 0.2, 0.2, 0.8]);
        (spec.r_max, spec.r_min) = (10.0, 10.0);
        let model = SortingModel::new(spec).unwrap();
        let policy = OneObjectPolicy::solve(&model);
        assert!(policy.value(&model, (&[0.5, 0.5], Remaining::ENDLESS), Viewpoint(0)) > 0.0);
    }

    /// The third and fourth look at a symmetric object pay only together, and its optima are known from `solve`.
    #[test]
    fn looks_that_pay_only_together_are_taken() {
        for (r_min, optimum) in [(50.0, 15.7663), (500.0, 0.6925)] {
            let mut spec = from_weights(1, 1, 2, &[0.8, 0.2, 0.2, 0.8]);
            (spec.r_max, spec.r_min, spec.discount) = (10.0, r_min, 0.95);
            let model = SortingModel::new(spec).unwrap();
            let value =
                OneObjectPolicy::solve(&model).value(&model, (&[0.5, 0.5], Remaining::ENDLESS), Viewpoint(0));
            assert!((value / optimum - 1.0).abs() < 3e-3, "r_min {r_min}: {value} instead of {optimum}");
        }
    }

    #[test]
    fn value_scales_with_the_rewards() {
        let unit = paper(50.0).with_positions(1).unwrap();
        let mut spec = unit.spec().clone();
        (spec.r_max, spec.r_min) = (spec.r_max * 1e-3, spec.r_min * 1e-3);
        spec.motion_cost = ScalarOrMatrix::Scalar(1e-3);
        let scaled = SortingModel::new(spec).unwrap();
        let value = |model| {
            OneObjectPolicy::solve(model).value(model, (&[0.25; 4], Remaining::ENDLESS), Viewpoint(0))
        };
        assert!((1e3 * value(&scaled) / value(&unit) - 1.0).abs() < 1e-6);
    }

    /// A table of rewards that holds the paper's leads to the same plans, whatever a wrong decision costs.
    #[test]
    fn rewards_that_are_written_out_lead_to_the_same_value() {
        let model = paper(500.0).with_positions(1).unwrap();
        let mut spec = model.spec().clone();
        let right = |bin: usize, class: usize| if bin == class { spec.r_max } else { -spec.r_min };
        let reward = (0..4).map(|bin| (0..4).map(|class| right(bin, class)).collect()).collect();
        spec.reward = Some(reward);
        let written = SortingModel::new(spec).unwrap();
        let value = |model| {
            OneObjectPolicy::solve(model).value(model, (&[0.25; 4], Remaining::ENDLESS), Viewpoint(0))
        };
        assert!((value(&written) - value(&model)).abs() < 1e-9, "{} {}", value(&written), value(&model));
    }

    #[test]
    fn value_reaches_the_known_optimum_from_below() {
        for (r_min, optimum, tolerance) in [(5.0, 46.987, 0.001), (50.0, 17.5, 0.001), (500.0, 5.842, 0.01)] {
            let model = paper(r_min).with_positions(1).unwrap();
            let policy = OneObjectPolicy::solve(&model);
            let value = policy.value(&model, Belief::new(&model).known(), Viewpoint(0));
            assert!(value <= optimum + 5e-4, "r_min {r_min}: {value} above {optimum}");
            assert!(value >= optimum * (1.0 - tolerance), "r_min {r_min}: {value} far below {optimum}");
        }
    }
}
