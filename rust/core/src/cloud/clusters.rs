//! Clusters of points: whoever is nearer than a gap to a member belongs to it.

use std::collections::BTreeMap;

type Cell = [i64; 3];

/// The number of each point's cluster, from 0 in the order of the clusters' first points.
///
/// Two points share a cluster if a chain of points leads from one to the other with no step longer than `gap`: DBSCAN
/// with one point as its fewest. Points go into cubes whose diagonal is the gap, so that a cube is of one cluster and
/// two cubes are compared until the first pair is near.
#[must_use]
pub fn clusters(points: &[[f64; 3]], gap: f64) -> Vec<usize> {
    let edge = gap / 3.0_f64.sqrt();
    let mut cubes: BTreeMap<Cell, Vec<usize>> = BTreeMap::new();
    for (index, point) in points.iter().enumerate() {
        #[allow(clippy::cast_possible_truncation)] // the cast saturates
        let cell = point.map(|x| (x / edge).floor() as i64);
        cubes.entry(cell).or_default().push(index);
    }
    let mut forest = Forest((0..points.len()).collect());
    for (cell, members) in &cubes {
        for &member in members {
            forest.join(members[0], member);
        }
        for others in neighbours(&cubes, *cell) {
            let near = |&a: &usize| others.iter().any(|&b| within(gap, &points[a], &points[b]));
            if forest.root(members[0]) != forest.root(others[0]) && members.iter().any(near) {
                forest.join(members[0], others[0]);
            }
        }
    }
    forest.numbered()
}

/// The occupied cubes behind `cell`, in the order of cells, that may hold a point within the gap of one in it.
fn neighbours(cubes: &BTreeMap<Cell, Vec<usize>>, [x, y, z]: Cell) -> impl Iterator<Item = &Vec<usize>> {
    let columns = (0..=2).flat_map(|dx| (-2..=2).map(move |dy| (dx, dy)));
    columns.filter(|&column| column >= (0, 0)).flat_map(move |(dx, dy)| {
        let column = [x.saturating_add(dx), y.saturating_add(dy)];
        let lowest = if (dx, dy) == (0, 0) { z.saturating_add(1) } else { z.saturating_sub(2) };
        let highest = z.saturating_add(2).max(lowest);
        cubes
            .range([column[0], column[1], lowest]..=[column[0], column[1], highest])
            .map(|(_, members)| members)
    })
}

fn within(gap: f64, a: &[f64; 3], b: &[f64; 3]) -> bool {
    let squared: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    squared <= gap * gap
}

/// Sets of points, each a tree of indices whose root is its smallest.
struct Forest(Vec<usize>);

impl Forest {
    fn root(&mut self, mut index: usize) -> usize {
        while self.0[index] != index {
            self.0[index] = self.0[self.0[index]];
            index = self.0[index];
        }
        index
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }

    /// The number of each index's set.
    fn numbered(mut self) -> Vec<usize> {
        let mut numbers: Vec<usize> = Vec::with_capacity(self.0.len());
        let mut next = 0;
        for index in 0..self.0.len() {
            // A root is the smallest of its set: it comes first.
            let root = self.root(index);
            numbers.push(if root == index { next } else { numbers[root] });
            next += usize::from(root == index);
        }
        numbers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::seeded;
    use proptest::prelude::*;

    /// The definition: spread the smallest number along every near pair until nothing changes.
    fn by_definition(points: &[[f64; 3]], gap: f64) -> Vec<usize> {
        let mut first: Vec<usize> = (0..points.len()).collect();
        loop {
            let before = first.clone();
            for a in 0..points.len() {
                for b in (0..points.len()).filter(|&b| within(gap, &points[a], &points[b])) {
                    first[b] = first[b].min(first[a]);
                }
            }
            if first == before {
                let firsts: Vec<usize> = (0..points.len()).filter(|&index| first[index] == index).collect();
                return first.iter().map(|f| firsts.iter().position(|g| g == f).unwrap()).collect();
            }
        }
    }

    #[test]
    fn a_chain_is_one_cluster_and_what_lies_apart_another() {
        let line = [0.0, 0.9, 5.0, 1.8, 2.7, 5.5].map(|x| [x, 0.0, 0.0]);
        assert_eq!(clusters(&line, 1.0), [0, 0, 1, 0, 0, 1]);
        assert_eq!(clusters(&line, 0.8), [0, 1, 2, 3, 4, 2]);
        assert!(clusters(&[], 1.0).is_empty());
    }

    #[test]
    fn coordinates_beyond_all_cubes_are_no_panic() {
        let far = [[f64::MAX; 3], [f64::MIN; 3], [f64::NAN; 3], [0.0; 3]];
        assert_eq!(clusters(&far, 1e-9).len(), 4);
    }

    proptest! {
        #![proptest_config(seeded(256))]

        #[test]
        fn clusters_are_what_the_definition_says(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 0..60), gap in 0.05..0.8_f64
        ) {
            prop_assert_eq!(clusters(&points, gap), by_definition(&points, gap));
        }
    }
}
