//! What keeps a triangle soup from bounding a solid: one variant per cause, with how often and where first.

use std::fmt;

/// Where a defect shows first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// A point of it, in model coordinates.
    pub point: [f64; 3],
    /// The face of the input it lies on, counted from 0.
    pub face: u32,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "first at {}, face {} of the input", coordinates(self.point), u64::from(self.face) + 1)
    }
}

/// A point to nine digits, whatever the scale of the model.
pub(crate) fn coordinates(point: [f64; 3]) -> String {
    // `{:?}` of an f64 is the shortest text that reads back as the same number, with an exponent where that is due.
    let [x, y, z] = point.map(short);
    format!("({x:?}, {y:?}, {z:?})")
}

/// A number to nine digits.
fn short(x: f64) -> f64 {
    // Text that `{:e}` made always parses.
    format!("{x:.8e}").parse().unwrap_or(x)
}

/// "1 edge", "2 edges".
fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// A defect: what, how often, and where first.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Defect {
    /// No triangle at all.
    #[error("it has no triangles, so it is empty: export the surface as polygons")]
    Empty,
    /// Every triangle has no area.
    #[error("it is empty: {}: export the surface as polygons", counted(*count, "triangle, which is degenerate (has no area)", "triangles, which are all degenerate (have no area)"))]
    AllDegenerate {
        /// Triangles without area.
        count: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("face {} of the input names vertex {index}, but there are only {count} vertices", u64::from(*face) + 1)]
    BadIndex {
        /// The face, counted from 0.
        face: u32,
        /// The index, counted from 0.
        index: u32,
        /// Vertices.
        count: usize,
    },
    /// Coordinates that are NaN or infinite.
    #[error(
        "{} a coordinate that is not finite (NaN, or too large for a 64-bit number), {place}: repair the file's numbers",
        counted(*count, "vertex in use has", "vertices in use have")
    )]
    NonFinite {
        /// Vertices.
        count: usize,
        /// The first.
        place: Place,
    },
    /// A model so large or so small that its shape is lost in 64-bit numbers.
    #[error("its longest side is {extent:?}, out of the range of 64-bit numbers that leaves room to compute: scale it")]
    OutOfRange {
        /// Longest side of the bounding box.
        extent: f64,
    },
    /// Edges with one face only.
    #[error(
        "it is open: {} a face on one side only, {place}: close the holes, or weld vertices that nearly meet (--repair does where they are small)",
        counted(*count, "edge has", "edges have")
    )]
    Open {
        /// Edges.
        count: usize,
        /// The first.
        place: Place,
    },
    /// Edges with more than two faces, where none of the faces cover each other.
    #[error(
        "it has {} (more than two faces meet there), {place}: separate bodies that touch (--repair moves them apart), remove inner walls and sheets",
        counted(*count, "non-manifold edge", "non-manifold edges")
    )]
    NonManifoldEdges {
        /// Edges.
        count: usize,
        /// The first.
        place: Place,
    },
    /// Vertices whose faces form several fans.
    #[error(
        "it has {} (parts of it touch in a point), {place}: move the parts away from each other there (--repair does)",
        counted(*count, "non-manifold vertex", "non-manifold vertices")
    )]
    NonManifoldVertices {
        /// Vertices.
        count: usize,
        /// The first.
        place: Place,
    },
    /// No choice of orientations agrees along every edge.
    #[error(
        "it is not orientable (like a Moebius strip or Klein bottle, it has one side only), {place}: such a surface bounds no solid"
    )]
    NonOrientable {
        /// Edge where the orientations cannot agree.
        place: Place,
    },
    /// Faces over the same three vertices.
    #[error(
        "it has {} over the same three vertices as another, which makes a non-manifold edge or a fold, {place}: remove the copies, or both faces of an inner wall where bodies touch (--repair does)",
        counted(*count, "duplicate face", "duplicate faces")
    )]
    DuplicateFaces {
        /// Faces that repeat an earlier one.
        count: usize,
        /// The first.
        place: Place,
    },
    /// Faces that lie on each other, beside a non-manifold edge.
    #[error(
        "it has {} where touching faces coincide, {place}: join the bodies that touch there, or move them apart",
        counted(*count, "non-manifold edge", "non-manifold edges")
    )]
    CoincidingFaces {
        /// Edges with such faces.
        count: usize,
        /// The first.
        place: Place,
    },
    /// Triangles without area that no local change removes.
    #[error(
        "{} without area cannot be removed without changing the shape, {place}: remesh the surface there",
        counted(*count, "degenerate triangle", "degenerate triangles")
    )]
    Degenerate {
        /// Triangles.
        count: usize,
        /// The first.
        place: Place,
    },
    /// Triangles that meet others elsewhere than along a common edge or in a common vertex.
    #[error(
        "it crosses or touches itself: {} others beyond common edges and vertices, {place}{}: cut the surface along \
         itself (a union of its bodies), or move what touches apart",
        counted(*count, "triangle meets", "triangles meet"),
        if *coplanar { format!(", where face {} lies on it", u64::from(*other) + 1) }
        else { format!(", where face {} meets it", u64::from(*other) + 1) }
    )]
    SelfCrossing {
        /// Triangles that meet others.
        count: usize,
        /// A point of the first meeting.
        place: Place,
        /// The other face of the first meeting, counted from 0.
        other: u32,
        /// Whether the two lie in one plane.
        coplanar: bool,
    },
    /// More triangles than can be numbered.
    #[error("it has {count} triangles, more than {most}: simplify it")]
    TooMany {
        /// Triangles.
        count: usize,
        /// The most there may be.
        most: usize,
    },
    /// A shell that encloses nothing.
    #[error("{} no volume, {place}: remove what is flat, or give it a thickness",
        counted(*count, "connected part encloses", "connected parts enclose"))]
    NoVolume {
        /// Shells.
        count: usize,
        /// A vertex of the first.
        place: Place,
    },
}

/// What is wrong at one place, and the number that stands for it in a file of defects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Flaw {
    /// An edge with one face only.
    Open = 1,
    /// An edge with more than two faces.
    NonManifoldEdge = 2,
    /// A vertex whose faces form several fans.
    NonManifoldVertex = 3,
    /// An edge along which no choice of orientations agrees.
    NonOrientable = 4,
    /// A face over the same vertices as another.
    DuplicateFace = 5,
    /// A triangle that meets another elsewhere than along a common edge or in a common vertex.
    SelfCrossing = 6,
    /// A triangle without area that cannot be removed.
    Degenerate = 7,
    /// A triangle of a shell that encloses nothing.
    NoVolume = 8,
}

/// Where something is wrong, in model coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A vertex.
    Point([f64; 3]),
    /// An edge.
    Edge([[f64; 3]; 2]),
    /// A triangle.
    Triangle([[f64; 3]; 3]),
}

/// All that is wrong with a surface as far as it was looked at, for a picture of it: more than the first place that a
/// [`Defect`] names, and other flaws of the same check too.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    /// Each flaw, its shape, and the face of the input that it is on, counted from 0.
    pub list: Vec<(Flaw, Shape, u32)>,
    /// What was mended before the surface was refused.
    pub notes: Vec<String>,
}
