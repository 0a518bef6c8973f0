//! The best of many policies at each of very many beliefs, nearly: only those that are good at the centre of a
//! belief's neighbourhood are compared. Whichever is chosen, its value is a lower bound.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::alpha::{AlphaVectors, joint};
use crate::model::SortingModel;

/// Neighbourhoods are cells of this many intervals along the fourth root of every probability.
const INTERVALS: f64 = 8.0;
/// Policies that are compared in a neighbourhood.
const SHORTLIST: usize = 32;

/// Neighbourhoods whose centres are valued at once.
const BATCH: usize = 32;

/// Number of a good policy for each belief, one distribution per position.
pub(super) fn good_policies(
    model: &SortingModel,
    alphas: &AlphaVectors,
    beliefs: impl Fn(usize) -> Vec<f64> + Sync,
    count: usize,
) -> Vec<usize> {
    let neighbourhoods = neighbourhoods(&beliefs, count);
    let centre =
        |members: &Vec<usize>| members.iter().map(|i| joint(model, &beliefs(*i))).sum::<DVector<f64>>();
    let chosen: Vec<_> = neighbourhoods
        .par_chunks(BATCH)
        .flat_map_iter(|batch| {
            let worth = &alphas.0 * DMatrix::from_columns(&batch.iter().map(centre).collect::<Vec<_>>());
            let shortlists =
                worth.column_iter().map(|column| shortlist(column.as_slice())).collect::<Vec<_>>();
            let best = |members: &Vec<usize>, shortlist: Vec<usize>| {
                let compared = alphas.0.select_rows(&shortlist);
                let best = |i: &usize| (*i, shortlist[(&compared * joint(model, &beliefs(*i))).imax()]);
                members.iter().map(best).collect::<Vec<_>>()
            };
            batch.iter().zip(shortlists).flat_map(|(members, list)| best(members, list)).collect::<Vec<_>>()
        })
        .collect();
    let mut by_belief = vec![0; count];
    for (belief, policy) in chosen {
        by_belief[belief] = policy;
    }
    by_belief
}

fn neighbourhoods(beliefs: impl Fn(usize) -> Vec<f64> + Sync, count: usize) -> Vec<Vec<usize>> {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most INTERVALS
    let cell = |b: &f64| (b.powf(0.25) * INTERVALS).round() as u8;
    let keys: Vec<Box<[u8]>> =
        (0..count).into_par_iter().map(|i| beliefs(i).iter().map(cell).collect()).collect();
    let mut numbers = HashMap::new();
    let mut members: Vec<Vec<usize>> = Vec::new();
    for (i, key) in keys.iter().enumerate() {
        let number = *numbers.entry(key).or_insert(members.len());
        if number == members.len() {
            members.push(Vec::new());
        }
        members[number].push(i);
    }
    members
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
