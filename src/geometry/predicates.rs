//! Exact predicates: the only file that calls `robust`, and the one sign convention.

/// The sign of an exact quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sign {
    /// Below zero.
    Negative = -1,
    /// Zero.
    Zero = 0,
    /// Above zero.
    Positive = 1,
}
