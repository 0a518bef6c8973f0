//! Scenarios: what would happen, sampled beforehand.
//!
//! A scenario fixes the classes of the objects in the order of the belt and a stream of observation randoms per
//! depth. No state is ever copied: a node of the search knows its scenarios by index.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::belief::Belief;
use crate::model::SortingModel;
use crate::sampling::{Purpose, invert, label, stream};

/// Streams drawn by one task; fewer are not worth the hand-over to another thread.
const STREAMS_PER_TASK: usize = 512;

/// A set of scenarios, drawn depth by depth as the search goes deeper.
pub(crate) struct Scenarios {
    streams: Vec<Stream>,
    positions: usize,
    depth: usize,
}

/// One scenario: its random stream and all that has been drawn from it.
struct Stream {
    rng: ChaCha8Rng,
    /// The class of the n-th object on the belt, the one at the belt end first.
    classes: Vec<usize>,
    /// The uniform behind the label of position j at depth d: entry `d * H + j`.
    uniforms: Vec<f64>,
}

impl Scenarios {
    /// Draw the visible objects of `count` scenarios from a belief. Scenario i depends on `seed` and i alone.
    pub(crate) fn sample(belief: &Belief, count: usize, seed: u64) -> Self {
        let (positions, _) = belief.shape();
        let draw = |index: usize| {
            let mut rng = stream(seed, Purpose::Scenario, index as u64);
            let classes =
                (0..positions).map(|j| invert(belief.position(j).iter(), rng.random::<f64>())).collect();
            Stream { rng, classes, uniforms: Vec::new() }
        };
        let streams = (0..count).into_par_iter().with_min_len(STREAMS_PER_TASK).map(draw).collect();
        Self { streams, positions, depth: 0 }
    }

    /// Draw what is needed to observe at `depth`: one more object, and one uniform per position, for each depth.
    pub(crate) fn reach(&mut self, model: &SortingModel, depth: usize) {
        let positions = self.positions;
        while self.depth <= depth {
            self.streams.par_iter_mut().with_min_len(STREAMS_PER_TASK).for_each(|s| {
                s.classes.push(invert(model.arrival().iter(), s.rng.random::<f64>()));
                s.uniforms.extend((0..positions).map(|_| s.rng.random::<f64>()));
            });
            self.depth += 1;
        }
    }

    /// The label of every position that a scan gives, as one number: see [`labels`].
    pub(crate) fn label_code(&self, model: &SortingModel, scenario: usize, at: ScanPoint) -> u64 {
        let stream = &self.streams[scenario];
        let uniforms = &stream.uniforms[at.depth * self.positions..][..self.positions];
        let positions = stream.classes[at.decisions..].iter().zip(uniforms).enumerate();
        positions.fold(0, |code, (j, (&class, &u))| {
            code * model.class_count() as u64 + label(model, j, at.viewpoint, None, class, u) as u64
        })
    }
}

/// The labels behind a code: its digits in base L, the belt end's first.
pub(crate) fn labels(model: &SortingModel, mut code: u64) -> Vec<usize> {
    let base = model.class_count() as u64;
    let mut labels = vec![0; model.position_count()];
    for label in labels.iter_mut().rev() {
        // A digit is below L, which is a usize.
        #[allow(clippy::cast_possible_truncation)]
        let digit = (code % base) as usize;
        *label = digit;
        code /= base;
    }
    labels
}

/// Where in a scenario a scan is taken.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScanPoint {
    /// Planner steps since the root.
    pub(crate) depth: usize,
    /// Decisions since the root.
    pub(crate) decisions: usize,
    /// Where the camera stands.
    pub(crate) viewpoint: usize,
}
