//! Arm, belt and sorter, and what they are told to do: the same as `tests/drivers/ros/machine.py`, from its description.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

/// Time between messages.
pub const BEAT: Duration = Duration::from_millis(20);

const BINS: usize = 5;

/// Position of each joint, radians.
pub type Joints = BTreeMap<String, f64>;

/// What a line on standard input may change; an unknown key is an error.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    cloud: Option<String>,
    offset: Option<f64>,
    speed: Option<f64>,
    verdict: Option<i32>,
    travel: Option<f64>,
    emergency: Option<bool>,
    sort: Option<f64>,
    full: Option<bool>,
    stuck: Option<bool>,
    overshoot: Option<bool>,
    mute: Option<bool>,
}

/// What the peer does.
#[expect(clippy::struct_excessive_bools, reason = "each is told by itself")]
pub struct Settings {
    /// Whether the camera is "good" or, for example, "silent".
    pub cloud: String,
    /// How goals end: 4 aborted, 5 rejected.
    pub verdict: i32,
    /// Whether the emergency stop is pressed.
    pub emergency: bool,
    offset: f64,
    speed: f64,
    travel: f64,
    sort: f64,
    full: bool,
    stuck: bool,
    overshoot: bool,
    mute: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            cloud: "good".to_owned(),
            verdict: 3,
            emergency: false,
            offset: 0.0,
            speed: 5.0,
            travel: 0.15,
            sort: 0.1,
            full: false,
            stuck: false,
            overshoot: false,
            mute: false,
        }
    }
}

impl Settings {
    /// Takes over what was told.
    pub fn change(&mut self, told: Change) {
        macro_rules! take {
            ($($name:ident),*) => { $(if let Some(value) = told.$name { self.$name = value; })* };
        }
        take!(cloud, offset, speed, verdict, travel, emergency, sort, full, stuck, overshoot, mute);
    }
}

/// What became of a key: its state and the reason.
#[derive(Clone)]
pub struct Verdict(pub &'static str, pub String);

struct Sort {
    key: String,
    bin: usize,
    ends: Instant,
}

/// The world, as an onlooker sees it.
#[derive(Serialize)]
pub struct World {
    joints: Joints,
    object: i32,
    bins: [u32; BINS],
    busy: BTreeMap<&'static str, bool>,
    halted: bool,
    beats: u64,
}

/// Where a belt is on its way.
enum Travel {
    Stands,
    Until(Instant),
    Halted,
}

/// Arm, belt and sorter.
pub struct Machine {
    pub settings: Settings,
    pub joints: Joints,
    target: Joints,
    object: i32,
    travel: Travel,
    keys: Vec<(String, Verdict)>,
    sorting: Option<Sort>,
    bins: [u32; BINS],
    told: bool,
    beats: u64,
}

impl Default for Machine {
    fn default() -> Self {
        let home = Joints::from([("shoulder".to_owned(), 0.0), ("elbow".to_owned(), 0.0)]);
        Self {
            settings: Settings::default(),
            joints: home.clone(),
            target: home,
            object: 0,
            travel: Travel::Stands,
            keys: Vec::new(),
            sorting: None,
            bins: [0; BINS],
            told: false,
            beats: 0,
        }
    }
}

impl Machine {
    /// Begins a motion of the arm.
    pub fn go(&mut self, names: &[String], positions: &[f64]) {
        self.told = true;
        for (name, at) in names.iter().zip(positions) {
            self.target.insert(name.clone(), at + self.settings.offset);
        }
    }

    /// Whether the arm is where it was sent.
    pub fn arrived(&self) -> bool {
        self.joints == self.target
    }

    /// Stops the arm where it is.
    pub fn halt_arm(&mut self) {
        self.target.clone_from(&self.joints);
    }

    /// Begins to bring an object to the belt end.
    pub fn advance(&mut self, number: i32) {
        self.told = true;
        if !self.settings.stuck {
            self.object = number + i32::from(self.settings.overshoot);
            self.travel = Travel::Until(Instant::now() + Duration::from_secs_f64(self.settings.travel));
        }
    }

    /// Stops the belt where it is.
    pub fn halt_belt(&mut self) {
        self.travel = Travel::Halted;
    }

    fn travels(&self) -> bool {
        match self.travel {
            Travel::Stands => false,
            Travel::Until(end) => Instant::now() < end,
            Travel::Halted => true,
        }
    }

    /// What the belt reports.
    pub fn belt(&self) -> i32 {
        if self.travels() { -1 } else { self.object }
    }

    /// Begins a sort, unless the key is known.
    pub fn sort(&mut self, key: &str, value: &str) {
        self.told = true;
        if self.keys.iter().any(|(known, _)| known == key) {
            return;
        }
        let verdict = match value.parse::<usize>() {
            Ok(bin) if bin < BINS && self.settings.full => Verdict("rejected", "the bin is full".to_owned()),
            Ok(bin) if bin < BINS => {
                let ends = Instant::now() + Duration::from_secs_f64(self.settings.sort);
                self.sorting = Some(Sort { key: key.to_owned(), bin, ends });
                Verdict("active", String::new())
            }
            _ => Verdict("rejected", format!("there is no bin {value}")),
        };
        self.keys.push((key.to_owned(), verdict));
    }

    /// Breaks a sort off.
    pub fn halt_sorter(&mut self) {
        if let Some(sort) = self.sorting.take() {
            self.settle(&sort.key, &Verdict("aborted", "stopped on the way".to_owned()));
        }
    }

    fn settle(&mut self, key: &str, verdict: &Verdict) {
        for (known, state) in &mut self.keys {
            if known == key {
                *state = verdict.clone();
            }
        }
    }

    /// What became of each key.
    pub fn keys(&self) -> &[(String, Verdict)] {
        &self.keys
    }

    /// Goes on by a beat; returns whether the peer may report.
    pub fn beat(&mut self) -> bool {
        self.beats += 1;
        let step = self.settings.speed * BEAT.as_secs_f64();
        for (name, at) in &self.target {
            let joint = self.joints.entry(name.clone()).or_default();
            *joint = if (at - *joint).abs() <= step { *at } else { *joint + step.copysign(at - *joint) };
        }
        if let Some(sort) = self.sorting.take_if(|sort| Instant::now() >= sort.ends) {
            self.bins[sort.bin] += 1;
            self.settle(&sort.key, &Verdict("succeeded", String::new()));
        }
        self.told &= self.settings.mute;
        !self.told
    }

    /// The world, as an onlooker sees it.
    pub fn world(&self) -> World {
        let busy = [("arm", !self.arrived()), ("belt", self.travels()), ("sorter", self.sorting.is_some())];
        World {
            joints: self.joints.clone(),
            object: self.object,
            bins: self.bins,
            busy: busy.into(),
            halted: matches!(self.travel, Travel::Halted),
            beats: self.beats,
        }
    }
}
