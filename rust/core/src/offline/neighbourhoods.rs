//! The best of many policies at each of very many beliefs, nearly: only those that are good at the centre of a
//! belief's neighbourhood are compared. Whichever is chosen, its value is a lower bound.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector, DVectorView};
use rayon::prelude::*;

use super::alpha::joint;
use crate::model::SortingModel;

/// Neighbourhoods are cells of this many intervals along the fourth root of every probability.
const INTERVALS: f64 = 8.0;
/// Policies that are compared in a neighbourhood.
const SHORTLIST: usize = 32;
/// Policies that begin in a neighbourhood and are compared there, too.
const NEARBY: usize = 64;

/// Neighbourhoods whose centres are valued at once.
const BATCH: usize = 32;

/// Policies by number, each with its value by joint kind.
pub(super) struct Candidates<'a> {
    /// A row of joint kinds per policy.
    pub values: &'a [f64],
    pub states: usize,
    /// Those to compare in every neighbourhood.
    pub anywhere: Vec<usize>,
    /// The first so many are compared where they begin, too.
    pub nearby: usize,
}

impl Candidates<'_> {
    fn row(&self, policy: usize) -> &[f64] {
        &self.values[policy * self.states..][..self.states]
    }

    fn matrix(&self, policies: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(policies.len(), self.states, |i, state| self.row(policies[i])[state])
    }
}

/// Number of a good policy for each of `count` beliefs, one distribution per position.
///
/// The candidates near by begin at `beliefs(0..nearby)`; the beliefs to choose for follow.
pub(super) fn good_policies(
    model: &SortingModel,
    candidates: &Candidates<'_>,
    beliefs: impl Fn(usize) -> Vec<f64> + Sync,
    count: usize,
) -> Vec<usize> {
    let first = candidates.nearby;
    let neighbourhoods = neighbourhoods(&beliefs, first, count);
    let centre =
        |n: &Neighbourhood| n.members.iter().map(|i| joint(model, &beliefs(*i))).sum::<DVector<f64>>();
    let anywhere = candidates.matrix(&candidates.anywhere);
    let chosen: Vec<_> = neighbourhoods
        .par_chunks(BATCH)
        .flat_map_iter(|batch| {
            let worth = &anywhere * DMatrix::from_columns(&batch.iter().map(centre).collect::<Vec<_>>());
            let best = |(neighbourhood, worth): (&Neighbourhood, DVectorView<'_, f64>)| {
                let mut compared: Vec<_> =
                    shortlist(worth.as_slice()).into_iter().map(|i| candidates.anywhere[i]).collect();
                compared.extend(&neighbourhood.nearby);
                let values = candidates.matrix(&compared);
                let best = |i: &usize| (*i - first, compared[(&values * joint(model, &beliefs(*i))).imax()]);
                neighbourhood.members.iter().map(best).collect::<Vec<_>>()
            };
            batch.iter().zip(worth.column_iter()).flat_map(best).collect::<Vec<_>>()
        })
        .collect();
    let mut by_belief = vec![0; count];
    for (belief, policy) in chosen {
        by_belief[belief] = policy;
    }
    by_belief
}

/// Beliefs in one cell.
#[derive(Default)]
struct Neighbourhood {
    members: Vec<usize>,
    /// Candidates that begin there, the first [`NEARBY`].
    nearby: Vec<usize>,
}

/// Of `count` beliefs from `first` on; those before are candidates.
fn neighbourhoods(
    beliefs: impl Fn(usize) -> Vec<f64> + Sync,
    first: usize,
    count: usize,
) -> Vec<Neighbourhood> {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most INTERVALS
    let cell = |b: &f64| (b.powf(0.25) * INTERVALS).round() as u8;
    let keys: Vec<Box<[u8]>> =
        (0..first + count).into_par_iter().map(|i| beliefs(i).iter().map(cell).collect()).collect();
    let mut numbers = HashMap::new();
    let mut found: Vec<Neighbourhood> = Vec::new();
    for (i, key) in keys.iter().enumerate().skip(first) {
        let number = *numbers.entry(key).or_insert(found.len());
        if number == found.len() {
            found.push(Neighbourhood::default());
        }
        found[number].members.push(i);
    }
    for (i, key) in keys[..first].iter().enumerate() {
        let neighbourhood = numbers.get(key).map(|number| &mut found[*number]);
        if let Some(n) = neighbourhood.filter(|n| n.nearby.len() < NEARBY) {
            n.nearby.push(i);
        }
    }
    found
}

/// The policies that are worth most.
fn shortlist(worth: &[f64]) -> Vec<usize> {
    let mut policies: Vec<usize> = (0..worth.len()).collect();
    if policies.len() > SHORTLIST {
        policies.select_nth_unstable_by(SHORTLIST, |a, b| worth[*b].total_cmp(&worth[*a]));
        policies.truncate(SHORTLIST);
    }
    policies
}
