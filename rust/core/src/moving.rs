//! A belt that never stops.

pub(crate) mod planning;
