//! Runs of a moving belt, many at once.
//!
//! Randoms are indexed by (run, object, look): every policy meets the same objects, and the n-th look at an object draws
//! on the same random, whatever happened in between.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::action::MovingAction;
use super::belief::MovingBelief;
use super::belt::MovingBelt;
use super::policy::MovingPolicy;
use crate::error::{Error, Result, argument_error};
use crate::index::{Bin, Kind, Position, Viewpoint};
use crate::model::Look;
use crate::sampling::{Purpose, invert, label, stream};

/// Runs of an evaluation that is given no number of them.
pub const DEFAULT_RUNS: usize = 100;
/// Objects of a run, likewise.
pub const DEFAULT_MOVING_OBJECTS: usize = 50;
/// Ticks without a decision after which a belt that advances on decisions is given up.
const MOST_TICKS_BETWEEN: usize = 10_000;

/// Runs, and objects of a run, are fewer than this: together they number a stream of randoms.
const LIMIT: usize = 1 << 31;

/// What to simulate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MovingRuns {
    /// Number of runs.
    pub runs: usize,
    /// Objects of a run.
    pub objects: usize,
    /// Seed of kinds and labels.
    pub seed: u64,
    /// Where the camera stands when a run starts.
    pub viewpoint: Viewpoint,
}

/// What one run brought.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MovingOutcome {
    /// Ticks until the action ended in which the last object was decided or passed the exit.
    pub ticks: u64,
    /// Looks at undecided objects: a scan of two of them counts twice.
    pub looks: u64,
    /// Right decisions: into a bin than which none is worth more for the object's class.
    pub right: u64,
    /// Other decisions.
    pub wrong: u64,
    /// Objects that passed the exit undecided, by true class.
    pub missed: Vec<u64>,
    /// Decided objects by bin and true class: entry `bin * L + class`.
    pub confusion: Vec<u64>,
    /// Sum of rewards.
    pub total: f64,
    /// Sum of rewards, each discounted from its tick.
    pub discounted: f64,
}

/// Simulate a policy, run by run.
///
/// # Errors
/// [`Error::Argument`] for numbers or a viewpoint that make no sense; [`Error::Policy`] for an illegal action, and whatever
/// the policy returns.
pub fn evaluate_moving(
    belt: &MovingBelt,
    policy: &dyn MovingPolicy,
    config: &MovingRuns,
) -> Result<Vec<MovingOutcome>> {
    belt.model().check_viewpoint(config.viewpoint)?;
    for (name, value) in [("runs", config.runs), ("objects", config.objects)] {
        if value == 0 || value >= LIMIT {
            return argument_error(format!("{name} = {value}; give at least 1, and less than {LIMIT}"));
        }
    }
    (0..config.runs).into_par_iter().map(|run| Run::new(belt, config, run).simulate(policy)).collect()
}

/// An object on the belt.
struct Object {
    kind: Kind,
    rng: ChaCha8Rng,
}

/// One run in progress.
struct Run<'a> {
    belt: &'a MovingBelt,
    belief: MovingBelief,
    viewpoint: Viewpoint,
    /// One per place, the exit's first, those that do not come included.
    objects: Vec<Object>,
    seed: u64,
    index: u64,
    arrived: u64,
    discount: f64,
    outcome: MovingOutcome,
}

impl<'a> Run<'a> {
    fn new(belt: &'a MovingBelt, config: &MovingRuns, run: usize) -> Self {
        let (bins, classes) = (belt.model().bin_count(), belt.model().class_count());
        let outcome = MovingOutcome {
            missed: vec![0; classes],
            confusion: vec![0; bins * classes],
            ..MovingOutcome::default()
        };
        let mut this = Self {
            belt,
            belief: MovingBelief::new(belt, Some(config.objects)),
            viewpoint: config.viewpoint,
            objects: Vec::new(),
            seed: config.seed,
            index: run as u64,
            arrived: 0,
            discount: 1.0,
            outcome,
        };
        for _ in belt.model().positions() {
            this.arrive();
        }
        this
    }

    /// Run until nothing is left to decide. It ends: all that takes no time is a decision, each object has one, and the belt
    /// moves on.
    fn simulate(mut self, policy: &dyn MovingPolicy) -> Result<MovingOutcome> {
        while !self.belief.is_over() {
            if self.belt.timing().advances_on_decisions() && self.belief.offset() >= MOST_TICKS_BETWEEN {
                return Err(Error::Policy(format!(
                    "the policy decided nothing for {MOST_TICKS_BETWEEN} ticks, and the belt waits for a decision; lower its \
                     threshold"
                )));
            }
            match policy.act(&self.belief, self.viewpoint)? {
                MovingAction::Wait => self.pass(1),
                MovingAction::Decide { position, bin } => self.decide(position, bin)?,
                MovingAction::Look(to) => self.look(to)?,
            }
        }
        Ok(self.outcome)
    }

    fn earn(&mut self, reward: f64) {
        self.outcome.total += reward;
        self.outcome.discounted += self.discount * reward;
    }

    fn decide(&mut self, position: Position, bin: Bin) -> Result<()> {
        let model = self.belt.model();
        let illegal = |e: Error| Error::Policy(format!("the policy chose a decision that is illegal: {e}"));
        model.check_bin(bin).map_err(illegal)?;
        self.belief.decide(self.belt, position).map_err(illegal)?;
        let kind = self.objects[position.0].kind;
        let right = u64::from(model.is_right(bin, kind));
        self.outcome.right += right;
        self.outcome.wrong += 1 - right;
        self.outcome.confusion[bin.0 * model.class_count() + model.class_of(kind).0] += 1;
        self.earn(model.reward(bin, kind));
        if self.belt.timing().advances_on_decisions() {
            self.replace_first();
        }
        self.pass(self.belt.decision_ticks());
        Ok(())
    }

    fn look(&mut self, to: Viewpoint) -> Result<()> {
        let model = self.belt.model();
        if !model.legal_moves(self.viewpoint).contains(&to) {
            return Err(Error::Policy(format!(
                "the policy chose a look from viewpoint {to} at viewpoint {}; legal are {:?}",
                self.viewpoint,
                model.legal_moves(self.viewpoint).iter().map(|to| to.0).collect::<Vec<_>>()
            )));
        }
        self.earn(-model.motion_cost(self.viewpoint, to));
        self.pass(self.belt.timing().look(self.viewpoint, to));
        self.viewpoint = to;
        let mut labels = vec![None; self.objects.len()];
        for (position, object) in model.positions().zip(&mut self.objects) {
            if !self.belief.decided()[position.0] {
                let u = object.rng.random::<f64>();
                labels[position.0] = Some(label(model, Look::first(position, to), object.kind, u));
                self.outcome.looks += 1;
            }
        }
        self.belief.observe(self.belt, to, &labels)
    }

    /// Let ticks pass.
    fn pass(&mut self, ticks: usize) {
        let model = self.belt.model();
        for _ in 0..ticks {
            let undecided = !self.belief.decided()[0];
            self.belief.advance_time(self.belt, 1);
            self.discount *= model.discount();
            self.outcome.ticks += 1;
            if self.belief.offset() == 0 {
                let gone = self.replace_first();
                if undecided {
                    let class = model.class_of(gone.kind);
                    self.outcome.missed[class.0] += 1;
                    self.earn(-self.belt.missed()[class.0]);
                }
            }
        }
    }

    /// The object at the exit leaves, and the next one comes to the last place.
    fn replace_first(&mut self) -> Object {
        self.arrive();
        self.objects.remove(0)
    }

    /// The next object comes to the last place.
    fn arrive(&mut self) {
        let mut rng = stream(self.seed, Purpose::Object, self.index << 31 | self.arrived);
        let u = rng.random::<f64>();
        let kind = Kind(invert(self.belt.model().arrival().iter(), u));
        self.objects.push(Object { kind, rng });
        self.arrived += 1;
    }
}
