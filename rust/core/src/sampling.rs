//! Drawing classes and labels from uniform randoms by inversion.
//!
//! Inversion keeps common random numbers common: the same uniform gives the same, or a neighbouring, label under
//! every table.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::model::SortingModel;

/// What a stream of randoms is for; streams of different purposes never meet.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
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
pub(crate) fn invert<'a>(distribution: impl IntoIterator<Item = &'a f64>, u: f64) -> usize {
    let mut cumulated = 0.0;
    let mut last_possible = 0;
    for (index, &p) in distribution.into_iter().enumerate() {
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

/// The label that a scan from `viewpoint` gives to an object of `class` at `position`.
pub(crate) fn label(model: &SortingModel, position: usize, viewpoint: usize, class: usize, u: f64) -> usize {
    invert(model.table(position, viewpoint).row(class).iter(), u)
}
