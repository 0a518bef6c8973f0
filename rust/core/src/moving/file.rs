//! The file of a moving belt: the keys of a model file, and one more object.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use super::belt::MovingBelt;
use super::spec::{Drive, MovingSpec};
use crate::error::{Error, Result, model_error};
use crate::model::{MOVING_BELT, ModelSpec, SortingModel, read, write};
use crate::names::nearest;

const KEYS: [&str; 8] = [
    "ticks_per_place",
    "advance_ticks",
    "reach",
    "move_ticks",
    "scan_ticks",
    "sort_ticks",
    "missed",
    "seconds_per_tick",
];

impl MovingBelt {
    /// Read the text of a file: a model file with one more key, `moving_belt`, which holds [`MovingSpec`]'s fields.
    ///
    /// # Errors
    /// [`Error::Model`] if the text is not JSON, a key is unknown or missing, or a value has the wrong type; whatever
    /// [`MovingBelt::new`] refuses.
    pub fn from_json(text: &str) -> Result<Self> {
        let mut fields = ModelSpec::fields(text)?;
        let Some(belt) = fields.remove(MOVING_BELT) else {
            return model_error(format!(
                "there is no key {MOVING_BELT}, which holds ticks_per_place and what else is known of a moving belt; add it, or \
                 read a model alone with SortingModel.load"
            ));
        };
        let model = SortingModel::new(ModelSpec::from_fields(fields)?)?;
        Self::new(model, spec_of(&belt)?)
    }

    /// The file as text.
    ///
    /// # Errors
    /// [`Error::Model`] if a number cannot be written as JSON.
    pub fn to_json(&self) -> Result<String> {
        let mut fields = self.model().spec().to_fields()?;
        fields.insert(MOVING_BELT.into(), Value::Object(fields_of(self.spec())));
        serde_json::to_string_pretty(&fields)
            .map_err(|e| Error::Model(format!("the belt cannot be written as JSON: {e}")))
    }

    /// Read a file.
    ///
    /// # Errors
    /// As [`MovingBelt::from_json`], naming the file; also if it cannot be read.
    pub fn load(path: &Path) -> Result<Self> {
        read(path, Self::from_json)
    }

    /// Write a file.
    ///
    /// # Errors
    /// [`Error::Model`] naming the file if it cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        write(path, &self.to_json()?)
    }
}

fn spec_of(belt: &Value) -> Result<MovingSpec> {
    let Some(fields) = belt.as_object() else {
        return model_error(format!(
            "{MOVING_BELT} is {belt}, expected an object: write {{\"ticks_per_place\": 4}} for example"
        ));
    };
    if let Some(key) = fields.keys().find(|key| !KEYS.contains(&key.as_str())) {
        let guess = nearest(key, KEYS.iter().copied()).unwrap_or_default();
        return model_error(format!(
            "unknown key {key:?} in {MOVING_BELT}; did you mean {guess:?}? Known keys: {}",
            KEYS.join(", ")
        ));
    }
    let ticks = "a whole number of ticks";
    let drive = Drive::of(value(fields, KEYS[0], ticks)?, value(fields, KEYS[1], ticks)?)?;
    let plain = MovingSpec::new(drive);
    Ok(MovingSpec {
        drive,
        reach: value(fields, KEYS[2], "a whole number of places")?.unwrap_or(plain.reach),
        move_ticks: value(fields, KEYS[3], "a number of ticks, or a row of them per viewpoint")?
            .unwrap_or(plain.move_ticks),
        scan_ticks: value(fields, KEYS[4], ticks)?.unwrap_or(plain.scan_ticks),
        sort_ticks: value(fields, KEYS[5], ticks)?.unwrap_or(plain.sort_ticks),
        missed: value(fields, KEYS[6], "a price per class")?,
        seconds_per_tick: value(fields, KEYS[7], "a number of seconds")?,
    })
}

/// The value of a key, if it is there and not null.
fn value<T: DeserializeOwned>(fields: &Map<String, Value>, key: &str, expected: &str) -> Result<Option<T>> {
    let Some(value) = fields.get(key) else { return Ok(None) };
    serde_json::from_value(value.clone())
        .map_err(|_| Error::Model(format!("{MOVING_BELT}.{key} is {value}, expected {expected}; correct it")))
}

fn fields_of(spec: &MovingSpec) -> Map<String, Value> {
    let drive = match spec.drive {
        Drive::Constant { ticks_per_place } => (KEYS[0], json!(ticks_per_place)),
        Drive::OnDecision { advance_ticks } => (KEYS[1], json!(advance_ticks)),
    };
    let always = [
        drive,
        (KEYS[2], json!(spec.reach)),
        (KEYS[3], json!(spec.move_ticks)),
        (KEYS[4], json!(spec.scan_ticks)),
        (KEYS[5], json!(spec.sort_ticks)),
    ];
    let given = [
        spec.missed.as_ref().map(|prices| (KEYS[6], json!(prices))),
        spec.seconds_per_tick.map(|seconds| (KEYS[7], json!(seconds))),
    ];
    always.into_iter().chain(given.into_iter().flatten()).map(|(key, value)| (key.into(), value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ScalarOrMatrix;
    use crate::testing::paper;

    #[test]
    fn what_is_written_is_read() {
        for drive in [Drive::Constant { ticks_per_place: 4 }, Drive::OnDecision { advance_ticks: 3 }] {
            let plain = MovingSpec::new(drive);
            let full = MovingSpec {
                move_ticks: ScalarOrMatrix::Matrix(vec![vec![0.0, 2.0, 3.0]; 3]),
                scan_ticks: 2,
                missed: Some(vec![1.0, 0.1, 3.0, 0.0]),
                seconds_per_tick: Some(0.1),
                ..plain.clone()
            };
            for spec in [plain, full] {
                let belt = MovingBelt::new(paper(50.0), spec).unwrap();
                assert_eq!(MovingBelt::from_json(&belt.to_json().unwrap()).unwrap(), belt);
            }
        }
    }

    #[test]
    fn a_file_that_is_none_of_a_belt_is_refused() {
        let model = paper(50.0).spec().to_json().unwrap();
        let with = |belt: &str| model.replacen('{', &format!("{{\"{MOVING_BELT}\": {belt},"), 1);
        for (text, word) in [
            (model.clone(), "SortingModel.load"),
            (with("4"), "expected an object"),
            (with("{\"tick_per_place\": 4}"), "did you mean \"ticks_per_place\""),
            (with("{\"ticks_per_place\": 4.5}"), "ticks_per_place is 4.5"),
            (with("{\"ticks_per_place\": 4, \"advance_ticks\": 1}"), "both"),
            (with("{}"), "neither"),
        ] {
            let error = MovingBelt::from_json(&text).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
        let error = ModelSpec::from_json(&with("{\"ticks_per_place\": 4}")).unwrap_err().to_string();
        assert!(error.contains("MovingBelt.load"), "{error}");
    }
}
