//! What the default policy is expected to fall short of the optimum by.
//!
//! `V* = l + s`, l the default policy's value; s is taken as linear in l, and in the entropy that is left where learning
//! is rewarded (the default policy's value leaves the bonus aside). It is fitted such that `l + s` is on average what
//! one backup makes of it (fitted value iteration: Gordon, ICML 1995), at beliefs such as searches meet. So values at
//! different depths can be compared: looking deeper changes them only where it finds something.
//!
//! Most of s is the same everywhere, which is of no consequence on an endless belt. Where the belt ends it would be:
//! what can still be gained falls with the objects left, and putting off a decision would seem to pay. There l is the
//! better estimate; only what is left to learn still counts where learning is rewarded.

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;

use crate::belief::{Belief, entropy};
use crate::bounds::{self, Foresight, Look};
use crate::index::{Label, Position, Viewpoint};
use crate::model::{Action, SortingModel};
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

/// What a set of beliefs promises, each counted with its weight.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Prospect {
    /// Sum of the weights.
    pub mass: f64,
    /// The default policy's value.
    pub value: f64,
    /// What is left to learn: see [`left_to_learn`].
    pub entropy: f64,
}

impl Prospect {
    fn features(self) -> Vector3<f64> {
        Vector3::new(self.mass, self.value, self.entropy)
    }
}

/// Entropy of all positions, where learning is rewarded; 0 elsewhere.
pub(super) fn left_to_learn<'a>(model: &SortingModel, distributions: impl Iterator<Item = &'a [f64]>) -> f64 {
    if model.spec().information_gain > 0.0 {
        return distributions.map(entropy).sum();
    }
    0.0
}

/// The coefficients of a prospect's features.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shortfall(Vector3<f64>);

impl Shortfall {
    /// Shortfall of the default policy, never negative.
    #[inline(always)]
    pub(super) fn at(self, prospect: Prospect, remaining: Remaining) -> f64 {
        let Prospect { mass, value, entropy } = prospect;
        let of_value = if remaining.ends() { 0.0 } else { self.0[0] * mass + self.0[1] * value };
        (of_value + self.0[2] * entropy).max(0.0)
    }

    /// Fit to a model. Deterministic.
    pub(super) fn fitted(model: &SortingModel, policy: &OneObjectPolicy) -> Self {
        let mut walk = Walk::new(model, policy);
        let visits: Vec<Visit> = (0..walk.length()).map(|_| walk.step()).collect();
        let mut fit = Self(Vector3::zeros());
        for _ in 0..ITERATIONS {
            let Some(next) = fit.backed_up(model.discount(), &visits) else { break };
            fit = next;
        }
        fit
    }

    /// The closest fit to what one backup makes of this one.
    fn backed_up(self, discount: f64, visits: &[Visit]) -> Option<Self> {
        let (mut system, mut target) = (Matrix3::identity() * RIDGE, Vector3::zeros());
        for visit in visits {
            let features = visit.here.features();
            let value = |(reward, next): &(f64, Prospect)| {
                reward + discount * (next.value + self.at(*next, Remaining::ENDLESS))
            };
            let best = visit.actions.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
            system += features * features.transpose();
            target += features * (best - visit.here.value);
        }
        system.lu().solve(&target).filter(|fit| fit.iter().all(|x| x.is_finite())).map(Self)
    }
}

/// What a belief promises; and of each action the reward, and what it promises after it.
struct Visit {
    here: Prospect,
    actions: Vec<(f64, Prospect)>,
}

/// A walk that now and then does not do what seems best, as searches do.
struct Walk<'a> {
    model: &'a SortingModel,
    policy: &'a OneObjectPolicy,
    rng: rand_chacha::ChaCha8Rng,
    belief: Belief,
    viewpoint: Viewpoint,
    /// One per action.
    scans: Vec<Foresight>,
}

impl<'a> Walk<'a> {
    fn new(model: &'a SortingModel, policy: &'a OneObjectPolicy) -> Self {
        Self {
            model,
            policy,
            rng: stream(0, Purpose::Walk, u64::from(u32::MAX)),
            belief: Belief::new(model),
            viewpoint: Viewpoint(0),
            scans: (0..=model.viewpoint_count()).map(|_| Foresight::default()).collect(),
        }
    }

    fn length(&self) -> usize {
        let entries = self.model.viewpoint_count() * self.model.position_count() * self.model.class_count();
        (WORK / entries).clamp(BELIEFS.start, BELIEFS.end)
    }

    /// Note where the walk stands, and go on.
    fn step(&mut self) -> Visit {
        let here = self.prospect(&self.belief);
        let decide = Action::Decide(self.belief.most_likely(Position(0)).0);
        let moves = self.model.legal_moves(self.viewpoint).iter().map(|to| Action::Move(*to));
        let actions: Vec<_> = std::iter::once(decide).chain(moves).collect();
        let promises: Vec<_> =
            actions.iter().enumerate().map(|(index, action)| self.promise(index, *action)).collect();
        let worth = |(reward, next): &(f64, Prospect)| reward + self.model.discount() * next.value;
        let best = (0..promises.len()).max_by(|a, b| worth(&promises[*a]).total_cmp(&worth(&promises[*b])));
        let explores = self.rng.random::<f64>() < EXPLORATION;
        let chosen = if explores { self.rng.random_range(0..actions.len()) } else { best.unwrap_or(0) };
        let step = self.model.step(actions[chosen], self.viewpoint, Remaining::ENDLESS);
        if step.advances() {
            self.belief.advance(self.model);
        }
        self.viewpoint = step.viewpoint;
        if step.scan.is_some() {
            self.observe(chosen);
        }
        Visit { here, actions: promises }
    }

    fn prospect(&self, belief: &Belief) -> Prospect {
        Prospect {
            mass: 1.0,
            value: bounds::lower(self.model, self.policy, belief.known(), self.viewpoint),
            entropy: left_to_learn(self.model, belief.as_slice().chunks_exact(self.model.class_count())),
        }
    }

    fn observe(&mut self, action: usize) {
        for j in self.model.positions() {
            let probabilities = self.scans[action].probabilities_of(j.0);
            let label = Label(invert(probabilities.iter().copied(), self.rng.random::<f64>()));
            // It was drawn, so it is possible.
            let _ = self.belief.observe_one(self.model, j, self.viewpoint, label);
        }
    }

    /// Reward of an action, and what it promises.
    fn promise(&mut self, index: usize, action: Action) -> (f64, Prospect) {
        let (model, mut belief) = (self.model, self.belief.clone());
        let step = model.step(action, self.viewpoint, Remaining::ENDLESS);
        let reward = model.expected_reward(&step, belief.position(Position(0)).as_slice());
        if step.advances() {
            belief.advance(model);
        }
        let Some(from) = step.scan else { return (reward, self.prospect(&belief)) };
        let (bonus, next) = self.scanned(index, from, &belief);
        (reward + bonus, next)
    }

    /// The bonus of a scan, and what is expected to be promised after it.
    fn scanned(&mut self, action: usize, viewpoint: Viewpoint, belief: &Belief) -> (f64, Prospect) {
        let looks = bounds::looks(self.model, self.policy, belief, viewpoint);
        let bonus = self.model.spec().information_gain * looks.iter().map(Look::information).sum::<f64>();
        let scan = &mut self.scans[action];
        scan.take(self.policy, looks.iter(), viewpoint, Remaining::ENDLESS);
        (bonus, Prospect { mass: 1.0, value: scan.value(), entropy: scan.expected_entropy() })
    }
}
