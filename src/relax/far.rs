//! Points far around the solid that are triangulated with the seeds.
//!
//! Seeds on a flat face of the hull are coplanar but for the rounding of their coordinates. By themselves they have thousands of
//! tets between them that are flat to the last digit, and others after every motion. A sphere through four such seeds is
//! nearly a half-space: with points on all sides none of them is empty, and the seeds of a face have the tets of a face.
//!
//! No clipped cell changes. The solid lies in the frame's cube of side 1, these points are the corners of one of side 3: a
//! point of the smaller cube is at least √3 away from them, and no farther than that from any seed. Differences of
//! coordinates are at most 2, or 3 between these points, and so exact on the frame's grid.

use glam::DVec3;

/// How far each coordinate is from the centre of the frame.
const FAR: f64 = 1.5;

/// How many there are.
pub const COUNT: usize = 8;

/// The points.
pub fn points() -> [DVec3; COUNT] {
    std::array::from_fn(|i| {
        let side = |axis: usize| if i >> axis & 1 == 1 { FAR } else { -FAR };
        DVec3::new(side(0), side(1), side(2))
    })
}
