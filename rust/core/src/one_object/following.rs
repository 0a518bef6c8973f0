//! What may follow an object: what the objects behind it are worth at least and at most.

use super::OneObjectPolicy;
use super::candidates::Range;
use super::plan_set::{ConditionalPlan, PlanSet};
use crate::model::SortingModel;
use crate::remaining::Remaining;

/// Convergence tolerance of the value of n unseen objects in n, in units of `r_max`.
const TOLERANCE: f64 = 1e-6;
/// Most unseen objects that are told apart; they differ up to here only where the discount is close to 1.
const MOST_OBJECTS: usize = 2000;

/// What is known of all continuations, whatever is known of the objects behind.
#[derive(Debug, Clone, Default)]
pub(super) struct Following {
    /// By the number of visible objects behind, on an endless belt.
    endless: Vec<Range>,
    /// By the number of positions behind, on a belt that ends, however soon.
    ending: Vec<Range>,
    /// Value of 0, 1, 2, ... unseen objects, per group; that of more is an endless belt's.
    unseen: Vec<Vec<f64>>,
}

impl Following {
    /// What may follow an object with so many positions behind it.
    pub(super) fn range(&self, behind: usize, ends: bool) -> &Range {
        if ends { &self.ending[behind] } else { &self.endless[behind] }
    }

    /// Value of so many unseen objects, unless their number does not matter.
    #[inline(always)]
    pub(super) fn unseen(&self, unseen: Remaining) -> Option<&[f64]> {
        self.unseen.get(unseen.0?).map(Vec::as_slice)
    }
}

impl OneObjectPolicy {
    /// Know what may follow an object.
    pub(super) fn bound_continuations(&mut self, model: &SortingModel) {
        self.plans.iter_mut().for_each(|set| set.settle(&self.arrival_values));
        let unseen = self.values_on_ending_belts(model);
        let endless = (self.arrival_values.clone(), self.arrival_values.clone());
        let over_all = |fold: fn(f64, f64) -> f64| -> Vec<f64> {
            let group = |(s, value): (usize, &f64)| unseen.iter().map(|row| row[s]).fold(*value, fold);
            self.arrival_values.iter().enumerate().map(group).collect()
        };
        let ending = (over_all(f64::min), over_all(f64::max));
        self.following = Following {
            endless: self.ranges(model.position_count(), endless, false),
            ending: self.ranges(model.position_count(), ending, true),
            unseen,
        };
    }

    /// Ranges behind 0, 1, ... positions, from the values of unseen objects at worst and at best.
    ///
    /// An object is worth no less than by the plan with the best worst case, and no more than by the best plan for the
    /// best class. Where there may be fewer objects than positions, what follows fewer of them may follow too.
    fn ranges(
        &self,
        positions: usize,
        (mut worst, mut best): (Vec<f64>, Vec<f64>),
        maybe_fewer: bool,
    ) -> Vec<Range> {
        let mut ranges = Vec::new();
        for _ in 0..positions {
            let centre = worst.iter().zip(&best).map(|(a, b)| 0.5 * (a + b)).collect();
            let radius = worst.iter().zip(&best).map(|(a, b)| 0.5 * (b - a)).collect();
            ranges.push(Range { centre, radius });
            let mut low = self.best_over_plans(|plan| plan.values(&worst).fold(f64::INFINITY, f64::min));
            let mut high = self.best_over_plans(|plan| plan.values(&best).fold(f64::NEG_INFINITY, f64::max));
            if maybe_fewer {
                low.iter_mut().zip(worst).for_each(|(low, fewer)| *low = low.min(fewer));
                high.iter_mut().zip(best).for_each(|(high, fewer)| *high = high.max(fewer));
            }
            (worst, best) = (low, high);
        }
        ranges
    }

    /// Value of 0, 1, 2, ... unseen objects and none behind them, until one more changes next to nothing.
    fn values_on_ending_belts(&self, model: &SortingModel) -> Vec<Vec<f64>> {
        let arrival = model.arrival().as_slice();
        let mut values = vec![vec![0.0; self.group_count()]];
        while let Some(last) = values.last().filter(|_| values.len() < MOST_OBJECTS) {
            let next: Vec<f64> = (0..last.len()).map(|s| self.best(s, arrival, last).1).collect();
            let change = next.iter().zip(last).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            values.push(next);
            if change < TOLERANCE * model.spec().r_max {
                break;
            }
        }
        values
    }

    /// The highest score of any plan, per group.
    fn best_over_plans(&self, score: impl Fn(&ConditionalPlan) -> f64) -> Vec<f64> {
        let top = |set: &PlanSet| set.plans().iter().map(&score).fold(f64::NEG_INFINITY, f64::max);
        self.plans.iter().map(top).collect()
    }
}
