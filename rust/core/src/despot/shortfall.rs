//! What the default policy is expected to fall short of the optimum by.
//!
//! `V* = l + s`, l the default policy's value; s is taken as linear in l and fitted such that `l + s` is on average
//! what one backup makes of it (fitted value iteration: Gordon, ICML 1995), at beliefs such as searches meet. So
//! values at different depths can be compared: looking deeper changes them only where it finds something.

use nalgebra::{Matrix2, Vector2};
use rand::RngExt;

use super::branch::Scan;
use crate::belief::{Memory, condition, most_likely, shift};
use crate::bounds::{self, Look};
use crate::model::SortingModel;
use crate::one_object::OneObjectPolicy;
use crate::sampling::{Purpose, invert, stream};

/// Beliefs of the walk: as many as this work allows, counted in entries of looks.
const WORK: usize = 100_000;
const BELIEFS: std::ops::Range<usize> = 500..2000;

/// How often the walk takes any action instead of the best.
const STRAYING: f64 = 0.5;
/// Backups of the fit; the discount leaves nothing of its start.
const ROUNDS: usize = 300;

/// `s(b) = offset + slope l(b)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shortfall {
    offset: f64,
    slope: f64,
}

impl Shortfall {
    /// Shortfall of the default policy where its value is `value`, times `mass`; `value` counts with it already.
    #[inline(always)]
    pub(super) fn at(self, mass: f64, value: f64) -> f64 {
        self.offset * mass + self.slope * value
    }

    /// Fit to a model. Deterministic.
    pub(super) fn fitted(model: &SortingModel, policy: &OneObjectPolicy) -> Self {
        let mut walk = Walk::new(model, policy);
        let visits: Vec<Visit> = (0..walk.length()).map(|_| walk.step()).collect();
        let mut fit = Self { offset: 0.0, slope: 0.0 };
        for _ in 0..ROUNDS {
            let Some(next) = fit.backed_up(model.discount(), &visits) else { break };
            fit = next;
        }
        fit
    }

    /// The closest fit to what one backup makes of this one.
    fn backed_up(self, discount: f64, visits: &[Visit]) -> Option<Self> {
        let (mut system, mut target) = (Matrix2::zeros(), Vector2::zeros());
        for visit in visits {
            let features = Vector2::new(1.0, visit.value);
            let value = |&(reward, next): &(f64, f64)| reward + discount * (next + self.at(1.0, next));
            let best = visit.actions.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
            system += features * features.transpose();
            target += features * (best - visit.value);
        }
        // Where the default policy is worth the same everywhere there is nothing to tell.
        let fit = system.lu().solve(&target).filter(|fit| fit.iter().all(|x| x.is_finite()))?;
        Some(Self { offset: fit[0], slope: fit[1] })
    }
}

/// The default policy's value at a belief, and of each action the reward and its expected value after it.
struct Visit {
    value: f64,
    actions: Vec<(f64, f64)>,
}

/// A walk that now and then does not do what seems best, as searches do.
struct Walk<'a> {
    model: &'a SortingModel,
    policy: &'a OneObjectPolicy,
    rng: rand_chacha::ChaCha8Rng,
    belief: Vec<f64>,
    memory: Memory,
    viewpoint: usize,
    /// One per legal move.
    looks: Vec<Look>,
}

impl<'a> Walk<'a> {
    fn new(model: &'a SortingModel, policy: &'a OneObjectPolicy) -> Self {
        Self {
            model,
            policy,
            rng: stream(0, Purpose::Walk, u64::from(u32::MAX)),
            belief: model.arrival().as_slice().repeat(model.position_count()),
            memory: Memory::new(model),
            viewpoint: 0,
            looks: (0..model.viewpoint_count()).map(|_| Look::default()).collect(),
        }
    }

    fn length(&self) -> usize {
        let entries = self.model.viewpoint_count() * self.model.position_count() * self.model.class_count();
        (WORK / entries).clamp(BELIEFS.start, BELIEFS.end)
    }

    /// Note where the walk stands, and go on.
    fn step(&mut self) -> Visit {
        let value = bounds::lower(self.model, self.policy, &self.belief, self.viewpoint);
        let actions = self.actions();
        let worth = |&(reward, next): &(f64, f64)| reward + self.model.discount() * next;
        let best = (0..actions.len()).max_by(|a, b| worth(&actions[*a]).total_cmp(&worth(&actions[*b])));
        let strays = self.rng.random::<f64>() < STRAYING;
        let chosen = if strays { self.rng.random_range(0..actions.len()) } else { best.unwrap_or(0) };
        match chosen.checked_sub(1) {
            None => shift(self.model, &mut self.belief, &mut self.memory),
            Some(index) => self.look(index),
        }
        Visit { value, actions }
    }

    fn look(&mut self, index: usize) {
        self.viewpoint = self.model.legal_moves(self.viewpoint)[index];
        for j in 0..self.model.position_count() {
            let label =
                invert(self.looks[index].probabilities_of(j).iter().copied(), self.rng.random::<f64>());
            condition(self.model, &mut self.belief, &mut self.memory, (j, self.viewpoint, label));
        }
    }

    /// Reward of each action, and the default policy's expected value after it: the best decision, then the moves.
    fn actions(&mut self) -> Vec<(f64, f64)> {
        let Self { model, policy, belief, memory, viewpoint, looks, .. } = self;
        let l = model.class_count();
        let advanced = [&belief[l..], model.arrival().as_slice()].concat();
        let next = bounds::lower(model, policy, &advanced, *viewpoint);
        let mut actions = vec![(model.decision_reward(most_likely(&belief[..l]).1), next)];
        for (look, &to) in looks.iter_mut().zip(model.legal_moves(*viewpoint)) {
            look.take(model, policy, belief, memory, to);
            let bonus = Scan { depth: 0, decisions: 0, viewpoint: to }.bonus(model, belief, memory);
            actions.push((bonus - model.motion_cost(*viewpoint, to), look.value()));
        }
        actions
    }
}
