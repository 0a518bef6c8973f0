//! Model files on disk.

use std::path::Path;

use crate::error::{Error, Result};

/// What a file holds, by its text; errors name the file.
pub(crate) fn read<T>(path: &Path, parse: impl FnOnce(&str) -> Result<T>) -> Result<T> {
    let in_file = |reason: String| Error::Model(format!("{}: {reason}", path.display()));
    let text =
        std::fs::read_to_string(path).map_err(|e| in_file(format!("the model file cannot be read: {e}")))?;
    parse(&text).map_err(|e| in_file(e.to_string()))
}

/// Write a file with this text.
pub(crate) fn write(path: &Path, text: &str) -> Result<()> {
    std::fs::write(path, format!("{text}\n"))
        .map_err(|e| Error::Model(format!("{}: the model file cannot be written: {e}", path.display())))
}
