//! Solutions on disk.
//!
//! A file is a line that names the format and its version, a line of JSON ([`Header`]), the grid's values (`f32`), the
//! policies' values (`f64`, a row per policy), the one-object policy (`f64`), and a checksum (`u64`) of all that; numbers are little-endian.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::alpha::{AlphaVectors, joint_kinds};
use super::prices::{PricedBound, SavedPrices};
use super::upper::{GridBound, Resolution};
use super::{LeafBounds, Solution};
use crate::error::{Error, Result, argument_error};
use crate::model::{ModelSpec, SortingModel};
use crate::one_object::OneObjectPolicy;

const FORMAT: &str = "beltsort solution ";
const VERSION: &str = "1";
const CHECKSUM_BYTES: usize = 8;

#[derive(Serialize, Deserialize)]
struct Header {
    model: ModelSpec,
    lower: f64,
    upper: f64,
    seconds: f64,
    /// Nothing for models that are solved without a grid.
    grid: Option<Resolution>,
    /// Of models that are solved without a grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    prices: Option<SavedPrices>,
    /// Rows of the policies' values.
    policies: usize,
}

impl Solution {
    /// Write the solution to disk: to a new file that then takes the place of an old one.
    ///
    /// # Errors
    /// [`Error::Argument`] naming the file if it cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        let unwritten = |e: &dyn std::fmt::Display| {
            Error::Argument(format!("{}: the solution cannot be written: {e}", path.display()))
        };
        let bytes = self.to_bytes().map_err(|e| unwritten(&e))?;
        let Some(name) = path.file_name() else { return Err(unwritten(&"the path names no file")) };
        let beside = path.with_file_name(format!(".{}.{}", name.to_string_lossy(), std::process::id()));
        let written = File::create(&beside)
            .and_then(|mut file| file.write_all(&bytes).and_then(|()| file.sync_all()))
            .and_then(|()| std::fs::rename(&beside, path));
        written.map_err(|e| {
            // What is left of it, if anything; the first error is the one to tell.
            let _ = std::fs::remove_file(&beside);
            unwritten(&e)
        })
    }

    /// Read a solution from disk, of `model` if one is given; it answers like the one that was saved.
    ///
    /// # Errors
    /// [`Error::Argument`] if the file cannot be read, is damaged, has another version, or holds the solution of
    /// another model; then it names the first difference.
    pub fn load(path: &Path, model: Option<&SortingModel>) -> Result<Self> {
        let in_file = |reason: String| Error::Argument(format!("{}: {reason}", path.display()));
        let bytes = std::fs::read(path).map_err(|e| in_file(format!("the solution cannot be read: {e}")))?;
        let solution = Self::from_bytes(&bytes).map_err(|e| in_file(e.to_string()))?;
        if let Some(model) = model {
            solution.check_solves(model).map_err(|e| in_file(e.to_string()))?;
        }
        Ok(solution)
    }

    /// The content of the file that [`Solution::save`] writes.
    ///
    /// # Errors
    /// If the header cannot be written as JSON.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let (grid, alphas) = (self.leaves.grid.as_deref(), self.leaves.alphas.as_ref());
        let header = Header {
            model: self.model.spec().clone(),
            lower: self.lower,
            upper: self.upper,
            seconds: self.elapsed.as_secs_f64(),
            grid: grid.map(|grid| grid.resolution),
            prices: self.leaves.prices.as_ref().map(|prices| prices.to_saved()),
            policies: alphas.map_or(0, |alphas| alphas.0.nrows()),
        };
        let header = serde_json::to_string(&header)
            .map_err(|e| Error::Argument(format!("the solution's header is no JSON: {e}")))?;
        let mut bytes = format!("{FORMAT}{VERSION}\n{header}\n").into_bytes();
        bytes.extend(grid.iter().flat_map(|grid| &grid.values).flat_map(|value| value.to_le_bytes()));
        let rows = alphas.iter().flat_map(|alphas| alphas.0.row_iter());
        for row in rows {
            bytes.extend(row.iter().flat_map(|value| value.to_le_bytes()));
        }
        let one_object = self.leaves.policy.to_numbers(&self.model);
        bytes.extend(one_object.iter().flat_map(|number| number.to_le_bytes()));
        bytes.extend(checksum(&bytes).to_le_bytes());
        Ok(bytes)
    }

    /// The solution of such a content.
    ///
    /// # Errors
    /// [`Error::Argument`] as [`Solution::load`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let (header, payload) = opened(bytes)?;
        let model = SortingModel::new(header.model)?;
        let states = joint_kinds(&model);
        let (values, numbers) = payload
            .split_at_checked(header.grid.map_or(0, |resolution| 4 * resolution.values(&model)))
            .ok_or_else(contradicted)?;
        let (rows, one_object) =
            numbers.split_at_checked(8 * header.policies * states).ok_or_else(contradicted)?;
        let values = || values.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let grid =
            header.grid.map(|resolution| Arc::new(GridBound::with_values(&model, resolution, values())));
        let rows = || DMatrix::from_row_iterator(header.policies, states, numbers_in(rows));
        let alphas = grid.is_some().then(|| AlphaVectors(rows()));
        let one_object: Vec<_> = numbers_in(one_object).collect();
        let policy = OneObjectPolicy::from_numbers(&model, &one_object).ok_or_else(contradicted)?;
        let prices = match header.prices {
            Some(saved) => Some(Arc::new(PricedBound::restored(&model, saved).ok_or_else(contradicted)?)),
            None => None,
        };
        let leaves = LeafBounds { policy, grid, prices, alphas };
        let elapsed = Duration::try_from_secs_f64(header.seconds).unwrap_or_default();
        Ok(Self { model, leaves, lower: header.lower, upper: header.upper, elapsed })
    }
}

fn numbers_in(bytes: &[u8]) -> impl Iterator<Item = f64> {
    bytes.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes))
}

fn contradicted() -> Error {
    Error::Argument("the file is damaged: its content contradicts its header; save the solution anew".into())
}

/// The header, and what is between it and the checksum.
fn opened(bytes: &[u8]) -> Result<(Header, &[u8])> {
    let Some((version, rest)) = bytes.strip_prefix(FORMAT.as_bytes()).and_then(line) else {
        return argument_error(
            "this is no solution of beltsort; write one with `beltsort solve MODEL -o FILE`",
        );
    };
    if version != VERSION.as_bytes() {
        return argument_error(format!(
            "the solution has format version {}, this beltsort reads {VERSION}; solve the model anew",
            String::from_utf8_lossy(version)
        ));
    }
    let intact = bytes.split_last_chunk::<CHECKSUM_BYTES>();
    let Some((_, stored)) = intact.filter(|(body, stored)| checksum(body) == u64::from_le_bytes(**stored))
    else {
        return argument_error("the file is damaged: its checksum is wrong; save the solution anew");
    };
    let Some((header, payload)) = line(rest) else {
        return argument_error("the file is damaged: it has no header; save the solution anew");
    };
    let header = serde_json::from_slice(header).map_err(|e| {
        Error::Argument(format!("the file is damaged: its header: {e}; save the solution anew"))
    })?;
    Ok((header, &payload[..payload.len() - stored.len()]))
}

/// What is before and behind the first end of a line.
fn line(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().position(|byte| *byte == b'\n')?;
    Some((&bytes[..end], &bytes[end + 1..]))
}

/// FNV-1a over words of 8 bytes, then over the bytes that are left.
fn checksum(bytes: &[u8]) -> u64 {
    let (words, rest) = bytes.as_chunks::<8>();
    let words = words.iter().map(|word| u64::from_le_bytes(*word));
    words.chain(rest.iter().map(|byte| u64::from(*byte))).fold(0xcbf2_9ce4_8422_2325, |hash, word| {
        // The rotation lets high bits reach low ones.
        (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(23)
    })
}

#[cfg(test)]
#[path = "saved_tests.rs"]
mod tests;
