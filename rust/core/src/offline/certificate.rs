//! Certified upper bounds for searches: at a belief, and after each label vector of a scan.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::prices::PricedBound;
use super::simplex_grid::{Combination, merged};
use super::upper::{GridBound, sole};
use super::{SLACK, all_alike, stages};
use crate::belief::{Belief, condition};
use crate::index::{Label, Position, Viewpoint};
use crate::model::SortingModel;

/// Values times classes times moves of a bound that is ready at once.
const MOST_AT_ONCE: f64 = 2e6;
/// Work of one look at every grid point of such a bound: points times labels times squared kinds times moves.
const MOST_WORK: f64 = 2e8;
/// Tolerance of its values, in units of `r_max`; what is left of it is added to the bound.
const AT_ONCE_TOLERANCE: f64 = 3e-3;

/// A certified upper bound of V*, for the searches of others.
#[derive(Debug, Clone)]
pub(crate) struct Certificate(pub(super) Source);

#[derive(Debug, Clone)]
pub(super) enum Source {
    Grid(Arc<GridBound>),
    Prices(Arc<PricedBound>),
}

impl Certificate {
    /// One that is ready in a fraction of a second, and loose, more so if `stop` is set meanwhile; for models that
    /// [`upper`] has a proof for, unless their kinds are too many for any grid.
    pub(crate) fn coarse(model: &SortingModel, stop: &AtomicBool) -> Option<Self> {
        let moves = model.legal_moves(Viewpoint(0)).len().max(1) as f64;
        let stopped = || stop.load(Ordering::Relaxed);
        let grid = || stages::coarse_grid(model, MOST_AT_ONCE / moves, AT_ONCE_TOLERANCE, stopped);
        let fits = || stages::work_of_coarsest(model) * moves <= MOST_WORK;
        (model.check_plain().is_ok() && all_alike(model) && fits())
            .then(|| Self(Source::Grid(Arc::new(grid()))))
    }

    /// The bound at a belief.
    pub(crate) fn value(&self, model: &SortingModel, belief: &[f64], viewpoint: Viewpoint) -> f64 {
        let upper = match &self.0 {
            Source::Grid(grid) => grid.value(belief),
            Source::Prices(prices) => prices.value(belief, viewpoint),
        };
        upper + SLACK * model.reward_scale()
    }

    /// The bound at a belief, one exact step ahead.
    pub(crate) fn one_step_ahead(&self, model: &SortingModel, belief: &[f64], viewpoint: Viewpoint) -> f64 {
        let upper = match &self.0 {
            Source::Grid(grid) => grid.look_ahead(model, belief, viewpoint).1,
            Source::Prices(prices) => prices.upper(belief, viewpoint),
        };
        upper + SLACK * model.reward_scale()
    }
}

/// The bound after each label vector of one scan. It is put together from what is known of each object alone, so that
/// no posterior is computed twice.
#[derive(Debug)]
pub(crate) struct ScanBounds<'a> {
    source: &'a Source,
    labels: usize,
    slack: f64,
    /// Entry `position * Z + z`: the posterior of an object after a label.
    located: Vec<Located>,
    /// Of each position, expected over its labels.
    expected: Vec<Located>,
}

/// What a bound knows of one object's belief.
#[derive(Debug)]
enum Located {
    /// Points of the grid that it lies between.
    Grid(Combination),
    /// Its part of the sum, per mode.
    Prices(Vec<f64>),
}

impl Certificate {
    /// The bound after the labels of a scan from `viewpoint`, at the belief just before it.
    pub(crate) fn after_scan(
        &self,
        model: &SortingModel,
        belief: &Belief,
        viewpoint: Viewpoint,
    ) -> ScanBounds<'_> {
        let mut bounds = ScanBounds {
            source: &self.0,
            labels: model.label_count(),
            slack: SLACK * model.reward_scale(),
            located: Vec::new(),
            expected: Vec::new(),
        };
        for position in model.positions() {
            let prior = belief.position(position);
            let look = belief.look(model, position, viewpoint);
            let outcomes: Vec<(f64, Located)> = model
                .labels()
                .map(|label| {
                    let mut posterior = prior.as_slice().to_vec();
                    let probability = condition(&mut posterior, model.likelihoods(look, label));
                    (probability, self.0.locate(position, &posterior, viewpoint))
                })
                .collect();
            bounds.expected.push(mean(&outcomes));
            bounds.located.extend(outcomes.into_iter().map(|(_, located)| located));
        }
        bounds
    }
}

impl Source {
    fn locate(&self, position: Position, belief: &[f64], viewpoint: Viewpoint) -> Located {
        match self {
            Self::Grid(grid) => Located::Grid(grid.axis.grid.locate(belief)),
            Self::Prices(prices) => Located::Prices(prices.parts(position, belief, viewpoint)),
        }
    }

    /// The bound at a belief, given each object's part of it.
    fn joined<'b>(&self, mut parts: impl Iterator<Item = &'b Located>) -> f64 {
        match self {
            Self::Grid(grid) => {
                let sole = Located::Grid(sole());
                match (parts.next(), parts.next().unwrap_or(&sole)) {
                    (Some(Located::Grid(end)), Located::Grid(behind)) => grid.mixture(end, behind),
                    _ => f64::INFINITY,
                }
            }
            Self::Prices(_) => {
                let mut sums: Vec<f64> = Vec::new();
                for part in parts {
                    let Located::Prices(part) = part else { return f64::INFINITY };
                    sums.resize(part.len(), 0.0);
                    sums.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
                }
                sums.into_iter().fold(f64::INFINITY, f64::min)
            }
        }
    }
}

impl ScanBounds<'_> {
    /// The bound after these labels, one per position.
    pub(crate) fn upper(&self, labels: &[Label]) -> f64 {
        let at = labels.iter().enumerate().map(|(position, z)| &self.located[position * self.labels + z.0]);
        self.source.joined(at) + self.slack
    }

    /// At least the bound expected over all label vectors.
    pub(crate) fn expected_upper(&self) -> f64 {
        self.source.joined(self.expected.iter()) + self.slack
    }
}

/// The mean of an object's parts over its labels: bounds are linear in them.
fn mean(outcomes: &[(f64, Located)]) -> Located {
    let mut points = Combination::new();
    let mut sums: Vec<f64> = Vec::new();
    for (p, located) in outcomes {
        match located {
            Located::Grid(combination) => points.extend(combination.iter().map(|(i, w)| (*i, w * p))),
            Located::Prices(parts) => {
                sums.resize(parts.len(), 0.0);
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += p * part);
            }
        }
    }
    if sums.is_empty() { Located::Grid(merged(points)) } else { Located::Prices(sums) }
}
