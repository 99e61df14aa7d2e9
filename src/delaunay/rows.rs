//! Certificates of many tets: those are tested together, in vectors, that answer for as many facets.
//!
//! A facet is left to one of its two tets, so a tet answers for two of its four, more or less. To test all four and drop
//! the others is half as slow again.

use glam::DVec3;
use rayon::prelude::*;

use super::certificate::{Block, NONE, hull_certificate, rounded, test};
use super::detect::{BLOCKS, LANES, is_left_to_other};
use super::facet::INFINITE;
use super::flip::Mesh;

/// Tets that one thread tests in a row.
const CHUNK: usize = 2048;

/// Tets whose vertices are looked up in a row.
const ROW: usize = BLOCKS * LANES;

/// Vectors of these.
type Blocks = [Block; BLOCKS];

/// Tests tets; the motions that each is good for, given each vertex's bound, are left in `found`, [`NONE`] for what could
/// not be cleared.
pub fn certify(mesh: &Mesh, tets: &[u32], bounds: &[f32], found: &mut Vec<f32>) {
    found.clear();
    found.resize(tets.len(), NONE);
    let chunk = |(tets, found): (&[u32], &mut [f32])| {
        certify_finite(mesh, bounds, tets, found);
        for (&t, found) in tets.iter().zip(found) {
            if mesh.vertices[t as usize][3] == INFINITE {
                *found = rounded(hull_certificate(mesh, bounds, t));
            }
        }
    };
    if rayon::current_num_threads() == 1 || tets.len() <= CHUNK {
        chunk((tets, found));
    } else {
        tets.par_chunks(CHUNK).zip(found.par_chunks_mut(CHUNK)).for_each(chunk);
    }
}

/// Tests finite tets, those together that answer for as many facets. The infinite ones are left as they are.
fn certify_finite(mesh: &Mesh, bounds: &[f32], tets: &[u32], found: &mut [f32]) {
    let mut rows = [Row::default(); 5];
    let mut blocks = [Block::default(); BLOCKS];
    let mut next = [([0; 4], [0; 4]); ROW];
    for (n, tets) in tets.chunks(ROW).enumerate() {
        for (&t, next) in tets.iter().zip(&mut next) {
            *next = (mesh.vertices[t as usize], mesh.opposite[t as usize]);
        }
        for (&(corners, opposite), place) in next[..tets.len()].iter().zip((n * ROW) as u32..) {
            if corners[3] == INFINITE {
                continue;
            }
            let (vertices, facets) = with_own_apexes(&corners, &opposite);
            let row = &mut rows[facets];
            row.push(place, vertices);
            if row.count == ROW {
                row.test_of(facets, &mesh.points, bounds, &mut blocks, found);
            }
        }
    }
    for (facets, row) in rows.iter_mut().enumerate() {
        row.test_of(facets, &mesh.points, bounds, &mut blocks, found);
    }
}

/// A tet's corners and, after them, the vertices across the facets that it answers for; and how many these are.
#[inline]
fn with_own_apexes(corners: &[u32; 4], opposite: &[u32; 4]) -> ([u32; 8], usize) {
    let [a, b, c, d] = *corners;
    // All apexes are written, and those that are left to the other tet again.
    let (mut vertices, mut facets) = ([a, b, c, d, 0, 0, 0, 0], 0);
    for (&v, &q) in corners.iter().zip(opposite) {
        vertices[4 + facets.min(3)] = q;
        facets += usize::from(!is_left_to_other(v, q));
    }
    (vertices, facets)
}

/// Tets that answer for as many facets.
#[derive(Clone, Copy)]
struct Row {
    count: usize,
    /// Where each is found in the list of those that are tested.
    places: [u32; ROW],
    /// Corners, and vertices across these facets.
    vertices: [[u32; 8]; ROW],
}

impl Default for Row {
    fn default() -> Row {
        Row { count: 0, places: [0; ROW], vertices: [[0; 8]; ROW] }
    }
}

impl Row {
    #[inline]
    fn push(&mut self, place: u32, vertices: [u32; 8]) {
        (self.places[self.count], self.vertices[self.count]) = (place, vertices);
        self.count += 1;
    }

    /// Tests the tets, of so many facets each, by the widest vectors that the processor has, and clears the row.
    fn test_of(&mut self, facets: usize, points: &[DVec3], bounds: &[f32], blocks: &mut Blocks, found: &mut [f32]) {
        let arch = pulp::Arch::new();
        match facets {
            0 => arch.dispatch(Batch::<0> { row: self, points, bounds, blocks, found }),
            1 => arch.dispatch(Batch::<1> { row: self, points, bounds, blocks, found }),
            2 => arch.dispatch(Batch::<2> { row: self, points, bounds, blocks, found }),
            3 => arch.dispatch(Batch::<3> { row: self, points, bounds, blocks, found }),
            _ => arch.dispatch(Batch::<4> { row: self, points, bounds, blocks, found }),
        }
        self.count = 0;
    }
}

/// Tets to be tested; compiled for each width of vectors, like the test of all.
struct Batch<'a, const FACETS: usize> {
    row: &'a Row,
    points: &'a [DVec3],
    bounds: &'a [f32],
    blocks: &'a mut Blocks,
    found: &'a mut [f32],
}

impl<const FACETS: usize> pulp::WithSimd for Batch<'_, FACETS> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Batch { row, points, bounds, blocks, found } = self;
        let count = row.count.div_ceil(LANES);
        for (block, vertices) in blocks[..count].iter_mut().zip(row.vertices.as_chunks::<LANES>().0) {
            for l in 0..LANES {
                let to = block.at.iter_mut().zip(&mut block.reach);
                for ((at, reach), v) in to.zip(vertices[l]).take(4 + FACETS) {
                    (at[l], reach[l]) = (points[v as usize], bounds[v as usize]);
                }
            }
        }
        // Vectors are read well after their numbers were written.
        for (block, places) in blocks[..count].iter().zip(row.places[..row.count].chunks(LANES)) {
            let motions = test::<FACETS>(block);
            for (&place, n) in places.iter().zip(motions) {
                found[place as usize] = rounded(n);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::certificate::tests::{mesh_of, point_sets};
    use super::*;

    /// A tet's certificate, by itself and without vectors.
    fn plain<const FACETS: usize>(row: &Row, points: &[DVec3], bounds: &[f32]) -> f32 {
        let (mut blocks, mut found) = ([Block::default(); BLOCKS], [NONE]);
        let batch = Batch::<FACETS> { row, points, bounds, blocks: &mut blocks, found: &mut found };
        pulp::WithSimd::with_simd(batch, pulp::Scalar::new());
        found[0]
    }

    #[test]
    fn every_width_of_vectors_gives_the_same_certificates() {
        for points in point_sets() {
            let mesh = mesh_of(&points);
            let all: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
            let bounds: Vec<f32> = (0..points.len()).map(|v| 1e-3 + (v % 7) as f32 * 1e-4).collect();
            let mut expected = Vec::new();
            certify(&mesh, &all, &bounds, &mut expected);
            let mut seen = [0; 5];
            for (t, &expected) in all.iter().zip(&expected) {
                let (corners, opposite) = (mesh.vertices[*t as usize], mesh.opposite[*t as usize]);
                if corners[3] == INFINITE {
                    continue;
                }
                let (vertices, facets) = with_own_apexes(&corners, &opposite);
                seen[facets] += 1;
                let mut row = Row::default();
                row.push(0, vertices);
                let of = [plain::<0>, plain::<1>, plain::<2>, plain::<3>, plain::<4>];
                let plain = of[facets](&row, &points, &bounds);
                assert!(expected == plain, "tet {t}: {expected} {plain}");
            }
            assert!(seen.iter().all(|n| *n > 0), "tets with none to four facets of their own: {seen:?}");
        }
    }
}
