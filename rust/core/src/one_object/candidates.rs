//! The plans for one object that may be best while it is still open what follows.
//!
//! What is expected of the objects behind depends on the node, what is known of the object itself does not: so its
//! plans are weighed once, and those few are kept among which the continuation decides.

use super::plan_set::{Best, LANES, PlanSet, Top, parts, weigh};

/// A buffer for plans on their way to be candidates.
#[derive(Debug, Default)]
pub(crate) struct Weighed(Vec<[f64; LANES]>);

/// What may follow an object, per group: `centre[s]`, give or take `radius[s]`.
#[derive(Debug, Clone)]
pub(crate) struct Range {
    pub centre: Vec<f64>,
    pub radius: Vec<f64>,
}

impl PlanSet {
    /// `G` and `D_s` at a belief of every plan that is best for some continuation within `range`, in the plans' order.
    pub(crate) fn candidates(
        &self,
        belief: &[f64],
        range: &Range,
        found: &mut Vec<f64>,
        weighed: &mut Weighed,
    ) {
        self.arch.dispatch(Candidates { set: self, belief, range, found, weighed: &mut weighed.0 });
    }
}

/// Plans that are worse than the best at the centre by no more than another continuation may make up for.
struct Candidates<'a> {
    set: &'a PlanSet,
    belief: &'a [f64],
    range: &'a Range,
    found: &'a mut Vec<f64>,
    /// Of each block the plans' values at the centre, then their `D_s`.
    weighed: &'a mut Vec<[f64; LANES]>,
}

impl Candidates<'_> {
    #[inline(always)]
    fn push(&mut self, index: usize) {
        let plan = &self.set.plans[index];
        self.found.push(plan.gain_at(self.belief));
        self.found.extend(plan.discounts_at(self.belief));
    }
}

impl pulp::WithSimd for Candidates<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, simd: S) {
        let Self { set, belief, range: Range { centre, radius }, .. } = self;
        if radius.iter().all(|radius| *radius == 0.0) {
            // Unseen objects follow, for certain.
            let (best, _) = Best { blocks: &set.settled, belief, continuation: &[] }.with_simd(simd);
            return self.push(best);
        }
        let (l, rows) = (belief.len(), 1 + radius.len());
        let mut top = Top::new(simd);
        self.weighed.resize(set.blocks.len() / l, [0.0; LANES]);
        for (block, weighed) in set.blocks.chunks_exact(l * rows).zip(self.weighed.chunks_exact_mut(rows)) {
            for part in 0..parts::<S>() {
                let keep = |s: usize, discount| S::as_mut_simd_f64s(&mut weighed[1 + s]).0[part] = discount;
                let values = weigh(simd, (block, part), belief, centre, keep);
                S::as_mut_simd_f64s(&mut weighed[0]).0[part] = values;
                top.see(simd, part, values);
            }
            top.first += LANES as f64;
        }
        let (best, value) = top.best(simd);
        let weighed = std::mem::take(self.weighed);
        for (number, block) in weighed.chunks_exact(rows).enumerate() {
            let mut reach = block[0];
            for part in 0..parts::<S>() {
                let mut values = S::as_simd_f64s(&reach).0[part];
                for ((discounts, radius), s) in block[1..].iter().zip(radius).zip(1..) {
                    let own = simd.splat_f64s(weighed[best / LANES * rows + s][best % LANES]);
                    let apart = simd.abs_f64s(simd.sub_f64s(S::as_simd_f64s(discounts).0[part], own));
                    values = simd.add_f64s(values, simd.mul_f64s(simd.splat_f64s(*radius), apart));
                }
                S::as_mut_simd_f64s(&mut reach).0[part] = values;
            }
            if reach.iter().any(|reach| *reach >= value) {
                let plans = number * LANES..set.plans.len().min((number + 1) * LANES);
                plans.zip(reach).filter(|(_, reach)| *reach >= value).for_each(|(index, _)| self.push(index));
            }
        }
        *self.weighed = weighed;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::belief::Belief;
    use crate::index::{Label, Position, Viewpoint};
    use crate::model::SortingModel;
    use crate::one_object::{OneObjectPolicy, Turn};
    use crate::testing::{models_in_full, paper, seeded};

    /// The best of the candidates is the best of all plans, whatever follows.
    fn check(model: &SortingModel, labels: &[usize], part: f64) {
        let policy = OneObjectPolicy::solve(model);
        let mut belief = Belief::new(model);
        for (step, label) in labels.iter().enumerate() {
            let (viewpoint, label) =
                (Viewpoint(step % model.viewpoint_count()), Label(label % model.label_count()));
            let _ = belief.observe_one(model, Position(0), viewpoint, label);
        }
        let distribution = &belief.as_slice()[..model.class_count()];
        for (behind, ends) in (0..model.position_count()).flat_map(|behind| [(behind, false), (behind, true)])
        {
            let range = policy.following.range(behind, ends);
            let follows: Vec<_> = range.centre.iter().zip(&range.radius).map(|(c, r)| c + part * r).collect();
            for group in 0..policy.group_count() {
                let mut found = Vec::new();
                let turn = Turn { group, behind, ends };
                policy.candidates(turn, distribution, &mut found, &mut Weighed::default());
                let value =
                    |plan: &[f64]| plan[0] + plan[1..].iter().zip(&follows).map(|(d, w)| d * w).sum::<f64>();
                let plans = found.chunks_exact(1 + follows.len());
                assert!(plans.len() <= policy.plans[group].plans().len());
                let best = plans.map(value).fold(f64::NEG_INFINITY, f64::max);
                let (_, expected) = policy.best(group, distribution, &follows);
                assert!(
                    (best - expected).abs() < 1e-9 * (1.0 + expected.abs()),
                    "{best} instead of {expected}"
                );
            }
        }
    }

    proptest! {
        #![proptest_config(seeded(16))]

        #[test]
        fn the_best_plan_is_among_the_candidates(
            spec in models_in_full(),
            labels in prop::collection::vec(0..4_usize, 0..4),
            part in -1.0..1.0_f64,
            restricted in any::<bool>(),
        ) {
            let mut spec = spec;
            if restricted && spec.viewpoints.len() == 2 {
                spec.travel = Some(vec![vec![1], vec![]]);
            }
            check(&SortingModel::new(spec).unwrap(), &labels, part);
        }
    }

    #[test]
    fn the_best_of_many_plans_is_among_the_candidates() {
        for part in [-1.0, -0.3, 0.8, 1.0] {
            check(&paper(50.0), &[2, 1], part);
        }
    }
}
