//! Bayes' rule for one object (eq. 7), the only place where it is applied.
//!
//! The belief about all objects is a product, and each label depends on its own object alone, so a look changes one
//! distribution at a time. The likelihoods `P(z | c)` of a label are [`SortingModel::likelihoods`].
//!
//! [`SortingModel::likelihoods`]: crate::model::SortingModel::likelihoods

/// Below this quotients lose digits: a label of less evidence counts as impossible.
const LEAST_EVIDENCE: f64 = f64::MIN_POSITIVE;

/// `b_c` becomes `b_c P(z | c) / P(z)`, given the likelihoods of the label z; its evidence `P(z)`.
///
/// A label that is impossible under the belief leaves the distribution as it is; the evidence is then 0.
#[inline(always)]
pub(crate) fn condition(distribution: &mut [f64], likelihoods: impl Iterator<Item = f64> + Clone) -> f64 {
    let evidence = evidence(distribution, likelihoods.clone());
    if evidence < LEAST_EVIDENCE {
        return 0.0;
    }
    for (b, p) in distribution.iter_mut().zip(likelihoods) {
        *b = *b * p / evidence;
    }
    evidence
}

/// `P(z) = sum_c b_c P(z | c)`.
#[inline(always)]
pub(crate) fn evidence(distribution: &[f64], likelihoods: impl Iterator<Item = f64>) -> f64 {
    joint(distribution, likelihoods).sum()
}

/// `P(c, z) = b_c P(z | c)`, class by class: the posterior before it is normalised.
#[inline(always)]
pub(crate) fn joint(
    distribution: &[f64],
    likelihoods: impl Iterator<Item = f64>,
) -> impl Iterator<Item = f64> {
    distribution.iter().zip(likelihoods).map(|(b, p)| b * p)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::testing::seeded;

    /// A distribution of three classes, now and then without some of them.
    fn distributions() -> impl Strategy<Value = Vec<f64>> {
        let weight = || prop_oneof![1 => Just(0.0), 4 => 0.01..1.0_f64];
        (0.01..1.0_f64, weight(), weight()).prop_map(|(a, b, c)| [a, b, c].map(|w| w / (a + b + c)).to_vec())
    }

    /// The posterior of a label, and its evidence.
    fn posterior(distribution: &[f64], likelihoods: &[f64]) -> (Vec<f64>, f64) {
        let mut posterior = distribution.to_vec();
        let evidence = condition(&mut posterior, likelihoods.iter().copied());
        (posterior, evidence)
    }

    proptest! {
        #![proptest_config(seeded(128))]

        /// The mean of the posteriors, weighted by the evidence of their labels, is the prior.
        #[test]
        fn posteriors_average_to_the_prior(
            prior in distributions(),
            labels in prop::collection::vec(distributions(), 3),
        ) {
            let mut mean = vec![0.0; 3];
            for z in 0..3 {
                let likelihoods: Vec<_> = labels.iter().map(|row| row[z]).collect();
                let (posterior, evidence) = posterior(&prior, &likelihoods);
                prop_assert!((posterior.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                mean.iter_mut().zip(posterior).for_each(|(mean, p)| *mean += evidence * p);
            }
            prop_assert!(mean.iter().zip(&prior).all(|(a, b)| (a - b).abs() < 1e-12), "{mean:?} {prior:?}");
        }

        /// Labels are independent given the class: their order does not matter.
        #[test]
        fn labels_may_come_in_any_order(prior in distributions(), a in distributions(), b in distributions()) {
            let in_turn = |first: &[f64], second: &[f64]| {
                let (after_one, p) = posterior(&prior, first);
                let (after_both, q) = posterior(&after_one, second);
                (after_both, p * q)
            };
            let ((one, p), (other, q)) = (in_turn(&a, &b), in_turn(&b, &a));
            prop_assert!((p - q).abs() < 1e-12);
            prop_assert!(p == 0.0 || one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-9));
        }
    }

    #[test]
    fn an_impossible_label_tells_nothing() {
        assert_eq!(posterior(&[0.25, 0.75, 0.0], &[0.0, 0.0, 1.0]), (vec![0.25, 0.75, 0.0], 0.0));
        assert_eq!(posterior(&[1.0, 0.0], &[1e-320, 1.0]), (vec![1.0, 0.0], 0.0));
    }
}
