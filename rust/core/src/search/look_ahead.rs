//! Looking a fixed number of steps ahead: what the search has to beat.

use std::sync::atomic::AtomicBool;

use super::{BeliefSearch, Search};
use crate::belief::Belief;
use crate::config::{DespotConfig, NEVER};
use crate::error::{Result, argument_error};
use crate::index::Viewpoint;
use crate::model::{Action, SortingModel};
use crate::policy::Policy;

/// Deeper trees grow beyond any use.
const DEEPEST: usize = 4;

/// Every action, `depth` steps ahead, with the leaf values of [`BeliefSearch`]; no bounds, no trials.
///
/// The branches are those of the search: labels that no scenario gives follow the default policy.
#[derive(Debug, Clone)]
pub struct LookAhead {
    search: BeliefSearch,
    depth: usize,
}

impl LookAhead {
    /// Look `depth` steps ahead, 1 to 4; the tree grows with the power of it.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for another depth, or settings that [`BeliefSearch`] refuses.
    pub fn new(model: &SortingModel, depth: usize, config: DespotConfig) -> Result<Self> {
        Self::new_until(model, depth, config, &NEVER)
    }

    /// The same, prepared until `stop` is set, as [`BeliefSearch::new_until`].
    ///
    /// # Errors
    /// As [`LookAhead::new`].
    pub fn new_until(
        model: &SortingModel,
        depth: usize,
        config: DespotConfig,
        stop: &AtomicBool,
    ) -> Result<Self> {
        if !(1..=DEEPEST).contains(&depth) {
            return argument_error(format!("depth = {depth}; look 1 to {DEEPEST} steps ahead"));
        }
        Ok(Self { search: BeliefSearch::new_until(model, None, config, stop)?, depth })
    }
}

impl Policy for LookAhead {
    fn act(&self, belief: &Belief, viewpoint: Viewpoint) -> Result<Action> {
        let mut search = Search::new(&self.search, belief, viewpoint)?;
        search.look_ahead(self.depth);
        Ok(search.best_action())
    }
}

impl Search<'_> {
    /// Expand everything down to a depth.
    pub(super) fn look_ahead(&mut self, depth: usize) {
        self.expand_root();
        let mut next = 0;
        while let Some(node) = self.tree.nodes.get(next) {
            if node.depth + 1 < depth {
                self.expand_children(next);
            }
            next += 1;
        }
    }
}
