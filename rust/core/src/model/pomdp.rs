//! The model as a flat POMDP in Cassandra's file format (<http://www.pomdp.org/code/pomdp-file-spec.html>), for
//! other solvers.
//!
//! * A state is the kind at every position (`c1_c0`: kind 1 at the belt end), with the viewpoint in front
//!   (`v2_c1_c0`) unless it does not matter. In the paper's model kinds are classes.
//! * The actions are `move_k` and `decide_i`. Every action is open in every state of such a file: a move that
//!   `travel` forbids costs so much that it is never optimal ([`Flat::forbidden`]).
//! * An observation is the label at every position (`z1_z0`), or `nothing` after a decision that no scan follows.
//! * The start is the arrival prior at every position, the camera at the first viewpoint.

use std::fmt;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::{SortingModel, shift};
use crate::error::{Error, Result, model_error};
use crate::index::{Bin, Kind, Label, Viewpoint};

#[cfg(test)]
mod tests;

/// States times observations beyond which no solver of flat POMDPs gets anywhere, and files fill disks.
const MOST_ENTRIES: usize = 2_000_000;

impl SortingModel {
    /// Write the model as a flat POMDP in Cassandra's format.
    ///
    /// # Errors
    /// [`Error::Model`] if it has too many states and observations, if labels repeat (the labels seen so far are no
    /// part of such a state) or information is rewarded, or if the file cannot be written.
    pub fn to_pomdp(&self, path: &Path) -> Result<()> {
        let flat = Flat::new(self)?;
        let write = || {
            let mut out = BufWriter::new(File::create(path)?);
            flat.write(&mut out)?;
            out.flush()
        };
        write().map_err(|e: io::Error| {
            Error::Model(format!("{}: the POMDP file cannot be written: {e}", path.display()))
        })
    }
}

/// A model whose states and observations are numbered.
struct Flat<'a> {
    model: &'a SortingModel,
    /// How many viewpoints the states tell apart: K, or 1 if the viewpoint does not matter.
    viewpoints: usize,
    /// N^H, the number of kind vectors.
    kind_vectors: usize,
    /// Z^H, the number of label vectors.
    label_vectors: usize,
}

/// The camera's viewpoint (0 if it does not matter) and the kind at each position.
#[derive(Clone)]
struct State {
    viewpoint: Viewpoint,
    kinds: Vec<Kind>,
}

impl<'a> Flat<'a> {
    fn new(model: &'a SortingModel) -> Result<Self> {
        check_expressible(model)?;
        let viewpoints = if viewpoint_matters(model) { model.viewpoint_count() } else { 1 };
        let (h, n, z) = (model.position_count(), model.kind_count(), model.label_count());
        let power = |base: usize| u32::try_from(h).ok().and_then(|h| base.checked_pow(h));
        if let (Some(kind_vectors), Some(label_vectors)) = (power(n), power(z))
            && let Some(..=MOST_ENTRIES) =
                kind_vectors.checked_mul(label_vectors).and_then(|pairs| pairs.checked_mul(viewpoints))
        {
            return Ok(Self { model, viewpoints, kind_vectors, label_vectors });
        }
        let kinds = if model.has_modes() { "modes of classes" } else { "classes" };
        model_error(format!(
            "{n} {kinds} at {h} positions from {viewpoints} viewpoints give {viewpoints} * {n}^{h} states and {z}^{h} \
             observations, more than {MOST_ENTRIES} pairs; keep fewer positions (with_positions)"
        ))
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        self.preamble(out)?;
        self.model.viewpoints().try_for_each(|to| self.motion(out, to))?;
        self.model.bins().try_for_each(|bin| self.decision(out, bin))
    }

    fn preamble(&self, out: &mut impl Write) -> io::Result<()> {
        let spec = self.model.spec();
        writeln!(out, "# A sorting POMDP, written by beltsort. Names count from 0.")?;
        self.names(out)?;
        writeln!(out, "# viewpoints: {:?}", spec.viewpoints)?;
        writeln!(out, "# a forbidden move costs {}", number(self.forbidden()))?;
        writeln!(out, "discount: {}", number(spec.discount))?;
        writeln!(out, "values: reward")?;
        writeln!(out, "states: {}", joined(self.states().map(|state| self.name(&state))))?;
        let moves = self.model.viewpoints().map(|v| format!("move_{v}"));
        let decisions = self.model.bins().map(|bin| format!("decide_{bin}"));
        writeln!(out, "actions: {}", joined(moves.chain(decisions)))?;
        let nothing = (!self.model.observes_after_decision()).then(|| "nothing".to_owned());
        let labels = self.label_vectors().map(|labels| vector_name('z', &labels));
        writeln!(out, "observations: {}", joined(labels.chain(nothing)))?;
        writeln!(out, "start: {}", joined(self.states().map(|state| number(self.start(&state)))))
    }

    /// What the numbers in names stand for.
    fn names(&self, out: &mut impl Write) -> io::Result<()> {
        let spec = self.model.spec();
        if spec.labels.is_none() && spec.bins.is_none() && !self.model.has_modes() {
            return writeln!(out, "# classes and labels: {:?}", spec.classes);
        }
        let class = |kind| &spec.classes[self.model.class_of(kind).0];
        writeln!(out, "# class of each kind: {:?}", self.model.kinds().map(class).collect::<Vec<_>>())?;
        writeln!(out, "# labels: {:?}", self.model.label_names())?;
        writeln!(out, "# bins: {:?}", self.model.bin_names())
    }

    fn motion(&self, out: &mut impl Write, to: Viewpoint) -> io::Result<()> {
        let action = format!("move_{to}");
        for state in self.states() {
            let mut next = state.clone();
            next.viewpoint = if self.viewpoints == 1 { Viewpoint(0) } else { to };
            let name = self.name(&state);
            writeln!(out, "T: {action} : {name} : {} 1.0", self.name(&next))?;
            writeln!(
                out,
                "R: {action} : {name} : * : * {}",
                number(self.motion_reward(state.viewpoint, to))
            )?;
            self.scan(out, &action, &state, to)?;
        }
        Ok(())
    }

    fn decision(&self, out: &mut impl Write, decided: Bin) -> io::Result<()> {
        let action = format!("decide_{decided}");
        let scans = self.model.observes_after_decision();
        if !scans {
            writeln!(out, "O: {action} : * : nothing 1.0")?;
        }
        for state in self.states() {
            let name = self.name(&state);
            let arriving = self.model.kinds().zip(self.model.arrival());
            for (kind, &p) in arriving.filter(|(_, p)| **p > 0.0) {
                let mut next = state.clone();
                shift(&mut next.kinds, std::iter::once(kind));
                writeln!(out, "T: {action} : {name} : {} {}", self.name(&next), number(p))?;
            }
            let reward = self.model.reward(decided, state.kinds[0]);
            writeln!(out, "R: {action} : {name} : * : * {}", number(reward))?;
            if scans {
                self.scan(out, &action, &state, state.viewpoint)?;
            }
        }
        Ok(())
    }

    /// The labels that a scan from `viewpoint` gives once `action` has led to `state`.
    fn scan(
        &self,
        out: &mut impl Write,
        action: &str,
        state: &State,
        viewpoint: Viewpoint,
    ) -> io::Result<()> {
        let name = self.name(state);
        for labels in self.label_vectors() {
            let seen = self.model.positions().zip(state.kinds.iter().zip(&labels));
            let p: f64 = seen.map(|(j, (c, z))| self.model.table(j, viewpoint)[(c.0, z.0)]).product();
            if p > 0.0 {
                writeln!(out, "O: {action} : {name} : {} {}", vector_name('z', &labels), number(p))?;
            }
        }
        Ok(())
    }

    fn motion_reward(&self, from: Viewpoint, to: Viewpoint) -> f64 {
        if self.model.legal_moves(from).contains(&to) {
            0.0 - self.model.motion_cost(from, to)
        } else {
            0.0 - self.forbidden()
        }
    }

    /// The cost of a forbidden move: nothing that follows can be worth more than the largest reward for ever, and
    /// deciding for ever earns the least one at worst.
    fn forbidden(&self) -> f64 {
        (self.model.most_reward() - self.model.least_reward()) / (1.0 - self.model.discount())
    }

    fn start(&self, state: &State) -> f64 {
        if state.viewpoint != Viewpoint(0) {
            return 0.0;
        }
        state.kinds.iter().map(|c| self.model.arrival()[c.0]).product()
    }

    /// Every state, in the order of the file: by viewpoint, then by the kind at the belt end, and so on.
    fn states(&self) -> impl Iterator<Item = State> {
        (0..self.viewpoints).map(Viewpoint).flat_map(move |viewpoint| {
            (0..self.kind_vectors).map(move |index| {
                let kinds = self.vector((index, self.model.kind_count()), Kind);
                State { viewpoint, kinds }
            })
        })
    }

    /// Every vector of labels, in the order of the file.
    fn label_vectors(&self) -> impl Iterator<Item = Vec<Label>> {
        (0..self.label_vectors).map(|index| self.vector((index, self.model.label_count()), Label))
    }

    /// The vector with this number among those of so many kinds or labels, position 0 first (and most significant).
    fn vector<T>(&self, (index, base): (usize, usize), entry: fn(usize) -> T) -> Vec<T> {
        let mut rest = index;
        let mut entries: Vec<T> = (0..self.model.position_count())
            .map(|_| {
                let digit = rest % base;
                rest /= base;
                entry(digit)
            })
            .collect();
        entries.reverse();
        entries
    }

    fn name(&self, state: &State) -> String {
        let kinds = vector_name('c', &state.kinds);
        if self.viewpoints == 1 { kinds } else { format!("v{}_{kinds}", state.viewpoint) }
    }
}

fn check_expressible(model: &SortingModel) -> Result<()> {
    let beyond = [
        ("repeat", model.ever_repeats(), "the labels seen so far are no part of its states"),
        ("information_gain", model.spec().information_gain > 0.0, "its rewards do not depend on the belief"),
    ];
    match beyond.iter().find(|(_, used, _)| *used) {
        Some((key, _, reason)) => {
            model_error(format!("{key} is set, which a POMDP file cannot hold: {reason}. Leave it out"))
        }
        None => Ok(()),
    }
}

/// Whether the viewpoint is needed to tell which moves are legal, what they cost, or what is seen.
fn viewpoint_matters(model: &SortingModel) -> bool {
    let costs = |from| model.legal_moves(from).iter().map(move |to| (*to, model.motion_cost(from, *to)));
    let differ = || model.viewpoints().any(|from| !costs(from).eq(costs(Viewpoint(0))));
    model.viewpoint_count() > 1 && (model.observes_after_decision() || differ())
}

fn vector_name(letter: char, entries: &[impl fmt::Display]) -> String {
    entries.iter().map(|entry| format!("{letter}{entry}")).collect::<Vec<_>>().join("_")
}

fn joined(words: impl Iterator<Item = String>) -> String {
    words.collect::<Vec<_>>().join(" ")
}

/// A number that reads back exactly, as the format wants it: digits before and after the point, no exponent.
fn number(value: f64) -> String {
    let digits = value.to_string();
    if digits.contains('.') { digits } else { digits + ".0" }
}
