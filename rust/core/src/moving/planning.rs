//! Planning for a belt that never stops.
//!
//! One object with a deadline ([`deadline`]) is the building block: its values under shares of the looks' costs bound the
//! value of the whole belt from above ([`priced`]).

mod deadline;
mod expand;
mod plans;
mod priced;
mod search;
mod serving;
mod state;
mod timing;

#[cfg(test)]
mod tests;
