//! The belief points of the one-object problem.

use std::sync::atomic::{AtomicBool, Ordering};

use rand::RngExt;

use crate::belief::{condition, evidence};
use crate::index::{Label, Position, Viewpoint};
use crate::model::{Look, SortingModel};
use crate::sampling::{Purpose, invert, stream};

/// Most belief points of point-based value iteration, and the random walks that they are met on.
const POINTS: usize = 1000;
const WALKS: u64 = 2000;
const LOOKS_PER_WALK: usize = 8;
/// Points whose probabilities differ by less than this count as one.
const SAME_POINT: f64 = 2e-3;

/// Beliefs about one object that random looks reach, from each of its positions on the way to the belt end; those
/// met before `stop` is set, the arrival prior at least.
pub(crate) fn reachable_beliefs(model: &SortingModel, stop: &AtomicBool) -> Vec<Vec<f64>> {
    let mut points = vec![model.arrival().as_slice().to_vec()];
    for walk in 0..WALKS {
        let mut rng = stream(0, Purpose::Walk, walk);
        let mut belief = model.arrival().as_slice().to_vec();
        for look in 0..LOOKS_PER_WALK {
            if stop.load(Ordering::Relaxed) {
                return points;
            }
            // Some walks see the object only at the belt end, some also on its way there.
            let on_the_way = model.position_count() > 1 && walk % 2 == 1 && look < LOOKS_PER_WALK / 2;
            let position = if on_the_way { rng.random_range(1..model.position_count()) } else { 0 };
            let viewpoint = Viewpoint(rng.random_range(0..model.viewpoint_count()));
            let look = Look::first(Position(position), viewpoint);
            let predicted = model.labels().map(|z| evidence(&belief, model.likelihoods(look, z)));
            let z = Label(invert(predicted, rng.random::<f64>()));
            condition(&mut belief, model.likelihoods(look, z));
            if points.iter().all(|p| distance(p, &belief) > SAME_POINT) {
                points.push(belief.clone());
            }
        }
        if points.len() >= POINTS {
            break;
        }
    }
    points
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}
