//! The first difference of two models, as they are written down.

use serde_json::Value;

use super::Solution;
use crate::error::{Error, Result, argument_error};
use crate::model::{ModelSpec, SortingModel};

/// Keys that no plan depends on.
const REMARKS: [&str; 3] = ["note", "counts", "smoothing"];

impl Solution {
    /// Refuse a model that this is no solution of; remarks and label counts may differ.
    ///
    /// # Errors
    /// [`Error::Argument`] naming the first difference.
    pub fn check_solves(&self, model: &SortingModel) -> Result<()> {
        match first_difference(self.model.spec(), model.spec())? {
            None => Ok(()),
            Some(difference) => {
                argument_error(format!("the solution is of another model: {difference}; solve this one"))
            }
        }
    }
}

/// Where two models differ first, and how: `r_min: 50 in the solution, 5 in the model`.
fn first_difference(solved: &ModelSpec, given: &ModelSpec) -> Result<Option<String>> {
    let written = |spec: &ModelSpec| {
        let mut value = serde_json::to_value(spec)
            .map_err(|e| Error::Model(format!("the model cannot be written as JSON: {e}")))?;
        if let Some(fields) = value.as_object_mut() {
            fields.retain(|key, _| !REMARKS.contains(&key.as_str()));
        }
        Ok(value)
    };
    Ok(difference("", &written(solved)?, &written(given)?))
}

fn difference(place: &str, solved: &Value, given: &Value) -> Option<String> {
    match (solved, given) {
        (Value::Object(a), Value::Object(b)) => {
            let mut keys: Vec<_> = a.keys().chain(b.keys()).collect();
            keys.sort_unstable();
            let field = |fields: &serde_json::Map<String, Value>, key| fields.get(key).cloned();
            keys.into_iter().find_map(|key| {
                let (a, b) = (field(a, key).unwrap_or_default(), field(b, key).unwrap_or_default());
                difference(&format!("{place}{key}"), &a, &b)
            })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let mut entries = a.iter().zip(b).enumerate();
            entries.find_map(|(i, (a, b))| difference(&format!("{place}[{i}]"), a, b))
        }
        (a, b) if a == b => None,
        (a, b) => Some(format!("{place}: {} in the solution, {} in the model", shown(a), shown(b))),
    }
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => "nothing".into(),
        Value::Array(entries) => format!("a list of {}", entries.len()),
        Value::Number(number) => {
            number.as_f64().map_or_else(|| number.to_string(), |number| number.to_string())
        }
        other => other.to_string(),
    }
}
