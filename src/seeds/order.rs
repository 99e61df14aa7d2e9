//! The numbering of seeds: along a Hilbert curve, so that neighbours in space are neighbours in memory.

use glam::DVec3;

use super::Anchor;
use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::hilbert;

/// Renumbers positions and anchors together along a Hilbert curve.
pub(super) fn along_hilbert_curve(positions: &mut Vec<DVec3>, anchors: &mut Vec<Anchor>) {
    let bounds = BoundingBox::of(positions.iter());
    let mut order: Vec<(u64, u32)> =
        positions.iter().enumerate().map(|(i, &p)| (hilbert::key(p, &bounds), i as u32)).collect();
    order.sort_unstable();
    *positions = order.iter().map(|&(_, i)| positions[i as usize]).collect();
    *anchors = order.iter().map(|&(_, i)| anchors[i as usize]).collect();
}
