//! The one-object policy as a row of numbers: to store it, and to have it back without solving anew.
//!
//! The value of an unseen object per viewpoint group; then for each group the number of its plans, and per plan its
//! action (a bin, or the number of bins and a viewpoint), `G(c)` and `D_s(c)`.

use nalgebra::DVector;

use super::OneObjectPolicy;
use super::plan_set::{ConditionalPlan, PlanSet};
use super::viewpoint_groups;
use crate::index::{Bin, Viewpoint};
use crate::model::{Action, SortingModel};

impl OneObjectPolicy {
    /// The numbers that [`OneObjectPolicy::from_numbers`] takes.
    pub(crate) fn to_numbers(&self, model: &SortingModel) -> Vec<f64> {
        let mut numbers = self.arrival_values.clone();
        for set in &self.plans {
            numbers.push(set.plans().len() as f64);
            for plan in set.plans() {
                let action = match plan.action {
                    Action::Decide(bin) => bin.0,
                    Action::Move(viewpoint) => model.bin_count() + viewpoint.0,
                };
                numbers.push(action as f64);
                numbers.extend(plan.gain.iter().chain(plan.discount_to.iter()));
            }
        }
        numbers
    }

    /// The policy of a model from its numbers; nothing if these cannot be those of this model.
    pub(crate) fn from_numbers(model: &SortingModel, numbers: &[f64]) -> Option<Self> {
        let (group_of, groups) = viewpoint_groups(model);
        let (arrival_values, mut rest) = numbers.split_at_checked(groups)?;
        let mut plans = Vec::new();
        for _ in 0..groups {
            let (count, behind) = rest.split_first()?;
            let (rows, behind) =
                behind.split_at_checked(index(*count)?.checked_mul(length(model, groups))?)?;
            let stored: Option<Vec<_>> =
                rows.chunks_exact(length(model, groups)).map(|row| plan(model, row)).collect();
            plans.push(PlanSet::new(stored.filter(|plans| !plans.is_empty())?));
            rest = behind;
        }
        let arrival_values = arrival_values.to_vec();
        let mut policy = Self { group_of, plans, arrival_values, unseen_values: Vec::new() };
        policy.unseen_values = policy.values_on_ending_belts(model);
        rest.is_empty().then_some(policy)
    }
}

/// Numbers per plan.
fn length(model: &SortingModel, groups: usize) -> usize {
    1 + model.kind_count() * (1 + groups)
}

fn plan(model: &SortingModel, row: &[f64]) -> Option<ConditionalPlan> {
    let bins = model.bin_count();
    let action = match index(row[0])? {
        bin if bin < bins => Action::Decide(Bin(bin)),
        viewpoint if viewpoint < bins + model.viewpoint_count() => Action::Move(Viewpoint(viewpoint - bins)),
        _ => return None,
    };
    let (gain, discount_to) = row[1..].split_at(model.kind_count());
    let vector = DVector::from_column_slice;
    Some(ConditionalPlan { action, gain: vector(gain), discount_to: vector(discount_to) })
}

/// A whole number that is no less than 0.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked
fn index(number: f64) -> Option<usize> {
    (number >= 0.0 && number.fract() == 0.0 && number <= f64::from(u32::MAX)).then_some(number as usize)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::testing::{enumerable_models, seeded};

    proptest! {
        #![proptest_config(seeded(8))]

        #[test]
        fn numbers_make_the_same_policy(model in enumerable_models()) {
            let policy = OneObjectPolicy::solve(&model);
            let numbers = policy.to_numbers(&model);
            let stored = OneObjectPolicy::from_numbers(&model, &numbers).unwrap();
            for group in 0..policy.group_count() {
                prop_assert_eq!(policy.plans[group].plans(), stored.plans[group].plans());
            }
            prop_assert_eq!(numbers.clone(), stored.to_numbers(&model));
            prop_assert_eq!(policy.group_of, stored.group_of);
            let cut = OneObjectPolicy::from_numbers(&model, &numbers[..numbers.len() - 1]);
            prop_assert!(cut.is_none());
        }
    }
}
