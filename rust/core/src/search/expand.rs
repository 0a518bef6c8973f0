//! Expanding a leaf: its belief, its actions, and the children of each.

use super::Search;
use super::outcomes::ScanOutcomes;
use super::shortfall::{Features, left_to_learn};
use super::tree::{Child, Edge, Node, Place, Values};
use crate::belief::Belief;
use crate::bounds;
use crate::index::{Label, Position, Viewpoint};
use crate::model::{Action, SortingModel};
use crate::offline::ScanBounds;
use crate::planes;
use crate::scenario::LookPoint;

/// A scan in the scenarios, and the belief just before it.
struct Scan<'a> {
    node: &'a Node,
    belief: &'a Belief,
    viewpoint: Viewpoint,
    /// Decisions before it.
    decisions: usize,
}

impl Search<'_> {
    /// Expand the leaf at a place.
    pub(super) fn expand(&mut self, place: Option<Place>) {
        let mut node = self.node_at(place);
        let decide = Action::Decide(node.belief.best_decision(&self.planner.model).0);
        let moves = self.planner.model.legal_moves(node.viewpoint).iter().map(|to| Action::Move(*to));
        node.edges = std::iter::once(decide).chain(moves).map(|action| self.edge(&node, action)).collect();
        self.nodes_created += node.edges.iter().map(|edge| edge.children.len() as u64).sum::<u64>();
        let moves = node.edges.len() as u64 - 1;
        self.scenario_steps += moves * planes::count(&node.scenarios);
        self.tree.attach(node);
    }

    /// The node of a leaf, without actions.
    fn node_at(&self, place: Option<Place>) -> Node {
        let default = self.tree.child(place).values.lower;
        let Some(Place { node, edge, child }) = place else {
            return Node {
                place,
                depth: 0,
                decisions: 0,
                viewpoint: self.viewpoint,
                belief: self.belief.clone(),
                default,
                scenarios: planes::first(self.planner.config.scenarios),
                edges: Vec::new(),
            };
        };
        let parent = &self.tree.nodes[node];
        let edge = &parent.edges[edge];
        let labels = edge.labels_of(child).unwrap_or(&[]);
        let (before_scan, viewpoint) = after(&self.planner.model, parent, edge.action, &[]);
        let (belief, _) = after(&self.planner.model, parent, edge.action, labels);
        let decisions = parent.decisions + usize::from(matches!(edge.action, Action::Decide(_)));
        let mut scenarios = parent.scenarios.clone();
        let scan = Scan { node: parent, belief: &before_scan, viewpoint, decisions };
        for (look, label) in scan.looks(&self.planner.model, labels.len()).into_iter().zip(labels) {
            let given = self.scenarios.label(look, *label);
            scenarios.iter_mut().zip(given).for_each(|(word, given)| *word &= given);
        }
        let depth = parent.depth + 1;
        Node { place, depth, decisions, viewpoint, belief, default, scenarios, edges: Vec::new() }
    }

    /// An action at a node. All decisions lead to the same next belief, so that on the most likely class stands for all.
    fn edge(&self, node: &Node, action: Action) -> Edge {
        let planner = self.planner;
        let (model, policy) = (&planner.model, &planner.default_policy);
        let step = model.step(action, node.viewpoint, node.belief.objects_left());
        let reward = model.expected_reward(&step, node.belief.position(Position(0)).as_slice());
        let mut belief = node.belief.clone();
        if step.advances() {
            belief.advance(model);
        }
        if let Some(viewpoint) = step.scan {
            let decisions = node.decisions + usize::from(step.advances());
            return self.scan(&Scan { node, belief: &belief, viewpoint, decisions }, action, reward);
        }
        let value = bounds::lower(model, policy, belief.known(), step.viewpoint);
        let upper = planner.upper(&belief, step.viewpoint);
        let bound = if planner.certificate_for(&belief).is_some() { upper - value } else { 0.0 };
        let features = Features { mass: 1.0, value, entropy: left_to_learn(model, &belief), bound };
        let values = planner.leaf(node.depth + 1, &belief, features, upper);
        let child = Child { values, probability: 1.0, node: None };
        let fixed = Values::all(reward);
        Edge {
            action,
            discount: model.discount(),
            fixed,
            values: fixed,
            children: vec![child],
            labels: Vec::new(),
        }
    }

    /// An action that ends in a scan: a child per label vector that some scenario gives. The others follow the default
    /// policy: what it is worth in expectation over all label vectors, less what the children take of it.
    fn scan(&self, scan: &Scan<'_>, action: Action, reward: f64) -> Edge {
        let planner = self.planner;
        let outcomes =
            ScanOutcomes::new(&planner.model, &planner.default_policy, scan.belief, scan.viewpoint);
        let certificate = planner
            .certificate_for(scan.belief)
            .map(|bound| bound.after_scan(&planner.model, scan.belief, scan.viewpoint));
        let looks = scan.looks(&planner.model, outcomes.positions());
        let mut branches = Branches {
            search: self,
            scan,
            outcomes: &outcomes,
            certificate: certificate.as_ref(),
            looks: &looks,
            children: Vec::new(),
            labels: Vec::new(),
            sum: Features::default(),
            upper: 0.0,
            certified: 0.0,
        };
        let all = Features { mass: 1.0, ..Features::default() };
        branches.descend(&scan.node.scenarios, &[], all, outcomes.unseen());
        let Branches { children, labels, sum, upper, certified, .. } = branches;
        let rest = Features {
            mass: (1.0 - sum.mass).max(0.0),
            value: outcomes.expected_value() - sum.value,
            entropy: outcomes.expected_entropy() - sum.entropy,
            bound: certificate
                .as_ref()
                .map_or(0.0, |bounds| bounds.expected_upper() - outcomes.expected_value())
                - sum.bound,
        };
        let reward = reward + outcomes.bonus;
        let discount = planner.model.discount();
        let bound = reward + discount * rest.value;
        let closed = outcomes.expected_upper() - upper;
        let rest_upper = certificate.map_or(closed, |bounds| closed.min(bounds.expected_upper() - certified));
        let fixed = Values {
            estimate: bound + discount * planner.shortfall.at(rest, scan.belief.objects_left()),
            certified: reward + discount * rest_upper,
            ..Values::all(bound)
        };
        Edge { action, discount, fixed, values: fixed, children, labels }
    }

    /// Expand all leaves below a node at which there is something to find.
    pub(super) fn expand_children(&mut self, node: usize) {
        for edge in 0..self.tree.nodes[node].edges.len() {
            for child in 0..self.tree.nodes[node].edges[edge].children.len() {
                let place = Some(Place { node, edge, child });
                let leaf = self.tree.child(place);
                if leaf.node.is_none() && leaf.values.gap() > 0.0 {
                    self.expand(place);
                }
            }
        }
    }
}

/// The belief and the viewpoint after an action at a node and the labels of its scan, if any.
pub(super) fn after(
    model: &SortingModel,
    node: &Node,
    action: Action,
    labels: &[Label],
) -> (Belief, Viewpoint) {
    let step = model.step(action, node.viewpoint, node.belief.objects_left());
    let (mut belief, viewpoint) = (node.belief.clone(), step.viewpoint);
    if step.advances() {
        belief.advance(model);
    }
    for (position, label) in model.positions().zip(labels) {
        // A scenario gives it, so it is possible.
        let _ = belief.observe_one(model, position, viewpoint, *label);
    }
    (belief, viewpoint)
}

impl Scan<'_> {
    /// Its looks, one per position at which an object is left.
    fn looks(&self, model: &SortingModel, positions: usize) -> Vec<LookPoint> {
        let look = |position| LookPoint {
            depth: self.node.depth,
            decisions: self.decisions,
            look: self.belief.look(model, position, self.viewpoint),
        };
        model.positions().take(positions).map(look).collect()
    }
}

/// The label vectors of a scan that some scenario gives, from the last position to the belt end: a position's labels
/// are tried only where scenarios are left.
struct Branches<'a, 'b> {
    search: &'a Search<'b>,
    scan: &'a Scan<'a>,
    outcomes: &'a ScanOutcomes,
    certificate: Option<&'a ScanBounds<'a>>,
    looks: &'a [LookPoint],
    children: Vec<Child>,
    labels: Vec<Label>,
    /// Of all children, each with its probability.
    sum: Features,
    /// Their upper bounds in closed form, and by the certificate, each with its probability.
    upper: f64,
    certified: f64,
}

impl Branches<'_, '_> {
    /// Go on from `behind`, the labels of the last positions: their probability and entropy, their scenarios, and the
    /// value of these positions per viewpoint group.
    fn descend(&mut self, scenarios: &[u64], behind: &[Label], so_far: Features, worth: &[f64]) {
        let Some(position) = self.looks.len().checked_sub(behind.len() + 1) else {
            return self.child(behind, Features { value: worth[self.outcomes.group()], ..so_far });
        };
        for (label, p) in (0..).map(Label).zip(self.outcomes.probabilities(Position(position))) {
            let mut given = vec![0; scenarios.len()];
            let plane = self.search.scenarios.label(self.looks[position], label);
            if *p == 0.0 || !planes::intersect(scenarios, plane, &mut given) {
                continue;
            }
            let labels = [&[label], behind].concat();
            let entropy = so_far.entropy + self.outcomes.entropy(Position(position), label);
            let worth = self.outcomes.value_after(Position(position), label, worth);
            self.descend(&given, &labels, Features { mass: so_far.mass * p, entropy, ..so_far }, &worth);
        }
    }

    fn child(&mut self, labels: &[Label], Features { mass: probability, value, entropy, .. }: Features) {
        let closed = self.outcomes.upper(labels[0]);
        let certified = self.certificate.map_or(closed, |bounds| bounds.upper(labels));
        let upper = closed.min(certified);
        let bound = self.certificate.map_or(0.0, |_| certified - value);
        let leaf = Features { mass: 1.0, value, entropy, bound };
        self.sum.bound += probability * bound;
        let values = self.search.planner.leaf(self.scan.node.depth + 1, self.scan.belief, leaf, upper);
        self.sum.mass += probability;
        self.sum.value += probability * value;
        self.sum.entropy += probability * entropy;
        self.upper += probability * closed;
        self.certified += probability * certified;
        self.children.push(Child { values, probability, node: None });
        self.labels.extend(labels);
    }
}
