//! The problems of single objects under prices: each decides for itself what camera and belt do, and pays for it.
//!
//! An object passes from the position farthest from the belt end to the belt end, is decided, and the next one takes
//! its place: one process with positions and modes that are known, and a belief that is not. Values on points are
//! found by modified policy iteration (Puterman & Shin 1978) and proved as in [`super::super::value_iteration`]: if one
//! more backup raises no value by more than m, which may be negative, values raised by m / (1 - discount) are upper bounds.

use rayon::prelude::*;

use super::points::{ARRIVAL, Points};
use super::shared::{Choice, Mode, Shared};
use crate::index::Position;

/// What each position is paid for each choice: `prices[position][choice]`. Those of all positions add up to what the
/// choice earns.
pub(super) type Prices = Vec<Vec<f64>>;

/// A value per point, of each mode and position.
#[derive(Debug, Clone)]
pub(super) struct Values {
    positions: usize,
    tables: Vec<Vec<f64>>,
}

impl Values {
    pub(super) fn of(&self, mode: Mode, position: Position) -> &[f64] {
        &self.tables[mode * self.positions + position.0]
    }

    /// The value that a combination of points has.
    pub(super) fn average(&self, mode: Mode, position: Position, combination: &[(u32, f64)]) -> f64 {
        let values = self.of(mode, position);
        combination.iter().map(|(point, weight)| weight * values[*point as usize]).sum()
    }

    /// Values from their tables, if these are as many as the points.
    pub(super) fn restored(points: &Points, modes: usize, tables: Vec<Vec<f64>>) -> Option<Self> {
        let positions = points.object.positions();
        let fits =
            |(index, table): (usize, &Vec<f64>)| table.len() == points.len(Position(index % positions));
        (tables.len() == modes * positions && tables.iter().enumerate().all(fits))
            .then_some(Self { positions, tables })
    }

    /// A table per mode and position.
    pub(super) fn tables(&self) -> &[Vec<f64>] {
        &self.tables
    }

    fn raise(&mut self, by: f64) {
        self.tables.par_iter_mut().for_each(|table| table.iter_mut().for_each(|value| *value += by));
    }
}

/// The choice taken at each point, of each mode and position.
pub(super) type Policy = Vec<Vec<Choice>>;

/// Sweeps under a fixed policy between two that improve it.
const EVALUATIONS: usize = 12;
/// Most improvements of a policy.
const MOST_IMPROVEMENTS: usize = 60;

/// Least and largest rise of a value in a sweep.
type Range = (f64, f64);

const NO_RISE: Range = (f64::INFINITY, f64::NEG_INFINITY);

fn joined(a: Range, b: Range) -> Range {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Everything that the values depend on.
#[derive(Clone, Copy)]
pub(super) struct Problem<'a> {
    pub points: &'a Points,
    pub shared: &'a Shared,
    pub prices: &'a Prices,
}

impl Problem<'_> {
    fn discount(&self) -> f64 {
        self.points.object.discount
    }

    fn positions(&self) -> usize {
        self.points.object.positions()
    }

    /// The same value everywhere.
    pub(super) fn constant(&self, value: f64) -> Values {
        let positions = self.positions();
        let table = |index: usize| vec![value; self.points.len(Position(index % positions))];
        Values { positions, tables: (0..self.shared.modes.len() * positions).map(table).collect() }
    }

    /// Values that others interpolate to: no tighter, but near those sought.
    pub(super) fn interpolated(&self, points: &Points, values: &Values) -> Values {
        let mut fine = self.constant(0.0);
        for position in (0..self.positions()).map(Position) {
            let located = |point| points.locate(position, &self.points.belief(position, point));
            let located: Vec<_> = (0..self.points.len(position)).into_par_iter().map(located).collect();
            for mode in 0..self.shared.modes.len() {
                let average = |row: &Vec<(u32, f64)>| values.average(mode, position, row);
                fine.tables[mode * self.positions() + position.0] = located.iter().map(average).collect();
            }
        }
        fine
    }

    /// Value of a choice at a point.
    #[inline(always)]
    fn worth(
        &self,
        values: &Values,
        (mode, position): (Mode, Position),
        choice: Choice,
        point: usize,
    ) -> f64 {
        let moves = &self.shared.modes[mode];
        let price = self.prices[position.0][choice];
        let next = match moves.looks.get(choice - moves.first_choice) {
            Some(look) => {
                self.points.look(position, look.viewpoint).average(point, values.of(look.next, position))
            }
            None if position.0 > 0 => {
                let values = values.of(moves.after_advance, Position(position.0 - 1));
                self.points.shift(position).average(point, values)
            }
            None => {
                let arrived = values.of(moves.after_advance, Position(self.positions() - 1));
                return price
                    + self.points.reward(point)
                    + self.discount() * arrived[self.points.node(ARRIVAL)];
            }
        };
        price + self.discount() * next
    }

    fn best(&self, values: &Values, place: (Mode, Position), point: usize) -> (Choice, f64) {
        let moves = &self.shared.modes[place.0];
        let advance = moves.advance();
        let mut best = (advance, self.worth(values, place, advance, point));
        for choice in moves.first_choice..advance {
            let value = self.worth(values, place, choice, point);
            if value > best.1 {
                best = (choice, value);
            }
        }
        best
    }

    fn places(&self) -> impl Iterator<Item = (Mode, Position)> + use<> {
        let (modes, positions) = (self.shared.modes.len(), self.positions());
        (0..modes).flat_map(move |mode| (0..positions).map(move |position| (mode, Position(position))))
    }

    /// One sweep of value iteration; the policy is what is best.
    fn improve(&self, values: &mut Values, policy: &mut Policy) -> Range {
        let best = |place: (Mode, Position)| -> Vec<_> {
            let points = (0..self.points.len(place.1)).into_par_iter().with_min_len(64);
            points.map(|point| self.best(values, place, point)).collect()
        };
        let best: Vec<_> = self.places().map(best).collect();
        let mut range = NO_RISE;
        for ((best, policy), table) in best.into_iter().zip(policy).zip(&mut values.tables) {
            for ((choice, value), (chosen, old)) in best.into_iter().zip(policy.iter_mut().zip(table)) {
                range = joined(range, (value - *old, value - *old));
                (*chosen, *old) = (choice, value);
            }
        }
        range
    }

    /// One sweep under a fixed policy.
    fn evaluate(&self, values: &mut Values, policy: &Policy) -> Range {
        let evaluated = |(place, policy): ((Mode, Position), &Vec<Choice>)| -> Vec<f64> {
            let points = policy.par_iter().with_min_len(256).enumerate();
            points.map(|(point, choice)| self.worth(values, place, *choice, point)).collect()
        };
        let new: Vec<_> = self.places().zip(policy).map(evaluated).collect();
        let rise = |range, (new, old): (&f64, &f64)| joined(range, (new - old, new - old));
        let range = new.iter().flatten().zip(values.tables.iter().flatten()).fold(NO_RISE, rise);
        values.tables = new;
        range
    }

    /// Jump to where a constant rise in every sweep would lead (`MacQueen`'s extrapolation).
    fn extrapolate(&self, values: &mut Values, (least, most): Range) {
        values.raise(self.discount() / (1.0 - self.discount()) * 0.5 * (least + most));
    }

    /// Improve values until their differences have settled to `tolerance`, or it is time to stop; the policy they ask for.
    pub(super) fn iterate(&self, values: &mut Values, tolerance: f64, stop: impl Fn() -> bool) -> Policy {
        let settled = tolerance * (1.0 - self.discount());
        let mut policy: Policy = values.tables.iter().map(|table| vec![0; table.len()]).collect();
        for _ in 0..MOST_IMPROVEMENTS {
            let range = self.improve(values, &mut policy);
            if range.1 - range.0 < settled || stop() {
                break;
            }
            self.extrapolate(values, range);
            for _ in 0..EVALUATIONS {
                let range = self.evaluate(values, &policy);
                self.extrapolate(values, range);
                if range.1 - range.0 < 0.3 * settled {
                    break;
                }
            }
        }
        policy
    }

    /// Raise, or lower, all values until they are proved.
    pub(super) fn certify(&self, values: &mut Values) {
        let rise = |place: (Mode, Position)| {
            let old = values.of(place.0, place.1);
            let rise = |point| self.best(values, place, point).1 - old[point];
            (0..old.len()).into_par_iter().map(rise).reduce(|| f64::NEG_INFINITY, f64::max)
        };
        let largest = self.places().map(rise).fold(f64::NEG_INFINITY, f64::max);
        values.raise(largest / (1.0 - self.discount()));
    }

    /// By how much interpolation at a belief exceeds what is found one step ahead.
    pub(super) fn interpolation_excess(
        &self,
        values: &Values,
        (mode, position): (Mode, Position),
        belief: &[f64],
    ) -> f64 {
        let (points, moves) = (self.points, &self.shared.modes[mode]);
        let worth =
            |mode, position, belief: &[f64]| values.average(mode, position, &points.locate(position, belief));
        let advanced = match position {
            Position(0) => {
                let arrived = values.of(moves.after_advance, Position(self.positions() - 1));
                points.object.reward(belief) + self.discount() * arrived[points.node(ARRIVAL)]
            }
            _ => self.discount() * worth(moves.after_advance, Position(position.0 - 1), belief),
        };
        let mut best = self.prices[position.0][moves.advance()] + advanced;
        for (look, price) in moves.looks.iter().zip(&self.prices[position.0][moves.first_choice..]) {
            let labels = points.object.look(position, look.viewpoint, belief);
            let expected: f64 = labels.map(|(p, posterior)| p * worth(look.next, position, &posterior)).sum();
            best = best.max(price + self.discount() * expected);
        }
        worth(mode, position, belief) - best
    }

    /// Value of unseen objects at all positions: what prices are to minimise.
    pub(super) fn objective(&self, values: &Values, mode: Mode) -> f64 {
        let arrival = self.points.node(ARRIVAL);
        (0..self.positions()).map(Position).map(|position| values.of(mode, position)[arrival]).sum()
    }
}
