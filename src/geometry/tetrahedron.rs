//! Tets: volume, circumcentre, dihedral angles, quality.
//!
//! A tet (a, b, c, d) is positively oriented when d lies on the side of triangle (a, b, c) that its normal points to.

use glam::DVec3;

/// The corners of the facet opposite each corner, counter-clockwise seen from outside a positively oriented tet.
pub const FACETS: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// The ends of each edge; edge 5 - i lies opposite edge i.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Six times the signed volume: det[b - a, c - a, d - a].
pub fn volume6(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    (b - a).cross(c - a).dot(d - a)
}

/// The signed volume, positive for a positively oriented tet.
pub fn volume(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    volume6(a, b, c, d) / 6.0
}

/// The mean of the corners.
pub fn centroid(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> DVec3 {
    // Relative to a corner: no digits are lost to the distance from the origin.
    a + ((b - a) + (c - a) + (d - a)) * 0.25
}

/// The point as far from every corner; not finite where the tet is flat.
pub fn circumcenter(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> DVec3 {
    let (numerator, volume6) = circumcenter_numerator(b - a, c - a, d - a);
    a + numerator / (2.0 * volume6)
}

/// With one corner at the origin and the others at b, c and d: the circumcentre times twice the second value, which is
/// six times the volume.
fn circumcenter_numerator(b: DVec3, c: DVec3, d: DVec3) -> (DVec3, f64) {
    let cd = c.cross(d);
    let numerator = cd * b.length_squared() + d.cross(b) * c.length_squared() + b.cross(c) * d.length_squared();
    (numerator, b.dot(cd))
}

/// The normals of the facets, outward, twice the facets' area long.
fn facet_normals(p: &[DVec3; 4]) -> [DVec3; 4] {
    FACETS.map(|[i, j, k]| (p[j] - p[i]).cross(p[k] - p[i]))
}

/// The angle between the two facets at each of [`EDGES`], in degrees, whichever way the tet is oriented.
///
/// By the arc tangent: sines and cosines both come from cross products, so that the angles of slivers are as accurate
/// as those of a regular tet.
pub fn dihedral_angles(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> [f64; 6] {
    sines_and_cosines([a, b, c, d]).map(|[sine, cosine]| sine.atan2(cosine).to_degrees())
}

/// Sine and cosine of the angle at each of [`EDGES`], both times some number that is not negative.
fn sines_and_cosines(p: [DVec3; 4]) -> [[f64; 2]; 6] {
    let normals = facet_normals(&p);
    let volume6 = volume6(p[0], p[1], p[2], p[3]).abs();
    // The facets at edge ij lie opposite the other two corners, k and l. For outward normals n_k and n_l,
    // |n_k x n_l| = |ij| 6V, and n_k . n_l is the cosine of the angle outside.
    std::array::from_fn(|e| {
        let [[i, j], [k, l]] = [EDGES[e], EDGES[5 - e]];
        [(p[j] - p[i]).length() * volume6, -normals[k].dot(normals[l])]
    })
}

/// The smallest dihedral angle, in degrees: 70.53 for a regular tet, 0 for a flat one. Edges are to be of a size whose eighth power
/// is a normal number, as those of the frame are.
pub fn min_dihedral(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let all = sines_and_cosines([a, b, c, d]);
    if all.iter().any(|sc| sc[0] == 0.0) {
        return dihedral_angles(a, b, c, d).into_iter().fold(f64::INFINITY, f64::min);
    }
    // Of two angles below 180 degrees the sine of the difference tells the smaller.
    let smaller = |x: [f64; 2], y: [f64; 2]| if y[0] * x[1] < x[0] * y[1] { y } else { x };
    let [sine, cosine] = all.into_iter().reduce(smaller).expect("six angles: this is a bug in tetcvt");
    sine.atan2(cosine).to_degrees()
}

/// Three times the radius of the inscribed sphere over that of the circumsphere: 1 for a regular tet, 0 for a flat one.
pub fn radius_ratio(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    // r = 6V / sum of |facet normals|, R = |numerator| / 12V.
    let (numerator, volume6) = circumcenter_numerator(b - a, c - a, d - a);
    let area2: f64 = facet_normals(&[a, b, c, d]).iter().map(|n| n.length()).sum();
    let ratio = 6.0 * (volume6 / area2) * (volume6 / numerator.length());
    // 0 / 0 where corners coincide.
    if ratio.is_finite() { ratio.min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn regular() -> [DVec3; 4] {
        [(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)].map(|(x, y, z)| DVec3::new(x as f64, y as f64, z as f64))
    }

    /// The corner of a unit cube.
    fn corner() -> [DVec3; 4] {
        [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]
    }

    #[test]
    fn the_regular_tet() {
        let [a, b, c, d] = regular();
        assert!((volume(a, b, c, d).abs() - 8.0 / 3.0).abs() < 1e-15);
        for angle in dihedral_angles(a, b, c, d) {
            assert!((angle - (1.0f64 / 3.0).acos().to_degrees()).abs() < 1e-12, "{angle}");
        }
        assert!((radius_ratio(a, b, c, d) - 1.0).abs() < 1e-15);
        assert!(circumcenter(a, b, c, d).length() < 1e-15);
    }

    #[test]
    fn the_corner_of_a_cube() {
        let [a, b, c, d] = corner();
        assert_eq!(volume6(a, b, c, d), 1.0);
        assert_eq!(volume6(a, c, b, d), -1.0);
        assert_eq!(circumcenter(a, b, c, d), DVec3::splat(0.5));
        let slant = (1.0 / 3.0f64.sqrt()).acos().to_degrees();
        for (e, angle) in dihedral_angles(a, b, c, d).into_iter().enumerate() {
            let expected = if e < 3 { 90.0 } else { slant };
            assert!((angle - expected).abs() < 1e-12, "edge {e}: {angle}");
        }
        assert_eq!(dihedral_angles(a, b, c, d)[0], dihedral_angles(a, c, b, d)[1]);
        // r = 1 / (3 + sqrt 3), R = sqrt(3) / 2.
        let expected = 3.0 / (3.0 + 3.0f64.sqrt()) / (3.0f64.sqrt() / 2.0);
        assert!((radius_ratio(a, b, c, d) - expected).abs() < 1e-15);
    }

    #[test]
    fn facets_are_outward_and_edges_opposite() {
        let p = corner();
        let center = centroid(p[0], p[1], p[2], p[3]);
        for (i, normal) in facet_normals(&p).into_iter().enumerate() {
            assert!(!FACETS[i].contains(&i));
            assert!(normal.dot(p[FACETS[i][0]] - center) > 0.0);
        }
        for e in 0..6 {
            let mut all = [EDGES[e], EDGES[5 - e]].concat();
            all.sort();
            assert_eq!(all, [0, 1, 2, 3]);
        }
    }

    #[test]
    fn slivers_keep_their_angles() {
        // A square with one pair of opposite corners lifted by h: four angles of about 2h, two of nearly 180 degrees.
        for h in [1e-3, 1e-6, 1e-9, 1e-12] {
            let [a, b, c, d] =
                [DVec3::ZERO, DVec3::new(1.0, 0.0, h), DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.0, 1.0, h)];
            let angles = dihedral_angles(a, b, c, d);
            let (min, max) = (min_dihedral(a, b, c, d), angles.into_iter().fold(0.0, f64::max));
            // Facets through a side of the square are tilted by h against it, one up, one down.
            assert!((min.to_radians() / (2.0 * h) - 1.0).abs() < 1e-4, "{h}: {min}");
            assert!(max > 179.0 && max <= 180.0, "{h}: {max}");
        }
    }

    #[test]
    fn flat_tets_have_no_quality() {
        let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        assert_eq!(radius_ratio(a, b, c, d), 0.0);
        assert_eq!(min_dihedral(a, b, c, d), 0.0);
        assert!(dihedral_angles(a, b, c, d).iter().all(|&angle| angle == 0.0 || angle == 180.0));
        assert_eq!(radius_ratio(a, a, a, a), 0.0);
        assert!(!circumcenter(a, b, c, d).is_finite());
    }
}
