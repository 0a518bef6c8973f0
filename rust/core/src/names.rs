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

#[cfg(test)]
mod tests {
    use super::{index_of, nearest};

    #[test]
    fn a_name_has_its_index() {
        let names = ["front".to_string(), "above".to_string()];
        assert_eq!(index_of("viewpoint", "above", &names), Ok(1));
    }

    #[test]
    fn an_unknown_name_is_told_the_nearest() {
        let names = ["front".to_string(), "above".to_string()];
        let message = index_of("viewpoint", "abvoe", &names).unwrap_err().to_string();
        assert_eq!(
            message,
            "there is no viewpoint \"abvoe\"; did you mean \"above\"? Known: front, above, or 0 to 1"
        );
        assert_eq!(nearest("any", std::iter::empty()), None);
    }
}
