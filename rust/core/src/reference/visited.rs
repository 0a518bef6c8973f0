//! The beliefs that a policy visits.

use rand::RngExt;

use crate::belief::Belief;
use crate::model::{Action, SortingModel};
use crate::sampling::{Purpose, invert, label, stream};

/// Planner steps of one walk.
const STEPS: usize = 40;
/// Walks per wanted belief, at most: a policy may visit fewer beliefs than are wanted.
const WALKS_PER_BELIEF: usize = 5;
/// Beliefs nearer than this (largest difference of two probabilities) count as one.
const SAME: f64 = 0.005;

/// Up to `count` different beliefs on random walks of a policy, the arrival prior first. Deterministic.
pub(super) fn visited_beliefs(
    model: &SortingModel,
    count: usize,
    policy: impl Fn(&[f64]) -> Action,
) -> Vec<Vec<f64>> {
    let mut beliefs = vec![Belief::new(model).as_slice().to_vec()];
    for walk in 0..count * WALKS_PER_BELIEF {
        for belief in walked(model, walk as u64, &policy) {
            if beliefs.len() >= count {
                return beliefs;
            }
            if !beliefs.iter().any(|known| near(known, &belief)) {
                beliefs.push(belief);
            }
        }
    }
    beliefs
}

fn walked(model: &SortingModel, walk: u64, policy: impl Fn(&[f64]) -> Action) -> Vec<Vec<f64>> {
    let mut rng = stream(0, Purpose::Walk, walk);
    let mut belief = Belief::new(model);
    let arriving = |u: f64| invert(model.arrival().iter(), u);
    let mut classes: Vec<usize> = (0..model.position_count()).map(|_| arriving(rng.random())).collect();
    let mut beliefs = Vec::new();
    for _ in 0..STEPS {
        match policy(belief.as_slice()) {
            Action::Decide(_) => {
                classes.remove(0);
                classes.push(arriving(rng.random()));
                belief.advance(model);
            }
            Action::Move(to) => {
                let mut seen =
                    |(j, class): (usize, &usize)| Some(label(model, j, to, None, *class, rng.random()));
                let labels: Vec<_> = classes.iter().enumerate().map(&mut seen).collect();
                if belief.observe(model, to, &labels).is_err() {
                    return beliefs;
                }
            }
        }
        beliefs.push(belief.as_slice().to_vec());
    }
    beliefs
}

fn near(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(x, y)| (x - y).abs() < SAME)
}
