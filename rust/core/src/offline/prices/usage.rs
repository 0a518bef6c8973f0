//! How often the objects of each position want each choice: the subgradient of what prices are to minimise.

use super::points::ARRIVAL;
use super::problem::{Policy, Problem};
use super::shared::{Choice, Mode};
use crate::index::Position;

/// Sweeps from the last occupancy, and when they may end.
const MOST_SWEEPS: usize = 300;
const TOLERANCE: f64 = 1e-4;

/// Expected discounted number of visits of each point, of each mode and position, summed over the objects that start.
#[derive(Debug, Clone)]
pub(super) struct Occupancy(pub Vec<Vec<f64>>);

impl Occupancy {
    pub(super) fn none(problem: &Problem<'_>) -> Self {
        let positions = problem.points.object.positions();
        let places = 0..problem.shared.modes.len() * positions;
        Self(places.map(|index| vec![0.0; problem.points.len(Position(index % positions))]).collect())
    }

    /// Renew the occupancy: that of a policy from unseen objects at all positions.
    pub(super) fn renew(&mut self, problem: &Problem<'_>, policy: &Policy, start: Mode) {
        let positions = problem.points.object.positions();
        let mass = positions as f64 / (1.0 - problem.points.object.discount);
        for _ in 0..MOST_SWEEPS {
            let mut next = self.followed(problem, policy, start);
            let total: f64 = next.0.iter().flatten().sum();
            next.0.iter_mut().flatten().for_each(|visits| *visits *= mass / total);
            let pairs = next.0.iter().flatten().zip(self.0.iter().flatten());
            let change: f64 = pairs.map(|(a, b)| (a - b).abs()).sum();
            *self = next;
            if change < TOLERANCE * mass {
                break;
            }
        }
    }

    /// One step of all visits, and those that start.
    fn followed(&self, problem: &Problem<'_>, policy: &Policy, start: Mode) -> Self {
        let (points, positions) = (problem.points, problem.points.object.positions());
        let discount = points.object.discount;
        let arrival = points.node(ARRIVAL);
        let mut next = Self::none(problem);
        for position in 0..positions {
            next.0[start * positions + position][arrival] += 1.0;
        }
        for (index, (visits, policy)) in self.0.iter().zip(policy).enumerate() {
            let (mode, position) = (index / positions, Position(index % positions));
            let moves = &problem.shared.modes[mode];
            for (point, (visits, choice)) in visits.iter().zip(policy).enumerate() {
                if *visits == 0.0 {
                    continue;
                }
                let leaving = discount * visits;
                match moves.looks.get(choice - moves.first_choice) {
                    Some(look) => {
                        let to = &mut next.0[look.next * positions + position.0];
                        let row = points.look(position, look.viewpoint).row(point);
                        row.for_each(|(point, weight)| to[point] += leaving * weight);
                    }
                    None if position.0 > 0 => {
                        let to = &mut next.0[moves.after_advance * positions + position.0 - 1];
                        let row = points.shift(position).row(point);
                        row.for_each(|(point, weight)| to[point] += leaving * weight);
                    }
                    None => next.0[moves.after_advance * positions + positions - 1][arrival] += leaving,
                }
            }
        }
        next
    }

    /// Visits in which each position takes each choice: `[position][choice]`.
    pub(super) fn usage(&self, problem: &Problem<'_>, policy: &Policy) -> Vec<Vec<f64>> {
        let positions = problem.points.object.positions();
        let mut usage = vec![vec![0.0; problem.shared.choices()]; positions];
        for (index, (visits, policy)) in self.0.iter().zip(policy).enumerate() {
            for (visits, choice) in visits.iter().zip(policy) {
                let choice: Choice = *choice;
                usage[index % positions][choice] += visits;
            }
        }
        usage
    }

    /// Beliefs that are no nodes to which objects come from nodes, where they come to, and how often.
    pub(super) fn departures(
        &self,
        problem: &Problem<'_>,
        policy: &Policy,
    ) -> Vec<((Mode, Position), Vec<f64>, f64)> {
        let (points, positions) = (problem.points, problem.points.object.positions());
        let mut found = Vec::new();
        let mut push = |place: (Mode, Position), belief: Vec<f64>, visits: f64| {
            if !points.knows(place.1, &belief) {
                found.push((place, belief, points.object.discount * visits));
            }
        };
        for (index, (visits, policy)) in self.0.iter().zip(policy).enumerate() {
            let (mode, position) = (index / positions, Position(index % positions));
            let moves = &problem.shared.modes[mode];
            for point in points.node(0)..visits.len() {
                if visits[point] <= 0.0 {
                    continue;
                }
                let belief = points.belief(position, point);
                match moves.looks.get(policy[point] - moves.first_choice) {
                    Some(look) => {
                        for (p, posterior) in points.object.look(position, look.viewpoint, &belief) {
                            push((look.next, position), posterior, p * visits[point]);
                        }
                    }
                    None if position.0 > 0 => {
                        push((moves.after_advance, Position(position.0 - 1)), belief, visits[point]);
                    }
                    None => (),
                }
            }
        }
        found
    }
}
