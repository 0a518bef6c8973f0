//! Conditional plans side by side, so that the best of them for a belief is found in one sweep.

use nalgebra::DVector;

use super::dot;
use crate::model::Action;

/// Plans evaluated at once; their numbers lie next to each other in memory.
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

    /// All numbers of the plan, to the bit: equal for equal plans.
    pub(crate) fn bits(&self) -> Vec<u64> {
        self.gain.iter().chain(&self.discount_to).map(|number| number.to_bits()).collect()
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
    pub(crate) fn best(&self, belief: &[f64], continuation: &[f64]) -> (&ConditionalPlan, f64) {
        let (index, value) = self.arch.dispatch(Best { blocks: &self.blocks, belief, continuation });
        (&self.plans[index], value)
    }

    /// The number of the best plan for one object and nothing behind it; probabilities need not sum to 1.
    pub(crate) fn best_index(&self, belief: &[f64]) -> usize {
        self.arch.dispatch(Best { blocks: &self.blocks, belief, continuation: &[] }).0
    }
}

/// Index and value of the best plan; compiled for the CPU at hand.
struct Best<'a> {
    blocks: &'a [[f64; LANES]],
    belief: &'a [f64],
    continuation: &'a [f64],
}

impl pulp::NullaryFnOnce for Best<'_> {
    type Output = (usize, f64);

    #[inline(always)]
    fn call(self) -> (usize, f64) {
        let Self { blocks, belief, continuation } = self;
        let (mut best, mut found) = ([f64::NEG_INFINITY; LANES], [0; LANES]);
        for (number, block) in blocks.chunks_exact(belief.len() * (1 + continuation.len())).enumerate() {
            let mut rows = block.chunks_exact(belief.len());
            let mut values = rows.next().map_or([0.0; LANES], |gains| mean(gains, belief));
            for (discounts, worth) in rows.zip(continuation) {
                let discount = mean(discounts, belief);
                for lane in 0..LANES {
                    values[lane] += worth * discount[lane];
                }
            }
            for lane in 0..LANES {
                let better = values[lane] > best[lane];
                best[lane] = if better { values[lane] } else { best[lane] };
                found[lane] = if better { number } else { found[lane] };
            }
        }
        // Padding repeats a block's first plan, which has the smaller number and wins the tie.
        let ranked = |lane: &usize| (best[*lane], std::cmp::Reverse(found[*lane] * LANES + lane));
        let order = |a: &usize, b: &usize| {
            let ((a, first), (b, second)) = (ranked(a), ranked(b));
            a.total_cmp(&b).then(first.cmp(&second))
        };
        let lane = (0..LANES).max_by(order).unwrap_or(0);
        (found[lane] * LANES + lane, best[lane])
    }
}

/// `sum_c b_c rows[c]` of every lane.
#[inline(always)]
fn mean(rows: &[[f64; LANES]], belief: &[f64]) -> [f64; LANES] {
    let mut sum = [0.0; LANES];
    for (row, b) in rows.iter().zip(belief) {
        for lane in 0..LANES {
            sum[lane] += b * row[lane];
        }
    }
    sum
}

/// One block: `G(c)`, then `D_s(c)`; lanes without a plan repeat the first one.
fn block(plans: &[ConditionalPlan]) -> Vec<[f64; LANES]> {
    let entry = |plan: &ConditionalPlan, e: usize| {
        let classes = plan.gain.len();
        if e < classes { plan.gain[e] } else { plan.discount_to[e - classes] }
    };
    let entries = plans[0].gain.len() + plans[0].discount_to.len();
    let lanes = |e| std::array::from_fn(|lane| entry(plans.get(lane).unwrap_or(&plans[0]), e));
    (0..entries).map(lanes).collect()
}
