//! V* of tiny models, to a millionth: an oracle for all that is certified.
//!
//! Two classes, one or two positions. The tables are such that every label moves the log-odds of its object by a multiple
//! of one step, so that what can ever be known of an object is where it started from and a whole number: the steps since.
//! Value iteration over these numbers needs no approximation but at their ends. Two relaxations bracket V* there: in
//! one, a look that would lead beyond the end tells nothing about that object; in the other it tells its class. Who
//! ignores a label can do no better, and who is told the class no worse. Both iterations start from values that
//! bound V* trivially, and each sweep keeps that, so the bracket holds whenever the sweeps stop.

use std::borrow::Cow;

use proptest::prelude::*;

use crate::belief::Belief;
use crate::index::{Position, Viewpoint};
use crate::model::{ModelSpec, ScalarOrMatrix, SortingModel};

/// Log-odds, from where an object starts, at which the numbers end.
const FARTHEST: f64 = 16.0;
const MOST_SWEEPS: usize = 700;
/// A bracket wider than this is no oracle.
const WIDEST: f64 = 1e-6;

/// A model of two classes whose labels move the log-odds by multiples of `step`.
#[derive(Debug, Clone)]
pub(crate) struct TinyModel {
    pub model: SortingModel,
    step: f64,
    /// Per position and viewpoint: steps towards class 0 on label 0, and towards class 1 on label 1.
    steps: Vec<Vec<(usize, usize)>>,
}

impl TinyModel {
    /// The tables follow from the steps; everything else is the default.
    pub(crate) fn new(
        step: f64,
        steps: Vec<Vec<(usize, usize)>>,
        change: impl FnOnce(&mut ModelSpec),
    ) -> Self {
        let table = |&(towards_0, towards_1): &(usize, usize)| {
            let (up, down) = ((towards_0 as f64 * step).exp(), (-(towards_1 as f64) * step).exp());
            // P(label 0 | class 1); `up` and `down` are the ratios of the likelihoods of labels 0 and 1.
            let wrong = (1.0 - down) / (up - down);
            vec![vec![up * wrong, 1.0 - up * wrong], vec![wrong, 1.0 - wrong]]
        };
        let p_obs: Vec<Vec<_>> = steps.iter().map(|row| row.iter().map(table).collect()).collect();
        let names = |prefix: &str, n: usize| (0..n).map(|i| format!("{prefix}{i}")).collect();
        let mut spec = ModelSpec::new(names("c", 2), names("p", p_obs[0].len()), p_obs);
        change(&mut spec);
        Self { model: SortingModel::new(spec).expect("a tiny model is a model"), step, steps }
    }

    /// The same model, in which a scan follows each decision or not.
    pub(crate) fn observing(self, after_decision: bool) -> Self {
        let spec = ModelSpec { observe_after_decision: after_decision, ..self.model.spec().clone() };
        Self { model: SortingModel::new(spec).expect("a scan more changes no number"), ..self }
    }
}

/// Random tiny models. In half of them all viewpoints are alike, as the grid of `solve` needs it; some see nearly
/// everything, and in some the arriving objects are nearly all of one class: there bounds are tight that are loose
/// elsewhere.
pub(crate) fn tiny_models(positions: std::ops::RangeInclusive<usize>) -> impl Strategy<Value = TinyModel> {
    let steps = prop::collection::vec(prop::collection::vec((1..=3_usize, 1..=3_usize), 2), 2);
    let step = prop_oneof![3 => 0.5..1.5_f64, 1 => 3.0..5.0_f64];
    let arrival = prop_oneof![2 => 0.2..0.8_f64, 1 => 0.001..0.02_f64];
    let discount = prop_oneof![Just(0.5), Just(0.8), Just(0.95)];
    let numbers = (step, arrival, discount, 5.0..100.0_f64);
    let moves = (prop::collection::vec(0.2..2.0_f64, 4), any::<bool>(), any::<bool>());
    (positions, 1..=2_usize, steps, numbers, moves).prop_map(|(h, k, mut steps, numbers, moves)| {
        let (step, arrival, discount, r_min) = numbers;
        let (costs, alike, restricted) = moves;
        steps.truncate(h);
        for row in &mut steps {
            row.truncate(k);
        }
        TinyModel::new(step, steps, |spec| {
            (spec.r_min, spec.discount) = (r_min, discount);
            spec.arrival = Some(vec![arrival, 1.0 - arrival]);
            if alike || k == 1 {
                spec.motion_cost = ScalarOrMatrix::Scalar(costs[0]);
                return;
            }
            spec.motion_cost = ScalarOrMatrix::Matrix(vec![costs[..2].to_vec(), costs[2..].to_vec()]);
            if restricted {
                spec.travel = Some(vec![vec![1], vec![0, 1]]);
            }
        })
    })
}

/// Beliefs about the objects at two positions, as weights; a third are nearly certain.
pub(crate) fn tiny_beliefs() -> impl Strategy<Value = Vec<f64>> {
    let row = prop_oneof![
        2 => (0.02..1.0_f64, 0.02..1.0_f64),
        1 => (1e-9..1e-4_f64, Just(1.0)),
        1 => (Just(1.0), 1e-9..1e-4_f64),
    ];
    prop::collection::vec(row, 2).prop_map(|rows| rows.into_iter().flat_map(|(a, b)| [a, b]).collect())
}

/// What the numbers end in.
#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    NothingTold,
    ClassTold,
}

/// A value for each viewpoint and what is known of the two objects.
type Values = Vec<Vec<Vec<f64>>>;

/// Brackets of V*.
pub(crate) struct Exact {
    tiny: TinyModel,
    /// Steps to either side; the number n is at place `n + reach`. Two more places are for known classes.
    reach: usize,
    /// Log-odds of an arriving object.
    arrival: f64,
    /// Of unseen objects on an endless belt, for both ends.
    unseen: [Values; 2],
}

const ENDS: [End; 2] = [End::NothingTold, End::ClassTold];

impl Exact {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small whole number
    pub(crate) fn new(tiny: &TinyModel) -> Self {
        let arrival = log_odds(tiny.model.arrival().as_slice());
        let reach = (FARTHEST / tiny.step).ceil() as usize + 3;
        let mut exact = Self { tiny: tiny.clone(), reach, arrival, unseen: [Vec::new(), Vec::new()] };
        exact.unseen = ENDS.map(|end| exact.values(end, [arrival; 2], None));
        exact
    }

    /// Bounds of V* from each viewpoint, less than 1e-6 apart.
    pub(crate) fn bounds(&self, belief: &Belief) -> Vec<(f64, f64)> {
        let two_positions = self.tiny.model.position_count() == 2;
        let first = log_odds(belief.position(Position(0)).as_slice());
        let second =
            if two_positions { log_odds(belief.position(Position(1)).as_slice()) } else { self.arrival };
        let [low, high] = [0, 1].map(|i| {
            let values = match belief.remaining() {
                None => {
                    let after_one = self.values(ENDS[i], [second, self.arrival], Some(&self.unseen[i]));
                    self.values(ENDS[i], [first, second], Some(&after_one))
                }
                Some(objects) => {
                    let start = |object| [first, second].get(object).copied().unwrap_or(self.arrival);
                    let over = self.everywhere(0.0);
                    (0..objects).rev().fold(over, |after, object| {
                        self.values(ENDS[i], [start(object), start(object + 1)], Some(&after))
                    })
                }
            };
            values.into_iter().map(|values| values[self.reach][self.reach])
        });
        let brackets: Vec<_> = low.zip(high).collect();
        let narrow = |(low, high): &(f64, f64)| *low <= high + 1e-9 && high - low < WIDEST;
        assert!(brackets.iter().all(narrow), "no oracle: {brackets:?}");
        brackets
    }

    fn everywhere(&self, value: f64) -> Values {
        let places = 2 * self.reach + 3;
        vec![vec![vec![value; places]; places]; self.tiny.model.viewpoint_count()]
    }

    /// Values while the object that started from log-odds `starts[0]` is at the belt end and the other one behind it;
    /// `after` is what they are once the belt has moved, `None` for the same again.
    fn values(&self, end: End, starts: [f64; 2], after: Option<&Values>) -> Values {
        let spec = self.tiny.model.spec();
        let (arriving, discount) = (self.reach, spec.discount);
        let trivial = if end == End::NothingTold { -spec.r_min } else { spec.r_max };
        let mut values = self.everywhere(trivial / (1.0 - discount));
        for _ in 0..MOST_SWEEPS {
            let scanned = self.scanned(end, starts, &values);
            let decided = after.unwrap_or(&values);
            let decided = if self.tiny.model.observes_after_decision() {
                Cow::Owned(self.scanned(end, [starts[1], self.arrival], decided))
            } else {
                Cow::Borrowed(decided)
            };
            let mut change: f64 = 0.0;
            let mut next = values.clone();
            for v in 0..values.len() {
                for i in 0..values[v].len() {
                    let right = self.probability(starts[0], i);
                    let right = right.max(1.0 - right);
                    let reward = right * spec.r_max - (1.0 - right) * spec.r_min;
                    for j in self.places_behind() {
                        let mut best = reward + discount * decided[v][j][arriving];
                        for &to in self.tiny.model.legal_moves(Viewpoint(v)) {
                            let look = discount * scanned[to.0][i][j]
                                - self.tiny.model.motion_cost(Viewpoint(v), to);
                            best = best.max(look);
                        }
                        change = change.max((best - values[v][i][j]).abs());
                        next[v][i][j] = best;
                    }
                }
            }
            values = next;
            if change < 1e-10 {
                break;
            }
        }
        values
    }

    /// Objects that cannot be seen give no labels.
    fn places_behind(&self) -> std::ops::Range<usize> {
        if self.tiny.model.position_count() == 2 { 0..2 * self.reach + 3 } else { self.reach..self.reach + 1 }
    }

    /// Expectation of the values over the labels of a scan, before it.
    fn scanned(&self, end: End, [here, behind]: [f64; 2], values: &Values) -> Values {
        let mut expected = values.clone();
        for (v, expected) in self.tiny.model.viewpoints().zip(&mut expected) {
            let second: Vec<_> =
                (0..expected.len()).map(|j| self.look(end, Position(1), v, behind, j)).collect();
            for (i, row) in expected.iter_mut().enumerate() {
                let first = self.look(end, Position(0), v, here, i);
                for j in self.places_behind() {
                    row[j] = 0.0;
                    for (p, to_i) in first {
                        for (q, to_j) in second[j] {
                            row[j] += p * q * values[v.0][to_i][to_j];
                        }
                    }
                }
            }
        }
        expected
    }

    /// What a look at one object leads to: two places with their probabilities.
    fn look(
        &self,
        end: End,
        position: Position,
        viewpoint: Viewpoint,
        start: f64,
        place: usize,
    ) -> [(f64, usize); 2] {
        let (last, class_0, class_1) = (2 * self.reach, 2 * self.reach + 1, 2 * self.reach + 2);
        if position.0 >= self.tiny.model.position_count() || place > last {
            return [(1.0, place), (0.0, place)];
        }
        let p = self.probability(start, place);
        let (towards_0, towards_1) = self.tiny.steps[position.0][viewpoint.0];
        if place + towards_0 > last || place < towards_1 {
            return match end {
                End::NothingTold => [(1.0, place), (0.0, place)],
                End::ClassTold => [(p, class_0), (1.0 - p, class_1)],
            };
        }
        let table = &self.tiny.model.spec().p_obs[position.0][viewpoint.0];
        let label_0 = p * table[0][0] + (1.0 - p) * table[1][0];
        [(label_0, place + towards_0), (1.0 - label_0, place - towards_1)]
    }

    /// Probability of class 0.
    fn probability(&self, start: f64, place: usize) -> f64 {
        match place.checked_sub(2 * self.reach) {
            Some(1) => 1.0,
            Some(2) => 0.0,
            _ => 1.0 / (1.0 + (-start - self.tiny.step * (place as f64 - self.reach as f64)).exp()),
        }
    }
}

fn log_odds(belief: &[f64]) -> f64 {
    (belief[0] / belief[1]).ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{belief_of, belts, enumerated_value, seeded};

    proptest! {
        #![proptest_config(seeded(24))]

        #[test]
        fn the_oracle_agrees_with_complete_enumeration(
            tiny in tiny_models(1..=2),
            weights in tiny_beliefs(),
            remaining in belts(),
            observe in any::<bool>(),
        ) {
            let tiny = tiny.observing(observe);
            let belief = belief_of(&tiny.model, &weights).with_remaining(remaining);
            let (low, high) = Exact::new(&tiny).bounds(&belief)[0];
            let (at_least, at_most) = enumerated_value(&tiny.model, &belief, Viewpoint(0), 5);
            prop_assert!(at_least <= high + 1e-9 && low <= at_most + 1e-9, "[{low}, {high}], [{at_least}, {at_most}]");
        }
    }

    /// Found by `solve`, to four digits; the table is 0.8 right.
    #[test]
    fn known_optima_are_found() {
        for (r_min, optimum) in [(50.0, 15.7663), (500.0, 0.6925)] {
            let tiny = TinyModel::new(4_f64.ln(), vec![vec![(1, 1)]], |spec| spec.r_min = r_min);
            let (low, high) = Exact::new(&tiny).bounds(&Belief::new(&tiny.model))[0];
            assert!((low - optimum).abs() < 1e-4 && (high - optimum).abs() < 1e-4, "[{low}, {high}]");
        }
    }

    /// One object and nothing behind it: decide, or look once and then decide, or look on and on.
    #[test]
    fn one_last_object_by_hand() {
        // 0.9 right; a second look that agrees or not is never worth its cost.
        let tiny = TinyModel::new(9_f64.ln(), vec![vec![(1, 1)]], |spec| spec.r_min = 10.0);
        let belief = Belief::new(&tiny.model).with_remaining(Some(1));
        let (low, high) = Exact::new(&tiny).bounds(&belief)[0];
        let by_hand = -1.0 + 0.95 * (0.9 * 10.0 - 0.1 * 10.0);
        assert!((low - by_hand).abs() < 1e-9 && (high - by_hand).abs() < 1e-9, "[{low}, {high}], {by_hand}");
    }
}
