//! What the default policy is expected to fall short of the optimum by.
//!
//! `V* = l + s`, l the default policy's value; s is taken as linear in l, in how far a certified upper bound lies above l,
//! and in the entropy that is left where learning is rewarded (the default policy's value leaves the bonus aside). It is
//! fitted such that `l + s` is on average what one backup makes of it (fitted value iteration: Gordon, ICML 1995), at
//! beliefs such as searches meet. So values at different depths can be compared: looking deeper changes them only where
//! it finds something.
//!
//! Most of s is the same everywhere, which is of no consequence on an endless belt. Where the belt ends it would be:
//! what can still be gained falls with the objects left, and putting off a decision would seem to pay. There l is the
//! better estimate; only what is left to learn still counts where learning is rewarded.

use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{Matrix4, Vector4};
use rand::RngExt;

use super::outcomes::ScanOutcomes;
use super::tree::first_best;
use crate::belief::{Belief, class_entropy};
use crate::bounds;
use crate::index::{Label, Position, Viewpoint};
use crate::model::{Action, SortingModel};
use crate::offline::Certificate;
use crate::one_object::OneObjectPolicy;
use crate::remaining::Remaining;
use crate::sampling::{Purpose, invert, stream};

/// Beliefs of the walk: as many as this work allows, counted in entries of looks.
const WORK: usize = 100_000;
const BELIEFS: std::ops::Range<usize> = 500..2000;

/// Probability that the walk takes a random action instead of the best one.
const EXPLORATION: f64 = 0.5;
/// Iterations of fitted value iteration; the discount leaves nothing of the start value after so many.
const ITERATIONS: usize = 300;

/// Regularisation of the least-squares fit, for features that are constant over all beliefs; far below any sum of squares.
const RIDGE: f64 = 1e-9;

/// What the estimate at a set of beliefs is a function of, each belief counted with its weight.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Features {
    /// Sum of the weights.
    pub mass: f64,
    /// The default policy's value.
    pub value: f64,
    /// What is left to learn: see [`left_to_learn`].
    pub entropy: f64,
    /// How far the certificate lies above the default policy's value; 0 without one.
    pub bound: f64,
}

impl Features {
    fn vector(self) -> Vector4<f64> {
        Vector4::new(self.mass, self.value, self.entropy, self.bound)
    }
}

/// Entropy of all positions where learning is rewarded; 0 elsewhere.
pub(super) fn left_to_learn(model: &SortingModel, belief: &Belief) -> f64 {
    if model.spec().information_gain > 0.0 {
        let kinds = belief.as_slice().chunks_exact(model.kind_count());
        return kinds.map(|kinds| class_entropy(model, kinds)).sum();
    }
    0.0
}

/// Coefficients of the features.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shortfall(Vector4<f64>);

impl Shortfall {
    /// Shortfall of the default policy, never negative.
    pub(super) fn at(self, features: Features, remaining: Remaining) -> f64 {
        let Features { mass, value, entropy, bound } = features;
        let of_value =
            if remaining.ends() { 0.0 } else { self.0[0] * mass + self.0[1] * value + self.0[3] * bound };
        (of_value + self.0[2] * entropy).max(0.0)
    }

    /// Fit to a model, at the beliefs met before `stop` is set. Deterministic if it is not.
    pub(super) fn fitted(
        model: &SortingModel,
        policy: &OneObjectPolicy,
        certificate: Option<&Certificate>,
        stop: &AtomicBool,
    ) -> Self {
        let visits = walk((model, certificate), policy, stop);
        let mut fit = Self(Vector4::zeros());
        for _ in 0..ITERATIONS {
            let Some(next) = fit.backed_up(model.discount(), &visits) else { break };
            fit = next;
        }
        fit
    }

    /// The closest fit to what one backup makes of this one.
    fn backed_up(self, discount: f64, visits: &[Visit]) -> Option<Self> {
        let (mut system, mut target) = (Matrix4::identity() * RIDGE, Vector4::zeros());
        for visit in visits {
            let features = visit.here.vector();
            let value = |(reward, next): &(f64, Features)| {
                reward + discount * (next.value + self.at(*next, Remaining::ENDLESS))
            };
            let best = visit.actions.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
            system += features * features.transpose();
            target += features * (best - visit.here.value);
        }
        system.lu().solve(&target).filter(|fit| fit.iter().all(|x| x.is_finite())).map(Self)
    }
}

/// A model, and its certificate if there is one.
type Bounded<'a> = (&'a SortingModel, Option<&'a Certificate>);

/// A belief of the walk; and of each action the reward, and the features after it.
struct Visit {
    here: Features,
    actions: Vec<(f64, Features)>,
}

/// Beliefs along a walk that takes the action with the highest value, or now and then a random one, as searches do.
fn walk((model, certificate): Bounded<'_>, policy: &OneObjectPolicy, stop: &AtomicBool) -> Vec<Visit> {
    let entries = model.viewpoint_count() * model.position_count() * model.label_count();
    let length = (WORK / entries).clamp(BELIEFS.start, BELIEFS.end);
    let mut rng = stream(0, Purpose::Walk, u64::from(u32::MAX));
    let (mut belief, mut viewpoint) = (Belief::new(model), Viewpoint(0));
    let mut visits = Vec::with_capacity(length);
    for _ in 0..length {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let steps = steps((model, certificate), policy, &belief, viewpoint);
        let worth = |step: &Step| step.reward + model.discount() * step.next.value;
        let chosen = if rng.random::<f64>() < EXPLORATION {
            rng.random_range(0..steps.len())
        } else {
            first_best(&steps, worth)
        };
        let here = features((model, certificate), policy, &belief, viewpoint);
        visits.push(Visit { here, actions: steps.iter().map(|step| (step.reward, step.next)).collect() });
        let Some(Step { belief: before_scan, viewpoint: stands, scan, .. }) = steps.into_iter().nth(chosen)
        else {
            break;
        };
        (belief, viewpoint) = (before_scan, stands);
        for (scan, position) in scan.iter().flat_map(|scan| model.positions().map(move |j| (scan, j))) {
            let label = Label(invert(scan.probabilities(position), rng.random::<f64>()));
            // It was drawn, so it is possible.
            let _ = belief.observe_one(model, position, viewpoint, label);
        }
    }
    visits
}

/// What an action at a belief leads to.
struct Step {
    reward: f64,
    /// Expected features after it.
    next: Features,
    /// The belief before the scan, if any.
    belief: Belief,
    viewpoint: Viewpoint,
    scan: Option<ScanOutcomes>,
}

/// The best decision, then the legal moves.
fn steps(
    (model, certificate): Bounded<'_>,
    policy: &OneObjectPolicy,
    from: &Belief,
    viewpoint: Viewpoint,
) -> Vec<Step> {
    let step = |action| {
        let step = model.step(action, viewpoint, from.objects_left());
        let reward = model.expected_reward(&step, from.position(Position(0)).as_slice());
        let (mut belief, viewpoint) = (from.clone(), step.viewpoint);
        if step.advances() {
            belief.advance(model);
        }
        let Some(scanned) = step.scan else {
            let next = features((model, certificate), policy, &belief, viewpoint);
            return Step { reward, next, belief, viewpoint, scan: None };
        };
        let scan = ScanOutcomes::new(model, policy, &belief, scanned);
        let value = scan.expected_value();
        let upper =
            certificate.map_or(value, |bound| bound.after_scan(model, &belief, scanned).expected_upper());
        let next = Features { mass: 1.0, value, entropy: scan.expected_entropy(), bound: upper - value };
        Step { reward: reward + scan.bonus, next, belief, viewpoint, scan: Some(scan) }
    };
    let decide = Action::Decide(from.best_decision(model).0);
    let moves = model.legal_moves(viewpoint).iter().map(|to| Action::Move(*to));
    std::iter::once(decide).chain(moves).map(step).collect()
}

fn features(
    (model, certificate): Bounded<'_>,
    policy: &OneObjectPolicy,
    belief: &Belief,
    viewpoint: Viewpoint,
) -> Features {
    let value = bounds::lower(model, policy, belief.known(), viewpoint);
    let upper = certificate.map_or(value, |bound| bound.value(model, belief.as_slice(), viewpoint));
    Features { mass: 1.0, value, entropy: left_to_learn(model, belief), bound: upper - value }
}
