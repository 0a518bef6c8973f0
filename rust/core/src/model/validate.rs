//! The checks that make a written-down model a sorting POMDP.

use std::collections::BTreeSet;

use super::spec::{ModelSpec, ScalarOrMatrix, Smoothing, Tables};
use crate::error::{Result, model_error};

/// How far the sum of a probability row may miss 1; the arithmetic normalises what is left.
const ROW_TOLERANCE: f64 = 1e-6;

pub(super) fn validate(spec: &ModelSpec) -> Result<()> {
    names("classes", &spec.classes, 2)?;
    names("viewpoints", &spec.viewpoints, 1)?;
    if let Some(labels) = &spec.labels {
        names("labels", labels, 1)?;
    }
    modes(spec)?;
    tables(spec)?;
    bins(spec)?;
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
    if let Some(rule) = spec.label_rule.as_ref().filter(|rule| !rule.is_object()) {
        return model_error(format!(
            "label_rule = {rule} is no JSON object; give the rule's settings by name"
        ));
    }
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
        return model_error(format!("{what} = {names:?} has {} entries; give at least {least}", names.len()));
    }
    let mut seen = BTreeSet::new();
    for name in names {
        if name.is_empty() {
            return model_error(format!("{what} = {names:?} has an empty name; give each a name"));
        }
        if !seen.insert(name) {
            return model_error(format!(
                "{what} = {names:?} has {name:?} twice; names must be unique: rename one"
            ));
        }
    }
    Ok(())
}

fn tables(spec: &ModelSpec) -> Result<()> {
    let k = spec.viewpoints.len();
    let kinds = kinds(spec);
    let of_rows = if spec.modes.is_some() {
        "mode of each class"
    } else {
        "true class (if its classes have several modes, give modes)"
    };
    let labels = spec.labels.as_ref().unwrap_or(&spec.classes).len();
    let of_entries = match &spec.labels {
        Some(_) => "label",
        None => "observed class (if a look yields other labels than the classes, name them in labels)",
    };
    if spec.p_obs.is_empty() {
        return model_error(format!("p_obs has no position; its shape is {} with H at least 1", shape(spec)));
    }
    for (j, position) in spec.p_obs.iter().enumerate() {
        length(&format!("p_obs[{j}]"), position.len(), k, "viewpoint")?;
        for (v, table) in position.iter().enumerate() {
            length(&format!("p_obs[{j}][{v}]"), table.len(), kinds.len(), of_rows)?;
            for ((n, row), kind) in table.iter().enumerate().zip(&kinds) {
                let name = format!("p_obs[{j}][{v}][{n}] (viewpoint {:?}, {kind})", spec.viewpoints[v]);
                length(&name, row.len(), labels, of_entries)?;
                distribution(&name, row)?;
            }
        }
    }
    Ok(())
}

/// What each row of a table is of, in words.
fn kinds(spec: &ModelSpec) -> Vec<String> {
    let of_class = |(c, class): (usize, &String)| -> Vec<String> {
        let modes = spec.modes.as_ref().map_or(1, |modes| modes[c].len());
        let mode = |m| format!("true class {class:?}, mode {m}");
        if modes == 1 { vec![format!("true class {class:?}")] } else { (0..modes).map(mode).collect() }
    };
    spec.classes.iter().enumerate().flat_map(of_class).collect()
}

/// The shape of the tables, in the letters of the keys that are set.
fn shape(spec: &ModelSpec) -> String {
    let kinds = if spec.modes.is_some() { "N" } else { "L" };
    let labels = if spec.labels.is_some() { "Z" } else { "L" };
    format!("(H, K, {kinds}, {labels})")
}

fn modes(spec: &ModelSpec) -> Result<()> {
    let Some(modes) = &spec.modes else { return Ok(()) };
    length("modes", modes.len(), spec.classes.len(), "class")?;
    for (weights, class) in modes.iter().zip(&spec.classes) {
        let name = format!("modes of class {class:?}");
        if weights.is_empty() {
            return model_error(format!(
                "{name} = []; expected weights that sum to 1, so give a class with one mode [1.0]"
            ));
        }
        distribution(&name, weights)?;
    }
    Ok(())
}

/// Bins and their rewards: either both follow from the classes, or each bin has a row of rewards.
fn bins(spec: &ModelSpec) -> Result<()> {
    if let Some(bins) = &spec.bins {
        names("bins", bins, 1)?;
    }
    let bins = spec.bins.as_ref().unwrap_or(&spec.classes);
    let Some(reward) = &spec.reward else {
        if *bins == spec.classes {
            return Ok(());
        }
        return model_error(format!(
            "bins = {bins:?} are not the classes, so their worth does not follow from r_max and r_min; give reward, a row \
             per bin with what each class is worth in it"
        ));
    };
    let rewards = matrix("reward", reward, (bins.len(), "bin"), (spec.classes.len(), "class"))?;
    if let Some(bad) = rewards.iter().find(|reward| !reward.is_finite()) {
        return model_error(format!(
            "reward holds {bad}; rewards are finite, so give a large number, negative for a penalty"
        ));
    }
    if rewards.iter().all(|reward| *reward <= 0.0) {
        return model_error(format!(
            "reward = {reward:?} holds nothing above 0, so nothing is worth deciding; give right bins a reward above 0"
        ));
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
    if let Some(smoothing) = &spec.smoothing {
        self::smoothing(spec, smoothing)?;
    }
    match &spec.counts {
        Some(counts) if !same_shape(counts, &spec.p_obs) => {
            model_error(format!("counts and p_obs differ in shape; both are {}", shape(spec)))
        }
        _ => Ok(()),
    }
}

fn smoothing(spec: &ModelSpec, smoothing: &Smoothing) -> Result<()> {
    let wrong = |number: &f64| !(number.is_finite() && *number >= 0.0);
    let found = match smoothing {
        Smoothing::Scalar(number) => Some(number).filter(|number| wrong(number)),
        Smoothing::Tables(tables) if same_shape(tables, &spec.p_obs) => {
            tables.iter().flatten().flatten().flatten().find(|number| wrong(number))
        }
        Smoothing::Tables(_) => {
            return model_error(format!(
                "smoothing and p_obs differ in shape; give a number, or one for each entry, {}",
                shape(spec)
            ));
        }
    };
    match found {
        Some(number) => {
            model_error(format!("smoothing = {number}; it is a pseudo-count, finite and not negative"))
        }
        None => Ok(()),
    }
}

fn same_shape<A, B>(a: &Tables<A>, b: &Tables<B>) -> bool {
    a.len() == b.len()
        && a.iter().zip(b).all(|(a, b)| {
            a.len() == b.len()
                && a.iter()
                    .zip(b)
                    .all(|(a, b)| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.len() == b.len()))
        })
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
