//! What the default policy is expected to fall short of the optimum by.
//!
//! If `V* = l + s` with the same s at every belief, one backup of l gains `(1 - discount) s`. So the mean gain of
//! one backup, at beliefs that acting on it visits, estimates s. It makes values at different depths comparable.

use rand::RngExt;

use super::branch::Scan;
use crate::belief::{Memory, condition, most_likely, shift};
use crate::bounds::{self, Look};
use crate::model::{Action, SortingModel};
use crate::one_object::OneObjectPolicy;
use crate::sampling::{Purpose, invert, stream};

/// Entries of all looks together; more beliefs tell little more.
const WORK: usize = 100_000;
const BELIEFS: std::ops::Range<usize> = 50..1000;

/// The expected shortfall, never negative.
pub(super) fn expected(model: &SortingModel, policy: &OneObjectPolicy) -> f64 {
    let look = model.viewpoint_count() * model.position_count() * model.class_count();
    let beliefs = (WORK / look).clamp(BELIEFS.start, BELIEFS.end);
    let mut rng = stream(0, Purpose::Walk, u64::from(u32::MAX));
    let (mut belief, mut memory) =
        (model.arrival().as_slice().repeat(model.position_count()), Memory::new(model));
    let (mut viewpoint, mut gained) = (0, 0.0);
    let mut looks: Vec<Look> = (0..model.viewpoint_count()).map(|_| Look::default()).collect();
    for _ in 0..beliefs {
        let (action, value) = best_step(model, policy, (&belief, &memory), viewpoint, &mut looks);
        gained += value - bounds::lower(model, policy, &belief, viewpoint);
        match action {
            Action::Decide(_) => shift(model, &mut belief, &mut memory),
            Action::Move(to) => {
                viewpoint = to;
                for j in 0..model.position_count() {
                    let label = invert(looks[to].probabilities_of(j).iter().copied(), rng.random::<f64>());
                    condition(model, &mut belief, &mut memory, (j, to, label));
                }
            }
        }
    }
    (gained / beliefs as f64 / (1.0 - model.discount())).max(0.0)
}

/// The best action one step ahead of the default policy, and its value.
fn best_step(
    model: &SortingModel,
    policy: &OneObjectPolicy,
    (belief, memory): (&[f64], &Memory),
    viewpoint: usize,
    looks: &mut [Look],
) -> (Action, f64) {
    let (label, p_right) = most_likely(&belief[..model.class_count()]);
    let advanced = [&belief[model.class_count()..], model.arrival().as_slice()].concat();
    let next = bounds::lower(model, policy, &advanced, viewpoint);
    let mut best = (Action::Decide(label), model.decision_reward(p_right) + model.discount() * next);
    for &to in model.legal_moves(viewpoint) {
        looks[to].take(model, policy, belief, memory, to);
        let bonus = Scan { depth: 0, decisions: 0, viewpoint: to }.bonus(model, belief, memory);
        let value = bonus - model.motion_cost(viewpoint, to) + model.discount() * looks[to].value();
        if value > best.1 {
            best = (Action::Move(to), value);
        }
    }
    best
}
