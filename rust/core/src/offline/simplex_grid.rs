//! A grid of beliefs about one object, and linear interpolation between its points.
//!
//! In the cumulated coordinates `s_k = b_{k+1} + ... + b_L` the simplex is `1 >= s_1 >= ... >= s_{L-1} >= 0`. The
//! grid puts the same levels on every axis; its cells are cut into simplices by the order of the coordinates'
//! fractions (Freudenthal, Kuhn), so locating a belief is a sort. Every grid simplex lies in the belief simplex
//! because equal levels are shared by all axes.

/// A belief as a convex combination of grid points: pairs of (point, weight).
pub(crate) type Combination = Vec<(u32, f64)>;

/// Levels on every axis, and the points they span.
#[derive(Debug, Clone)]
pub(super) struct SimplexGrid {
    classes: usize,
    /// From 0 to 1, ascending.
    levels: Vec<f64>,
    /// `binomials[n][k]`, for ranking points.
    binomials: Vec<Vec<usize>>,
}

impl SimplexGrid {
    /// A grid of `intervals` per axis, finer towards 0 and 1, with a point at `anchor` if it is fine enough.
    ///
    /// `grading` 0 spaces levels evenly, 1 by a quarter-cosine towards both ends.
    pub(super) fn new(anchor: &[f64], intervals: usize, grading: f64) -> Self {
        let classes = anchor.len();
        let graded = |x: f64| 0.5 - 0.5 * (std::f64::consts::PI * x).cos();
        let level = |i: usize| {
            let even = i as f64 / intervals as f64;
            let (blunt, sharp) =
                if grading <= 1.0 { (even, graded(even)) } else { (graded(even), graded(graded(even))) };
            let part = if grading <= 1.0 { grading } else { grading - 1.0 };
            (1.0 - part) * blunt + part * sharp
        };
        let mut levels: Vec<f64> = (0..=intervals).map(level).collect();
        (levels[0], levels[intervals]) = (0.0, 1.0);
        for coordinate in cumulated(anchor) {
            move_nearest(&mut levels, coordinate);
        }
        Self { classes, levels, binomials: binomials(intervals + classes, classes) }
    }

    /// Intervals per axis.
    pub(super) fn intervals(&self) -> usize {
        self.levels.len() - 1
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        let axes = self.classes - 1;
        self.binomials[self.levels.len() - 1 + axes][axes]
    }

    /// The belief at each point, in the order of their ranks.
    pub(super) fn points(&self) -> Vec<Vec<f64>> {
        let mut points = vec![Vec::new(); self.len()];
        let mut index = vec![0; self.classes - 1];
        loop {
            points[self.rank(&index)] = self.belief(&index);
            // The next non-increasing sequence: raise the last axis that may rise, reset those behind it.
            let top = self.levels.len() - 1;
            let may_rise = |axis: &usize| index[*axis] < if *axis == 0 { top } else { index[*axis - 1] };
            let Some(axis) = (0..index.len()).rev().find(may_rise) else { return points };
            index[axis] += 1;
            index[axis + 1..].fill(0);
        }
    }

    /// A belief as a combination of at most L points.
    pub(super) fn locate(&self, belief: &[f64]) -> Combination {
        let axes = self.classes - 1;
        let cumulated = cumulated(belief);
        let mut index: Vec<usize> = cumulated.iter().map(|s| self.cell(*s)).collect();
        let fractions: Vec<f64> = cumulated.iter().zip(&index).map(|(s, i)| self.fraction(*s, *i)).collect();
        let mut order: Vec<usize> = (0..axes).collect();
        // A stable sort: where coordinates are equal the earlier axis rises first, which keeps them in order.
        order.sort_by(|a, b| fractions[*b].total_cmp(&fractions[*a]));
        let mut combination = Vec::with_capacity(self.classes);
        let mut above = 1.0;
        for &axis in &order {
            push(&mut combination, self.rank(&index), above - fractions[axis]);
            above = fractions[axis];
            index[axis] += 1;
        }
        // Without any rise left over, the last point may lie outside the grid: its weight is then 0.
        if above > 0.0 {
            push(&mut combination, self.rank(&index), above);
        }
        combination
    }

    /// The interval of a level, from below.
    fn cell(&self, s: f64) -> usize {
        let last = self.levels.len() - 2;
        self.levels.partition_point(|level| *level <= s).saturating_sub(1).min(last)
    }

    fn fraction(&self, s: f64, cell: usize) -> f64 {
        ((s - self.levels[cell]) / (self.levels[cell + 1] - self.levels[cell])).clamp(0.0, 1.0)
    }

    /// Number of a point, given its level on each axis (non-increasing): the combinatorial number system.
    fn rank(&self, index: &[usize]) -> usize {
        let axes = index.len();
        index.iter().enumerate().map(|(k, i)| self.binomials[i + axes - 1 - k][axes - k]).sum()
    }

    fn belief(&self, index: &[usize]) -> Vec<f64> {
        let cumulated: Vec<f64> =
            std::iter::once(1.0).chain(index.iter().map(|i| self.levels[*i])).chain([0.0]).collect();
        cumulated.windows(2).map(|pair| pair[0] - pair[1]).collect()
    }
}

/// The same combination with every point once.
pub(crate) fn merged(mut combination: Combination) -> Combination {
    combination.sort_unstable_by_key(|(point, _)| *point);
    combination.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    combination
}

fn cumulated(belief: &[f64]) -> Vec<f64> {
    let mut cumulated = belief[1..].to_vec();
    let mut sum = 0.0;
    for coordinate in cumulated.iter_mut().rev() {
        sum += *coordinate;
        *coordinate = f64::min(sum, 1.0);
    }
    cumulated
}

/// Move the level nearest to a coordinate there, but no end and none past another.
fn move_nearest(levels: &mut [f64], coordinate: f64) {
    let above = levels.partition_point(|level| *level <= coordinate);
    let distance = |i: &usize| (levels[*i] - coordinate).abs();
    let inner = |i: &usize| (1..levels.len() - 1).contains(i);
    let nearest =
        [above - 1, above].into_iter().filter(inner).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    if let Some(nearest) = nearest.filter(|i| levels[i - 1] < coordinate && coordinate < levels[i + 1]) {
        levels[nearest] = coordinate;
    }
}

#[allow(clippy::cast_possible_truncation)] // a grid of 2^32 points fits no memory
fn push(combination: &mut Combination, point: usize, weight: f64) {
    if weight > 0.0 {
        combination.push((point as u32, weight));
    }
}

/// Pascal's triangle up to `n` over `k`; a grid as large as numbers can be is never made.
fn binomials(n: usize, k: usize) -> Vec<Vec<usize>> {
    let mut rows = vec![vec![0; k + 1]; n + 1];
    for i in 0..=n {
        rows[i][0] = 1;
        for j in 1..=k.min(i) {
            rows[i][j] = usize::saturating_add(rows[i - 1][j - 1], if j < i { rows[i - 1][j] } else { 0 });
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::testing::seeded;

    proptest! {
        #![proptest_config(seeded(200))]

        #[test]
        fn every_belief_is_the_combination_it_is_located_as(
            weights in prop::collection::vec(0.0..1.0_f64, 2..5),
            zeroed in prop::collection::vec(any::<bool>(), 4),
            intervals in 1..9_usize,
            grading in 0.0..=1.0_f64,
        ) {
            let mut belief: Vec<f64> =
                weights.iter().zip(zeroed).map(|(w, zero)| if zero { 0.0 } else { *w }).collect();
            belief[0] += 1e-3;
            let sum: f64 = belief.iter().sum();
            let belief: Vec<f64> = belief.iter().map(|b| b / sum).collect();
            let grid = SimplexGrid::new(&belief, intervals, grading);
            let points = grid.points();
            let combination = grid.locate(&belief);
            prop_assert!(combination.len() <= belief.len());
            prop_assert!((combination.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
            for class in 0..belief.len() {
                let b: f64 = combination.iter().map(|(i, w)| w * points[*i as usize][class]).sum();
                prop_assert!((b - belief[class]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn every_point_is_its_own_combination() {
        let grid = SimplexGrid::new(&[0.25; 4], 6, 0.7);
        let points = grid.points();
        assert_eq!(points.len(), 84);
        for (i, point) in points.iter().enumerate() {
            assert!((point.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let combination = grid.locate(point);
            let weight: f64 = combination.iter().filter(|(j, _)| *j as usize == i).map(|(_, w)| w).sum();
            assert!(weight > 1.0 - 1e-9, "{combination:?}");
        }
    }
}
