//! The memory of a search, handed from plan to plan.

use std::ops::{Deref, DerefMut};
use std::sync::{Arc, Mutex, PoisonError};

use super::Despot;
use super::expand::{Expansion, Scratch};
use super::frontier::Frontier;
use super::objects::{Findings, Objects};
use super::sightings::{Sightings, act};
use crate::belief::Belief;
use crate::index::{Class, Position, Viewpoint};
use crate::model::Action;
use crate::scenario::LookPoint;
use crate::tree::Child;

/// Nodes that are kept for the next plan at most: an occasional long search would hold its memory for ever.
const MOST_KEPT: usize = 100_000;

/// What the expansions of a search share.
#[derive(Debug, Default)]
pub(crate) struct Knowledge {
    pub sightings: Sightings,
    pub findings: Findings,
    /// The looks of a batch, in the scenarios.
    pub points: Vec<LookPoint>,
}

impl Knowledge {
    /// Learn what the expansions of chosen leaves need, and what has been seen on the way to them.
    pub(super) fn prepare(&mut self, despot: &Despot, chosen: &mut [Expansion], parallel: bool) {
        for Expansion { node, scan, .. } in &mut *chosen {
            if let Some(scan) = scan {
                self.sightings.see(&despot.model, scan, node.labels, &mut node.objects);
            }
        }
        self.require(despot, chosen, parallel);
        let Self { sightings, findings, points } = self;
        findings.work_out(despot, sightings, points.drain(..), parallel);
    }

    /// Number the looks that the expansions need. They are still to be worked out.
    fn require(&mut self, despot: &Despot, chosen: &[Expansion], parallel: bool) {
        let Despot { model, randoms, .. } = despot;
        let depths = chosen.iter().map(|expansion| expansion.node.depth);
        randoms.reach(depths.max().unwrap_or(0), parallel);
        let Self { sightings, points, .. } = self;
        let mut objects = Vec::new();
        points.clear();
        for Expansion { node, .. } in chosen {
            let moves = model.legal_moves(node.viewpoint).iter().map(|to| Action::Move(*to));
            for action in moves.chain([Action::Decide(Class(0))]) {
                objects.clone_from(&node.objects);
                let Some(scan) = act(model, (node, action), &mut objects) else { continue };
                sightings.require(model, &objects, scan.viewpoint);
                points.extend((0..).map(Position).zip(&objects).map(|(position, object)| {
                    scan.look(sightings.sighting(*object, position, scan.viewpoint))
                }));
            }
        }
    }

    /// What is known about objects.
    pub(super) fn objects(&self) -> Objects<'_> {
        Objects { sightings: &self.sightings, findings: &self.findings }
    }
}

/// Everything that a search writes to. Its content never outlives a plan, its memory does.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    pub frontier: Frontier,
    pub knowledge: Knowledge,
    /// The belief at the root, one distribution per position.
    pub root: Vec<f64>,
    /// One per task.
    pub scratch: Vec<Scratch>,
}

impl Workspace {
    /// Forget the last search and start from a root.
    pub(super) fn restart(
        &mut self,
        despot: &Despot,
        (belief, viewpoint): (&Belief, Viewpoint),
        root: Child,
    ) {
        self.root = belief.as_slice().to_vec();
        self.knowledge.sightings.restart(&despot.model, belief);
        self.knowledge.findings.restart(despot, belief);
        self.frontier.restart(root, viewpoint, belief.horizon());
    }
}

/// Workspaces that no search uses at the moment.
#[derive(Debug, Clone, Default)]
pub(super) struct Pool(Arc<Mutex<Vec<Workspace>>>);

impl Pool {
    pub(super) fn lease(&self) -> Lease {
        let space = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        Lease { space: space.unwrap_or_default(), pool: self.clone() }
    }
}

/// A workspace that returns to its pool.
#[derive(Debug)]
pub(super) struct Lease {
    space: Workspace,
    pool: Pool,
}

impl Deref for Lease {
    type Target = Workspace;

    fn deref(&self) -> &Workspace {
        &self.space
    }
}

impl DerefMut for Lease {
    fn deref_mut(&mut self) -> &mut Workspace {
        &mut self.space
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        let space = std::mem::take(&mut self.space);
        if space.frontier.size() <= MOST_KEPT {
            self.pool.0.lock().unwrap_or_else(PoisonError::into_inner).push(space);
        }
    }
}
