//! Bit planes: one bit per scenario, 64 scenarios to a word.
//!
//! Loops over planes are written plainly and inlined into a dispatch of [`pulp::Arch`], which compiles them for
//! AVX-512, AVX2 and the baseline and chooses at run time. Nothing here rounds, so all of them agree to the bit.

/// Scenarios in a word.
pub(crate) const LANES: usize = 64;

/// Words that hold a bit for each of `count` scenarios.
pub(crate) fn words(count: usize) -> usize {
    count.div_ceil(LANES)
}

/// The plane of the first `count` scenarios.
pub(crate) fn first(count: usize) -> Vec<u64> {
    let word = |w: usize| match count - w * LANES {
        rest if rest < LANES => (1 << rest) - 1,
        _ => u64::MAX,
    };
    (0..words(count)).map(word).collect()
}

/// Number of scenarios in a plane.
pub(crate) fn count(plane: &[u64]) -> u64 {
    plane.iter().map(|word| u64::from(word.count_ones())).sum()
}

/// Words that fill the widest register.
const WIDE: usize = 8;

/// `out = a & b`; whether any scenario is left.
#[inline(always)]
pub(crate) fn intersect(a: &[u64], b: &[u64], out: &mut [u64]) -> bool {
    let ((wide_a, rest_a), (wide_b, rest_b)) = (a.as_chunks::<WIDE>(), b.as_chunks::<WIDE>());
    let (wide, rest) = out.as_chunks_mut::<WIDE>();
    let mut any = [0; WIDE];
    for ((out, a), b) in wide.iter_mut().zip(wide_a).zip(wide_b) {
        for lane in 0..WIDE {
            out[lane] = a[lane] & b[lane];
            any[lane] |= out[lane];
        }
    }
    for ((out, a), b) in rest.iter_mut().zip(rest_a).zip(rest_b) {
        *out = a & b;
        any[0] |= *out;
    }
    any.into_iter().fold(0, |any, word| any | word) != 0
}

/// Bit i of `out` says whether `values[i] < threshold`; thresholds reach 2^32, which every value is below.
#[inline(always)]
pub(crate) fn below(values: &[u32], threshold: u64, out: &mut [u64]) {
    let Ok(threshold) = u32::try_from(threshold) else {
        out.fill(u64::MAX);
        return;
    };
    for (word, values) in out.iter_mut().zip(values.chunks_exact(LANES)) {
        *word = values
            .iter()
            .enumerate()
            .fold(0, |bits, (lane, value)| bits | u64::from(*value < threshold) << lane);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::testing::seeded;

    proptest! {
        #![proptest_config(seeded(64))]

        #[test]
        fn every_bit_says_what_its_value_does(
            values in prop::collection::vec(any::<u32>(), 3 * LANES),
            threshold in 0..=1_u64 << 32,
        ) {
            let mut plane = vec![0; 3];
            pulp::Arch::new().dispatch(|| below(&values, threshold, &mut plane));
            for (i, value) in values.iter().enumerate() {
                let bit = plane[i / LANES] >> (i % LANES) & 1 == 1;
                prop_assert_eq!(bit, u64::from(*value) < threshold);
            }
        }

        #[test]
        fn the_first_scenarios_are_as_many_as_asked_for(n in 1..400_usize) {
            prop_assert_eq!(count(&first(n)), n as u64);
        }
    }
}
