//! The input: a closed, oriented, outward triangle surface.

use glam::DVec3;

use crate::geometry::frame::Frame;

pub mod box_tree;

pub mod defects;

pub mod features;

use box_tree::BoxTree;
use defects::Defect;

/// A closed, edge- and vertex-manifold, consistently oriented surface that bounds a solid; it cannot be built with a
/// defect. Its points are in the normalised frame, on its grid.
pub struct Surface {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    source: Vec<u32>,
    patch: Vec<u32>,
    shell: Vec<u32>,
    solid_of_shell: Vec<u32>,
    frame: Frame,
    tree: BoxTree,
    notes: Vec<String>,
}

impl Surface {
    /// Checks `triangles` over `points` (model units) and makes them a surface. `source[t]` and `patch[t]` say where
    /// triangle `t` comes from: the index of its face in the input, and the id of its patch.
    pub fn new(_points: &[DVec3], _triangles: &[[u32; 3]], _source: &[u32], _patch: &[u32]) -> Result<Surface, Defect> {
        todo!()
    }

    /// Vertices, in the frame, on its grid.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Triangles, counter-clockwise seen from outside the solid.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The three corners of triangle `t`.
    pub fn corners(&self, t: u32) -> [DVec3; 3] {
        self.triangles[t as usize].map(|v| self.points[v as usize])
    }

    /// For each triangle, the index of its face in the input.
    pub fn source(&self) -> &[u32] {
        &self.source
    }

    /// For each triangle, the id of its patch.
    pub fn patch(&self) -> &[u32] {
        &self.patch
    }

    /// For each triangle, the connected shell that it belongs to.
    pub fn shell(&self) -> &[u32] {
        &self.shell
    }

    /// For each shell, the solid that it bounds: an outermost shell and the cavities right inside it share one.
    pub fn solid_of_shell(&self) -> &[u32] {
        &self.solid_of_shell
    }

    /// The way back to the model's coordinates.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The box tree over the triangles.
    pub fn tree(&self) -> &BoxTree {
        &self.tree
    }

    /// What was mended while the surface was made.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Volume of the solid, in the frame.
    pub fn volume(&self) -> f64 {
        todo!()
    }

    /// Area of the surface, in the frame.
    pub fn area(&self) -> f64 {
        todo!()
    }

    /// Diagonal of the bounding box, in the frame.
    pub fn diagonal(&self) -> f64 {
        todo!()
    }

    /// Sum over all shells of the number of handles.
    pub fn genus(&self) -> usize {
        todo!()
    }
}
