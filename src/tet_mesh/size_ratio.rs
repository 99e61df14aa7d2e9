//! How well sizes are met.

use serde::Serialize;

use super::TetMesh;
use crate::geometry::tetrahedron::EDGES;
use crate::seeds::Seeds;
use crate::sizing::MEAN_OVER_MEDIAN;
use crate::surface::Surface;

/// Of all edges, the length over the size asked for at the middle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SizeRatio {
    /// Half of them are below.
    pub median: f64,
    /// A twentieth is below.
    pub p5: f64,
    /// A twentieth is above.
    pub p95: f64,
}

impl SizeRatio {
    /// For the mesh of `seeds` in the solid of `surface`; `None` where one size was asked for everywhere.
    pub(crate) fn of(mesh: &TetMesh, seeds: &Seeds, surface: &Surface) -> Option<SizeRatio> {
        seeds.sizing.as_ref()?;
        let spacing = seeds.spacings();
        let points: Vec<_> = mesh.points.iter().map(|&p| (p - surface.frame().shift) * surface.frame().scale).collect();
        let mut edges: Vec<[u32; 2]> = mesh
            .tets
            .iter()
            .flat_map(|tet| EDGES.map(|e| e.map(|k| tet[k])))
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let ratio = |[a, b]: &[u32; 2]| {
            let [p, q] = [a, b].map(|v| points[*v as usize]);
            p.distance(q) * MEAN_OVER_MEDIAN / spacing.at((p + q) * 0.5)
        };
        let mut ratios: Vec<f64> = edges.iter().map(ratio).collect();
        ratios.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| ratios[((ratios.len() - 1) as f64 * share).round() as usize];
        Some(SizeRatio { median: at(0.5), p5: at(0.05), p95: at(0.95) })
    }
}
