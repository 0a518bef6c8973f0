//! What decisions are worth: `R[b, c]` of putting an object of class c into bin b.

use nalgebra::DMatrix;

use super::{ModelSpec, SortingModel};
use crate::belief::most_likely;
use crate::index::{Bin, Class, Kind};

/// Rewards of decisions.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Rewards {
    /// The paper's: the bins are the classes, `r_max` for the right one and `-r_min` for any other.
    RightOrWrong,
    /// Shape (B, N): all kinds of a class have the same.
    Table(DMatrix<f64>),
}

impl Rewards {
    pub(super) fn new(spec: &ModelSpec) -> Self {
        let Some(reward) = &spec.reward else { return Self::RightOrWrong };
        let modes = |class: usize| spec.modes.as_ref().map_or(1, |modes| modes[class].len());
        let classes = (0..spec.classes.len()).flat_map(|class| std::iter::repeat_n(class, modes(class)));
        let columns: Vec<f64> = classes.flat_map(|class| reward.iter().map(move |row| row[class])).collect();
        Self::Table(DMatrix::from_vec(reward.len(), columns.len() / reward.len(), columns))
    }
}

impl SortingModel {
    /// Expected reward of a decision that is right with probability `p_right`, in the paper's model.
    #[must_use]
    pub fn decision_reward(&self, p_right: f64) -> f64 {
        p_right * self.spec().r_max - (1.0 - p_right) * self.spec().r_min
    }

    /// Reward of putting an object of a kind into a bin.
    #[must_use]
    pub fn reward(&self, bin: Bin, kind: Kind) -> f64 {
        match &self.rewards {
            Rewards::RightOrWrong => {
                self.decision_reward(f64::from(u8::from(self.class_of(kind).0 == bin.0)))
            }
            Rewards::Table(table) => table[(bin.0, kind.0)],
        }
    }

    /// Expected reward of a decision, given the distribution of the object's kind.
    #[must_use]
    pub fn expected_decision_reward(&self, bin: Bin, kinds: &[f64]) -> f64 {
        match &self.rewards {
            Rewards::RightOrWrong => self.decision_reward(self.class_probability(Class(bin.0), kinds)),
            Rewards::Table(table) => kinds.iter().zip(table.row(bin.0).iter()).map(|(b, r)| b * r).sum(),
        }
    }

    /// The decision that earns most (the first among equals) and its expected reward: `max_b sum_n p(n) R[b, n]`.
    /// Weights that do not sum to 1 lead to the same decision.
    #[must_use]
    #[inline(always)]
    pub fn best_decision(&self, kinds: &[f64]) -> (Bin, f64) {
        if matches!(self.rewards, Rewards::RightOrWrong) {
            let (class, p_right) = self.most_likely_class(kinds);
            return (Bin(class.0), self.decision_reward(p_right));
        }
        let mut best = (Bin(0), f64::NEG_INFINITY);
        for bin in self.bins() {
            let reward = self.expected_decision_reward(bin, kinds);
            if reward > best.1 {
                best = (bin, reward);
            }
        }
        best
    }

    /// Whether no bin is worth more for an object of this kind.
    #[must_use]
    pub fn is_right(&self, bin: Bin, kind: Kind) -> bool {
        let earned = self.reward(bin, kind);
        self.bins().all(|other| self.reward(other, kind) <= earned)
    }

    /// Probability that no other bin is worth more than this one: that a decision for it is right.
    #[must_use]
    pub fn probability_right(&self, bin: Bin, kinds: &[f64]) -> f64 {
        match &self.rewards {
            Rewards::RightOrWrong => self.class_probability(Class(bin.0), kinds),
            Rewards::Table(_) => {
                let right = self.kinds().zip(kinds).filter(|(kind, _)| self.is_right(bin, *kind));
                right.map(|(_, p)| p).sum()
            }
        }
    }

    /// The most that one decision can earn; not below 0.
    #[must_use]
    pub fn most_reward(&self) -> f64 {
        match &self.rewards {
            Rewards::RightOrWrong => self.spec().r_max,
            Rewards::Table(table) => table.max().max(0.0),
        }
    }

    /// The least that one decision can earn.
    #[must_use]
    pub fn least_reward(&self) -> f64 {
        match &self.rewards {
            Rewards::RightOrWrong => -self.spec().r_min,
            Rewards::Table(table) => table.min(),
        }
    }

    /// The unit of tolerances of values: `r_max`, or the largest reward, in absolute value, of putting a class into the
    /// bin that is best for it; the largest of all rewards if every best bin is worth nothing.
    ///
    /// Losses of wrong decisions do not count: they may be a hundred times as large, and the policies of interest run
    /// into few of them.
    #[must_use]
    pub fn reward_scale(&self) -> f64 {
        match &self.rewards {
            Rewards::RightOrWrong => self.spec().r_max,
            Rewards::Table(table) => {
                let best = table.column_iter().map(|kind| kind.max().abs()).fold(0.0, f64::max);
                if best > 0.0 { best } else { table.amax() }
            }
        }
    }

    /// Probability of a class, given the distribution of the kind.
    #[must_use]
    #[inline(always)]
    pub fn class_probability(&self, class: Class, kinds: &[f64]) -> f64 {
        kinds[self.kinds_of(class)].iter().sum()
    }

    /// Probability of each class, given the distribution of the kind.
    pub fn class_probabilities<'a>(&'a self, kinds: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.classes().map(|class| self.class_probability(class, kinds))
    }

    /// The most likely class (the first among equals) and its probability, given the distribution of the kind.
    #[must_use]
    #[inline(always)]
    pub fn most_likely_class(&self, kinds: &[f64]) -> (Class, f64) {
        if !self.has_modes() {
            let (kind, p) = most_likely(kinds);
            return (Class(kind), p);
        }
        let classes: Vec<f64> = self.class_probabilities(kinds).collect();
        let (class, p) = most_likely(&classes);
        (Class(class), p)
    }
}
