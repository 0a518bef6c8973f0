//! Scenarios divided by the labels they give.

use std::ops::Range;

use super::node::Word;
use super::step::{count, members};
use crate::planes::LANES;
use crate::sampling::Thresholds;
use crate::scenario::{LookPoint, Scenarios};

/// Sets of so many scenarios are gone through one by one; larger ones all at once, as planes.
pub(super) const FEW: u32 = 32;

/// Sets of scenarios that give the same labels, in the order of the labels, the belt end's first.
#[derive(Debug, Default)]
pub(super) struct Groups {
    /// A buffer that only grows; `found` says what of it counts.
    words: Vec<Word>,
    found: Vec<Group>,
    /// The same one label earlier.
    before: (Vec<Word>, Vec<Group>),
    /// Few scenarios, each with the code of its labels.
    coded: Vec<(u64, usize)>,
}

/// Scenarios that have given the same labels.
#[derive(Debug, Clone)]
struct Group {
    /// The labels so far, as digits in base Z, the belt end's first.
    labels: u64,
    words: Range<usize>,
    /// Number of scenarios.
    count: u32,
}

impl Groups {
    /// Divide a set of scenarios by what they give at some looks, one per position.
    #[inline(always)]
    pub(super) fn divide(
        &mut self,
        (scenarios, thresholds): (&Scenarios<'_>, &Thresholds),
        (set, count): (&[Word], u32),
        looks: impl Iterator<Item = LookPoint>,
    ) {
        if count <= FEW {
            self.divide_few((scenarios, thresholds), set, looks);
        } else {
            self.restart(set, count);
            for look in looks {
                self.divide_by(scenarios.labels(look), scenarios.label_count());
            }
        }
    }

    /// Give each scenario the code of its labels, and sort them by it.
    #[inline(always)]
    fn divide_few(
        &mut self,
        (scenarios, thresholds): (&Scenarios<'_>, &Thresholds),
        set: &[Word],
        looks: impl Iterator<Item = LookPoint>,
    ) {
        let Self { words, found, coded, .. } = self;
        coded.clear();
        coded.extend(set.iter().flat_map(|word| members(*word)).map(|scenario| (0, scenario)));
        let base = scenarios.label_count() as u64;
        for look in looks {
            let thresholds = thresholds.of(look.look);
            let (randoms, kinds) = (scenarios.label_randoms(look), scenarios.kind_list(look.object()));
            for (code, scenario) in &mut *coded {
                let label = thresholds.label(kinds[*scenario] as usize, randoms[*scenario]);
                *code = *code * base + label;
            }
        }
        coded.sort_unstable();
        words.clear();
        found.clear();
        for &(labels, scenario) in &*coded {
            #[allow(clippy::cast_possible_truncation)] // at most a million scenarios
            let (word, bit) = ((scenario / LANES) as u32, 1 << (scenario % LANES));
            match (found.last_mut(), words.last_mut()) {
                (Some(group), Some(last)) if group.labels == labels => {
                    group.count += 1;
                    if last.0 == word {
                        last.1 |= bit;
                    } else {
                        words.push((word, bit));
                        group.words.end += 1;
                    }
                }
                _ => {
                    found.push(Group { labels, words: words.len()..words.len() + 1, count: 1 });
                    words.push((word, bit));
                }
            }
        }
    }

    /// Start with one set and no labels.
    #[inline(always)]
    fn restart(&mut self, set: &[Word], count: u32) {
        self.words.clear();
        self.words.extend_from_slice(set);
        self.found.clear();
        self.found.push(Group { labels: 0, words: 0..set.len(), count });
    }

    /// Divide each group by the next label, given the planes of the labels.
    #[inline(always)]
    fn divide_by(&mut self, planes: &[u64], labels: usize) {
        let Self { words: into, found, before, .. } = self;
        std::mem::swap(into, &mut before.0);
        std::mem::swap(found, &mut before.1);
        found.clear();
        let (mut end, words) = (0, planes.len() / labels);
        for Group { labels: code, words: group, count: all } in &before.1 {
            let (group, mut left) = (&before.0[group.clone()], *all);
            for (label, plane) in (0..).zip(planes.chunks_exact(words)) {
                if into.len() < end + group.len() {
                    into.resize(end + group.len(), Word::default());
                }
                let (from, out) = (end, &mut into[end..]);
                let mut kept = 0;
                for (word, bits) in group {
                    let bits = bits & plane[*word as usize];
                    out[kept] = (*word, bits);
                    kept += usize::from(bits != 0);
                }
                if kept > 0 {
                    let count = count(&out[..kept]);
                    end += kept;
                    left -= count;
                    let labels = code * labels as u64 + label;
                    found.push(Group { labels, words: from..end, count });
                    if left == 0 {
                        break;
                    }
                }
            }
        }
    }

    /// Add digits for positions without an object.
    #[inline(always)]
    pub(super) fn pad(&mut self, base: usize, positions: usize) {
        let unit = (0..positions).fold(1, |unit: u64, _| unit.wrapping_mul(base as u64));
        self.found.iter_mut().for_each(|group| group.labels = group.labels.wrapping_mul(unit));
    }

    /// The groups: labels, scenarios and their number.
    #[inline(always)]
    pub(super) fn iter(&self) -> impl Iterator<Item = (u64, &[Word], u32)> {
        self.found.iter().map(|group| (group.labels, &self.words[group.words.clone()], group.count))
    }
}
