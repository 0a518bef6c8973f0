//! Drawing classes and labels from uniform randoms by inversion.
//!
//! Inversion keeps common random numbers common: the same uniform gives the same, or a neighbouring, label under
//! every table.

use std::borrow::Borrow;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::index::{Kind, Label};
use crate::model::{Look, SortingModel};

/// What a stream of randoms is for; streams of different purposes never meet.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    /// The mode of a simulated object whose class was given.
    Mode = 0,
    /// A scenario of the search.
    Scenario = 1,
    /// A simulated object: its class and its labels.
    Object = 2,
    /// A walk that collects beliefs.
    Walk = 3,
}

/// Streams of one purpose.
pub(crate) const STREAMS: u64 = 1 << 62;

/// The generator of everything random here: reproducible on every platform, one stream (below [`STREAMS`]) per
/// scenario, object or walk.
pub(crate) fn stream(seed: u64, purpose: Purpose, index: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(purpose as u64 * STREAMS + index);
    rng
}

/// The entry of `distribution` that the uniform `u` in [0, 1) selects; never one of probability zero.
pub(crate) fn invert<P: Borrow<f64>>(distribution: impl IntoIterator<Item = P>, u: f64) -> usize {
    let mut cumulated = 0.0;
    let mut last_possible = 0;
    for (index, p) in distribution.into_iter().enumerate() {
        let p = *p.borrow();
        if p > 0.0 {
            last_possible = index;
            cumulated += p;
            if u < cumulated {
                break;
            }
        }
    }
    last_possible
}

/// The label that a look gives at an object of a kind.
///
/// It is drawn from the mixture of repeated and fresh labels at once: one uniform per look, whatever was seen before.
pub(crate) fn label(model: &SortingModel, look: Look, kind: Kind, u: f64) -> Label {
    Label(invert(model.label_distribution(look, kind), u))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::index::{Position, Viewpoint};
    use crate::testing::{models_in_full, seeded};

    proptest! {
        #![proptest_config(seeded(64))]

        #[test]
        fn labels_come_as_often_as_their_likelihood(spec in models_in_full(), last in 0..2_usize, class in 0..2_usize) {
            const N: usize = 2000;
            let model = SortingModel::new(spec).unwrap();
            let look = Look { last: Some(Label(last)), ..Look::first(Position(0), Viewpoint(0)) };
            let mut counts = vec![0.0; model.label_count()];
            for i in 0..N {
                counts[label(&model, look, Kind(class), i as f64 / N as f64).0] += 1.0 / N as f64;
            }
            for (z, share) in model.labels().zip(counts) {
                prop_assert!((share - model.likelihood(look, z, Kind(class))).abs() < 2.0 / N as f64);
            }
        }
    }
}
