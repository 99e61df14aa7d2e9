//! Mends what can be mended without guessing a shape, and says what it did; the surface is checked afterwards as any other.
//!
//! Steps, each on what the last one left: 1. vertices of open edges that nearly meet become one; 2. faces over the same
//! three vertices go, but for one where that closes the surface; 3. sheets that hang on a closed surface go; 4. where
//! parts touch along an edge or in a vertex each gets a vertex of its own, a little inward; 5. small holes that are nearly
//! flat are filled.
//!
//! A. Guéziec, G. Taubin, F. Lazarus, W. Horn, "Cutting and stitching: converting sets of polygons to manifold surfaces",
//! IEEE TVCG 7(2), 2001, doi 10.1109/2945.928166, has steps 1 and 4 by connectivity; here the parts also move away from
//! each other, since a mesh cannot tell apart what lies in one place.

use std::collections::BTreeMap;

use glam::DVec3;

use super::edges::{self, EdgeId};
use super::soup::{Soup, note_count};
use crate::disjoint_sets::DisjointSets;
use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::frame::{Frame, snap};

mod holes;

/// Vertices of open edges closer than this share of the diagonal become one.
const WELD: f64 = 1e-5;

/// How far at most a vertex moves where parts that touch are split, as a share of the diagonal, and of the way to the
/// middle of its neighbours.
const APART: f64 = 1e-3;
const APART_OF_PART: f64 = 0.1;

/// A sheet of more than this share of the area is too much to drop.
const SHEET: f64 = 0.25;

/// Mends `soup`.
pub(super) fn mend(soup: &mut Soup, frame: &Frame, notes: &mut Vec<String>) {
    let diagonal = BoundingBox::of(&soup.points).diagonal();
    weld_open(soup, diagonal, notes);
    drop_duplicates(soup, notes);
    drop_sheets(soup, notes);
    split(soup, frame, diagonal, notes);
    holes::fill(soup, notes);
    soup.drop_unused();
}

/// Step 1.
fn weld_open(soup: &mut Soup, diagonal: f64, notes: &mut Vec<String>) {
    let reach = WELD * diagonal;
    let mut open: Vec<u32> = edges::sorted(&soup.triangles)
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|group| group.len() == 1)
        .flat_map(|group| group[0].0)
        .collect();
    open.sort_unstable();
    open.dedup();
    // Cells as wide as the reach: what is near lies in the same or the next.
    let cell = |p: DVec3| (p / reach).floor().to_array().map(|x| x as i64);
    let mut kept: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
    let mut becomes: Vec<u32> = (0..soup.points.len() as u32).collect();
    let mut welded = 0;
    for v in open {
        let p = soup.points[v as usize];
        let [x, y, z] = cell(p);
        let near = (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])));
        let best = near
            .filter_map(|c| kept.get(&c))
            .flatten()
            .map(|&w| (soup.points[w as usize].distance(p), w))
            .filter(|&(distance, _)| distance <= reach)
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        match best {
            Some((_, w)) => {
                becomes[v as usize] = w;
                welded += 1;
            }
            None => kept.entry([x, y, z]).or_default().push(v),
        }
    }
    if welded == 0 {
        return;
    }
    for v in soup.triangles.as_flattened_mut() {
        *v = becomes[*v as usize];
    }
    let keep: Vec<bool> = soup.triangles.iter().map(|&[a, b, c]| a != b && b != c && c != a).collect();
    soup.retain(&keep);
    note_count(
        notes,
        welded,
        &format!("vertex of open edges was welded to another within {WELD:e} of the diagonal (--repair)"),
        &format!("vertices of open edges were welded to others within {WELD:e} of the diagonal (--repair)"),
    );
}

/// How many triangles each edge has.
struct Degrees(BTreeMap<[u32; 2], u32>);

impl Degrees {
    fn of(soup: &Soup) -> Degrees {
        let sorted = edges::sorted(&soup.triangles);
        Degrees(sorted.chunk_by(|a, b| a.0 == b.0).map(|g| (g[0].0, g.len() as u32)).collect())
    }

    /// The number for edge `i` of a triangle.
    fn at(&mut self, triangle: [u32; 3], i: usize) -> &mut u32 {
        let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
        self.0.entry([a.min(b), a.max(b)]).or_insert(0)
    }
}

/// Step 2. Of several faces over the same vertices one stays if that leaves fewer edges with an odd number of faces.
fn drop_duplicates(soup: &mut Soup, notes: &mut Vec<String>) {
    let mut keys: Vec<([u32; 3], usize)> = soup
        .triangles
        .iter()
        .enumerate()
        .map(|(t, &triangle)| {
            let mut key = triangle;
            key.sort_unstable();
            (key, t)
        })
        .collect();
    keys.sort_unstable();
    let mut groups: Vec<&[([u32; 3], usize)]> = keys.chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() > 1).collect();
    if groups.is_empty() {
        return;
    }
    groups.sort_unstable_by_key(|g| g[0].1);
    let mut degrees = Degrees::of(soup);
    let mut keep = vec![true; soup.triangles.len()];
    for group in groups {
        let triangle = group[0].0;
        // Edges that the others leave open want one of these.
        let odd = (0..3).filter(|&i| (*degrees.at(triangle, i) - group.len() as u32) % 2 == 1).count();
        let stay = usize::from(odd >= 2);
        for &(_, t) in &group[stay..] {
            keep[t] = false;
        }
        (0..3).for_each(|i| *degrees.at(triangle, i) -= (group.len() - stay) as u32);
    }
    let dropped = keep.iter().filter(|&&k| !k).count();
    soup.retain(&keep);
    note_count(
        notes,
        dropped,
        "face over the same vertices as another was dropped (--repair)",
        "faces over the same vertices as others were dropped (--repair)",
    );
}

/// Step 3. A sheet is what hangs together along edges of two faces, and has open edges as well as edges that it shares
/// with more than one other face.
fn drop_sheets(soup: &mut Soup, notes: &mut Vec<String>) {
    let area = |soup: &Soup, t: usize| {
        let [a, b, c] = soup.corners(t);
        crate::geometry::triangle::area(a, b, c)
    };
    let total: f64 = (0..soup.triangles.len()).map(|t| area(soup, t)).sum();
    let mut dropped = 0;
    // What one sheet leaves behind may be another.
    loop {
        let sorted = edges::sorted(&soup.triangles);
        let mut parts = DisjointSets::new(soup.triangles.len());
        for group in sorted.chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() == 2) {
            parts.join(group[0].1 / 3, group[1].1 / 3);
        }
        let (part, count) = parts.number();
        let (mut open, mut hangs, mut size) = (vec![false; count], vec![false; count], vec![0.0; count]);
        for group in sorted.chunk_by(|a, b| a.0 == b.0) {
            let flags = match group.len() {
                1 => &mut open,
                2 => continue,
                _ => &mut hangs,
            };
            group.iter().for_each(|&(_, e)| flags[part[e as usize / 3] as usize] = true);
        }
        (0..part.len()).for_each(|t| size[part[t] as usize] += area(soup, t));
        let goes = |p: u32| open[p as usize] && hangs[p as usize] && size[p as usize] <= SHEET * total;
        let keep: Vec<bool> = part.iter().map(|&p| !goes(p)).collect();
        let before = soup.triangles.len();
        soup.retain(&keep);
        if soup.triangles.len() == before || soup.triangles.is_empty() {
            break;
        }
        dropped += before - soup.triangles.len();
    }
    note_count(
        notes,
        dropped,
        "face of a sheet that hung on the surface was dropped (--repair)",
        "faces of sheets that hung on the surface were dropped (--repair)",
    );
}

/// Step 4. Faces are paired at edges with more than two: those of one part where each part has two there. Corners that
/// follow each other around a vertex across pairs are a fan; each fan gets a vertex of its own.
fn split(soup: &mut Soup, frame: &Frame, diagonal: f64, notes: &mut Vec<String>) {
    let sorted = edges::sorted(&soup.triangles);
    let mut parts = DisjointSets::new(soup.triangles.len());
    for group in sorted.chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() == 2) {
        parts.join(group[0].1 / 3, group[1].1 / 3);
    }
    let (part, _) = parts.number();
    let mut fans = DisjointSets::new(3 * soup.triangles.len());
    let mut join = |e: EdgeId, f: EdgeId| {
        for v in edges::ends(&soup.triangles, e) {
            fans.join(edges::corner_at(&soup.triangles, e / 3, v), edges::corner_at(&soup.triangles, f / 3, v));
        }
    };
    let mut crowded = vec![];
    for group in sorted.chunk_by(|a, b| a.0 == b.0) {
        match group {
            [_] => {}
            [(_, e), (_, f)] => join(*e, *f),
            _ => {
                let mut ids: Vec<EdgeId> = group.iter().map(|g| g.1).collect();
                ids.sort_unstable_by_key(|e| (part[*e as usize / 3], *e));
                let pairs: Vec<&[EdgeId]> =
                    ids.chunk_by(|e, f| part[*e as usize / 3] == part[*f as usize / 3]).collect();
                if pairs.iter().all(|pair| pair.len() == 2) {
                    pairs.iter().for_each(|pair| join(pair[0], pair[1]));
                } else {
                    crowded.push(group[0].0);
                }
            }
        }
    }
    // Vertices of edges that could not be paired stay as they are, for the check to name.
    let mut fixed = vec![false; soup.points.len()];
    crowded.as_flattened().iter().for_each(|&v| fixed[v as usize] = true);
    let (fan, count) = fans.number();
    let mut vertex_of_fan = vec![u32::MAX; count];
    let mut first_fan = vec![u32::MAX; soup.points.len()];
    let mut split = vec![];
    for corner in 0..fan.len() {
        let v = soup.triangles[corner / 3][corner % 3];
        let slot = &mut vertex_of_fan[fan[corner] as usize];
        if *slot != u32::MAX {
            continue;
        }
        if first_fan[v as usize] == u32::MAX || fixed[v as usize] {
            first_fan[v as usize] = fan[corner];
            *slot = v;
        } else {
            *slot = soup.points.len() as u32;
            soup.points.push(soup.points[v as usize]);
            soup.model.push(soup.model[v as usize]);
            split.extend([v, *slot]);
        }
    }
    if split.is_empty() {
        return;
    }
    for corner in 0..fan.len() {
        soup.triangles[corner / 3][corner % 3] = vertex_of_fan[fan[corner] as usize];
    }
    split.sort_unstable();
    split.dedup();
    move_inward(soup, frame, diagonal, &split);
    let count = split.len();
    notes.push(format!("{count} vertices where parts touched were split and moved apart, each by at most {APART:e} of the diagonal (--repair)"));
}

/// Moves vertices towards the middle of their neighbours.
fn move_inward(soup: &mut Soup, frame: &Frame, diagonal: f64, vertices: &[u32]) {
    let mut sum = vec![(DVec3::ZERO, 0.0); vertices.len()];
    for triangle in &soup.triangles {
        for (i, v) in triangle.iter().enumerate() {
            if let Ok(k) = vertices.binary_search(v) {
                sum[k].0 += soup.points[triangle[(i + 1) % 3] as usize] + soup.points[triangle[(i + 2) % 3] as usize];
                sum[k].1 += 2.0;
            }
        }
    }
    let moved: Vec<DVec3> = vertices
        .iter()
        .zip(&sum)
        .map(|(&v, &(sum, count))| {
            let p = soup.points[v as usize];
            let way = sum / count - p;
            p + way * APART_OF_PART.min(APART * diagonal / way.length().max(f64::MIN_POSITIVE))
        })
        .collect();
    for (&v, &p) in vertices.iter().zip(&moved) {
        soup.points[v as usize] = snap(p);
        soup.model[v as usize] = frame.to_model(snap(p));
    }
}
