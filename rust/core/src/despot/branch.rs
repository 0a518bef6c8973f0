//! A scan in the tree: a child per label vector that some scenario gives; the other labels follow the default policy.

use super::Despot;
use super::shortfall::Prospect;
use crate::belief::{Memory, information, most_likely};
use crate::bounds::{self, Look};
use crate::model::{Action, SortingModel};
use crate::planes;
use crate::scenario::{LabelPlanes, LookPoint};
use crate::tree::{Child, Node, Values};

/// Where in the scenarios a scan is taken.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scan {
    /// Planner steps before it.
    pub depth: usize,
    /// Decisions before it.
    pub decisions: usize,
    /// Where the camera stands.
    pub viewpoint: usize,
}

impl Scan {
    /// The scan that an action at a node brings, if any.
    pub(super) fn of(model: &SortingModel, node: &Node, action: Action) -> Option<Self> {
        let &Node { depth, decisions, viewpoint, .. } = node;
        match action {
            Action::Move(viewpoint) => Some(Self { depth, decisions, viewpoint }),
            Action::Decide(_) if model.observes_after_decision() => {
                Some(Self { depth, decisions: decisions + 1, viewpoint })
            }
            Action::Decide(_) => None,
        }
    }

    /// Its look at one position.
    #[inline(always)]
    pub(super) fn look(&self, model: &SortingModel, memory: &Memory, position: usize) -> LookPoint {
        let &Self { depth, decisions, viewpoint } = self;
        LookPoint { depth, decisions, viewpoint, position, last: memory.last(model, position, viewpoint) }
    }

    /// Reward for what it is expected to tell.
    #[inline(always)]
    pub(super) fn bonus(&self, model: &SortingModel, belief: &[f64], memory: &Memory) -> f64 {
        let alpha = model.spec().information_gain;
        if alpha == 0.0 {
            return 0.0;
        }
        let told = |(j, position): (usize, &[f64])| {
            information(model, position, j, self.viewpoint, memory.last(model, j, self.viewpoint))
        };
        alpha * belief.chunks_exact(model.class_count()).enumerate().map(told).sum::<f64>()
    }
}

/// Enumeration of label vectors, from the last position to the belt end; a position's label is only tried where
/// scenarios are left. The buffers are reused.
#[derive(Debug, Default)]
pub(super) struct Brancher {
    look: Look,
    /// Upper bound after each label of the object at the belt end.
    uppers: Vec<f64>,
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
}

impl Brancher {
    /// Take a scan apart.
    #[inline(always)]
    pub(super) fn take(&mut self, despot: &Despot, belief: &[f64], memory: &Memory, scan: &Scan) {
        let model = &despot.model;
        self.look.take(model, &despot.default_policy, belief, memory, scan.viewpoint);
        let upper =
            |z| bounds::upper_knowing(model, most_likely(self.look.posterior(0, z)).1, scan.viewpoint);
        self.uppers.clear();
        self.uppers.extend((0..model.class_count()).map(upper));
    }

    /// A child per label vector that a scenario gives.
    #[inline(always)]
    pub(super) fn branch(
        &mut self,
        despot: &Despot,
        labels: &LabelPlanes,
        (node, scan, memory): (&mut Node, &Scan, &Memory),
    ) {
        let (l, h) = (despot.model.class_count(), despot.model.position_count());
        self.start(despot, &node.scenarios);
        let mut j = h - 1;
        loop {
            if self.labels[j] == l {
                self.labels[j] = 0;
                j += 1;
                if j == h {
                    return;
                }
            } else if self.enter(despot, labels, scan.look(&despot.model, memory, j)) {
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
        let (h, words) = (despot.model.position_count(), scenarios.len());
        let arrival = despot.default_policy.arrival_values();
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
        self.branched = Prospect::default();
    }

    /// Take the label at hand of one position; whether any scenario gives it.
    #[inline(always)]
    fn enter(&mut self, despot: &Despot, labels: &LabelPlanes, at: LookPoint) -> bool {
        let (j, z) = (at.position, self.labels[at.position]);
        let (words, g) = (self.planes.len() / self.probabilities.len(), despot.default_policy.group_count());
        let probability = self.probabilities[j + 1] * self.look.probability(j, z);
        let (here, behind) = self.planes.split_at_mut((j + 1) * words);
        let given = labels.label(at, z);
        if probability <= 0.0 || !planes::intersect(&behind[..words], given, &mut here[j * words..]) {
            return false;
        }
        let (here, behind) = self.worth.split_at_mut((j + 1) * g);
        self.look.value_from(j, z, &behind[..g], &mut here[j * g..]);
        self.probabilities[j] = probability;
        self.entropies[j] = self.entropies[j + 1] + self.look.entropy(j, z);
        true
    }

    /// The child of the labels at hand.
    #[inline(always)]
    fn child(&mut self, despot: &Despot, node: &Node) -> Child {
        let l = despot.model.class_count() as u64;
        let probability = self.probabilities[0];
        let (value, entropy) = (self.worth[self.look.group()], self.entropies[0]);
        self.branched.mass += probability;
        self.branched.value += probability * value;
        self.branched.entropy += probability * entropy;
        let probability = node.probability * probability;
        let labels = self.labels.iter().rev().fold(0, |code, z| code * l + *z as u64);
        let values = despot.leaf((node.depth + 1, probability), value, entropy, self.uppers[self.labels[0]]);
        Child { values, probability, labels, node: None }
    }

    /// Values of the edge, its children left out: what the step earns, and the labels without a branch.
    #[inline(always)]
    pub(super) fn fixed(&self, despot: &Despot, node: &Node, reward: f64) -> Values {
        let scale = despot.scale(node.depth, node.probability);
        let next = scale * despot.model.discount();
        let rest = Prospect {
            mass: next * (1.0 - self.branched.mass).max(0.0),
            value: next * (self.look.value() - self.branched.value),
            entropy: next * (self.look.expected_entropy() - self.branched.entropy),
        };
        let bound = scale * reward + rest.value - despot.config.regularization;
        Values { estimate: bound + despot.shortfall.at(rest), ..Values::all(bound) }
    }
}
