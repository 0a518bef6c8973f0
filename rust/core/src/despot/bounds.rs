//! Bounds of a node from the class histograms of its scenarios: a default policy's value, and that of knowing all.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::index::{Bin, Label, Position, Viewpoint};
use crate::model::{Action, Look, SortingModel};
use crate::policy::next_moves;
use crate::remaining::Remaining;

/// Label sequences that the looks at one object may have at most.
const MOST_SEQUENCES: usize = 1024;
/// Objects farther away than discounting leaves this much of are as good as endlessly many.
const NEGLIGIBLE: f64 = 1e-10;
/// Largest number of objects whose value is not taken as that of endlessly many.
const MOST_OBJECTS: f64 = 20_000.0;

/// Values that are kept for known kinds at most.
const MOST_CERTAIN: usize = 1 << 16;
/// Sweeps for the cost of looking for ever.
const MOST_SWEEPS: usize = 10_000;

/// What single objects are worth: to the default policy, and to who knows their classes.
///
/// The default policy sorts one object after the other: it decides what earns most on the average over the node's scenarios,
/// or looks a fixed number of times and decides by these labels alone, or looks on for ever; whichever is worth most.
/// The looks decide by the arrival prior, so their value for an object of a given class is a constant of the model
/// and cannot fit the scenarios; objects that no scan has shown yet are valued by the prior.
#[derive(Debug)]
pub(super) struct Bounds {
    model: SortingModel,
    /// From each viewpoint.
    looks: Vec<Looks>,
    /// Looking for ever from each viewpoint; minus infinity where that is impossible.
    forever: Vec<f64>,
    /// `[objects][viewpoint]`: the default policy's value for so many unseen objects; the last for endlessly many.
    unseen: Vec<Vec<f64>>,
    /// `[objects]`: deciding so many objects right, one a step; the last for endlessly many.
    knowing: Vec<f64>,
    /// The default policy's value on an endless belt if all kinds are known, as in a single scenario: entry
    /// `(2 * viewpoint + fresh) * N^H + kinds`, kinds as digits in base N, the belt end's last. None if they are many.
    certain: Vec<f64>,
}

/// Looks at the object at the belt end, then the decision by their labels.
#[derive(Debug, Clone)]
struct Looks {
    /// Discounted reward for an object of each kind.
    worth: Vec<f64>,
    /// Discount up to the step after the decision.
    discount: f64,
    /// The first move.
    first: Option<Viewpoint>,
    /// Where the camera stands afterwards.
    end: Viewpoint,
}

/// The scenarios at a node as its bounds see them.
pub(super) struct Histogram<'a> {
    /// Share of each kind at each position where an object is left.
    pub shares: &'a [f64],
    /// Objects left to decide.
    pub remaining: Remaining,
    /// Where the camera stands.
    pub viewpoint: Viewpoint,
    /// Whether no label from here can repeat one already seen at the belt end.
    pub fresh: bool,
}

impl Bounds {
    /// The best default policy of those tried before `stop` is set, of at least one.
    pub(super) fn new(model: &SortingModel, stop: &AtomicBool) -> Self {
        let (spec, most) = (model.spec(), model.most_reward());
        let far = (NEGLIGIBLE.ln() / spec.discount.ln()).ceil().min(MOST_OBJECTS);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 1 and MOST_OBJECTS
        let objects = far as usize;
        let knowing = std::iter::successors(Some(0.0), |value| Some(most + spec.discount * value));
        let mut bounds = Self {
            model: model.clone(),
            looks: Vec::new(),
            forever: Vec::new(),
            unseen: Vec::new(),
            knowing: knowing.take(objects).chain([most / (1.0 - spec.discount)]).collect(),
            certain: Vec::new(),
        };
        let mut best = f64::NEG_INFINITY;
        for target in model.viewpoints() {
            for looks in (0..).take_while(|looks| sequences(model, *looks) <= MOST_SEQUENCES) {
                if best.is_finite() && stop.load(Ordering::Relaxed) {
                    return bounds;
                }
                let (plans, forever) = plans(model, target, looks);
                let unseen = values_of_unseen(model, &plans, &forever, objects);
                let worth = unseen[objects].iter().sum();
                if worth > best {
                    best = worth;
                    (bounds.looks, bounds.forever, bounds.unseen) = (plans, forever, unseen);
                }
            }
        }
        bounds.certain = bounds.values_of_certainty();
        bounds
    }

    fn values_of_certainty(&self) -> Vec<f64> {
        let Some(vectors) = kind_vectors(&self.model) else { return Vec::new() };
        let (kinds, mut scratch) = (self.model.kind_count(), Vec::new());
        let mut value = |viewpoint: Viewpoint, fresh: bool, vector: usize| {
            let known = self.model.positions().scan(vector, |rest, _| {
                let kind = *rest % kinds;
                *rest /= kinds;
                Some(kind)
            });
            let shares: Vec<f64> = known
                .flat_map(|known| (0..kinds).map(move |kind| f64::from(u8::from(kind == known))))
                .collect();
            let at = Histogram { shares: &shares, remaining: Remaining::ENDLESS, viewpoint, fresh };
            self.default_policy(&at, &mut scratch).0
        };
        let mut values = Vec::new();
        for (viewpoint, fresh) in self.model.viewpoints().flat_map(|v| [(v, false), (v, true)]) {
            values.extend((0..vectors).map(|vector| value(viewpoint, fresh, vector)));
        }
        values
    }

    /// The value of [`Bounds::default_policy`] in a single scenario on an endless belt, if it is kept.
    #[inline(always)]
    pub(super) fn certain(&self, viewpoint: Viewpoint, fresh: bool) -> Option<&[f64]> {
        let vectors = self.certain.len() / (2 * self.looks.len());
        let first = (2 * viewpoint.0 + usize::from(fresh)) * vectors;
        (vectors > 0).then(|| &self.certain[first..][..vectors])
    }

    /// What so many objects would be worth to who knows their classes: the fully observable upper bound.
    pub(super) fn upper(&self, remaining: Remaining) -> f64 {
        self.knowing[self.number(remaining)]
    }

    /// The default policy's value and its first action, `L_0` of the DESPOT paper.
    #[inline(always)]
    pub(super) fn default_policy(&self, at: &Histogram<'_>, scratch: &mut Vec<f64>) -> (f64, Action) {
        let unseen = &self.unseen[self.number(at.remaining.unseen(self.model.position_count()))];
        let visible = at.remaining.visible(self.model.position_count());
        // Entry i: the value with the camera where i rounds of looks have left it.
        scratch.clear();
        let mut viewpoint = at.viewpoint;
        for _ in 0..=visible {
            scratch.push(unseen[viewpoint.0]);
            viewpoint = self.looks[viewpoint.0].end;
        }
        let mut action = Action::Decide(Bin(0));
        for (position, shares) in at.shares.chunks_exact(self.model.kind_count()).enumerate().rev() {
            let (bin, reward) = self.model.best_decision(shares);
            let mut viewpoint = at.viewpoint;
            for round in 0..=position {
                let looks = &self.looks[viewpoint.0];
                let decided = reward + self.model.discount() * scratch[round];
                let mut looked = self.forever[viewpoint.0];
                if position > 0 || at.fresh {
                    looked = looked.max(looks.value(shares) + looks.discount * scratch[round + 1]);
                }
                scratch[round] = decided.max(looked);
                action = match looks.first {
                    Some(first) if looked > decided => Action::Move(first),
                    _ => Action::Decide(bin),
                };
                viewpoint = looks.end;
            }
        }
        (scratch[0], action)
    }

    fn number(&self, remaining: Remaining) -> usize {
        let endless = self.knowing.len() - 1;
        remaining.0.map_or(endless, |objects| objects.min(endless))
    }
}

impl Looks {
    #[inline(always)]
    fn value(&self, shares: &[f64]) -> f64 {
        self.worth.iter().zip(shares).map(|(worth, share)| worth * share).sum()
    }
}

/// Vectors of kinds at all positions, if values of all of them from everywhere are few enough to keep.
fn kind_vectors(model: &SortingModel) -> Option<usize> {
    let positions = u32::try_from(model.position_count()).ok()?;
    let vectors = model.kind_count().checked_pow(positions)?;
    (vectors.saturating_mul(2 * model.viewpoint_count()) <= MOST_CERTAIN).then_some(vectors)
}

/// Label sequences of so many looks.
fn sequences(model: &SortingModel, looks: u32) -> usize {
    model.label_count().checked_pow(looks).unwrap_or(usize::MAX)
}

/// From each viewpoint: so many looks on the way to `target` and at it, and looking like that for ever.
fn plans(model: &SortingModel, target: Viewpoint, looks: u32) -> (Vec<Looks>, Vec<f64>) {
    let next = next_moves(model, target);
    let plan = |viewpoint: Viewpoint| {
        let path = std::iter::successors(next[viewpoint.0], |at| next[at.0]).take(looks as usize).collect();
        Path { model, path }.looks(viewpoint)
    };
    // From below: a lower bound whenever the sweeps stop.
    let dearest = model.viewpoints().filter_map(|from| next[from.0].map(|to| model.motion_cost(from, to)));
    let dearest = dearest.fold(0.0, f64::max);
    let mut forever = vec![-dearest / (1.0 - model.discount()); next.len()];
    for _ in 0..MOST_SWEEPS {
        let step = |(from, to): (Viewpoint, &Option<Viewpoint>)| {
            to.map_or(f64::NEG_INFINITY, |to| model.discount() * forever[to.0] - model.motion_cost(from, to))
        };
        let once_more: Vec<f64> = model.viewpoints().zip(&next).map(step).collect();
        if once_more == forever {
            break;
        }
        forever = once_more;
    }
    (model.viewpoints().map(plan).collect(), forever)
}

/// Viewpoints from which one object is looked at.
struct Path<'a> {
    model: &'a SortingModel,
    path: Vec<Viewpoint>,
}

impl Path<'_> {
    fn looks(&self, from: Viewpoint) -> Looks {
        let Self { model, path } = self;
        let (mut at, mut discount, mut cost) = (from, 1.0, 0.0);
        for &to in path {
            cost += discount * model.motion_cost(at, to);
            (at, discount) = (to, discount * model.discount());
        }
        let mut earned = vec![0.0; model.kind_count()];
        self.decide(&mut Vec::new(), &vec![1.0; model.kind_count()], &mut earned);
        Looks {
            worth: earned.iter().map(|earned| discount * earned - cost).collect(),
            discount: discount * model.discount(),
            first: path.first().copied(),
            end: at,
        }
    }

    /// Add to `earned` the reward of the decision by the labels, weighted by how likely each kind gives them, those seen
    /// so far coming first.
    fn decide(&self, seen: &mut Vec<Label>, likelihoods: &[f64], earned: &mut [f64]) {
        let Self { model, path } = self;
        let Some(&viewpoint) = path.get(seen.len()) else {
            let joint: Vec<f64> = likelihoods.iter().zip(model.arrival()).map(|(l, p)| l * p).collect();
            let (bin, _) = model.best_decision(&joint);
            for ((earned, likelihood), kind) in earned.iter_mut().zip(likelihoods).zip(model.kinds()) {
                *earned += likelihood * model.reward(bin, kind);
            }
            return;
        };
        let last = path.iter().zip(&*seen).rev().find(|(from, _)| **from == viewpoint).map(|(_, z)| *z);
        for label in model.labels() {
            let of_label = model.likelihoods(Look { position: Position(0), viewpoint, last }, label);
            let likelihoods: Vec<f64> = likelihoods.iter().zip(of_label).map(|(l, p)| l * p).collect();
            seen.push(label);
            self.decide(seen, &likelihoods, earned);
            seen.pop();
        }
    }
}

/// The default policy's values for 0 to `objects` unseen objects, from each viewpoint.
fn values_of_unseen(model: &SortingModel, plans: &[Looks], forever: &[f64], objects: usize) -> Vec<Vec<f64>> {
    let arrival = model.arrival().as_slice();
    let more = |fewer: &Vec<f64>| {
        let value = |(looks, forever): (&Looks, &f64)| {
            forever.max(looks.value(arrival) + looks.discount * fewer[looks.end.0])
        };
        Some(plans.iter().zip(forever).map(value).collect())
    };
    std::iter::successors(Some(vec![0.0; plans.len()]), more).take(objects + 1).collect()
}
