//! One batch of the sorting POMDP.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::evaluation::Outcome;
use super::{EvaluationConfig, MAX_IMPOSSIBLE_LABELS, TrueClasses};
use crate::belief::{Belief, Memory};
use crate::error::{Error, Result};
use crate::index::{Class, Kind, Position, Viewpoint};
use crate::model::{Action, SortingModel, Step, shift};
use crate::policy::Policy;
use crate::sampling::{Purpose, invert, label, stream};

/// An object on the belt.
struct Object {
    kind: Kind,
    rng: ChaCha8Rng,
    looks: usize,
    impossible: usize,
}

/// One batch in progress.
pub(super) struct Batch<'a> {
    model: &'a SortingModel,
    truth: &'a SortingModel,
    config: &'a EvaluationConfig,
    /// Visible objects, the one at the belt end first.
    objects: Vec<Object>,
    index: usize,
    arrived: usize,
    belief: Belief,
    /// The labels that the next looks may repeat, whether the model knows of it or not.
    given: Memory,
    viewpoint: Viewpoint,
    discount: f64,
    outcome: Outcome,
}

impl<'a> Batch<'a> {
    pub(super) fn new(
        model: &'a SortingModel,
        truth: &'a SortingModel,
        config: &'a EvaluationConfig,
        batch: usize,
    ) -> Self {
        let mut this = Self {
            model,
            truth,
            config,
            objects: Vec::with_capacity(model.position_count()),
            index: batch,
            arrived: 0,
            belief: Belief::new(model).with_remaining(config.belt_ends.then_some(config.batch_size)),
            given: Memory::new(truth),
            viewpoint: config.viewpoint,
            discount: 1.0,
            outcome: Outcome::new(model),
        };
        for _ in 0..model.position_count() {
            let object = this.arriving();
            this.objects.push(object);
        }
        this
    }

    /// Sort the batch.
    pub(super) fn run(mut self, policy: &dyn Policy) -> Result<Outcome> {
        let mut decisions = 0;
        while decisions < self.config.batch_size {
            let action = self.choose(policy)?;
            self.add_regret(action)?;
            let step = self.model.step(action, self.viewpoint, self.belief.objects_left());
            self.take(step)?;
            decisions += usize::from(step.advances());
        }
        Ok(self.outcome)
    }

    /// The policy's action, or the forced decision.
    fn choose(&mut self, policy: &dyn Policy) -> Result<Action> {
        let object = &self.objects[0];
        if object.looks >= self.config.max_looks || object.impossible >= MAX_IMPOSSIBLE_LABELS {
            self.outcome.forced += 1;
            return Ok(Action::Decide(self.belief.best_decision(self.model).0));
        }
        let action = policy.act(&self.belief, self.viewpoint)?;
        let legal = match action {
            Action::Move(to) => self.model.legal_moves(self.viewpoint).contains(&to),
            Action::Decide(bin) => self.model.check_bin(bin).is_ok(),
        };
        if legal {
            return Ok(action);
        }
        Err(Error::Policy(format!(
            "the policy chose {action} at viewpoint {}; legal are moves to {:?} and decisions below {}",
            self.viewpoint,
            self.model.legal_moves(self.viewpoint).iter().map(|to| to.0).collect::<Vec<_>>(),
            self.model.bin_count()
        )))
    }

    /// Take a step, and the scan that follows.
    fn take(&mut self, step: Step) -> Result<()> {
        let expected = self.model.expected_reward(&step, self.belief.position(Position(0)).as_slice());
        let mut reward = expected;
        if let Some(bin) = step.decided {
            // Kinds of the truth need not be those of the model; classes are.
            let class = self.truth.class_of(self.objects[0].kind);
            let kind = Kind(self.model.kinds_of(class).start);
            self.outcome.correct += u64::from(self.model.is_right(bin, kind));
            self.outcome.confusion[bin.0 * self.model.class_count() + class.0] += 1;
            reward = self.model.reward(bin, kind);
        }
        self.viewpoint = step.viewpoint;
        if step.advances() {
            self.advance();
        }
        let bonus = step.scan.map_or(0.0, |from| self.belief.bonus(self.model, from));
        self.add_step(reward, expected, bonus);
        if step.scan.is_some() { self.scan() } else { Ok(()) }
    }

    /// One label of every visible object, from where the camera stands.
    fn scan(&mut self) -> Result<()> {
        for (position, object) in self.model.positions().zip(&mut self.objects) {
            object.looks += 1;
            let look = self.given.look(self.truth, position, self.viewpoint);
            let u = object.rng.random::<f64>();
            let seen = label(self.truth, look, object.kind, u);
            self.given.remember(self.truth, position, self.viewpoint, seen);
            match self.belief.observe_one(self.model, position, self.viewpoint, seen) {
                Ok(()) => object.impossible = 0,
                Err(Error::ImpossibleObservation { .. }) => object.impossible += 1,
                Err(other) => return Err(other),
            }
        }
        Ok(())
    }

    fn advance(&mut self) {
        let arriving = self.arriving();
        shift(&mut self.objects, std::iter::once(arriving));
        self.belief.advance(self.model);
        self.given.clear();
    }

    /// Add the regret of an action to the outcome, before it is taken.
    fn add_regret(&mut self, action: Action) -> Result<()> {
        if let Some(reference) = &self.config.reference {
            let regret = reference.regret(&self.belief, self.viewpoint, action)?;
            *self.outcome.regret.get_or_insert_default() += regret;
            *self.outcome.discounted_regret.get_or_insert_default() += self.discount * regret;
        }
        Ok(())
    }

    /// Add one step to the outcome: its reward, its expected reward and its bonus.
    fn add_step(&mut self, reward: f64, expected: f64, bonus: f64) {
        self.outcome.steps += 1;
        self.outcome.total += reward;
        self.outcome.discounted += self.discount * reward;
        self.outcome.expected_discounted += self.discount * expected;
        self.outcome.bonus += bonus;
        self.outcome.discounted_bonus += self.discount * bonus;
        self.discount *= self.model.discount();
    }

    /// A kind of a class, by the weights of its modes. Its random belongs to the object, apart from those of its looks.
    fn drawn_mode(&self, class: Class) -> Kind {
        let kinds = self.truth.kinds_of(class);
        if kinds.len() == 1 {
            return Kind(kinds.start);
        }
        let index = (self.index as u64) << 31 | self.arrived as u64;
        let u = stream(self.config.seed, Purpose::Mode, index).random::<f64>();
        let weights = kinds.clone().map(|kind| self.truth.mode_weight(Kind(kind)));
        Kind(kinds.start + invert(weights, u))
    }

    /// The next object on the belt.
    fn arriving(&mut self) -> Object {
        let mut rng =
            stream(self.config.seed, Purpose::Object, (self.index as u64) << 31 | self.arrived as u64);
        let u = rng.random::<f64>();
        let kind = match &self.config.true_classes {
            TrueClasses::Arrival => Kind(invert(self.truth.arrival().iter(), u)),
            TrueClasses::UniformlyFrom(classes) => {
                let even = 1.0 / classes.len() as f64;
                self.drawn_mode(classes[invert(classes.iter().map(|_| even), u)])
            }
            // Behind the last given object nothing is ever decided; any class will do.
            TrueClasses::Given(rows) => {
                self.drawn_mode(rows[self.index].get(self.arrived).copied().unwrap_or_default())
            }
        };
        self.arrived += 1;
        Object { kind, rng, looks: 0, impossible: 0 }
    }
}
