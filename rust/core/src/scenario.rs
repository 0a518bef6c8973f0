//! Scenarios: what would happen, sampled beforehand.
//!
//! A scenario fixes the classes of the objects in the order of the belt and a random per (depth, position) that
//! decides a label by inversion (see [`crate::sampling`]). No state is ever copied: a set of scenarios is a bit plane, and the scenarios of a
//! node that give label z at a position are the node's plane AND the plane of z.

use std::sync::OnceLock;

use rand::Rng;
use rayon::prelude::*;

use crate::index::{Class, Label, Position};
use crate::model::{Look, SortingModel};
use crate::planes;
use crate::sampling::{Purpose, stream};

/// Depths whose randoms are drawn together.
const DEPTHS: usize = 16;

/// The randoms of every scenario, drawn when a search first gets as deep; functions of the seed alone.
///
/// Scenario i has a stream of its own, so its randoms depend on neither the number of scenarios nor threads.
#[derive(Debug)]
pub(crate) struct Randoms {
    seed: u64,
    count: usize,
    positions: usize,
    /// A row for the class of each object that is visible at the root.
    visible: OnceLock<Rows>,
    /// Blocks of [`DEPTHS`] depths; per depth a row for the class of one more object, and one per position for its
    /// label.
    blocks: Vec<OnceLock<Rows>>,
}

/// Rows of randoms, an entry per scenario, padded to whole words of a plane.
type Rows = Vec<Vec<u32>>;

impl Randoms {
    /// Randoms of `count` scenarios down to `depth`.
    pub(crate) fn new(seed: u64, count: usize, positions: usize, depth: usize) -> Self {
        let blocks = std::iter::repeat_with(OnceLock::new).take(depth.div_ceil(DEPTHS) + 1).collect();
        Self { seed, count, positions, visible: OnceLock::new(), blocks }
    }

    /// Draw what is needed to observe at `depth`.
    pub(crate) fn reach(&self, depth: usize, parallel: bool) {
        let per_block = DEPTHS * (self.positions + 1);
        self.ready(&self.visible, 0, self.positions, parallel);
        for (index, block) in self.blocks.iter().enumerate().take(depth / DEPTHS + 1) {
            self.ready(block, self.positions + index * per_block, per_block, parallel);
        }
    }

    /// Nothing is locked while drawing: two threads may draw the same rows, and one of them wins.
    fn ready(&self, rows: &OnceLock<Rows>, from: usize, count: usize, parallel: bool) {
        if rows.get().is_none() {
            let _ = rows.set(self.draw(from, count, parallel));
        }
    }

    /// Randoms `from..from + count` of every stream, as rows.
    fn draw(&self, from: usize, count: usize, parallel: bool) -> Rows {
        let scenario = |index: usize| -> Vec<u32> {
            let mut rng = stream(self.seed, Purpose::Scenario, index as u64);
            rng.set_word_pos(from as u128);
            (0..count).map(|_| rng.next_u32()).collect()
        };
        let drawn: Vec<Vec<u32>> = if parallel {
            (0..self.count).into_par_iter().map(scenario).collect()
        } else {
            (0..self.count).map(scenario).collect()
        };
        let padded = planes::words(self.count) * planes::LANES;
        let entry = |row: usize, i: usize| drawn.get(i).map_or(u32::MAX, |scenario| scenario[row]);
        (0..count).map(|row| (0..padded).map(|i| entry(row, i)).collect()).collect()
    }

    /// The randoms behind the class of the n-th object on the belt.
    fn class(&self, object: usize) -> &[u32] {
        match object.checked_sub(self.positions) {
            None => row(&self.visible, object),
            Some(depth) => self.at(depth, 0),
        }
    }

    /// The randoms behind the labels of a position at a depth.
    fn label(&self, depth: usize, position: Position) -> &[u32] {
        self.at(depth, 1 + position.0)
    }

    fn at(&self, depth: usize, index: usize) -> &[u32] {
        row(&self.blocks[depth / DEPTHS], depth % DEPTHS * (self.positions + 1) + index)
    }
}

/// A row that [`Randoms::reach`] has drawn.
fn row(rows: &OnceLock<Rows>, index: usize) -> &[u32] {
    rows.get().map_or(&[], |rows| &rows[index])
}

/// A look at one position, in all scenarios.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LookPoint {
    /// Planner steps since the root.
    pub(crate) depth: usize,
    /// Decisions since the root.
    pub(crate) decisions: usize,
    /// At which position, and from where.
    pub(crate) look: Look,
}

impl LookPoint {
    /// The object looked at, by its place on the belt.
    fn object(self) -> usize {
        self.decisions + self.look.position.0
    }
}

/// Which scenarios give which label: a plane per label for every look that the search has needed so far.
#[derive(Debug, Default)]
pub(crate) struct LabelPlanes {
    words: usize,
    classes: usize,
    viewpoints: usize,
    positions: usize,
    /// Planes of a look per last label, and without any: 1 if no look repeats.
    variants: usize,
    /// Per object: the plane of each class.
    objects: Vec<Vec<u64>>,
    /// First word of the look's planes, by [`LabelPlanes::key`]; [`ABSENT`] where there are none yet.
    index: Vec<usize>,
    labels: Vec<u64>,
    /// Looks whose planes are being made.
    missing: Vec<LookPoint>,
}

const ABSENT: usize = usize::MAX;

impl LabelPlanes {
    /// Start a search from a belief, with one distribution per position.
    pub(crate) fn restart(&mut self, model: &SortingModel, randoms: &Randoms, belief: &[f64]) {
        (self.words, self.classes) = (planes::words(randoms.count), model.class_count());
        (self.viewpoints, self.positions) = (model.viewpoint_count(), model.position_count());
        self.variants = if model.ever_repeats() { self.classes + 1 } else { 1 };
        self.objects.clear();
        self.index.clear();
        self.labels.clear();
        for (object, distribution) in belief.chunks_exact(self.classes).enumerate() {
            let planes = self.class_planes(randoms.class(object), distribution);
            self.objects.push(planes);
        }
    }

    /// Have the planes of some looks; the randoms must reach their depths.
    pub(crate) fn require(
        &mut self,
        model: &SortingModel,
        randoms: &Randoms,
        looks: impl Iterator<Item = LookPoint>,
        parallel: bool,
    ) {
        let (first, size) = (self.labels.len(), self.classes * self.words);
        let mut missing = std::mem::take(&mut self.missing);
        for at in looks {
            let key = self.key(at);
            if key >= self.index.len() {
                self.index.resize(key + 1, ABSENT);
            }
            if self.index[key] == ABSENT {
                self.index[key] = first + missing.len() * size;
                missing.push(at);
                self.require_object(model, randoms, at.object());
            }
        }
        self.labels.resize(first + missing.len() * size, 0);
        let mut labels = std::mem::take(&mut self.labels);
        let fill = |(planes, at): (&mut [u64], &LookPoint)| self.fill(model, randoms, *at, planes);
        if parallel {
            labels[first..].par_chunks_exact_mut(size).zip(&missing).for_each(fill);
        } else {
            labels[first..].chunks_exact_mut(size).zip(&missing).for_each(fill);
        }
        missing.clear();
        (self.labels, self.missing) = (labels, missing);
    }

    fn require_object(&mut self, model: &SortingModel, randoms: &Randoms, object: usize) {
        while self.objects.len() <= object {
            let planes = self.class_planes(randoms.class(self.objects.len()), model.arrival().as_slice());
            self.objects.push(planes);
        }
    }

    /// The scenarios in which a look gives a label.
    #[inline(always)]
    pub(crate) fn label(&self, at: LookPoint, label: Label) -> &[u64] {
        &self.labels[self.index[self.key(at)] + label.0 * self.words..][..self.words]
    }

    /// Looks are numbered depth by depth: at depth d there have been 0 to d decisions, or d + 1 if the scan follows
    /// one.
    #[inline(always)]
    fn key(&self, at: LookPoint) -> usize {
        let step = at.depth * (at.depth + 3) / 2 + at.decisions;
        let Look { position, viewpoint, last } = at.look;
        let look = (step * self.viewpoints + viewpoint.0) * self.positions + position.0;
        look * self.variants + last.map_or(0, |label| label.0 + 1)
    }

    /// The plane of each class of an object with this distribution.
    fn class_planes(&self, randoms: &[u32], distribution: &[f64]) -> Vec<u64> {
        let mut planes = vec![0; self.classes * self.words];
        let among = &vec![u64::MAX; self.words];
        let distribution = distribution.iter().copied();
        pulp::Arch::new().dispatch(Inversion { randoms, distribution, among, planes: &mut planes });
        planes
    }

    /// The plane of each label of a look.
    fn fill(&self, model: &SortingModel, randoms: &Randoms, at: LookPoint, planes: &mut [u64]) {
        let object = &self.objects[at.object()];
        let randoms = randoms.label(at.depth, at.look.position);
        for (class, among) in object.chunks_exact(self.words).enumerate() {
            let distribution = model.label_distribution(at.look, Class(class));
            pulp::Arch::new().dispatch(Inversion { randoms, distribution, among, planes });
        }
    }
}

/// Add to the plane of each outcome the scenarios of `among` whose random selects it.
struct Inversion<'a, D> {
    randoms: &'a [u32],
    distribution: D,
    among: &'a [u64],
    planes: &'a mut [u64],
}

impl<D: Iterator<Item = f64>> pulp::NullaryFnOnce for Inversion<'_, D> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mut left = self.among.to_vec();
        let mut below = vec![0; left.len()];
        let mut cumulated = 0.0;
        for (p, plane) in self.distribution.zip(self.planes.chunks_exact_mut(below.len())) {
            cumulated += p;
            if p > 0.0 {
                planes::below(self.randoms, threshold(cumulated), &mut below);
                for ((plane, left), below) in plane.iter_mut().zip(&mut left).zip(&below) {
                    *plane |= *left & below;
                    *left &= !below;
                }
            }
        }
    }
}

/// A probability in units of 2^-32. What rounding leaves of 1 belongs to the last outcome.
fn threshold(cumulated: f64) -> u64 {
    const NEARLY_ONE: f64 = 1.0 - 1e-9;
    let scale = (1_u64 << 32) as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 0 and 2^32
    let threshold = (cumulated * scale).round() as u64;
    if cumulated > NEARLY_ONE { 1 << 32 } else { threshold }
}
