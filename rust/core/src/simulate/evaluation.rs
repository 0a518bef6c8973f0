//! What a simulation brought, and its statistics.

use serde::{Deserialize, Serialize};

use crate::model::SortingModel;

/// Outcomes, one entry per batch.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Moves and decisions.
    pub steps: Vec<u64>,
    /// Right decisions: into a bin than which none is worth more for the object's class.
    pub correct: Vec<u64>,
    /// Objects by bin and true class, shape (B, L) in each batch: entry `bin * L + class`.
    pub confusion: Vec<Vec<u64>>,
    /// Decisions forced by `max_looks` or by impossible labels.
    pub forced: Vec<u64>,
    /// Sum of rewards, without bonuses.
    pub returns: Vec<f64>,
    /// Sum of discounted rewards.
    pub discounted_returns: Vec<f64>,
    /// As `discounted_returns`, each decision scored by its expectation under the belief.
    pub expected_discounted_returns: Vec<f64>,
    /// Sum of the bonuses for information, [`Belief::bonus`](crate::Belief::bonus).
    pub bonuses: Vec<f64>,
    /// Sum of discounted bonuses.
    pub discounted_bonuses: Vec<f64>,
    /// Sum of what the policy's actions lost, [`Solution::regret`](crate::Solution::regret); empty without a reference.
    pub regrets: Vec<f64>,
    /// Sum of discounted regrets; empty without a reference.
    pub discounted_regrets: Vec<f64>,
}

/// What one batch brought; see [`Evaluation`].
#[derive(Default)]
pub(super) struct Outcome {
    pub(super) confusion: Vec<u64>,
    pub(super) steps: u64,
    pub(super) correct: u64,
    pub(super) forced: u64,
    pub(super) total: f64,
    pub(super) discounted: f64,
    pub(super) expected_discounted: f64,
    pub(super) bonus: f64,
    pub(super) discounted_bonus: f64,
    pub(super) regret: Option<f64>,
    pub(super) discounted_regret: Option<f64>,
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
    pub(super) fn of(sample: &[f64]) -> Self {
        let n = sample.len() as f64;
        let mean = sample.iter().sum::<f64>() / n;
        let squares = sample.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
        Self { mean, standard_error: (squares / (n - 1.0) / n).sqrt() }
    }
}

impl Outcome {
    pub(super) fn new(model: &SortingModel) -> Self {
        Self { confusion: vec![0; model.bin_count() * model.class_count()], ..Self::default() }
    }
}

impl Evaluation {
    pub(super) fn of(outcomes: Vec<Outcome>) -> Self {
        let mut evaluation = Self::default();
        for outcome in outcomes {
            evaluation.steps.push(outcome.steps);
            evaluation.correct.push(outcome.correct);
            evaluation.forced.push(outcome.forced);
            evaluation.confusion.push(outcome.confusion);
            evaluation.returns.push(outcome.total);
            evaluation.discounted_returns.push(outcome.discounted);
            evaluation.expected_discounted_returns.push(outcome.expected_discounted);
            evaluation.bonuses.push(outcome.bonus);
            evaluation.discounted_bonuses.push(outcome.discounted_bonus);
            evaluation.regrets.extend(outcome.regret);
            evaluation.discounted_regrets.extend(outcome.discounted_regret);
        }
        evaluation
    }

    /// Statistics of every outcome by name: `expected_discounted_returns` only if they are unbiased, bonuses only if
    /// the model gives any, regrets only against a reference.
    #[must_use]
    pub fn summary(
        &self,
        expectations_unbiased: bool,
        with_bonuses: bool,
    ) -> Vec<(&'static str, Statistics)> {
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
        if with_bonuses {
            summary.push(("bonuses", Statistics::of(&self.bonuses)));
            summary.push(("discounted_bonuses", Statistics::of(&self.discounted_bonuses)));
        }
        if !self.regrets.is_empty() {
            summary.push(("regrets", Statistics::of(&self.regrets)));
            summary.push(("discounted_regrets", Statistics::of(&self.discounted_regrets)));
        }
        summary
    }
}
