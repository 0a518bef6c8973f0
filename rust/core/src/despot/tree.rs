//! The arena that a DESPOT lives in, and branches of it that grow apart.

use std::ops::{Index, IndexMut, Range};

use super::node::{ENTRY, Edge, EdgeId, Node, NodeId, Place, ROOT, Values, Word};
use super::step::Scratch;
use crate::belief::Belief;
use crate::index::{Label, Position, Viewpoint};
use crate::model::{Action, SortingModel};

/// A DESPOT, or the branch of one that grows from a leaf.
#[derive(Debug, Default)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    edges: Vec<Edge>,
    words: Vec<Word>,
    /// `U - l_0` of the nodes above the root, the nearest first.
    pub above: Vec<f64>,
    /// The last labels at the root, entry `position * K + viewpoint`; none for a model that never repeats.
    memory: Vec<Option<Label>>,
    /// What has been done here.
    pub tally: Tally,
    pub scratch: Scratch,
}

/// Counts of work.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Tally {
    /// One scenario, one step.
    pub scenario_steps: u64,
    pub expansions: u64,
    /// Nodes made default because they were blocked.
    pub pruned: u64,
}

impl Index<NodeId> for Tree {
    type Output = Node;

    fn index(&self, node: NodeId) -> &Node {
        &self.nodes[node.0 as usize]
    }
}

impl IndexMut<NodeId> for Tree {
    fn index_mut(&mut self, node: NodeId) -> &mut Node {
        &mut self.nodes[node.0 as usize]
    }
}

impl Index<EdgeId> for Tree {
    type Output = Edge;

    fn index(&self, edge: EdgeId) -> &Edge {
        &self.edges[edge.0 as usize]
    }
}

impl IndexMut<EdgeId> for Tree {
    fn index_mut(&mut self, edge: EdgeId) -> &mut Edge {
        &mut self.edges[edge.0 as usize]
    }
}

/// Indices of the arena as it stores them; memory ends long before 2^32 of them.
#[allow(clippy::cast_possible_truncation)]
fn id(index: usize) -> u32 {
    index as u32
}

fn range((from, to): (u32, u32)) -> Range<usize> {
    from as usize..to as usize
}

impl Tree {
    fn clear(&mut self) {
        self.nodes.clear();
        self.edges.clear();
        self.words.clear();
        self.above.clear();
        self.memory.clear();
        self.tally = Tally::default();
    }

    /// Start from a belief: the root is still to be added.
    pub(super) fn restart(&mut self, model: &SortingModel, belief: &Belief, at: Place) {
        self.clear();
        self.enter(at);
        if model.ever_repeats() {
            let (h, k) = (model.position_count(), model.viewpoint_count());
            self.memory
                .extend((0..h * k).map(|at| belief.last_label(model, Position(at / k), Viewpoint(at % k))));
        }
    }

    fn enter(&mut self, at: Place) {
        let action = Action::Move(at.viewpoint);
        let (children, values) = ((0, 1), Values::default());
        self.edges.push(Edge { from: ROOT, action, reward: 0.0, children, to: at, values });
    }

    /// Where a node is.
    pub(super) fn place(&self, node: NodeId) -> Place {
        self[self[node].parent].to
    }

    /// Number of belief nodes.
    pub(super) fn size(&self) -> usize {
        self.nodes.len()
    }

    /// A belief with these scenarios.
    #[inline(always)]
    pub(super) fn add_node(&mut self, node: Node, scenarios: &[Word]) {
        let from = id(self.words.len());
        self.words.extend_from_slice(scenarios);
        self.nodes.push(Node { scenarios: (from, id(self.words.len())), ..node });
    }

    /// A belief with the scenarios of another.
    #[inline(always)]
    pub(super) fn add_node_like(&mut self, node: Node, other: NodeId) {
        let scenarios = self[other].scenarios;
        self.nodes.push(Node { scenarios, ..node });
    }

    /// The edge that is added next.
    pub(super) fn next_edge(&self) -> EdgeId {
        EdgeId(id(self.edges.len()))
    }

    /// An action of a node; its children are the nodes added since there were `first`.
    pub(super) fn add_edge(
        &mut self,
        from: NodeId,
        (action, to): (Action, Place),
        reward: f64,
        first: usize,
    ) {
        let edge = self.next_edge();
        let children = (id(first), id(self.nodes.len()));
        self.edges.push(Edge { from, action, reward, children, to, values: Values::default() });
        let (first, count) = self[from].actions;
        self[from].actions = (if count == 0 { edge.0 } else { first }, count + 1);
    }

    /// `Phi_b`.
    pub(super) fn scenarios(&self, node: NodeId) -> &[Word] {
        &self.words[range(self[node].scenarios)]
    }

    /// The node above.
    pub(super) fn parent(&self, node: NodeId) -> Option<NodeId> {
        (node != ROOT).then(|| self[self[node].parent].from)
    }

    /// The action that has led to a node.
    pub(super) fn edge_into(&self, node: NodeId) -> Option<EdgeId> {
        (node != ROOT).then(|| self[node].parent)
    }

    /// The path to the root, the node itself first.
    pub(super) fn path(&self, node: NodeId) -> impl Iterator<Item = &Node> {
        std::iter::successors(Some(node), |node| self.parent(*node)).map(|node| &self[node])
    }

    /// The label that a position gave from a viewpoint before, on the way to a node and since the belt last moved;
    /// `None` where none can be repeated.
    pub(super) fn last_label(
        &self,
        model: &SortingModel,
        node: NodeId,
        (position, viewpoint): (Position, Viewpoint),
    ) -> Option<Label> {
        if model.repeat(position, viewpoint) <= 0.0 {
            return None;
        }
        for node in self.path(node).take_while(|node| node.parent != ENTRY) {
            let edge = &self[node.parent];
            if edge.to.scanned && edge.to.viewpoint == viewpoint {
                return Some(nth_label(model, node.labels, position));
            }
            if matches!(edge.action, Action::Decide(_)) {
                return None;
            }
        }
        self.memory.get(position.0 * model.viewpoint_count() + viewpoint.0).copied().flatten()
    }

    /// A branch that grows from a leaf; it knows what searching below the leaf needs to know of what is above.
    pub(super) fn branch(&self, model: &SortingModel, leaf: NodeId, branch: &mut Tree) {
        branch.clear();
        branch.enter(self.place(leaf));
        if model.ever_repeats() {
            let (h, k) = (model.position_count(), model.viewpoint_count());
            branch.memory.extend(
                (0..h * k).map(|at| self.last_label(model, leaf, (Position(at / k), Viewpoint(at % k)))),
            );
        }
        let above = self.path(leaf).skip(1).map(|node| node.values.utility - node.default);
        branch.above.extend(above.chain(self.above.iter().copied()));
        branch.words.extend_from_slice(self.scenarios(leaf));
        let scenarios = (0, id(branch.words.len()));
        branch.nodes.push(Node { parent: ENTRY, scenarios, ..self[leaf] });
    }

    /// Put a grown branch where it has grown from.
    pub(super) fn graft(&mut self, leaf: NodeId, branch: &Tree) {
        // The branch's node 0 is the leaf and its edge 0 leads there; those after them are the next ones here.
        let (nodes, edges, words) =
            (id(self.nodes.len()) - 1, id(self.edges.len()) - 1, id(self.words.len()));
        let shift = |(from, to): (u32, u32), by: u32| (from + by, to + by);
        let node = |node: NodeId| if node == ROOT { leaf } else { NodeId(node.0 + nodes) };
        let actions = |(first, count): (u32, u16)| (first + edges, count);
        let (Some((root, others)), Some((_, edges_below))) =
            (branch.nodes.split_first(), branch.edges.split_first())
        else {
            return;
        };
        self.words.extend_from_slice(&branch.words);
        self.nodes.extend(others.iter().map(|node| Node {
            parent: EdgeId(node.parent.0 + edges),
            scenarios: shift(node.scenarios, words),
            actions: actions(node.actions),
            ..*node
        }));
        self.edges.extend(edges_below.iter().map(|edge| Edge {
            from: node(edge.from),
            children: shift(edge.children, nodes),
            ..*edge
        }));
        let grown = &mut self[leaf];
        (grown.values, grown.settled) = (root.values, root.settled);
        grown.actions = actions(root.actions);
        self.tally.scenario_steps += branch.tally.scenario_steps;
        self.tally.expansions += branch.tally.expansions;
        self.tally.pruned += branch.tally.pruned;
    }
}

/// The one with the largest value, the first among equals.
pub(super) fn first_best<T: Copy>(among: impl Iterator<Item = T>, value: impl Fn(T) -> f64) -> Option<T> {
    among
        .fold(None, |best: Option<(T, f64)>, next| {
            let value = value(next);
            if best.is_none_or(|(_, best)| value > best) { Some((next, value)) } else { best }
        })
        .map(|(best, _)| best)
}

/// A position's label, given the code of a scan's labels: digits in base Z, the belt end's first.
fn nth_label(model: &SortingModel, labels: u64, position: Position) -> Label {
    let base = model.label_count() as u64;
    let behind = position.0 + 1..model.position_count();
    let digit = behind.fold(labels, |code, _| code / base) % base;
    // A digit is below Z, which is a usize.
    #[allow(clippy::cast_possible_truncation)]
    let label = Label(digit as usize);
    label
}
