//! Trials that are made at once.
//!
//! One after the other they explore down to a leaf, which from then on counts as settled (virtual loss), so that the
//! others go elsewhere. Then each goes on below its leaf, in a branch of its own: that is most of the work, and threads
//! share it. The branches are put back in the order of the trials. A batch of one trial is that of the paper.

use rayon::prelude::*;

use super::node::{NodeId, ROOT};
use super::tree::Tree;
use super::{Search, XI};

/// The leaf that a trial has come to, and what it aims at.
struct Trial {
    leaf: NodeId,
    target: f64,
}

impl Search<'_> {
    /// So many trials, or fewer if nothing else is worth one; how many. None if what is left of the gap is rounding, or
    /// there was no time.
    pub(super) fn make_trials(&self, despot: &mut Tree, branches: &mut Vec<Tree>, count: u64) -> u64 {
        let (mut done, mut trials, pruned) = (0, Vec::new(), despot.tally.pruned);
        while done < count && !self.is_settled(despot) {
            done += 1;
            let target = XI * despot[ROOT].gap();
            let leaf = self.explore(despot, target, false);
            if despot[leaf].is_leaf() && self.excess_uncertainty(&despot[leaf], target) > 0.0 {
                branches.resize_with(branches.len().max(trials.len() + 1), Tree::default);
                despot.branch(self.model, leaf, &mut branches[trials.len()]);
                despot[leaf].values.upper = despot[leaf].values.lower;
                self.backup(despot, leaf);
                trials.push(Trial { leaf, target });
            }
        }
        if trials.is_empty() && despot.tally.pruned == pruned {
            return 0;
        }
        let go_on = |(branch, trial): (&mut Tree, &Trial)| {
            if !(self.out_of_time)() {
                let b = self.explore(branch, trial.target, true);
                self.backup(branch, b);
            }
        };
        if self.parallel && trials.len() > 1 {
            branches.par_iter_mut().zip(&trials).for_each(go_on);
        } else {
            branches.iter_mut().zip(&trials).for_each(go_on);
        }
        for (branch, Trial { leaf, .. }) in branches.iter().zip(&trials) {
            done -= u64::from(branch.tally.expansions + branch.tally.pruned == 0);
            despot.graft(*leaf, branch);
            self.backup(despot, *leaf);
        }
        done
    }
}
