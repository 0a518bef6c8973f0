//! The one error type of the core.

use crate::index::Position;

/// Everything that can be refused. Messages carry the value, what was expected, and the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A model that is not a sorting POMDP.
    #[error("{0}")]
    Model(String),
    /// An argument that does not fit the model or has no meaning.
    #[error("{0}")]
    Argument(String),
    /// A label with probability zero under the belief; the belief is left unchanged.
    #[error(
        "position {number}, viewpoint {viewpoint}: label {label} has probability 0 under the belief; \
         the belief is unchanged. Drop the label, or smooth the observation table so that no entry is 0",
        number = .position.number()
    )]
    ImpossibleObservation {
        /// Belt position; the message has its number.
        position: Position,
        /// Name of the viewpoint.
        viewpoint: String,
        /// Name of the label.
        label: String,
    },
    /// A policy that failed while it was asked for an action.
    #[error("{0}")]
    Policy(String),
}

/// A result of the core.
pub type Result<T> = std::result::Result<T, Error>;

/// Shorthand for [`Error::Model`].
pub(crate) fn model_error<T>(message: impl Into<String>) -> Result<T> {
    Err(Error::Model(message.into()))
}

/// Shorthand for [`Error::Argument`].
pub(crate) fn argument_error<T>(message: impl Into<String>) -> Result<T> {
    Err(Error::Argument(message.into()))
}
