//! Sparse rows, and the products that a sweep of value iteration consists of.

use std::ops::{Add, AddAssign, Mul};

use super::simplex_grid::Combination;

/// What a sweep is computed in: `f32` for speed, `f64` where it proves something.
pub(super) trait Real:
    Copy + Send + Sync + PartialOrd + From<f32> + Add<Output = Self> + AddAssign + Mul<Output = Self>
{
    fn of(value: f64) -> Self;
}

impl Real for f32 {
    #[allow(clippy::cast_possible_truncation)] // rounding is what it is for
    fn of(value: f64) -> Self {
        value as Self
    }
}

impl Real for f64 {
    fn of(value: f64) -> Self {
        value
    }
}

/// Rows of the values that are backed up at once; their numbers lie next to each other in memory.
pub(super) const LANES: usize = 8;
/// Entries of a row are padded to a multiple of this.
const UNROLLED: usize = 4;

/// A sparse matrix by rows.
#[derive(Debug, Clone)]
pub(super) struct Rows<T> {
    /// Row `i` is `entries[starts[i]..starts[i + 1]]`.
    starts: Vec<usize>,
    entries: Vec<(u32, T)>,
}

impl<T: Real> Rows<T> {
    /// The rows, each multiplied by `factor`.
    pub(super) fn new(rows: &[Combination], factor: f64) -> Self {
        let mut built = Self { starts: vec![0], entries: Vec::new() };
        for row in rows {
            built.entries.extend(row.iter().map(|(i, weight)| (*i, T::of(factor * weight))));
            let padded = built.entries.len().next_multiple_of(UNROLLED);
            built.entries.resize(padded, (0, T::of(0.0)));
            built.starts.push(padded);
        }
        built
    }

    pub(super) fn row(&self, i: usize) -> &[(u32, T)] {
        &self.entries[self.starts[i]..self.starts[i + 1]]
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[(u32, T)]> {
        self.starts.windows(2).map(|ends| &self.entries[ends[0]..ends[1]])
    }
}

/// The weighted sum of rows of a dense matrix with `sum.len()` columns.
pub(super) fn mix<T: Real>(row: &[(u32, T)], values: &[f32], sum: &mut [T]) {
    let width = sum.len();
    let dense = |i: u32| &values[i as usize * width..][..width];
    sum.fill(T::of(0.0));
    for [a, b, c, d] in row.as_chunks::<UNROLLED>().0 {
        let quads = dense(a.0).iter().zip(dense(b.0)).zip(dense(c.0).iter().zip(dense(d.0)));
        for (sum, ((va, vb), (vc, vd))) in sum.iter_mut().zip(quads) {
            *sum += a.1 * T::from(*va) + b.1 * T::from(*vb) + (c.1 * T::from(*vc) + d.1 * T::from(*vd));
        }
    }
}

/// The weighted sum of entries, in every lane.
pub(super) fn gather<T: Real>(row: &[(u32, T)], values: &[[T; LANES]]) -> [T; LANES] {
    let mut sums = [T::of(0.0); LANES];
    for (i, weight) in row {
        for (sum, value) in sums.iter_mut().zip(&values[*i as usize]) {
            *sum += *weight * *value;
        }
    }
    sums
}
