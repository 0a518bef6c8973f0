//! How many objects are left to decide.

/// Objects left, the one at the belt end included; a belt that never ends unless a number is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Remaining(pub Option<usize>);

impl Remaining {
    /// A belt that never ends.
    pub(crate) const ENDLESS: Self = Self(None);

    /// What is left after so many decisions.
    pub(crate) fn after(self, decisions: usize) -> Self {
        Self(self.0.map(|objects| objects.saturating_sub(decisions)))
    }

    /// Those at the positions; the others have still to arrive.
    pub(crate) fn visible(self, positions: usize) -> usize {
        self.0.map_or(positions, |objects| objects.min(positions))
    }

    /// Those that have still to arrive.
    pub(crate) fn unseen(self, positions: usize) -> Self {
        self.after(positions)
    }

    /// Whether the belt ever ends.
    pub(crate) fn ends(self) -> bool {
        self.0.is_some()
    }

    /// Whether nothing is left.
    pub(crate) fn is_over(self) -> bool {
        self.0 == Some(0)
    }
}
