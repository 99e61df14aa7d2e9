//! How good the tets of a mesh are.

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::frame::Frame;
use crate::geometry::tetrahedron;
use crate::tet_mesh::TetMesh;

/// Width of a bin of the histogram of dihedral angles, in degrees.
pub const BIN_DEGREES: f64 = 5.0;

/// Bins from 0 to 180 degrees.
pub const BINS: usize = 36;

/// Measures of each tet of a mesh, from the coordinates that its file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct TetQuality {
    /// Signed volumes, in model units.
    pub volume: Vec<f64>,
    /// Smallest dihedral angles, in degrees; 70.53 for a regular tet.
    pub min_dihedral: Vec<f64>,
    /// Largest dihedral angles, in degrees.
    pub max_dihedral: Vec<f64>,
    /// Three times the inscribed sphere's radius over the circumscribed one's; 1 for a regular tet.
    pub radius_ratio: Vec<f64>,
    /// Dihedral angles, six of each tet, counted in bins of [`BIN_DEGREES`]: bin k holds 5k <= angle < 5k + 5.
    pub histogram: [u64; BINS],
}

impl TetQuality {
    /// Measures the tets of `mesh`.
    pub fn of(mesh: &TetMesh) -> TetQuality {
        // Corners relative to one of them and at the scale of the unit box, so that no product under- or overflows.
        let scale = if mesh.points.is_empty() { 1.0 } else { Frame::around(&BoundingBox::of(&mesh.points)).scale };
        let measures: Vec<Measures> =
            mesh.tets.par_iter().map(|t| Measures::of(t.map(|v| mesh.points[v as usize]), scale)).collect();
        let mut histogram = [0; BINS];
        for angle in measures.iter().flat_map(|m| m.dihedrals) {
            // 180 degrees, which only a flat tet has, falls in the last bin.
            histogram[((angle / BIN_DEGREES) as usize).min(BINS - 1)] += 1;
        }
        TetQuality {
            volume: measures.iter().map(|m| m.volume).collect(),
            min_dihedral: measures.iter().map(|m| m.dihedrals.into_iter().fold(f64::INFINITY, f64::min)).collect(),
            max_dihedral: measures.iter().map(|m| m.dihedrals.into_iter().fold(0.0, f64::max)).collect(),
            radius_ratio: measures.iter().map(|m| m.radius_ratio).collect(),
            histogram,
        }
    }
}

struct Measures {
    volume: f64,
    dihedrals: [f64; 6],
    radius_ratio: f64,
}

impl Measures {
    fn of([a, b, c, d]: [DVec3; 4], scale: f64) -> Measures {
        let [b, c, d] = [b, c, d].map(|p| (p - a) * scale);
        let a = DVec3::ZERO;
        Measures {
            // One division after the other: the cube of the scale may be out of range where the volume is not.
            volume: tetrahedron::volume(a, b, c, d) / scale / scale / scale,
            dihedrals: tetrahedron::dihedral_angles(a, b, c, d),
            radius_ratio: tetrahedron::radius_ratio(a, b, c, d),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::SeedKind;
    use crate::tet_mesh::StageTimes;

    fn single(points: [DVec3; 4]) -> TetQuality {
        TetQuality::of(&TetMesh {
            points: points.to_vec(),
            kinds: vec![SeedKind::Corner; 4],
            seeds: vec![0, 1, 2, 3],
            tets: vec![[0, 1, 2, 3]],
            regions: vec![0],
            boundary: Vec::new(),
            steps: Vec::new(),
            size_ratio: None,
            stopped: String::new(),
            improved: String::new(),
            times: StageTimes::default(),
        })
    }

    #[test]
    fn the_corner_of_a_cube_at_any_scale() {
        for scale in [1e-90, 1.0, 1e90] {
            let q = single([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| p * scale));
            let volume = scale * scale * scale / 6.0;
            assert!((q.volume[0] / volume - 1.0).abs() < 1e-12, "{scale}: {}", q.volume[0]);
            let slanted = (1.0f64 / 3.0).sqrt().acos().to_degrees();
            assert!((q.min_dihedral[0] - slanted).abs() < 1e-12);
            assert!((q.max_dihedral[0] - 90.0).abs() < 1e-12);
            // r = 1 / (3 + sqrt 3), R = sqrt(3) / 2.
            assert!((q.radius_ratio[0] - 3.0 / (3.0 + 3f64.sqrt()) / (3f64.sqrt() / 2.0)).abs() < 1e-12);
            assert_eq!((q.histogram[10], q.histogram.iter().sum::<u64>()), (3, 6));
        }
    }
}
