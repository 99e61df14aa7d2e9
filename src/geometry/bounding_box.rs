//! Axis-parallel boxes.

use glam::DVec3;

/// An axis-parallel box; empty while `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    /// Least corner.
    pub min: DVec3,
    /// Greatest corner.
    pub max: DVec3,
}

impl BoundingBox {
    /// The box of no point.
    pub const EMPTY: BoundingBox = BoundingBox { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box that holds `points`.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a DVec3>) -> BoundingBox {
        points.into_iter().fold(BoundingBox::EMPTY, |b, &p| b.with(p))
    }

    /// This box, grown to hold `p`.
    pub fn with(self, p: DVec3) -> BoundingBox {
        BoundingBox { min: self.min.min(p), max: self.max.max(p) }
    }

    /// Edge lengths.
    pub fn extent(&self) -> DVec3 {
        self.max - self.min
    }

    /// Length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        self.extent().length()
    }

    /// Centre.
    pub fn center(&self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }
}
