//! Conditional plans side by side, so that the best of them for a belief is found in one sweep.

use nalgebra::DVector;

use super::dot;
use crate::model::Action;

/// Plans weighed at once; their numbers lie next to each other in memory.
const LANES: usize = 8;
const NUMBERS: [f64; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

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
    arch: pulp::Arch,
}

impl PlanSet {
    pub(crate) fn new(plans: Vec<ConditionalPlan>) -> Self {
        let blocks = plans.chunks(LANES).flat_map(block).collect();
        Self { plans, blocks, arch: pulp::Arch::new() }
    }

    pub(crate) fn plans(&self) -> &[ConditionalPlan] {
        &self.plans
    }

    /// The best plan at a belief when `continuation[s]` follows (the first among equals), and its value.
    #[inline(always)]
    pub(crate) fn best(&self, belief: &[f64], continuation: &[f64]) -> (&ConditionalPlan, f64) {
        let (index, value) = self.arch.dispatch(Best { blocks: &self.blocks, belief, continuation });
        (&self.plans[index], value)
    }
}

/// Index and value of the best plan: lane by lane first, so that the lanes run side by side.
///
/// Products and sums are not fused, so that all processors agree to the bit.
struct Best<'a> {
    blocks: &'a [[f64; LANES]],
    belief: &'a [f64],
    continuation: &'a [f64],
}

impl pulp::WithSimd for Best<'_> {
    type Output = (usize, f64);

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> (usize, f64) {
        let l = self.belief.len();
        let mut best = simd.splat_f64s(f64::NEG_INFINITY);
        let mut found = simd.splat_f64s(0.0);
        let mut first = 0.0;
        for block in self.blocks.chunks_exact(l * (1 + self.continuation.len())) {
            let (gains, discounts) = block.split_at(l);
            for (part, lanes) in S::as_simd_f64s(&NUMBERS).0.iter().enumerate() {
                let mut values = mean(simd, gains, self.belief, part);
                for (rows, w) in discounts.chunks_exact(l).zip(self.continuation) {
                    let discount = mean(simd, rows, self.belief, part);
                    values = simd.add_f64s(values, simd.mul_f64s(simd.splat_f64s(*w), discount));
                }
                let better = simd.greater_than_f64s(values, best);
                best = simd.select_f64s(better, values, best);
                let numbers = simd.add_f64s(simd.splat_f64s(first), *lanes);
                found = simd.select_f64s(better, numbers, found);
            }
            first += LANES as f64;
        }
        let top = simd.reduce_max_f64s(best);
        let wins = simd.equal_f64s(best, simd.splat_f64s(top));
        let winner = simd.reduce_min_f64s(simd.select_f64s(wins, found, simd.splat_f64s(f64::INFINITY)));
        // Padding repeats a block's first plan, which has the smaller number and wins the tie.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // an index into `plans`
        (winner as usize, top)
    }
}

/// `sum_c b_c rows[c]` of some lanes; four classes at a time, which spares a loop its counting.
#[inline(always)]
fn mean<S: pulp::Simd>(simd: S, rows: &[[f64; LANES]], belief: &[f64], part: usize) -> S::f64s {
    let add = |sum, (row, b): (&[f64; LANES], &f64)| {
        simd.add_f64s(sum, simd.mul_f64s(simd.splat_f64s(*b), S::as_simd_f64s(row).0[part]))
    };
    let ((fours, rest), (weights, others)) = (rows.as_chunks::<4>(), belief.as_chunks::<4>());
    let mut sum = simd.splat_f64s(0.0);
    for (rows, weights) in fours.iter().zip(weights) {
        sum = rows.iter().zip(weights).fold(sum, add);
    }
    rest.iter().zip(others).fold(sum, add)
}

/// One block; lanes without a plan repeat its first one, which wins every tie.
fn block(plans: &[ConditionalPlan]) -> Vec<[f64; LANES]> {
    let lane = |i: usize| plans.get(i).unwrap_or(&plans[0]);
    let gains = (0..plans[0].gain.len()).map(|c| std::array::from_fn(|i| lane(i).gain[c]));
    let discounts = (0..plans[0].discount_to.len()).map(|e| std::array::from_fn(|i| lane(i).discount_to[e]));
    gains.chain(discounts).collect()
}
