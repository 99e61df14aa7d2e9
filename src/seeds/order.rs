//! The numbering of seeds: along a Hilbert curve, so that neighbours in space are neighbours in memory.

use glam::DVec3;

use super::Anchor;
use crate::geometry::hilbert::hilbert_order;

/// Renumbers positions and anchors together along a Hilbert curve.
pub(super) fn along_hilbert_curve(positions: &mut Vec<DVec3>, anchors: &mut Vec<Anchor>) {
    let order = hilbert_order(positions);
    *positions = order.iter().map(|&i| positions[i as usize]).collect();
    *anchors = order.iter().map(|&i| anchors[i as usize]).collect();
}
