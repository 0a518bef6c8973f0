//! A scan in the tree: a child per label vector that some scenario gives; the other labels follow the default policy.

use super::Despot;
use super::objects::Objects;
use super::scan::Scan;
use super::shortfall::Prospect;
use crate::bounds::{self, Foresight, Look};
use crate::index::{Label, Position};
use crate::one_object::dot;
use crate::planes;
use crate::remaining::Remaining;
use crate::scenario::LookPoint;
use crate::tree::{Child, Node, Object, Values};

/// Enumeration of label vectors, from the last position to the belt end; a position's label is only tried where
/// scenarios are left. The buffers are reused.
#[derive(Debug, Default)]
pub(super) struct Brancher {
    foresight: Foresight,
    /// Objects left to decide.
    remaining: Remaining,
    /// Where in the scenarios each look is.
    points: Vec<LookPoint>,
    /// Upper bound after each label of the object at the belt end.
    uppers: Vec<f64>,
    /// The same expected over all labels.
    expected_upper: f64,
    /// Label of each position.
    labels: Vec<usize>,
    /// Scenarios left at each position, and behind the last one all of the node.
    planes: Vec<u64>,
    /// Probability of the labels from each position on.
    probabilities: Vec<f64>,
    /// Value of each position and those behind it, per viewpoint group.
    worth: Vec<f64>,
    /// What is left to learn about each position and those behind it, where learning is rewarded.
    entropies: Vec<f64>,
    /// All labels with a branch.
    branched: Prospect,
    /// Upper bound of what they promise.
    branched_upper: f64,
}

impl Brancher {
    /// Take a scan of objects apart; the bonus that it is expected to earn.
    #[inline(always)]
    pub(super) fn take(
        &mut self,
        despot: &Despot,
        known: Objects<'_>,
        objects: &[Object],
        scan: &Scan,
    ) -> f64 {
        let model = &despot.model;
        let looks = known.looks(objects, scan.viewpoint);
        self.remaining = scan.remaining;
        let unseen = scan.remaining.unseen(model.position_count());
        self.foresight.take(&despot.default_policy, looks.clone(), scan.viewpoint, unseen);
        self.points.clear();
        self.uppers.clear();
        for (position, object) in (0..).map(Position).zip(objects) {
            self.points.push(scan.look(known.sightings.sighting(*object, position, scan.viewpoint)));
        }
        let upper = bounds::upper_knowing(model, scan.viewpoint, scan.remaining);
        for look in looks.clone().take(1) {
            self.uppers.extend((0..model.class_count()).map(|z| upper(look.most_likely(z).1)));
            self.expected_upper = dot(look.probabilities(), &self.uppers);
        }
        model.spec().information_gain * looks.map(Look::information).sum::<f64>()
    }

    /// A child per label vector that a scenario gives.
    #[inline(always)]
    pub(super) fn branch(&mut self, despot: &Despot, known: Objects<'_>, node: &mut Node) {
        let (l, h) = (despot.model.class_count(), self.points.len());
        self.start(despot, &node.scenarios);
        let mut j = h - 1;
        loop {
            if self.labels[j] == l {
                self.labels[j] = 0;
                j += 1;
                if j == h {
                    return;
                }
            } else if self.enter(despot, known, self.points[j]) {
                if j > 0 {
                    j -= 1;
                    continue;
                }
                let child = self.child(despot, node);
                node.children.push(child);
            }
            self.labels[j] += 1;
        }
    }

    fn start(&mut self, despot: &Despot, scenarios: &[u64]) {
        let (h, words) = (self.points.len(), scenarios.len());
        let unseen = self.remaining.unseen(despot.model.position_count());
        let arrival = despot.default_policy.values_of_unseen(unseen);
        self.labels.clear();
        self.labels.resize(h, 0);
        self.planes.resize((h + 1) * words, 0);
        self.planes[h * words..].copy_from_slice(scenarios);
        self.probabilities.clear();
        self.probabilities.resize(h + 1, 1.0);
        self.worth.resize((h + 1) * arrival.len(), 0.0);
        self.worth[h * arrival.len()..].copy_from_slice(arrival);
        self.entropies.clear();
        self.entropies.resize(h + 1, 0.0);
        (self.branched, self.branched_upper) = (Prospect::default(), 0.0);
    }

    /// Take the label at hand of one position; whether any scenario gives it.
    #[inline(always)]
    fn enter(&mut self, despot: &Despot, known: Objects<'_>, at: LookPoint) -> bool {
        let j = at.look.position.0;
        let z = self.labels[j];
        let (words, g) = (self.planes.len() / self.probabilities.len(), despot.default_policy.group_count());
        let probability = self.probabilities[j + 1] * self.foresight.probability(j, z);
        let (here, behind) = self.planes.split_at_mut((j + 1) * words);
        let given = known.label(at, Label(z));
        if probability <= 0.0 || !planes::intersect(&behind[..words], given, &mut here[j * words..]) {
            return false;
        }
        let (here, behind) = self.worth.split_at_mut((j + 1) * g);
        self.foresight.value_from(j, z, &behind[..g], &mut here[j * g..]);
        self.probabilities[j] = probability;
        self.entropies[j] = self.entropies[j + 1] + self.foresight.entropy(j, z);
        true
    }

    /// The child of the labels at hand.
    #[inline(always)]
    fn child(&mut self, despot: &Despot, node: &Node) -> Child {
        let l = despot.model.class_count() as u64;
        let probability = self.probabilities[0];
        let (value, entropy) = (self.worth[self.foresight.group()], self.entropies[0]);
        let upper = self.uppers[self.labels[0]];
        self.branched.mass += probability;
        self.branched.value += probability * value;
        self.branched.entropy += probability * entropy;
        self.branched_upper += probability * upper;
        let probability = node.probability * probability;
        let labels = self.labels.iter().rev().fold(0, |code, z| code * l + *z as u64);
        let values = despot.leaf((node.depth + 1, probability, self.remaining), value, entropy, upper);
        Child { values, probability, labels, node: None }
    }

    /// Values of the edge, its children left out: what the step earns, and the labels without a branch.
    #[inline(always)]
    pub(super) fn fixed(&self, despot: &Despot, node: &Node, reward: f64) -> Values {
        let scale = despot.scale(node.depth, node.probability);
        let next = scale * despot.model.discount();
        let rest = Prospect {
            mass: next * (1.0 - self.branched.mass).max(0.0),
            value: next * (self.foresight.value() - self.branched.value),
            entropy: next * (self.foresight.expected_entropy() - self.branched.entropy),
        };
        let bound = scale * reward + rest.value - despot.config.regularization;
        let estimate = bound + despot.shortfall.at(rest, self.remaining);
        let certified = scale * reward + next * (self.expected_upper - self.branched_upper);
        Values { estimate, certified, ..Values::all(bound) }
    }
}
