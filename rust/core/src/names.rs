//! Look-up of names, with suggestions for unknown ones.

use crate::error::{Error, Result};

/// The name most like `text`, if there are any.
pub(crate) fn nearest<'a>(text: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    names.max_by(|a, b| strsim::jaro(text, a).total_cmp(&strsim::jaro(text, b)))
}

/// Index of `name` among the names of a set, `what` in messages.
pub(crate) fn index_of(what: &str, name: &str, names: &[String]) -> Result<usize> {
    names.iter().position(|known| known == name).ok_or_else(|| {
        let nearest = nearest(name, names.iter().map(String::as_str)).unwrap_or_default();
        Error::Argument(format!(
            "there is no {what} {name:?}; did you mean {nearest:?}? Known: {}, or 0 to {}",
            names.join(", "),
            names.len() - 1
        ))
    })
}
