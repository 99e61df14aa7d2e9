//! What keeps a triangle soup from bounding a solid.

/// A defect: what, how often, and where first (model coordinates).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Defect {
    /// No triangle at all.
    #[error("it has no triangles")]
    Empty,
}
