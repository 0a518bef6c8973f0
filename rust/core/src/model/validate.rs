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
    repeat(spec)?;
    information_gain(spec)?;
    empty(spec)
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

/// The entries of a matrix of the expected shape.
fn matrix(
    name: &str,
    rows: &[Vec<f64>],
    (m, of_rows): (usize, &str),
    (n, of_entries): (usize, &str),
) -> Result<Vec<f64>> {
    length(name, rows.len(), m, of_rows)?;
    for (i, row) in rows.iter().enumerate() {
        length(&format!("{name}[{i}]"), row.len(), n, of_entries)?;
    }
    Ok(rows.concat())
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
            matrix("motion_cost", rows, (k, "viewpoint left"), (k, "viewpoint reached"))?
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

/// `repeat` lies in [0, 1): at 1 no second look would ever tell anything.
fn repeat(spec: &ModelSpec) -> Result<()> {
    let (h, k) = (spec.p_obs.len(), spec.viewpoints.len());
    let repeats = match &spec.repeat {
        None => return Ok(()),
        Some(ScalarOrMatrix::Scalar(repeat)) => vec![*repeat],
        Some(ScalarOrMatrix::Matrix(rows)) => matrix("repeat", rows, (h, "position"), (k, "viewpoint"))?,
    };
    match repeats.iter().find(|repeat| !(0.0..1.0).contains(*repeat)) {
        Some(repeat) => model_error(format!(
            "repeat holds {repeat}; it is the probability that a second look only repeats the label of the first: \
             at least 0 and below 1"
        )),
        None => Ok(()),
    }
}

fn information_gain(spec: &ModelSpec) -> Result<()> {
    let alpha = spec.information_gain;
    if alpha.is_finite() && alpha >= 0.0 {
        return Ok(());
    }
    model_error(format!(
        "information_gain = {alpha}; it is a reward per nat, finite and not negative. Give 0 for the plain model"
    ))
}

fn empty(spec: &ModelSpec) -> Result<()> {
    match &spec.empty {
        Some(name) if !spec.classes.contains(name) => model_error(format!(
            "empty = {name:?} is no class; name the one that stands for an empty cup ({}), or leave it out",
            spec.classes.join(", ")
        )),
        _ => Ok(()),
    }
}
