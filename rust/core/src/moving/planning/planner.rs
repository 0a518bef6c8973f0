//! The planner's face: a belt, questions about a belief, and what is refused.

use std::sync::atomic::AtomicBool;

use super::deadline::Kinds;
use super::search::{MovingConfig, MovingPlan, Searching};
use crate::config::{Budget, NEVER};
use crate::error::{Result, argument_error};
use crate::index::{Class, Viewpoint};
use crate::moving::action::MovingAction;
use crate::moving::belief::MovingBelief;
use crate::moving::belt::MovingBelt;
use crate::moving::policy::MovingPolicy;

/// The recommended planner for a belt of constant speed.
#[derive(Debug, Clone)]
pub struct MovingSearch {
    searching: Searching,
}

impl MovingSearch {
    /// Prepare to plan: the default policy and the bound are made here.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] for a belt that advances on decisions, or settings that make no sense.
    pub fn new(belt: &MovingBelt, config: MovingConfig) -> Result<Self> {
        Self::new_until(belt, config, &NEVER)
    }

    /// The same, prepared until `stop` is set: with what was found by then.
    ///
    /// # Errors
    /// As [`MovingSearch::new`].
    pub fn new_until(belt: &MovingBelt, config: MovingConfig, stop: &AtomicBool) -> Result<Self> {
        if belt.timing().advances_on_decisions() {
            return argument_error(
                "the belt advances on decisions, and this planner is for belts of constant speed; use a threshold policy, or \
                 plan with the model alone if every action takes one tick",
            );
        }
        Ok(Self { searching: Searching::new(belt.model(), belt.timing(), config, stop)? })
    }

    /// The settings.
    #[must_use]
    pub fn config(&self) -> MovingConfig {
        self.searching.config
    }

    /// Plan the next action until the budget is spent or `stop` is set. With a budget of trials the plan is a pure function of
    /// the arguments.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if belief or viewpoint do not fit, nothing is left to decide, or the budget is zero.
    pub fn plan_until(
        &self,
        belief: &MovingBelief,
        viewpoint: Viewpoint,
        budget: Budget,
        stop: &AtomicBool,
    ) -> Result<MovingPlan> {
        self.check(belief, viewpoint)?;
        self.searching.search(belief.state(), viewpoint, budget, stop)
    }

    /// Bounds of the value: what the default policy earns, and the priced bound.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if belief or viewpoint do not fit.
    pub fn bounds(&self, belief: &MovingBelief, viewpoint: Viewpoint) -> Result<(f64, f64)> {
        self.check(belief, viewpoint)?;
        let Searching { serving, bound, .. } = &self.searching;
        Ok((serving.value(belief.state(), viewpoint), bound.value(belief.state(), viewpoint)))
    }

    /// By ticks left until the exit, from 1: the least probability of a class from which on deciding at once is optimal for one
    /// object alone, the other classes in their proportions at arrival; `None` out of reach, or where it never is.
    ///
    /// # Errors
    /// [`crate::Error::Argument`] if class or viewpoint do not exist.
    pub fn thresholds(&self, class: Class, viewpoint: Viewpoint) -> Result<Vec<Option<f64>>> {
        let model = &self.searching.model;
        model.check_class(class)?;
        model.check_viewpoint(viewpoint)?;
        let problem = self.searching.bound.problem();
        let values = problem.values(&vec![1.0; problem.horizon() + 1]);
        let (kinds, group) = (Kinds::towards(model, class), problem.group(viewpoint));
        let at = |n| problem.threshold(&values, n, group, &kinds);
        Ok((1..=problem.timing().visible()).map(at).collect())
    }

    /// The share of a look's cost that an object pays, by ticks left from 1, under the improved prices.
    #[must_use]
    pub fn shares(&self) -> &[f64] {
        &self.searching.bound.shares()[1..]
    }

    fn check(&self, belief: &MovingBelief, viewpoint: Viewpoint) -> Result<()> {
        belief.check_fits(self.searching.timing(), &self.searching.model)?;
        self.searching.model.check_viewpoint(viewpoint)
    }
}

/// The planner with a budget for each plan, as a policy.
#[derive(Debug, Clone)]
pub struct BudgetedMovingSearch {
    /// The planner.
    pub search: MovingSearch,
    /// Its budget per plan.
    pub budget: Budget,
}

impl MovingPolicy for BudgetedMovingSearch {
    fn act(&self, belief: &MovingBelief, viewpoint: Viewpoint) -> Result<MovingAction> {
        Ok(self.search.plan_until(belief, viewpoint, self.budget, &NEVER)?.action)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::moving::spec::{Drive, MovingSpec};
    use crate::testing::paper;

    fn belt(drive: Drive) -> MovingBelt {
        MovingBelt::new(paper(50.0), MovingSpec::new(drive)).unwrap()
    }

    #[test]
    fn what_it_cannot_plan_for_is_refused() {
        let belt_of_today = belt(Drive::OnDecision { advance_ticks: 1 });
        let error = MovingSearch::new(&belt_of_today, MovingConfig::default()).unwrap_err().to_string();
        assert!(error.contains("advances on decisions"), "{error}");
        let config = MovingConfig { optimism: 2.0, ..MovingConfig::default() };
        let moving = belt(Drive::Constant { ticks_per_place: 4 });
        let error = MovingSearch::new(&moving, config).unwrap_err().to_string();
        assert!(error.contains("optimism"), "{error}");
    }

    #[test]
    fn a_belief_has_to_fit_the_belt() {
        let moving = belt(Drive::Constant { ticks_per_place: 4 });
        let search = MovingSearch::new(&moving, MovingConfig::default()).unwrap();
        let one_place = Arc::new(moving.model().with_positions(1).unwrap());
        let other = MovingBelt::new(one_place, moving.spec().clone()).unwrap();
        let slower = belt(Drive::Constant { ticks_per_place: 6 });
        let mut late = MovingBelief::new(&slower, None);
        late.advance_time(&slower, 5);
        for (belief, word) in [(MovingBelief::new(&other, None), "places"), (late, "offset = 5")] {
            let error = search.bounds(&belief, Viewpoint(0)).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
        let (lower, upper) = search.bounds(&MovingBelief::new(&moving, None), Viewpoint(0)).unwrap();
        assert!(lower < upper);
    }
}
