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

/// A probability in units of 2^-32. What rounding leaves of 1 belongs to the last outcome.
pub(crate) fn threshold(cumulated: f64) -> u64 {
    const NEARLY_ONE: f64 = 1.0 - 1e-9;
    let scale = (1_u64 << 32) as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 0 and 2^32
    let threshold = (cumulated * scale).round() as u64;
    if cumulated > NEARLY_ONE { 1 << 32 } else { threshold }
}

/// Thresholds of all looks, in units of 2^-32: a random selects the label whose number is that of the thresholds up to it.
#[derive(Debug)]
pub(crate) struct Thresholds {
    /// Of all labels but the last, numbered by position, viewpoint, last label and kind.
    values: Vec<u64>,
    viewpoints: usize,
    /// 1, or how many last labels there are, none included.
    lasts: usize,
    kinds: usize,
    /// Labels but the last.
    steps: usize,
}

impl Thresholds {
    pub(crate) fn new(model: &SortingModel) -> Self {
        let steps = model.label_count() - 1;
        let mut values = Vec::new();
        let lasts = if model.ever_repeats() { model.label_count() } else { 0 };
        for (position, viewpoint) in model.positions().flat_map(|j| model.viewpoints().map(move |v| (j, v))) {
            for last in std::iter::once(None).chain((0..lasts).map(|z| Some(Label(z)))) {
                for kind in model.kinds() {
                    let of_look = model.label_distribution(Look { position, viewpoint, last }, kind);
                    let cumulated = of_look.scan(0.0, |sum, p| {
                        *sum += p;
                        Some(threshold(*sum))
                    });
                    values.extend(cumulated.take(steps));
                }
            }
        }
        let (viewpoints, kinds) = (model.viewpoint_count(), model.kind_count());
        Self { values, viewpoints, lasts: lasts + 1, kinds, steps }
    }

    /// Those of a look at an object of each kind, in their order.
    #[inline(always)]
    pub(crate) fn of(&self, Look { position, viewpoint, last }: Look) -> LookThresholds<'_> {
        let look = position.0 * self.viewpoints + viewpoint.0;
        let number = look * self.lasts + last.map_or(0, |label| label.0 + 1);
        let size = self.kinds * self.steps;
        LookThresholds { values: &self.values[number * size..][..size], steps: self.steps }
    }
}

/// Thresholds of one look.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LookThresholds<'a> {
    values: &'a [u64],
    steps: usize,
}

impl LookThresholds<'_> {
    /// The label that a random selects.
    #[inline(always)]
    pub(crate) fn label(self, kind: usize, random: u32) -> u64 {
        let up_to = |threshold: &u64| u64::from(u64::from(random) >= *threshold);
        self.values[kind * self.steps..][..self.steps].iter().map(up_to).sum()
    }
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
