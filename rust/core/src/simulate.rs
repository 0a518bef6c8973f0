//! Batches of the sorting POMDP, many at once.
//!
//! Randoms are indexed by (batch, object, look): every policy meets the same objects, and the n-th look at an object
//! draws on the same random, whatever happened in between.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::belief::Belief;
use crate::error::{Error, Result, argument_error};
use crate::model::{Action, SortingModel};
use crate::policy::Policy;
use crate::sampling::{Purpose, invert, label, stream};

/// This many impossible labels of one object in a row end the looking at it.
const IMPOSSIBLE_IN_A_ROW: usize = 3;

/// Batches, and objects of a batch, are fewer than this: together they number a stream of randoms.
const MOST: usize = 1 << 31;

/// Where the true classes of a batch come from.
#[derive(Debug, Clone, PartialEq)]
pub enum TrueClasses {
    /// The arrival prior of the model that draws labels.
    Arrival,
    /// Uniformly from these labels.
    UniformlyFrom(Vec<usize>),
    /// Given: a row of `batch_size + H - 1` labels per batch.
    Given(Vec<Vec<usize>>),
}

/// What to simulate.
#[derive(Debug, Clone)]
pub struct EvaluationConfig {
    /// Number of batches.
    pub batches: usize,
    /// Decisions per batch.
    pub batch_size: usize,
    /// Seed of classes and labels.
    pub seed: u64,
    /// Where the camera stands when a batch starts.
    pub viewpoint: usize,
    /// The objects.
    pub true_classes: TrueClasses,
    /// An object looked at this often is decided as its most likely class.
    pub max_looks: usize,
}

/// Outcomes, one entry per batch.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Evaluation {
    /// Moves and decisions.
    pub steps: Vec<u64>,
    /// Right decisions.
    pub correct: Vec<u64>,
    /// Decisions forced by `max_looks` or by impossible labels.
    pub forced: Vec<u64>,
    /// Sum of rewards.
    pub returns: Vec<f64>,
    /// Sum of discounted rewards.
    pub discounted_returns: Vec<f64>,
    /// As `discounted_returns`, each decision scored by its expectation under the belief.
    pub expected_discounted_returns: Vec<f64>,
}

/// Mean and standard error over batches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Sample mean.
    pub mean: f64,
    /// Standard error of the mean; NaN for a single batch.
    pub standard_error: f64,
}

impl Statistics {
    fn of(sample: &[f64]) -> Self {
        let n = sample.len() as f64;
        let mean = sample.iter().sum::<f64>() / n;
        let squares = sample.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
        Self { mean, standard_error: (squares / (n - 1.0) / n).sqrt() }
    }
}

impl Evaluation {
    /// Statistics of every outcome by name; `expected_discounted_returns` only if they are unbiased.
    #[must_use]
    pub fn summary(&self, expectations_unbiased: bool) -> Vec<(&'static str, Statistics)> {
        let counted = |counts: &[u64]| Statistics::of(&counts.iter().map(|n| *n as f64).collect::<Vec<_>>());
        let mut summary = vec![
            ("steps", counted(&self.steps)),
            ("correct", counted(&self.correct)),
            ("forced", counted(&self.forced)),
            ("returns", Statistics::of(&self.returns)),
            ("discounted_returns", Statistics::of(&self.discounted_returns)),
        ];
        if expectations_unbiased {
            summary.push(("expected_discounted_returns", Statistics::of(&self.expected_discounted_returns)));
        }
        summary
    }
}

/// Simulate a policy: `model` updates the belief, `truth` draws classes and labels.
///
/// # Errors
/// [`Error::Argument`] for arguments that do not fit; whatever the policy returns, and an error for an illegal action.
pub fn evaluate(
    model: &SortingModel,
    truth: &SortingModel,
    policy: &dyn Policy,
    config: &EvaluationConfig,
) -> Result<Evaluation> {
    check(model, truth, config)?;
    let outcomes: Result<Vec<Outcome>> = (0..config.batches)
        .into_par_iter()
        .map(|batch| Batch::new(model, truth, config, batch).run(policy))
        .collect();
    let mut evaluation = Evaluation::default();
    for outcome in outcomes? {
        evaluation.steps.push(outcome.steps);
        evaluation.correct.push(outcome.correct);
        evaluation.forced.push(outcome.forced);
        evaluation.returns.push(outcome.total);
        evaluation.discounted_returns.push(outcome.discounted);
        evaluation.expected_discounted_returns.push(outcome.expected_discounted);
    }
    Ok(evaluation)
}

fn check(model: &SortingModel, truth: &SortingModel, config: &EvaluationConfig) -> Result<()> {
    model.check_viewpoint(config.viewpoint)?;
    for (name, value) in
        [("batches", config.batches), ("batch_size", config.batch_size), ("max_looks", config.max_looks)]
    {
        if value == 0 || value >= MOST {
            return argument_error(format!("{name} = {value}; give at least 1, and less than {MOST}"));
        }
    }
    let shape = |m: &SortingModel| (m.position_count(), m.viewpoint_count(), m.class_count());
    if shape(model) != shape(truth) {
        return argument_error(format!(
            "truth has {:?} positions, viewpoints and classes, the model {:?}; they must agree",
            shape(truth),
            shape(model)
        ));
    }
    let objects = config.batch_size + model.position_count() - 1;
    match &config.true_classes {
        TrueClasses::Arrival => Ok(()),
        TrueClasses::UniformlyFrom(labels) if labels.is_empty() => {
            argument_error("true_classes is empty; list at least one label to draw from")
        }
        TrueClasses::UniformlyFrom(labels) => labels.iter().try_for_each(|&label| model.check_label(label)),
        TrueClasses::Given(rows) => {
            if rows.len() != config.batches || rows.iter().any(|row| row.len() != objects) {
                return argument_error(format!(
                    "true_classes must have shape ({}, {objects}): a row per batch, and batch_size + H - 1 objects a row",
                    config.batches
                ));
            }
            rows.iter().flatten().try_for_each(|&label| model.check_label(label))
        }
    }
}

#[derive(Default)]
struct Outcome {
    steps: u64,
    correct: u64,
    forced: u64,
    total: f64,
    discounted: f64,
    expected_discounted: f64,
}

/// An object on the belt.
struct Object {
    class: usize,
    rng: ChaCha8Rng,
    looks: usize,
    impossible: usize,
}

struct Batch<'a> {
    model: &'a SortingModel,
    truth: &'a SortingModel,
    config: &'a EvaluationConfig,
    /// Visible objects, the one at the belt end first.
    objects: Vec<Object>,
    index: usize,
    arrived: usize,
    belief: Belief,
    viewpoint: usize,
    discount: f64,
    outcome: Outcome,
}

impl<'a> Batch<'a> {
    fn new(
        model: &'a SortingModel,
        truth: &'a SortingModel,
        config: &'a EvaluationConfig,
        batch: usize,
    ) -> Self {
        let mut this = Self {
            model,
            truth,
            config,
            objects: Vec::new(),
            index: batch,
            arrived: 0,
            belief: Belief::new(model),
            viewpoint: config.viewpoint,
            discount: 1.0,
            outcome: Outcome::default(),
        };
        for _ in 0..model.position_count() {
            this.arrive();
        }
        this
    }

    fn run(mut self, policy: &dyn Policy) -> Result<Outcome> {
        for _ in 0..self.config.batch_size {
            loop {
                let action = self.choose(policy)?;
                match action {
                    Action::Move(to) => self.look_from(to)?,
                    Action::Decide(label) => {
                        self.decide(label);
                        break;
                    }
                }
            }
        }
        Ok(self.outcome)
    }

    /// The policy's action, or the forced decision.
    fn choose(&mut self, policy: &dyn Policy) -> Result<Action> {
        let object = &self.objects[0];
        if object.looks >= self.config.max_looks || object.impossible >= IMPOSSIBLE_IN_A_ROW {
            self.outcome.forced += 1;
            return Ok(Action::Decide(self.belief.most_likely(0).0));
        }
        let action = policy.act(&self.belief, self.viewpoint)?;
        let legal = match action {
            Action::Move(to) => self.model.legal_moves(self.viewpoint).contains(&to),
            Action::Decide(label) => label < self.model.class_count(),
        };
        if legal {
            return Ok(action);
        }
        Err(Error::Policy(format!(
            "the policy chose {action:?} at viewpoint {}; legal are moves to {:?} and decisions below {}",
            self.viewpoint,
            self.model.legal_moves(self.viewpoint),
            self.model.class_count()
        )))
    }

    fn look_from(&mut self, viewpoint: usize) -> Result<()> {
        self.reward(-self.model.motion_cost(self.viewpoint, viewpoint), None);
        self.viewpoint = viewpoint;
        for position in 0..self.objects.len() {
            let object = &mut self.objects[position];
            object.looks += 1;
            let seen = label(self.truth, position, viewpoint, object.class, object.rng.random::<f64>());
            let mut labels = vec![None; self.model.position_count()];
            labels[position] = Some(seen);
            match self.belief.observe(self.model, viewpoint, &labels) {
                Ok(()) => object.impossible = 0,
                Err(Error::ImpossibleObservation { .. }) => object.impossible += 1,
                Err(other) => return Err(other),
            }
        }
        Ok(())
    }

    fn decide(&mut self, label: usize) {
        let right = self.objects[0].class == label;
        self.outcome.correct += u64::from(right);
        let expected = self.model.decision_reward(self.belief.position(0)[label]);
        self.reward(self.model.decision_reward(f64::from(u8::from(right))), Some(expected));
        self.objects.remove(0);
        self.arrive();
        self.belief.advance(self.model);
    }

    /// Book one step's reward, and its expectation where that differs.
    fn reward(&mut self, reward: f64, expected: Option<f64>) {
        self.outcome.steps += 1;
        self.outcome.total += reward;
        self.outcome.discounted += self.discount * reward;
        self.outcome.expected_discounted += self.discount * expected.unwrap_or(reward);
        self.discount *= self.model.discount();
    }

    fn arrive(&mut self) {
        let mut rng =
            stream(self.config.seed, Purpose::Object, (self.index as u64) << 31 | self.arrived as u64);
        let u = rng.random::<f64>();
        let class = match &self.config.true_classes {
            TrueClasses::Arrival => invert(self.truth.arrival().iter(), u),
            TrueClasses::UniformlyFrom(labels) => {
                let even = vec![1.0 / labels.len() as f64; labels.len()];
                labels[invert(&even, u)]
            }
            // Behind the last given object nothing is ever decided; any class will do.
            TrueClasses::Given(rows) => rows[self.index].get(self.arrived).copied().unwrap_or(0),
        };
        self.arrived += 1;
        self.objects.push(Object { class, rng, looks: 0, impossible: 0 });
    }
}
