//! Triangles on their way to becoming a surface: into the frame, welded, without what is unused or collapsed.

use glam::DVec3;

use super::defects::{Defect, Flaw, Marks, Place, Shape};
use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::frame::Frame;

/// The most triangles that a surface may have: their edges are numbered in 32 bits.
const MOST_TRIANGLES: usize = u32::MAX as usize / 3;

/// Triangles over the vertices of the frame; nothing is known of how they fit together.
#[derive(Clone)]
pub(super) struct Soup {
    /// Vertices in the frame, each position once.
    pub points: Vec<DVec3>,
    /// The same in the model's coordinates.
    pub model: Vec<DVec3>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle, its face in the input.
    pub source: Vec<u32>,
    /// For each triangle, its patch.
    pub patch: Vec<u32>,
}

impl Soup {
    /// Steps: 1. refuse what cannot be placed in a frame; 2. find the frame of the vertices in use; 3. weld vertices
    /// that are one point of its grid; 4. drop triangles with two equal corners.
    pub fn new(
        points: &[DVec3],
        triangles: &[[u32; 3]],
        source: &[u32],
        patch: &[u32],
        notes: &mut Vec<String>,
    ) -> Result<(Soup, Frame), Defect> {
        // 1.
        if triangles.is_empty() {
            return Err(Defect::Empty);
        }
        if triangles.len() > MOST_TRIANGLES {
            return Err(Defect::TooMany { count: triangles.len(), most: MOST_TRIANGLES });
        }
        let used = used_vertices(points, triangles, source)?;
        let unused = points.len() - used.iter().filter(|&&u| u).count();
        note_count(notes, unused, "vertex that no face uses was dropped", "vertices that no face uses were dropped");
        // 2.
        let bounds = BoundingBox::of((0..points.len()).filter(|&v| used[v]).map(|v| &points[v]));
        let frame = Frame::around(&bounds);
        check_range(&frame, &bounds)?;
        // 3.
        let mut soup = Soup { points: vec![], model: vec![], triangles: vec![], source: vec![], patch: vec![] };
        let vertex = soup.weld(points, &used, &frame, notes);
        // 4.
        for (t, triangle) in triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| vertex[v as usize]);
            if a != b && b != c && c != a {
                soup.push([a, b, c], source[t], patch[t]);
            }
        }
        let dropped = triangles.len() - soup.triangles.len();
        if soup.triangles.is_empty() {
            return Err(Defect::AllDegenerate { count: dropped });
        }
        note_count(
            notes,
            dropped,
            "degenerate triangle with two equal corners was dropped",
            "degenerate triangles with two equal corners were dropped",
        );
        soup.drop_unused();
        Ok((soup, frame))
    }

    /// Adds a triangle.
    pub fn push(&mut self, triangle: [u32; 3], source: u32, patch: u32) {
        self.triangles.push(triangle);
        self.source.push(source);
        self.patch.push(patch);
    }

    /// Keeps the triangles of which `keep` is true.
    pub fn retain(&mut self, keep: &[bool]) {
        let mut k = keep.iter();
        self.triangles.retain(|_| *k.next().expect("one flag per triangle: this is a bug in tetcvt"));
        let mut k = keep.iter();
        self.source.retain(|_| *k.next().expect("one flag per triangle: this is a bug in tetcvt"));
        let mut k = keep.iter();
        self.patch.retain(|_| *k.next().expect("one flag per triangle: this is a bug in tetcvt"));
    }

    /// Removes vertices without a triangle; the others keep their order.
    pub fn drop_unused(&mut self) {
        let mut new = vec![u32::MAX; self.points.len()];
        for &v in self.triangles.as_flattened() {
            new[v as usize] = 0;
        }
        let mut count = 0;
        for (v, new) in new.iter_mut().enumerate().filter(|(_, new)| **new == 0) {
            *new = count;
            self.points[count as usize] = self.points[v];
            self.model[count as usize] = self.model[v];
            count += 1;
        }
        self.points.truncate(count as usize);
        self.model.truncate(count as usize);
        for v in self.triangles.as_flattened_mut() {
            *v = new[*v as usize];
        }
    }

    /// Corners of a triangle, in the frame.
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|v| self.points[v as usize])
    }

    /// The middle of the edge from corner `i` of triangle `t`, as the place of a defect.
    pub fn edge_place(&self, t: u32, i: usize) -> Place {
        let triangle = self.triangles[t as usize];
        let [a, b] = [triangle[i], triangle[(i + 1) % 3]].map(|v| self.model[v as usize]);
        Place { point: (a * 0.5 + b * 0.5).to_array(), face: self.source[t as usize] }
    }

    /// Corner `i` of triangle `t`, as the place of a defect.
    pub fn corner_place(&self, t: u32, i: usize) -> Place {
        let v = self.triangles[t as usize][i];
        Place { point: self.model[v as usize].to_array(), face: self.source[t as usize] }
    }

    /// Adds edge `i` of triangle `t` to `marks`.
    pub fn mark_edge(&self, marks: &mut Marks, flaw: Flaw, t: u32, i: usize) {
        let triangle = self.triangles[t as usize];
        let ends = [triangle[i], triangle[(i + 1) % 3]].map(|v| self.model[v as usize].to_array());
        marks.list.push((flaw, Shape::Edge(ends), self.source[t as usize]));
    }

    /// Adds corner `i` of triangle `t` to `marks`.
    pub fn mark_corner(&self, marks: &mut Marks, flaw: Flaw, t: u32, i: usize) {
        let v = self.triangles[t as usize][i];
        marks.list.push((flaw, Shape::Point(self.model[v as usize].to_array()), self.source[t as usize]));
    }

    /// Adds triangle `t` to `marks`.
    pub fn mark_triangle(&self, marks: &mut Marks, flaw: Flaw, t: u32) {
        let corners = self.triangles[t as usize].map(|v| self.model[v as usize].to_array());
        marks.list.push((flaw, Shape::Triangle(corners), self.source[t as usize]));
    }

    /// Fills the vertices; returns the new index of each old one.
    fn weld(&mut self, points: &[DVec3], used: &[bool], frame: &Frame, notes: &mut Vec<String>) -> Vec<u32> {
        // Sorting finds equal positions without the order of a hash table; to_frame leaves no -0.0.
        let mut order: Vec<(DVec3, u32)> =
            (0..points.len()).filter(|&v| used[v]).map(|v| (frame.to_frame(points[v]), v as u32)).collect();
        order.sort_unstable_by(|(p, i), (q, j)| {
            let coordinate = |k: usize| p[k].total_cmp(&q[k]);
            coordinate(0).then_with(|| coordinate(1)).then_with(|| coordinate(2)).then(i.cmp(j))
        });
        let mut first = vec![u32::MAX; points.len()];
        let (mut equal, mut rounded) = (0, 0);
        for (k, &(p, v)) in order.iter().enumerate() {
            first[v as usize] = v;
            if k > 0 && order[k - 1].0 == p {
                let representative = first[order[k - 1].1 as usize];
                first[v as usize] = representative;
                if points[v as usize] == points[representative as usize] {
                    equal += 1;
                } else {
                    rounded += 1;
                }
            }
        }
        note_count(notes, equal, "duplicate vertex was welded", "duplicate vertices were welded");
        note_count(
            notes,
            rounded,
            "vertex closer to another than 2^-52 of the model's size was welded to it",
            "vertices closer to another than 2^-52 of the model's size were welded to it",
        );
        let mut vertex = vec![u32::MAX; points.len()];
        for v in 0..points.len() {
            if first[v] == v as u32 {
                vertex[v] = self.points.len() as u32;
                self.points.push(frame.to_frame(points[v]));
                self.model.push(points[v]);
            }
        }
        (0..points.len()).map(|v| if used[v] { vertex[first[v] as usize] } else { u32::MAX }).collect()
    }
}

/// Which vertices the triangles use; refuses indices and coordinates that cannot be.
fn used_vertices(points: &[DVec3], triangles: &[[u32; 3]], source: &[u32]) -> Result<Vec<bool>, Defect> {
    let mut used = vec![false; points.len()];
    let mut bad = 0;
    let mut place = None;
    for (triangle, &face) in triangles.iter().zip(source) {
        for &v in triangle {
            let Some(seen) = used.get_mut(v as usize) else {
                return Err(Defect::BadIndex { face, index: v, count: points.len() });
            };
            if !*seen {
                *seen = true;
                let p = points[v as usize];
                if !p.is_finite() {
                    bad += 1;
                    place.get_or_insert(Place { point: p.to_array(), face });
                }
            }
        }
    }
    match place {
        Some(place) => Err(Defect::NonFinite { count: bad, place }),
        None => Ok(used),
    }
}

/// Refuses models that the frame cannot hold, or whose shape it would round away.
fn check_range(frame: &Frame, bounds: &BoundingBox) -> Result<(), Defect> {
    let [low, high] = [bounds.min, bounds.max].map(|p| frame.to_frame(p));
    let extent = (high - low).max_element();
    let inside = low.abs().max_element() <= 0.5 && high.abs().max_element() <= 0.5;
    // Below 2^-20 of the frame the grid of 2^-52 would leave less than the digits of single precision.
    if bounds.min == bounds.max || (inside && extent > 2f64.powi(-20)) {
        return Ok(());
    }
    Err(Defect::OutOfRange { extent: bounds.extent().max_element() })
}

/// Adds `one` or `many` after the count, unless it is 0.
pub(crate) fn note_count(notes: &mut Vec<String>, count: usize, one: &str, many: &str) {
    match count {
        0 => {}
        1 => notes.push(format!("1 {one}")),
        n => notes.push(format!("{n} {many}")),
    }
}
