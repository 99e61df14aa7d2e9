//! Why points have no Delaunay triangulation.

use glam::DVec3;

use super::insert::Obstacle;
use crate::geometry::predicates::lexicographic;

/// Why points have no Delaunay triangulation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DelaunayError {
    /// Fewer than four points.
    #[error("a tet needs four points, there are {count}")]
    TooFew {
        /// Number of points.
        count: usize,
    },
    /// More points than can be numbered, or so placed that they have more tets than can be numbered.
    #[error("{count} points are too many: their tets cannot be numbered")]
    TooMany {
        /// Number of points.
        count: usize,
    },
    /// Not as many new positions as there are points.
    #[error("{count} new positions for {expected} points")]
    WrongCount {
        /// Number of new positions.
        count: usize,
        /// Number of points.
        expected: usize,
    },
    /// A coordinate that is infinite or not a number.
    #[error("point {index} is ({}, {}, {}): not finite", point[0], point[1], point[2])]
    NotFinite {
        /// The first such point.
        index: usize,
        /// Its coordinates.
        point: [f64; 3],
    },
    /// No point has this index.
    #[error("there is no point {index}: there are {count}")]
    NoSuchPoint {
        /// The index asked for.
        index: u32,
        /// Number of points.
        count: usize,
    },
    /// All points on one line.
    #[error("all {count} points lie on one line: there is no tet")]
    Line {
        /// Number of points.
        count: usize,
    },
    /// All points on one plane.
    #[error("all {count} points lie on one plane: there is no tet")]
    Flat {
        /// Number of points.
        count: usize,
    },
    /// Points at the same place.
    #[error(
        "{count} points lie where another does: the first are points {first} and {second}, at ({}, {}, {})",
        point[0], point[1], point[2]
    )]
    Duplicates {
        /// Number of points at the place of a point before them.
        count: usize,
        /// The least index of a point with another at its place.
        first: usize,
        /// The least index of such another.
        second: usize,
        /// Their place.
        point: [f64; 3],
    },
}

impl DelaunayError {
    /// The error for `points`, given where the construction stopped.
    pub(super) fn explain(obstacle: Obstacle, points: &[DVec3]) -> DelaunayError {
        let count = points.len();
        // A line or plane of points is reported as duplicates if it holds any: that is mended first.
        DelaunayError::duplicates(points).unwrap_or_else(|| match obstacle {
            Obstacle::Line => DelaunayError::Line { count },
            Obstacle::Plane => DelaunayError::Flat { count },
            Obstacle::TooMany => DelaunayError::TooMany { count },
            Obstacle::Duplicate => unreachable!("the duplicates are there: this is a bug in tetcvt"),
        })
    }

    /// The duplicates among the points, if there are any.
    fn duplicates(points: &[DVec3]) -> Option<DelaunayError> {
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_unstable_by(|&i, &j| lexicographic(points[i], points[j]).then(i.cmp(&j)));
        let pairs = || order.windows(2).filter(|w| points[w[0]] == points[w[1]]);
        let first = pairs().min_by_key(|w| w[0])?;
        let (first, second) = (first[0], first[1]);
        Some(DelaunayError::Duplicates { count: pairs().count(), first, second, point: points[first].to_array() })
    }
}
