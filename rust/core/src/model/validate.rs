//! The checks that make a written-down model a sorting POMDP.

use std::collections::BTreeSet;

use super::spec::{ModelSpec, ScalarOrMatrix};
use crate::error::{Result, model_error};

/// How far the sum of a probability row may miss 1; the arithmetic normalises what is left.
const ROW_TOLERANCE: f64 = 1e-6;

pub(super) fn validate(spec: &ModelSpec) -> Result<()> {
    names("classes", &spec.classes, 2)?;
    names("viewpoints", &spec.viewpoints, 1)?;
    tables(spec)?;
    rewards(spec)?;
    if let Some(arrival) = &spec.arrival {
        if arrival.len() != spec.classes.len() {
            return model_error(format!(
                "arrival has {} entries, but there are {} classes; give one probability per class",
                arrival.len(),
                spec.classes.len()
            ));
        }
        distribution("arrival", arrival)?;
    }
    travel(spec)?;
    counts(spec)?;
    not_yet(spec)
}

/// Check that `row` is a probability distribution.
pub(crate) fn distribution(name: &str, row: &[f64]) -> Result<()> {
    if let Some(bad) = row.iter().find(|p| !p.is_finite() || **p < 0.0) {
        return model_error(format!(
            "{name} = {row:?} has the entry {bad}; probabilities are finite and not negative"
        ));
    }
    let sum: f64 = row.iter().sum();
    if (sum - 1.0).abs() > ROW_TOLERANCE {
        return model_error(format!(
            "{name} = {row:?} sums to {sum}; it must sum to 1 (within {ROW_TOLERANCE:e}). \
             Divide the entries by their sum"
        ));
    }
    Ok(())
}

fn names(what: &str, names: &[String], least: usize) -> Result<()> {
    if names.len() < least {
        return model_error(format!("{what} has {} entries; sorting needs at least {least}", names.len()));
    }
    let mut seen = BTreeSet::new();
    for name in names {
        if name.is_empty() || !seen.insert(name) {
            return model_error(format!(
                "{what} holds {name:?} twice or empty; names must be unique and not empty"
            ));
        }
    }
    Ok(())
}

fn tables(spec: &ModelSpec) -> Result<()> {
    let (k, l) = (spec.viewpoints.len(), spec.classes.len());
    if spec.p_obs.is_empty() {
        return model_error("p_obs has no position; its shape is (H, K, L, L) with H at least 1");
    }
    for (j, position) in spec.p_obs.iter().enumerate() {
        length(&format!("p_obs[{j}]"), position.len(), k, "viewpoint")?;
        for (v, table) in position.iter().enumerate() {
            length(&format!("p_obs[{j}][{v}]"), table.len(), l, "true class")?;
            for (c, row) in table.iter().enumerate() {
                let name = format!(
                    "p_obs[{j}][{v}][{c}] (viewpoint {:?}, true class {:?})",
                    spec.viewpoints[v], spec.classes[c]
                );
                length(&name, row.len(), l, "observed class")?;
                distribution(&name, row)?;
            }
        }
    }
    Ok(())
}

fn length(name: &str, found: usize, expected: usize, per: &str) -> Result<()> {
    if found == expected {
        return Ok(());
    }
    model_error(format!("{name} has {found} entries, expected {expected}, one per {per}"))
}

fn rewards(spec: &ModelSpec) -> Result<()> {
    for (name, value) in [("r_max", spec.r_max), ("r_min", spec.r_min)] {
        if !value.is_finite() || value <= 0.0 {
            return model_error(format!(
                "{name} = {value}; it must be finite and above 0 (r_min is a penalty: give it without its sign)"
            ));
        }
    }
    if !(spec.discount > 0.0 && spec.discount < 1.0) {
        return model_error(format!(
            "discount = {}; it must lie strictly between 0 and 1, 0.95 for example",
            spec.discount
        ));
    }
    let costs: Vec<f64> = match &spec.motion_cost {
        ScalarOrMatrix::Scalar(cost) => vec![*cost],
        ScalarOrMatrix::Matrix(rows) => {
            let k = spec.viewpoints.len();
            length("motion_cost", rows.len(), k, "viewpoint left")?;
            for (i, row) in rows.iter().enumerate() {
                length(&format!("motion_cost[{i}]"), row.len(), k, "viewpoint reached")?;
            }
            rows.concat()
        }
    };
    match costs.iter().find(|cost| !cost.is_finite() || **cost < 0.0) {
        Some(cost) => model_error(format!(
            "motion_cost holds {cost}; costs are finite and not negative. Leave forbidden moves out of travel instead"
        )),
        None => Ok(()),
    }
}

fn travel(spec: &ModelSpec) -> Result<()> {
    let Some(travel) = &spec.travel else { return Ok(()) };
    let k = spec.viewpoints.len();
    length("travel", travel.len(), k, "viewpoint")?;
    for (from, reached) in travel.iter().enumerate() {
        if let Some(bad) = reached.iter().find(|to| **to >= k) {
            return model_error(format!(
                "travel[{from}] lists viewpoint {bad}; viewpoints are 0 to {}",
                k - 1
            ));
        }
        let unique: BTreeSet<_> = reached.iter().collect();
        if unique.len() != reached.len() {
            return model_error(format!(
                "travel[{from}] = {reached:?} lists a viewpoint twice; list each once"
            ));
        }
    }
    Ok(())
}

fn counts(spec: &ModelSpec) -> Result<()> {
    if let Some(smoothing) = spec.smoothing
        && !(smoothing.is_finite() && smoothing >= 0.0)
    {
        return model_error(format!(
            "smoothing = {smoothing}; it is a pseudo-count, finite and not negative"
        ));
    }
    let Some(counts) = &spec.counts else { return Ok(()) };
    let same_shape = counts.len() == spec.p_obs.len()
        && counts.iter().zip(&spec.p_obs).all(|(a, b)| {
            a.len() == b.len()
                && a.iter()
                    .zip(b)
                    .all(|(a, b)| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.len() == b.len()))
        });
    if same_shape { Ok(()) } else { model_error("counts and p_obs differ in shape; both are (H, K, L, L)") }
}

fn not_yet(spec: &ModelSpec) -> Result<()> {
    if spec.observe_after_decision {
        return model_error(
            "observe_after_decision = true is not supported yet: the scan of the next object follows its first move. \
             Set it to false",
        );
    }
    let repeats = match &spec.repeat {
        None => false,
        Some(ScalarOrMatrix::Scalar(r)) => *r != 0.0,
        Some(ScalarOrMatrix::Matrix(rows)) => rows.iter().flatten().any(|r| *r != 0.0),
    };
    if repeats {
        return model_error(
            "repeat other than 0 is not supported yet: labels are taken as independent given the class. \
             Leave repeat out",
        );
    }
    Ok(())
}
