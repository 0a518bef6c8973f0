//! Indices of the model's sets, a type each: no two of them can be swapped.

use std::fmt;

use serde::{Deserialize, Serialize};

macro_rules! indices {
    ($($(#[$meaning:meta])* $name:ident;)*) => {$(
        $(#[$meaning])*
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
        )]
        pub struct $name(pub usize);

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

indices! {
    /// `j`: a belt position, 0 at the belt end.
    Position;
    /// `k`: where the camera can stand.
    Viewpoint;
    /// `c`: what an object is.
    Class;
    /// `n`: what an object hides: its class, and its mode among those of the class.
    Kind;
    /// `i`: what a decision chooses; in the paper's model a class.
    Bin;
    /// `z`: what one look at an object yields.
    Label;
}

impl Position {
    /// The number that people read: they count positions from 1, the belt end.
    #[must_use]
    pub fn number(self) -> usize {
        self.0 + 1
    }
}
