//! The model as it is written down: the fields of a model file.

use std::path::Path;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::file::{read, write};
use crate::error::{Error, Result, model_error};
use crate::names::nearest;

/// A number for all entries, or a matrix of one number each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ScalarOrMatrix {
    /// The same number everywhere.
    Scalar(f64),
    /// One row per first index.
    Matrix(Vec<Vec<f64>>),
}

impl ScalarOrMatrix {
    /// One number per entry of a matrix whose shape was checked.
    pub(super) fn expand(&self, rows: usize, columns: usize) -> DMatrix<f64> {
        match self {
            Self::Scalar(number) => DMatrix::from_element(rows, columns, *number),
            Self::Matrix(matrix) => DMatrix::from_fn(rows, columns, |i, j| matrix[i][j]),
        }
    }
}

/// Pseudo-counts of the prior that `p_obs` was estimated with: a number for all entries, or one for each entry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Smoothing {
    /// The same pseudo-count everywhere.
    Scalar(f64),
    /// One pseudo-count for each entry, of the shape of the counts.
    Tables(Tables<f64>),
}

/// Observation tables `p_obs[position][viewpoint][kind][label]`; in the paper's model kinds and labels are the classes.
pub type Tables<T> = Vec<Vec<Vec<Vec<T>>>>;

/// A sorting model as written down by its user; [`crate::SortingModel::new`] checks it.
///
/// The field names are the keys of a model file (JSON) and the arguments of the Python constructor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelSpec {
    /// Names of the object classes, `c_1..c_L`.
    pub classes: Vec<String>,
    /// Names of the viewpoints, `p_1..p_K`.
    pub viewpoints: Vec<String>,
    /// Observation tables of shape (H, K, N, Z); rows sum to 1.
    pub p_obs: Tables<f64>,
    /// Names of the Z labels that one look may yield; the classes if missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labels: Option<Vec<String>>,
    /// Names of the B bins that a decision chooses from; the classes if missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bins: Option<Vec<String>>,
    /// Worth of putting class c into bin b, shape (B, L); if missing `r_max` for the class's own bin and `-r_min` elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reward: Option<Vec<Vec<f64>>>,
    /// Weights of the modes of each class, which sum to 1; one mode each if missing. A mode is drawn when an object arrives.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modes: Option<Vec<Vec<f64>>>,
    /// Reward of a right decision.
    #[serde(default = "default_r_max")]
    pub r_max: f64,
    /// Penalty of a wrong decision.
    #[serde(default = "default_r_min")]
    pub r_min: f64,
    /// Cost of a move: a number, or a (K, K) matrix `[from][to]`.
    #[serde(default = "default_motion_cost")]
    pub motion_cost: ScalarOrMatrix,
    /// Discount per planner step.
    #[serde(default = "default_discount")]
    pub discount: f64,
    /// Prior of the class of an arriving object; uniform if missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arrival: Option<Vec<f64>>,
    /// `travel[k]`: the viewpoints one move from `k` reaches; all of them if missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub travel: Option<Vec<Vec<usize>>>,
    /// Whether a scan follows a decision too.
    #[serde(default)]
    pub observe_after_decision: bool,
    /// Probability that a second look from the same viewpoint at the same object in the same position only repeats
    /// its label: a number, or (H, K).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeat: Option<ScalarOrMatrix>,
    /// `alpha`: reward per nat of entropy that a scan is expected to remove.
    #[serde(default)]
    pub information_gain: f64,
    /// The class that stands for an empty cup.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub empty: Option<String>,
    /// How perception makes a label of what a classifier returns; kept here beside the tables that were counted with it,
    /// and not used by the planner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label_rule: Option<Value>,
    /// Label counts behind `p_obs`, same shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counts: Option<Tables<u64>>,
    /// Dirichlet pseudo-counts that were added to `counts`: a number, or of the same shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smoothing: Option<Smoothing>,
    /// Free text.
    #[serde(default)]
    pub note: String,
}

/// Characters of a wrong value that a message shows.
const LONGEST_SHOWN: usize = 60;
/// Reward of a right decision, unless the model says otherwise.
pub const DEFAULT_R_MAX: f64 = 10.0;
/// Penalty of a wrong decision, likewise.
pub const DEFAULT_R_MIN: f64 = 50.0;
/// Discount per planner step, likewise; usual for DESPOT, the paper prints none.
pub const DEFAULT_DISCOUNT: f64 = 0.95;

const KEYS: [&str; 21] = [
    "classes",
    "viewpoints",
    "p_obs",
    "labels",
    "bins",
    "reward",
    "modes",
    "r_max",
    "r_min",
    "motion_cost",
    "discount",
    "arrival",
    "travel",
    "observe_after_decision",
    "repeat",
    "information_gain",
    "empty",
    "label_rule",
    "counts",
    "smoothing",
    "note",
];

/// The key that a model file has not, and the file of a moving belt has besides those of its model.
pub(crate) const MOVING_BELT: &str = "moving_belt";

/// Keys that `reward` takes the place of.
const PAPERS: [&str; 2] = ["r_max", "r_min"];

fn default_r_max() -> f64 {
    DEFAULT_R_MAX
}

fn default_r_min() -> f64 {
    DEFAULT_R_MIN
}

fn default_motion_cost() -> ScalarOrMatrix {
    ScalarOrMatrix::Scalar(1.0)
}

fn default_discount() -> f64 {
    DEFAULT_DISCOUNT
}

impl ModelSpec {
    /// A model with the paper's rewards, the assumed discount 0.95, a uniform arrival prior and free travel.
    #[must_use]
    pub fn new(classes: Vec<String>, viewpoints: Vec<String>, p_obs: Tables<f64>) -> Self {
        Self {
            classes,
            viewpoints,
            p_obs,
            labels: None,
            bins: None,
            reward: None,
            modes: None,
            r_max: default_r_max(),
            r_min: default_r_min(),
            motion_cost: default_motion_cost(),
            discount: default_discount(),
            arrival: None,
            travel: None,
            observe_after_decision: false,
            repeat: None,
            information_gain: 0.0,
            empty: None,
            label_rule: None,
            counts: None,
            smoothing: None,
            note: String::new(),
        }
    }

    /// Read a model file.
    ///
    /// # Errors
    /// [`Error::Model`] if the text is not JSON, a key is unknown or missing, or a value has the wrong type.
    pub fn from_json(text: &str) -> Result<Self> {
        let fields = Self::fields(text)?;
        if fields.contains_key(MOVING_BELT) {
            return model_error(format!(
                "the key {MOVING_BELT} makes this the file of a moving belt; read it with MovingBelt.load, whose model it then is"
            ));
        }
        Self::from_fields(fields)
    }

    /// The keys of a model file, not checked.
    pub(crate) fn fields(text: &str) -> Result<Map<String, Value>> {
        let value: Value =
            serde_json::from_str(text).map_err(|e| Error::Model(format!("a model file is JSON: {e}")))?;
        match value {
            Value::Object(fields) => Ok(fields),
            _ => model_error(
                "a model file holds one JSON object, with the keys classes, viewpoints and p_obs at least",
            ),
        }
    }

    /// The model with these keys.
    pub(crate) fn from_fields(fields: Map<String, Value>) -> Result<Self> {
        if let (Some(_), Some(key)) =
            (fields.get("reward"), PAPERS.iter().find(|key| fields.contains_key(**key)))
        {
            return model_error(format!(
                "reward and {key} = {} are both given, but reward says what every class is worth in every bin; leave \
                 {key} out",
                fields[*key]
            ));
        }
        if let Some(key) = fields.keys().find(|key| !KEYS.contains(&key.as_str())) {
            return model_error(unknown_key(key));
        }
        let wrong = fields.iter().find_map(|(key, value)| wrong_value(key, value));
        let named = |e| Error::Model(wrong.unwrap_or_else(|| format!("model file: {e}")));
        serde_json::from_value(Value::Object(fields)).map_err(named)
    }

    /// What is wrong with a value at `place` in a key, whose type is not that of the key.
    #[must_use]
    pub fn wrong_type(key: &str, place: &str, value: &str) -> String {
        let expected = match key {
            "classes" | "viewpoints" | "labels" | "bins" => {
                "a list of names: write [\"nut\", \"bolt\"] for example"
            }
            "p_obs" => "numbers in four nested lists, (H, K, L, L) in the paper's model: correct it",
            "counts" => "whole numbers, not negative, in the shape of p_obs: correct it",
            "smoothing" => "a number, or numbers in the shape of p_obs: correct it",
            "reward" => {
                "a row for each bin, with a number for each class: write [[10, -50], [-50, 10]] for example"
            }
            "modes" => {
                "a list for each class, with the weights of its modes: write [[0.5, 0.5], [1]] for example"
            }
            "arrival" => "a probability for each class: write [0.3, 0.7] for example",
            "motion_cost" | "repeat" => "a number, or a list of rows of numbers: correct it",
            "travel" => {
                "for each viewpoint a list of the viewpoints' numbers that one move reaches: correct it"
            }
            "observe_after_decision" => "true or false: correct it",
            "empty" => "the name of a class: write it in quotes",
            "note" => "a text: write it in quotes",
            "label_rule" => "a table of keys and values: correct it",
            _ => "a number: write 10 for example",
        };
        let shown: String = value.chars().take(LONGEST_SHOWN).collect();
        let cut = if shown.len() < value.len() { "..." } else { "" };
        let of = if key == place { String::new() } else { format!("{key} to be ") };
        format!("{place} is {shown}{cut}, expected {of}{expected}")
    }

    /// The model file as text.
    ///
    /// # Errors
    /// [`Error::Model`] if a number is not finite, which JSON cannot hold.
    pub fn to_json(&self) -> Result<String> {
        if self.reward.is_none() {
            return serde_json::to_string_pretty(self).map_err(|e| not_json(&e));
        }
        serde_json::to_string_pretty(&self.to_fields()?).map_err(|e| not_json(&e))
    }

    /// The keys of the model file.
    pub(crate) fn to_fields(&self) -> Result<Map<String, Value>> {
        let Value::Object(mut fields) = serde_json::to_value(self).map_err(|e| not_json(&e))? else {
            return model_error("the model is no JSON object");
        };
        if self.reward.is_some() {
            fields.retain(|key, _| !PAPERS.contains(&key.as_str()));
        }
        Ok(fields)
    }

    /// Read a model file from disk.
    ///
    /// # Errors
    /// [`Error::Model`] naming the file if it cannot be read or is not a model file.
    pub fn load(path: &Path) -> Result<Self> {
        read(path, Self::from_json)
    }

    /// Write a model file to disk.
    ///
    /// # Errors
    /// [`Error::Model`] naming the file if it cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        write(path, &self.to_json()?)
    }
}

fn not_json(reason: &serde_json::Error) -> Error {
    Error::Model(format!("the model cannot be written as JSON: {reason}"))
}

/// What is wrong with the value of a key, if its type is; the innermost entry is named.
fn wrong_value(key: &str, value: &Value) -> Option<String> {
    let fails = |value: Value| {
        let mut fields = serde_json::json!({"classes": [], "viewpoints": [], "p_obs": []});
        fields[key] = value;
        serde_json::from_value::<ModelSpec>(fields).is_err()
    };
    let (place, value) = fails(value.clone()).then(|| innermost(key.into(), value, &fails))?;
    Some(ModelSpec::wrong_type(key, &place, &value.to_string()))
}

/// Place and value of the first entry that makes nested lists fail.
fn innermost<'v>(place: String, value: &'v Value, fails: &dyn Fn(Value) -> bool) -> (String, &'v Value) {
    let alone = |entry: Value| fails(Value::Array(vec![entry]));
    let entries = value.as_array().into_iter().flatten().enumerate();
    let wrong = entries.into_iter().find(|(_, entry)| alone((*entry).clone()));
    match wrong {
        Some((number, entry)) => innermost(format!("{place}[{number}]"), entry, &alone),
        None => (place, value),
    }
}

fn unknown_key(key: &str) -> String {
    let guess = nearest(key, KEYS.iter().copied()).unwrap_or_default();
    format!("unknown key {key:?} in the model file; did you mean {guess:?}? Known keys: {}", KEYS.join(", "))
}
