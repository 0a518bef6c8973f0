//! Expanding a leaf of the search: its actions, and the children of each.

use super::priced::least;
use super::search::Search;
use super::serving::Served;
use crate::index::{Label, Position, Viewpoint};
use crate::moving::action::MovingAction;
use crate::moving::state::State;
use crate::search::{Child, Edge, Node, Place, Values};

pub(super) type MovingNode = Node<MovingAction, State>;
pub(super) type MovingEdge = Edge<MovingAction>;

/// An undecided object that a look is about to see: the labels that it may give, their probabilities, and the beliefs after.
struct Seen {
    place: usize,
    labels: Vec<(Label, f64, Vec<f64>)>,
}

impl Search<'_> {
    /// Expand the leaf at a place.
    pub(super) fn expand(&mut self, place: Option<Place>) {
        let mut node = self.node_at(place);
        let steps = self.steps(&node);
        node.edges = steps.into_iter().map(|step| self.edge(&node, step)).collect();
        self.nodes_created += node.edges.iter().map(|edge| edge.children.len() as u64).sum::<u64>();
        self.tree.attach(node);
    }

    /// The node of a leaf, without actions.
    fn node_at(&self, place: Option<Place>) -> MovingNode {
        let default = self.tree.child(place).values.lower;
        let Some(Place { node, edge, child }) = place else {
            return Node {
                place,
                depth: 0,
                decisions: 0,
                viewpoint: self.viewpoint,
                belief: self.state.clone(),
                default,
                scenarios: (0..self.planner.scenarios() as u64).collect(),
                edges: Vec::new(),
            };
        };
        let parent = &self.tree.nodes[node];
        let edge = &parent.edges[edge];
        let (mut belief, viewpoint, _) = self.planner.after(&parent.belief, parent.viewpoint, edge.action);
        let mut scenarios = parent.scenarios.clone();
        if let Some(labels) = edge.labels_of(child) {
            let seen = self.seen(&belief, viewpoint);
            scenarios.retain(|scenario| {
                seen.iter()
                    .zip(labels)
                    .all(|(seen, label)| self.drawn(*scenario, parent.depth, seen) == *label)
            });
            for (seen, label) in seen.into_iter().zip(labels) {
                if let Some((_, _, after)) = seen.labels.into_iter().find(|(other, ..)| other == label) {
                    belief.rows[seen.place] = after;
                }
            }
        }
        let decisions = parent.decisions + usize::from(matches!(edge.action, MovingAction::Decide { .. }));
        let depth = parent.depth + 1;
        Node { place, depth, decisions, viewpoint, belief, default, scenarios, edges: Vec::new() }
    }

    /// The actions worth comparing at a node.
    ///
    /// Decisions that take no time commute, so after one of them only objects farther from the exit are decided in the same
    /// tick. Where deciding an object earns no less than it could with looks for nothing, that is optimal whatever the others
    /// need, since it takes nothing from them: then it is the only action.
    fn steps(&self, node: &MovingNode) -> Vec<MovingAction> {
        let planner = self.planner;
        let (timing, model) = (planner.timing(), &planner.model);
        let at_once = timing.sort_ticks == 0;
        let last =
            node.place.and_then(|Place { node, edge, .. }| match self.tree.nodes[node].edges[edge].action {
                MovingAction::Decide { position, .. } if at_once => Some(position.0 + 1),
                _ => None,
            });
        let mut steps = Vec::new();
        for place in 0..timing.reach {
            if node.belief.decided[place] {
                continue;
            }
            let (bin, reward) = model.best_decision(&node.belief.rows[place]);
            let decide = MovingAction::Decide { position: Position(place), bin };
            let left = node.belief.ticks_left(timing, place);
            if at_once && reward >= planner.with_free_looks(left, node.viewpoint, &node.belief.rows[place]) {
                return vec![decide];
            }
            if place >= last.unwrap_or(0) {
                steps.push(decide);
            }
        }
        steps.push(MovingAction::Wait);
        steps.extend(model.legal_moves(node.viewpoint).iter().map(|to| MovingAction::Look(*to)));
        steps
    }

    fn edge(&self, node: &MovingNode, action: MovingAction) -> MovingEdge {
        let planner = self.planner;
        let (belief, viewpoint, earned) = planner.after(&node.belief, node.viewpoint, action);
        let discount = planner.discount(action, node.viewpoint);
        let seen = match action {
            MovingAction::Look(_) => self.seen(&belief, viewpoint),
            _ => Vec::new(),
        };
        if !seen.is_empty() {
            return self.scan(node, action, &belief, (earned, discount), seen);
        }
        let lower = planner.serving.value(&belief, viewpoint);
        let values = planner.leaf(node.depth + 1, lower, planner.bound.value(&belief, viewpoint));
        let child = Child { values, probability: 1.0, node: None };
        let fixed = Values::all(earned);
        Edge { action, discount, fixed, values: fixed, children: vec![child], labels: Vec::new() }
    }

    /// A look: a child per label vector that some scenario gives. The others follow the default policy: what it and the bound
    /// are in expectation over all label vectors, object by object, less what the children take of it.
    fn scan(
        &self,
        node: &MovingNode,
        action: MovingAction,
        state: &State,
        (earned, discount): (f64, f64),
        seen: Vec<Seen>,
    ) -> MovingEdge {
        let planner = self.planner;
        let (timing, bound) = (planner.timing(), &planner.bound);
        let viewpoint = action.viewpoint(node.viewpoint);
        let outcomes = |seen: &Seen| Served {
            left: state.ticks_left(timing, seen.place),
            outcomes: seen.labels.iter().map(|(_, p, after)| (*p, after.clone())).collect(),
        };
        let objects: Vec<Served> = seen.iter().map(outcomes).collect();
        let served = planner.serving.evaluate(&objects, state, viewpoint);
        let of_outcome = |left: usize, after: &[f64]| -> Vec<f64> {
            bound.located(left, viewpoint, &bound.problem().locate(after)).collect()
        };
        let priced: Vec<Vec<Vec<f64>>> = objects
            .iter()
            .map(|object| object.outcomes.iter().map(|(_, after)| of_outcome(object.left, after)).collect())
            .collect();
        let mut expected = bound.to_come(state, viewpoint);
        let unseen = expected.clone();
        for (object, priced) in objects.iter().zip(&priced) {
            for ((p, _), priced) in object.outcomes.iter().zip(priced) {
                expected.iter_mut().zip(priced).for_each(|(sum, part)| *sum += p * part);
            }
        }
        let (mut children, mut labels) = (Vec::new(), Vec::new());
        let (mut mass, mut taken, mut bounded) = (1.0, 0.0, vec![0.0; unseen.len()]);
        for vector in self.vectors(node, &seen) {
            let probability: f64 =
                vector.iter().zip(&objects).map(|(z, object)| object.outcomes[*z].0).product();
            let mut sums = unseen.clone();
            for (z, priced) in vector.iter().zip(&priced) {
                sums.iter_mut().zip(&priced[*z]).for_each(|(sum, part)| *sum += part);
            }
            let lower = served.of(&vector);
            mass -= probability;
            taken += probability * lower;
            bounded.iter_mut().zip(&sums).for_each(|(sum, part)| *sum += probability * part);
            children.push(Child {
                values: planner.leaf(node.depth + 1, lower, least(&sums)),
                probability,
                node: None,
            });
            labels.extend(vector.iter().zip(&seen).map(|(z, seen)| seen.labels[*z].0));
        }
        let rest = served.expected() - taken;
        let at_most: Vec<f64> = expected.iter().zip(&bounded).map(|(all, part)| all - part).collect();
        let at_most = least(&at_most).max(rest);
        let fixed = Values {
            lower: earned + discount * rest,
            upper: earned + discount * rest,
            estimate: earned + discount * planner.between(rest, at_most),
            certified: earned + discount * if mass > 0.0 { at_most } else { rest },
        };
        Edge { action, discount, fixed, values: fixed, children, labels }
    }

    /// The outcomes, as numbers, of the objects in each label vector that some scenario gives, each once.
    fn vectors(&self, node: &MovingNode, seen: &[Seen]) -> Vec<Vec<usize>> {
        let number =
            |seen: &Seen, label: Label| seen.labels.iter().position(|(z, ..)| *z == label).unwrap_or(0);
        let drawn = |scenario: &u64| -> Vec<usize> {
            seen.iter().map(|seen| number(seen, self.drawn(*scenario, node.depth, seen))).collect()
        };
        let mut vectors: Vec<Vec<usize>> = node.scenarios.iter().map(drawn).collect();
        vectors.sort_unstable();
        vectors.dedup();
        vectors
    }

    /// The label that a scenario gives.
    fn drawn(&self, scenario: u64, depth: usize, seen: &Seen) -> Label {
        let u = self.planner.random(scenario, depth, seen.place);
        let chosen = crate::sampling::invert(seen.labels.iter().map(|(_, p, _)| *p), u);
        seen.labels[chosen].0
    }

    /// What a look may show of each undecided object.
    fn seen(&self, state: &State, viewpoint: Viewpoint) -> Vec<Seen> {
        let model = &self.planner.model;
        let undecided = (0..state.rows.len()).filter(|place| !state.decided[*place]);
        undecided
            .map(|place| {
                let look = crate::model::Look::first(Position(place), viewpoint);
                let outcome = |label: Label| {
                    let mut after = state.rows[place].clone();
                    let p = crate::belief::condition(&mut after, model.likelihoods(look, label));
                    (label, p, after)
                };
                let labels = model.labels().map(outcome).filter(|(_, p, _)| *p > 0.0).collect();
                Seen { place, labels }
            })
            .collect()
    }
}
