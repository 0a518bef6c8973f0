//! Conditional plans side by side, so that the best of them for a belief is found in one sweep.

use nalgebra::DVector;

use super::dot;
use crate::model::Action;

/// Plans weighed at once; their numbers lie next to each other in memory.
pub(super) const LANES: usize = 8;
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

    /// Value for each class when `continuation[s]` follows.
    pub(crate) fn values(&self, continuation: &[f64]) -> impl Iterator<Item = f64> {
        let l = self.gain.len();
        let discounted =
            move |c| continuation.iter().enumerate().map(move |(s, w)| self.discount_to[s * l + c] * w);
        (0..l).map(move |c| self.gain[c] + discounted(c).sum::<f64>())
    }

    /// Value at a belief when `continuation[s]` follows.
    pub(crate) fn value(&self, belief: &[f64], continuation: &[f64]) -> f64 {
        self.gain_at(belief) + self.discounts_at(belief).zip(continuation).map(|(d, w)| d * w).sum::<f64>()
    }
}

/// The plans of one viewpoint group; never empty.
#[derive(Debug, Clone)]
pub(crate) struct PlanSet {
    pub(super) plans: Vec<ConditionalPlan>,
    /// Blocks of [`LANES`] plans; in a block the `G(c)` of all its plans, class by class, then the `D_s(c)`.
    pub(super) blocks: Vec<[f64; LANES]>,
    /// The same of the plans' values when unseen objects follow: class by class, and nothing else.
    pub(super) settled: Vec<[f64; LANES]>,
    pub(super) arch: pulp::Arch,
}

impl PlanSet {
    pub(crate) fn new(plans: Vec<ConditionalPlan>) -> Self {
        let blocks = plans.chunks(LANES).flat_map(block).collect();
        Self { plans, blocks, settled: Vec::new(), arch: pulp::Arch::new() }
    }

    /// Know what unseen objects are worth, per group.
    pub(crate) fn settle(&mut self, arrival_values: &[f64]) {
        let values = |plan: &ConditionalPlan| plan.values(arrival_values).collect();
        let rows: Vec<Vec<f64>> = self.plans.iter().map(values).collect();
        self.settled = rows.chunks(LANES).flat_map(|rows| lanes(rows, rows[0].len())).collect();
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

/// Index and value of the best plan. Products and sums are not fused, so that all processors agree to the bit.
pub(super) struct Best<'a> {
    pub blocks: &'a [[f64; LANES]],
    pub belief: &'a [f64],
    pub continuation: &'a [f64],
}

impl pulp::WithSimd for Best<'_> {
    type Output = (usize, f64);

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> (usize, f64) {
        let Self { blocks, belief, continuation } = self;
        let mut top = Top::new(simd);
        for block in blocks.chunks_exact(belief.len() * (1 + continuation.len())) {
            for part in 0..parts::<S>() {
                top.see(simd, part, weigh(simd, (block, part), belief, continuation, |_, _| {}));
            }
            top.first += LANES as f64;
        }
        top.best(simd)
    }
}

/// The best plans of those seen, lane by lane, so that the lanes run side by side.
pub(super) struct Top<S: pulp::Simd> {
    best: S::f64s,
    found: S::f64s,
    /// Number of the block's first plan.
    pub first: f64,
}

impl<S: pulp::Simd> Top<S> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        Self { best: simd.splat_f64s(f64::NEG_INFINITY), found: simd.splat_f64s(0.0), first: 0.0 }
    }

    #[inline(always)]
    pub(super) fn see(&mut self, simd: S, part: usize, values: S::f64s) {
        let better = simd.greater_than_f64s(values, self.best);
        self.best = simd.select_f64s(better, values, self.best);
        let numbers = simd.add_f64s(simd.splat_f64s(self.first), S::as_simd_f64s(&NUMBERS).0[part]);
        self.found = simd.select_f64s(better, numbers, self.found);
    }

    /// Number and value of the best plan, the first among equals.
    #[inline(always)]
    pub(super) fn best(self, simd: S) -> (usize, f64) {
        let top = simd.reduce_max_f64s(self.best);
        let wins = simd.equal_f64s(self.best, simd.splat_f64s(top));
        let winner = simd.reduce_min_f64s(simd.select_f64s(wins, self.found, simd.splat_f64s(f64::INFINITY)));
        // Padding repeats a block's first plan, which has the smaller number and wins the tie.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // an index into `plans`
        (winner as usize, top)
    }
}

/// Registers that a block's plans fill.
#[inline(always)]
pub(super) fn parts<S: pulp::Simd>() -> usize {
    S::as_simd_f64s(&NUMBERS).0.len()
}

/// Values of some plans of a block when `continuation` follows; `keep` is told each `D_s`.
#[inline(always)]
pub(super) fn weigh<S: pulp::Simd>(
    simd: S,
    (block, part): (&[[f64; LANES]], usize),
    belief: &[f64],
    continuation: &[f64],
    mut keep: impl FnMut(usize, S::f64s),
) -> S::f64s {
    let (gains, discounts) = block.split_at(belief.len());
    let mut values = mean(simd, gains, belief, part);
    for (s, (rows, w)) in discounts.chunks_exact(belief.len()).zip(continuation).enumerate() {
        let discount = mean(simd, rows, belief, part);
        keep(s, discount);
        values = simd.add_f64s(values, simd.mul_f64s(simd.splat_f64s(*w), discount));
    }
    values
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

/// One block: `G(c)`, then `D_s(c)`.
fn block(plans: &[ConditionalPlan]) -> Vec<[f64; LANES]> {
    let row = |plan: &ConditionalPlan| plan.gain.iter().chain(plan.discount_to.iter()).copied().collect();
    let rows: Vec<Vec<f64>> = plans.iter().map(row).collect();
    lanes(&rows, rows[0].len()).collect()
}

/// Rows side by side, entry by entry; lanes without a row repeat the first one, which wins every tie.
fn lanes(rows: &[Vec<f64>], entries: usize) -> impl Iterator<Item = [f64; LANES]> {
    (0..entries).map(move |e| std::array::from_fn(|lane| rows.get(lane).unwrap_or(&rows[0])[e]))
}
