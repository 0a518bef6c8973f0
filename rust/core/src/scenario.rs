//! Scenarios: what would happen, sampled beforehand.
//!
//! A scenario fixes the classes of the objects in the order of the belt and a random per (depth, position) that
//! decides a label by inversion (see [`crate::sampling`]). No state is ever copied: a set of scenarios is a bit plane, and the scenarios of a
//! node that give label z at a position are the node's plane AND the plane of z.

use std::sync::OnceLock;

use rand::Rng;
use rayon::prelude::*;

use crate::belief::Belief;
use crate::index::{Label, Position};
use crate::model::{Look, SortingModel};
use crate::planes;
use crate::sampling::{Purpose, stream, threshold};

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

    /// Every random counted from the other end: inversion then gives the outcomes that it gives for distributions
    /// whose outcomes are listed in reverse.
    #[cfg(test)]
    pub(crate) fn mirrored(&self) -> Self {
        self.reach(DEPTHS * (self.blocks.len() - 1), false);
        let mirror = |rows: &OnceLock<Rows>| {
            let rows = rows.get().into_iter().flatten();
            OnceLock::from(rows.map(|row| row.iter().map(|random| !random).collect()).collect::<Rows>())
        };
        let blocks = self.blocks.iter().map(mirror).collect();
        Self { visible: mirror(&self.visible), blocks, ..*self }
    }

    /// The randoms behind the kind of the n-th object on the belt.
    fn kind(&self, object: usize) -> &[u32] {
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
    pub(crate) fn object(self) -> usize {
        self.decisions + self.look.position.0
    }
}

/// Planes, one per kind or label.
type Planes = Vec<u64>;

/// The scenarios of one search: object classes from a belief and the arrival prior, labels by inversion.
///
/// Planes are worked out when a search first asks for them, by whichever thread asks. What they hold depends on neither
/// the threads nor the order in which they ask.
#[derive(Debug)]
pub(crate) struct Scenarios<'a> {
    model: &'a SortingModel,
    randoms: &'a Randoms,
    belief: &'a Belief,
    words: usize,
    /// Per object on the belt.
    objects: Vec<OnceLock<Planes>>,
    /// The same as numbers: the kind in each scenario.
    kinds: Vec<OnceLock<Vec<u32>>>,
    /// Per number of decisions: the kinds at the positions in each scenario, see [`Scenarios::marks`].
    marks: Vec<OnceLock<Vec<u64>>>,
    joint_kinds: Vec<OnceLock<Vec<u32>>>,
    /// Per depth its looks, numbered by decisions, viewpoint, position and last label.
    looks: Vec<OnceLock<Vec<OnceLock<Planes>>>>,
}

impl<'a> Scenarios<'a> {
    /// Scenarios from a belief, down to `depth`.
    pub(crate) fn sampled(
        (model, randoms): (&'a SortingModel, &'a Randoms),
        belief: &'a Belief,
        depth: usize,
        parallel: bool,
    ) -> Self {
        randoms.reach(0, parallel);
        let objects = depth + 1 + model.position_count();
        Self {
            model,
            randoms,
            belief,
            words: planes::words(randoms.count),
            objects: std::iter::repeat_with(OnceLock::new).take(objects).collect(),
            kinds: std::iter::repeat_with(OnceLock::new).take(objects).collect(),
            marks: std::iter::repeat_with(OnceLock::new).take(depth + 1).collect(),
            joint_kinds: std::iter::repeat_with(OnceLock::new).take(depth + 1).collect(),
            looks: std::iter::repeat_with(OnceLock::new).take(depth).collect(),
        }
    }

    /// Number of scenarios.
    pub(crate) fn count(&self) -> usize {
        self.randoms.count
    }

    /// Number of kinds.
    pub(crate) fn kind_count(&self) -> usize {
        self.model.kind_count()
    }

    /// Number of labels.
    pub(crate) fn label_count(&self) -> usize {
        self.model.label_count()
    }

    /// Words of a plane.
    pub(crate) fn words(&self) -> usize {
        self.words
    }

    /// The kind of the n-th object on the belt in each scenario.
    pub(crate) fn kind_list(&self, object: usize) -> &[u32] {
        self.kinds[object].get_or_init(|| {
            let mut list = vec![0; self.words * planes::LANES];
            pulp::Arch::new().dispatch(Listing { planes: self.kinds(object), list: &mut list });
            list
        })
    }

    /// The randoms behind the labels of a look, one per scenario.
    pub(crate) fn label_randoms(&self, at: LookPoint) -> &[u32] {
        self.randoms.reach(at.depth, false);
        self.randoms.label(at.depth, at.look.position)
    }

    /// The kinds at the positions after so many decisions, [`Scenarios::mark_words`] words per scenario: a byte for each
    /// position and kind, 1 where the object there is of that kind. So the sum over up to 255 scenarios is their histogram.
    pub(crate) fn marks(&self, decisions: usize) -> &[u64] {
        self.marks[decisions].get_or_init(|| {
            let (stride, kinds) = (self.mark_words(), self.model.kind_count());
            let mut marks = vec![0; stride * self.words * planes::LANES];
            for position in 0..self.model.position_count() {
                let list = self.kind_list(decisions + position);
                for (marks, kind) in marks.chunks_exact_mut(stride).zip(list) {
                    let byte = position * kinds + *kind as usize;
                    marks[byte / 8] |= 1 << (byte % 8 * 8);
                }
            }
            marks
        })
    }

    /// The kinds at the positions after so many decisions in each scenario, as one number: digits in base N, the belt
    /// end's last. Only for models in which 32 bits hold it.
    pub(crate) fn joint_kinds(&self, decisions: usize) -> &[u32] {
        self.joint_kinds[decisions].get_or_init(|| {
            #[allow(clippy::cast_possible_truncation)] // see above
            let (mut joint, kinds) = (vec![0; self.words * planes::LANES], self.kind_count() as u32);
            for position in self.model.positions().rev() {
                let list = self.kind_list(decisions + position.0);
                for (joint, kind) in joint.iter_mut().zip(list) {
                    *joint = *joint * kinds + kind;
                }
            }
            joint
        })
    }

    /// Words for the marks of one scenario.
    pub(crate) fn mark_words(&self) -> usize {
        (self.model.position_count() * self.model.kind_count()).div_ceil(8)
    }

    /// The plane of each kind of the n-th object on the belt.
    pub(crate) fn kinds(&self, object: usize) -> &[u64] {
        self.objects[object].get_or_init(|| {
            let positions = self.model.position_count();
            self.randoms.reach(object.saturating_sub(positions), false);
            let arrival = self.model.arrival().as_slice();
            let seen = self.belief.as_slice().chunks_exact(self.model.kind_count()).nth(object);
            let distribution = seen.unwrap_or(arrival).iter().copied();
            let among = &vec![u64::MAX; self.words];
            let mut planes = vec![0; self.model.kind_count() * self.words];
            let randoms = self.randoms.kind(object);
            pulp::Arch::new().dispatch(Inversion { randoms, distribution, among, planes: &mut planes });
            planes
        })
    }

    /// The plane of each label of a look.
    pub(crate) fn labels(&self, at: LookPoint) -> &[u64] {
        let variants = if self.model.ever_repeats() { self.model.label_count() + 1 } else { 1 };
        let (viewpoints, positions) = (self.model.viewpoint_count(), self.model.position_count());
        // At depth d there have been 0 to d decisions, or d + 1 if the scan follows one.
        let count = (at.depth + 2) * viewpoints * positions * variants;
        let looks =
            self.looks[at.depth].get_or_init(|| std::iter::repeat_with(OnceLock::new).take(count).collect());
        let Look { position, viewpoint, last } = at.look;
        let number = (at.decisions * viewpoints + viewpoint.0) * positions + position.0;
        looks[number * variants + last.map_or(0, |label| label.0 + 1)].get_or_init(|| self.look(at))
    }

    /// The scenarios in which a look gives a label.
    pub(crate) fn label(&self, at: LookPoint, label: Label) -> &[u64] {
        &self.labels(at)[label.0 * self.words..][..self.words]
    }

    fn look(&self, at: LookPoint) -> Planes {
        self.randoms.reach(at.depth, false);
        let randoms = self.randoms.label(at.depth, at.look.position);
        let mut planes = vec![0; self.model.label_count() * self.words];
        for (kind, among) in self.model.kinds().zip(self.kinds(at.object()).chunks_exact(self.words)) {
            let distribution = self.model.label_distribution(at.look, kind);
            pulp::Arch::new().dispatch(Inversion { randoms, distribution, among, planes: &mut planes });
        }
        planes
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

/// The outcome of each scenario, given the plane of each.
struct Listing<'a> {
    planes: &'a [u64],
    list: &'a mut [u32],
}

impl pulp::NullaryFnOnce for Listing<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let words = self.list.len() / planes::LANES;
        for (outcome, plane) in (0..).zip(self.planes.chunks_exact(words)) {
            for (word, entries) in plane.iter().zip(self.list.chunks_exact_mut(planes::LANES)) {
                for (lane, entry) in entries.iter_mut().enumerate() {
                    *entry |= outcome * u32::from(word >> lane & 1 == 1);
                }
            }
        }
    }
}
