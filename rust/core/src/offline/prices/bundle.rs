//! Minimising a convex function from its values and subgradients: a proximal bundle method (Kiwiel 1990).
//!
//! Each subgradient is a *cut*, a linear function below the one sought; their maximum models it. The next point
//! minimises the model plus `|x - centre|^2 / (2 step)`. If the function falls there as foreseen, it is the next centre.

use crate::one_object::dot;

/// Most cuts kept.
const MOST_CUTS: usize = 80;
/// Part of the foreseen fall that makes a step a good one, and that which makes it so good that steps may be longer.
const GOOD: f64 = 0.1;
const VERY_GOOD: f64 = 0.5;
/// Sweeps over pairs of cuts when the model is minimised.
const SWEEPS: usize = 200;

/// A linear function below the one sought: `gap` below it at the centre.
struct Cut {
    slope: Vec<f64>,
    gap: f64,
    weight: f64,
}

/// The state of the minimisation.
pub(super) struct Bundle {
    centre: Vec<f64>,
    value: f64,
    cuts: Vec<Cut>,
    /// `products[i][j]` of the slopes of cuts i and j.
    products: Vec<Vec<f64>>,
    step: f64,
    /// What the last model foresaw.
    fall: f64,
    disappointments: u32,
}

impl Bundle {
    /// Start from a point, its value and subgradient; the first step is so many times the latter.
    pub(super) fn new(start: Vec<f64>, value: f64, slope: Vec<f64>, step: f64) -> Self {
        let mut bundle = Self {
            centre: start,
            value,
            cuts: Vec::new(),
            products: Vec::new(),
            step,
            fall: 0.0,
            disappointments: 0,
        };
        bundle.add(slope, 0.0);
        bundle
    }

    /// The best point so far.
    pub(super) fn centre(&self) -> &[f64] {
        &self.centre
    }

    /// The value at the best point.
    pub(super) fn value(&self) -> f64 {
        self.value
    }

    /// How long steps have become.
    pub(super) fn step(&self) -> f64 {
        self.step
    }

    /// How much the next step is foreseen to gain.
    pub(super) fn foreseen(&self) -> f64 {
        self.fall
    }

    /// The point to try next.
    pub(super) fn next(&mut self) -> Vec<f64> {
        self.minimise();
        let mut slope = vec![0.0; self.centre.len()];
        for cut in self.cuts.iter().filter(|cut| cut.weight > 0.0) {
            slope.iter_mut().zip(&cut.slope).for_each(|(sum, s)| *sum += cut.weight * s);
        }
        let gap: f64 = self.cuts.iter().map(|cut| cut.weight * cut.gap).sum();
        self.fall = self.step * dot(&slope, &slope) + gap;
        self.centre.iter().zip(&slope).map(|(x, s)| x - self.step * s).collect()
    }

    /// Learn the value and a subgradient at the point tried. Whether it is the new centre.
    pub(super) fn learn(&mut self, tried: Vec<f64>, value: f64, slope: Vec<f64>) -> bool {
        let gained = self.value - value;
        let way: Vec<f64> = tried.iter().zip(&self.centre).map(|(new, old)| new - old).collect();
        let good = gained >= GOOD * self.fall && gained > 0.0;
        if good {
            for cut in &mut self.cuts {
                cut.gap = (cut.gap - gained - dot(&cut.slope, &way)).max(0.0);
            }
            (self.centre, self.value) = (tried, value);
            self.add(slope, 0.0);
            self.disappointments = 0;
            if gained >= VERY_GOOD * self.fall {
                self.step *= 2.0;
            }
        } else {
            let gap = (gained + dot(&slope, &way)).max(0.0);
            self.disappointments += 1;
            // A cut that says nothing about the centre, again and again: the step is too long for the model.
            if gap > self.fall && self.disappointments > 2 {
                self.step *= 0.6;
                self.disappointments = 0;
            }
            self.add(slope, gap);
        }
        good
    }

    fn add(&mut self, slope: Vec<f64>, gap: f64) {
        if self.cuts.len() >= MOST_CUTS {
            let least = |a: &usize, b: &usize| {
                let rank = |i: usize| (self.cuts[i].weight, -self.cuts[i].gap);
                rank(*a).partial_cmp(&rank(*b)).unwrap_or(std::cmp::Ordering::Equal)
            };
            if let Some(dropped) = (0..self.cuts.len()).min_by(least) {
                self.cuts.remove(dropped);
                self.products.remove(dropped);
                self.products.iter_mut().for_each(|row| {
                    row.remove(dropped);
                });
            }
        }
        let with: Vec<f64> = self.cuts.iter().map(|cut| dot(&cut.slope, &slope)).collect();
        self.products.iter_mut().zip(&with).for_each(|(row, product)| row.push(*product));
        let mut row = with;
        row.push(dot(&slope, &slope));
        self.products.push(row);
        let weight = if self.cuts.is_empty() { 1.0 } else { 0.0 };
        self.cuts.push(Cut { slope, gap, weight });
        let sum: f64 = self.cuts.iter().map(|cut| cut.weight).sum();
        if sum > 0.0 {
            self.cuts.iter_mut().for_each(|cut| cut.weight /= sum);
        } else if let Some(last) = self.cuts.last_mut() {
            last.weight = 1.0;
        }
    }

    /// Weights of the cuts: the minimum of `step |sum w slope|^2 / 2 + sum w gap` over the simplex, by moving weight from
    /// the worst cut to the best one (sequential minimal optimisation).
    fn minimise(&mut self) {
        let n = self.cuts.len();
        let gradient = |cuts: &[Cut], i: usize| {
            let product = cuts.iter().zip(&self.products[i]).map(|(cut, product)| cut.weight * product);
            self.step * product.sum::<f64>() + cuts[i].gap
        };
        let mut gradients: Vec<f64> = (0..n).map(|i| gradient(&self.cuts, i)).collect();
        for _ in 0..SWEEPS * n {
            let by = |a: &usize, b: &usize| gradients[*a].total_cmp(&gradients[*b]);
            let used = (0..n).filter(|i| self.cuts[*i].weight > 0.0);
            let (Some(to), Some(from)) = ((0..n).min_by(by), used.max_by(by)) else { return };
            let slope = gradients[from] - gradients[to];
            if slope <= 1e-9 * (1.0 + self.value.abs()) {
                return;
            }
            let p = &self.products;
            let curvature = self.step * (p[from][from] + p[to][to] - 2.0 * p[from][to]);
            let most = self.cuts[from].weight;
            let moved = if curvature > 0.0 { (slope / curvature).min(most) } else { most };
            self.cuts[from].weight -= moved;
            self.cuts[to].weight += moved;
            for (i, gradient) in gradients.iter_mut().enumerate() {
                *gradient += self.step * moved * (p[i][to] - p[i][from]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `max(|x|, |y - 1| + 2)` and a subgradient.
    fn function(x: &[f64]) -> (f64, Vec<f64>) {
        let (a, b) = (x[0].abs(), (x[1] - 1.0).abs() + 2.0);
        if a > b { (a, vec![x[0].signum(), 0.0]) } else { (b, vec![0.0, (x[1] - 1.0).signum()]) }
    }

    #[test]
    fn a_function_with_kinks_is_minimised() {
        let start = vec![10.0, -7.0];
        let (value, slope) = function(&start);
        let mut bundle = Bundle::new(start, value, slope, 1.0);
        for _ in 0..60 {
            let next = bundle.next();
            let (value, slope) = function(&next);
            bundle.learn(next, value, slope);
        }
        assert!((bundle.value - 2.0).abs() < 1e-3, "{} at {:?}", bundle.value, bundle.centre);
    }
}
