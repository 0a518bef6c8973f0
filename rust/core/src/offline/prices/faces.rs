//! Beliefs about one object that leave few of its states possible, and how any belief is put together from them.
//!
//! The values of such beliefs bound those of all others from above: a belief about many states is an average of
//! beliefs about few, and since the value is convex, interpolating between those never falls below it. On a *face*, the simplex of few states, a grid interpolates. Looks never lead out of a face.

use super::super::simplex_grid::{Combination, SimplexGrid};

/// What a belief may be put together from: a few states and their probabilities.
#[derive(Debug)]
struct Part {
    weight: f64,
    states: Vec<(usize, f64)>,
}

/// Information, in nats, that knowing the part would bring, up to a constant that all splits of one belief share. The
/// split with the least interpolates closest.
fn information(parts: &[Part]) -> f64 {
    let negative_entropy =
        |part: &Part| part.states.iter().map(|(_, p)| if *p > 0.0 { p * p.ln() } else { 0.0 }).sum::<f64>();
    parts.iter().map(|part| part.weight * negative_entropy(part)).sum()
}

/// The grids of all sets of `size` states.
#[derive(Debug, Clone)]
pub(crate) struct Faces {
    states: usize,
    size: usize,
    /// In the order of their ranks; the states of each ascend.
    members: Vec<Vec<usize>>,
    /// The same grid for each of them.
    grid: SimplexGrid,
    corner_points: Vec<Vec<f64>>,
    binomials: Vec<Vec<usize>>,
}

impl Faces {
    /// Sets of at most `size` states; a grid of all of them has a point at `arrival`.
    pub(crate) fn new(arrival: &[f64], size: usize, intervals: usize, grading: f64) -> Self {
        let states = arrival.len();
        let size = size.min(states);
        let anchor = if size == states { arrival.to_vec() } else { vec![1.0 / size as f64; size] };
        let grid = SimplexGrid::new(&anchor, intervals, grading);
        let corner_points = grid.points();
        Self {
            states,
            size,
            members: subsets(states, size),
            grid,
            corner_points,
            binomials: (0..=states).map(|n| binomials(n, size)).collect(),
        }
    }

    /// States of a face, and intervals of its grid.
    pub(crate) fn resolution(&self) -> (usize, usize) {
        (self.size, self.grid.intervals())
    }

    /// Number of points of all faces.
    pub(crate) fn len(&self) -> usize {
        self.members.len() * self.corner_points.len()
    }

    /// Whether the only face is the whole simplex.
    pub(crate) fn are_whole(&self) -> bool {
        self.size == self.states
    }

    /// The belief at a point.
    pub(crate) fn belief(&self, point: usize) -> Vec<f64> {
        let per_face = self.corner_points.len();
        let mut belief = vec![0.0; self.states];
        for (state, b) in self.members[point / per_face].iter().zip(&self.corner_points[point % per_face]) {
            belief[*state] = *b;
        }
        belief
    }

    /// A belief as a combination of points, weighted by `weight` and put behind what is there.
    pub(crate) fn locate(&self, belief: &[f64], weight: f64, found: &mut Combination) {
        if self.are_whole() {
            return self.locate_on_face(0, belief, weight, found);
        }
        let mut order: Vec<usize> = (0..self.states).collect();
        order.sort_by(|a, b| belief[*b].total_cmp(&belief[*a]));
        if belief[order[self.size]] <= 0.0 {
            let states = order[..self.size].iter().map(|state| (*state, belief[*state])).collect();
            return self.locate_part(Part { weight, states }, found);
        }
        let parts = (0..self.size).map(|heads| self.parts(belief, &order, heads));
        let closest = parts.min_by(|a, b| information(a).total_cmp(&information(b))).unwrap_or_default();
        for mut part in closest {
            part.weight *= weight;
            self.locate_part(part, found);
        }
    }

    /// Split by groups of the less likely states. The more likely ones, the heads, keep their probabilities in every
    /// part.
    fn parts(&self, belief: &[f64], order: &[usize], heads: usize) -> Vec<Part> {
        let (heads, others) = order.split_at(heads);
        let mass = |states: &[usize]| states.iter().map(|state| belief[*state]).sum::<f64>();
        let rest = mass(others);
        let part = |group: &[usize]| {
            let weight = mass(group) / rest;
            let likely = heads.iter().map(|state| (*state, belief[*state]));
            let grouped = group.iter().map(|state| (*state, belief[*state] / weight));
            Part { weight, states: likely.chain(grouped).collect() }
        };
        let groups = others.chunks(self.size - heads.len());
        groups.filter(|group| mass(group) > 0.0).map(part).collect()
    }

    fn locate_part(&self, mut part: Part, found: &mut Combination) {
        let absent = |state: &usize| part.states.iter().all(|(member, _)| member != state);
        let missing = self.size - part.states.len();
        let others: Vec<usize> = (0..self.states).filter(absent).take(missing).collect();
        part.states.extend(others.into_iter().map(|state| (state, 0.0)));
        part.states.sort_unstable_by_key(|(state, _)| *state);
        let (members, belief): (Vec<_>, Vec<_>) = part.states.into_iter().unzip();
        self.locate_on_face(self.rank(&members), &belief, part.weight, found);
    }

    #[allow(clippy::cast_possible_truncation)] // points are far fewer than 2^32
    fn locate_on_face(&self, face: usize, part: &[f64], weight: f64, found: &mut Combination) {
        let first = (face * self.corner_points.len()) as u32;
        let located = self.grid.locate(part);
        found.extend(located.into_iter().map(|(point, w)| (first + point, weight * w)));
    }

    /// Colexicographic rank of a set of states in ascending order.
    fn rank(&self, members: &[usize]) -> usize {
        members.iter().enumerate().map(|(i, state)| self.binomials[*state][i + 1]).sum()
    }
}

/// All sets of `size` of `states` states in colexicographic order.
fn subsets(states: usize, size: usize) -> Vec<Vec<usize>> {
    if size == 0 {
        return vec![Vec::new()];
    }
    let with_last = |last: usize| {
        subsets(last, size - 1).into_iter().map(move |mut set| {
            set.push(last);
            set
        })
    };
    (size - 1..states).flat_map(with_last).collect()
}

/// `n` over 0 to `most`.
fn binomials(n: usize, most: usize) -> Vec<usize> {
    let mut row = vec![1];
    for k in 0..most {
        row.push(row[k] * n.saturating_sub(k) / (k + 1));
    }
    row
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::testing::seeded;

    proptest! {
        #![proptest_config(seeded(64))]

        #[test]
        fn a_combination_averages_to_its_belief(
            weights in prop::collection::vec(prop_oneof![Just(0.0), 0.01..1.0_f64], 2..7),
            size in 2..5_usize,
        ) {
            let sum: f64 = weights.iter().sum();
            prop_assume!(sum > 0.0);
            let belief: Vec<f64> = weights.iter().map(|w| w / sum).collect();
            let faces = Faces::new(&vec![1.0 / belief.len() as f64; belief.len()], size, 5, 0.6);
            let mut found = Combination::new();
            faces.locate(&belief, 1.0, &mut found);
            let mut average = vec![0.0; belief.len()];
            for (point, weight) in &found {
                prop_assert!(*weight >= 0.0);
                for (sum, b) in average.iter_mut().zip(faces.belief(*point as usize)) {
                    *sum += weight * b;
                }
            }
            for (a, b) in average.iter().zip(&belief) {
                prop_assert!((a - b).abs() < 1e-12, "{average:?} instead of {belief:?}");
            }
        }
    }

    #[test]
    fn sets_are_in_the_order_of_their_ranks() {
        let faces = Faces::new(&[1.0 / 6.0; 6], 3, 3, 0.0);
        assert_eq!(faces.members.len(), 20);
        for (rank, members) in faces.members.iter().enumerate() {
            assert_eq!(faces.rank(members), rank);
        }
    }
}
