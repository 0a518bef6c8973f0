//! Conditional plans side by side, so that the best of them for a belief is found in one sweep.

use nalgebra::DVector;

use super::dot;
use crate::model::Action;

/// Plans weighed at once; their numbers lie next to each other in memory.
const LANES: usize = 8;

/// A conditional plan for one object.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ConditionalPlan {
    /// Its first action.
    pub action: Action,
    /// `G(c)`, length L.
    pub gain: DVector<f64>,
    /// `D_s(c)`, entry `s * L + c`.
    pub discount_to: DVector<f64>,
}

impl ConditionalPlan {
    /// `sum_c b_c G(c)`.
    #[inline(always)]
    pub(crate) fn gain_at(&self, belief: &[f64]) -> f64 {
        dot(belief, self.gain.as_slice())
    }

    /// `sum_c b_c D_s(c)` for each group s.
    #[inline(always)]
    pub(crate) fn discounts_at<'a>(&'a self, belief: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.discount_to.as_slice().chunks_exact(belief.len()).map(move |row| dot(belief, row))
    }

    /// Value at a belief when `continuation[s]` follows.
    pub(crate) fn value(&self, belief: &[f64], continuation: &[f64]) -> f64 {
        self.gain_at(belief) + self.discounts_at(belief).zip(continuation).map(|(d, w)| d * w).sum::<f64>()
    }
}

/// The plans of one viewpoint group; never empty.
#[derive(Debug, Clone)]
pub(crate) struct PlanSet {
    plans: Vec<ConditionalPlan>,
    /// Blocks of [`LANES`] plans; in a block the `G(c)` of all its plans, class by class, then the `D_s(c)`.
    blocks: Vec<[f64; LANES]>,
}

impl PlanSet {
    pub(crate) fn new(plans: Vec<ConditionalPlan>) -> Self {
        let blocks = plans.chunks(LANES).flat_map(block).collect();
        Self { plans, blocks }
    }

    pub(crate) fn plans(&self) -> &[ConditionalPlan] {
        &self.plans
    }

    /// The best plan at a belief when `continuation[s]` follows (the first among equals), and its value.
    #[inline(always)]
    pub(crate) fn best(&self, belief: &[f64], continuation: &[f64]) -> (&ConditionalPlan, f64) {
        let (index, value) = self.best_index(belief, continuation);
        (&self.plans[index], value)
    }

    /// Index and value of the best plan: lane by lane first, so that the lanes run side by side.
    #[inline(always)]
    fn best_index(&self, belief: &[f64], continuation: &[f64]) -> (usize, f64) {
        let rows = belief.len() * (1 + continuation.len());
        let mut best = [f64::NEG_INFINITY; LANES];
        let mut found = [0_u64; LANES];
        for (index, block) in (0_u64..).zip(self.blocks.chunks_exact(rows)) {
            let (gains, discounts) = block.split_at(belief.len());
            let mut values = [0.0; LANES];
            accumulate(&mut values, gains, belief, 1.0);
            for (row, w) in discounts.chunks_exact(belief.len()).zip(continuation) {
                accumulate(&mut values, row, belief, *w);
            }
            for lane in 0..LANES {
                let better = values[lane] > best[lane];
                best[lane] = if better { values[lane] } else { best[lane] };
                found[lane] = if better { index } else { found[lane] };
            }
        }
        let top = best.iter().fold(f64::NEG_INFINITY, |top, value| if *value > top { *value } else { top });
        let mut winner = u64::MAX;
        for (lane, (value, block)) in (0_u64..).zip(best.into_iter().zip(found)) {
            let index = block * LANES as u64 + lane;
            winner = if value >= top { winner.min(index) } else { winner };
        }
        // Padding repeats a block's first plan, which has the smaller index and wins the tie.
        #[allow(clippy::cast_possible_truncation)] // an index into `plans`
        (winner as usize, top)
    }
}

/// `values += factor * sum_c b_c rows[c]`.
#[inline(always)]
fn accumulate(values: &mut [f64; LANES], rows: &[[f64; LANES]], belief: &[f64], factor: f64) {
    for (row, b) in rows.iter().zip(belief) {
        for (value, entry) in values.iter_mut().zip(row) {
            *value += factor * b * entry;
        }
    }
}

/// One block; lanes without a plan repeat its first one, which wins every tie.
fn block(plans: &[ConditionalPlan]) -> Vec<[f64; LANES]> {
    let lane = |i: usize| plans.get(i).unwrap_or(&plans[0]);
    let gains = (0..plans[0].gain.len()).map(|c| std::array::from_fn(|i| lane(i).gain[c]));
    let discounts = (0..plans[0].discount_to.len()).map(|e| std::array::from_fn(|i| lane(i).discount_to[e]));
    gains.chain(discounts).collect()
}
