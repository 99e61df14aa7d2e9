//! What the Voronoi edges that the surface does not cross add to the cells, tet by tet.
//!
//! The circumcentres of its facets part a Voronoi edge in two, one half for each of the two tets. The half from the
//! circumcentre c of a tet to g of its facet (i, j, k) adds to the cells of i and of j an orthoscheme each, with the corners
//! x_i, m_ij, g, c. With L the squared length of ij, R the circumradius, N the facet's normal into the tet, twice its area long,
//! t = (c - x_i) . N, and G = c - g = N t / N²:
//!
//! | of (i, j) in the facet, and of (j, i) | |
//! |---|---|
//! | volume, the same for both | V = L ((x_i - x_k) . (x_j - x_k)) t / (24 N²) |
//! | first moment of i | V ((x_j - x_i) / 2 + 2 (c - x_i) - G) / 4 |
//! | second moment, the same for both | V (3 L / 4 + 3 R² - 2 G²) / 10 |
//!
//! Nothing but the tet's corners is looked up, and all of its four facets are added at once, many tets in vectors. Where a tet or
//! one of its facets is nearly flat digits are lost: its edges are added whole, from one circumcentre to the other, and the halves
//! that other tets added of them are taken back.

use super::cell::Sums;
use super::crossings::FACET;
use super::voronoi_edges::{Edges, MOMENTS, interval};
use crate::geometry::triples::{cross, dot, greater, minus};

/// Tets that are added at once.
const LANES: usize = 8;

/// Blocks of as many that are gathered in a row.
const BLOCKS: usize = 4;

/// A facet is nearly flat if the square of twice its area is below this share of the fourth power of the tet's longest edge, a
/// tet if that of six times its volume is below this share of the sixth power.
const FLAT: f64 = 1e-4;

/// What is at hand of the tets of one thread.
#[derive(Default)]
pub(super) struct Shares {
    /// Those with the circumcentre inside.
    tets: Vec<u32>,
    blocks: [Block; BLOCKS],
    /// Those that are nearly flat.
    flat: Vec<u32>,
}

impl Shares {
    /// Adds what some tets share out.
    pub(super) fn add(&mut self, edges: &Edges, tets: std::ops::Range<usize>, sums: &mut Sums<MOMENTS>) {
        self.flat.clear();
        self.list(edges, tets);
        // Vectors are read long after their numbers were written one by one: else each would wait for all of these.
        for tets in self.tets.chunks(BLOCKS * LANES) {
            tets.iter().enumerate().for_each(|(n, &t)| self.blocks[n / LANES].set(n % LANES, t, edges));
            edges.arch.dispatch(Find { blocks: &mut self.blocks });
            for (n, &t) in tets.iter().enumerate() {
                let (block, l) = (&self.blocks[n / LANES], n % LANES);
                if is_flat(block.clearance[l]) {
                    self.flat.push(t);
                } else {
                    block.add(l, edges.delaunay.vertices()[t as usize], sums);
                }
            }
        }
        self.flat.iter().for_each(|&t| add_flat(edges, t, sums));
    }

    /// Lists the tets with the circumcentre inside.
    fn list(&mut self, edges: &Edges, tets: std::ops::Range<usize>) {
        self.tets.clear();
        self.tets.resize(tets.len() + 1, 0);
        let mut count = 0;
        for t in tets {
            self.tets[count] = t as u32;
            count += usize::from(edges.winding[t] != 0);
        }
        self.tets.truncate(count);
    }
}

/// As many tets, number by number.
#[derive(Default)]
struct Block {
    corners: [[[f64; LANES]; 3]; 4],
    /// Those of the facets across from these; 0 where the surface crosses the Voronoi edge.
    weights: [[f64; LANES]; 4],
    /// What they add to the cells of the corners.
    parts: [[[f64; LANES]; MOMENTS]; 4],
    /// Not above 0 where a tet is nearly flat.
    clearance: [f64; LANES],
}

impl Block {
    /// Puts tet `t` into lane `l`.
    #[inline]
    fn set(&mut self, l: usize, t: u32, edges: &Edges) {
        let corners = corners(edges, t);
        let weights = weights(edges, t);
        for k in 0..4 {
            (0..3).for_each(|n| self.corners[k][n][l] = corners[k][n]);
            self.weights[k][l] = weights[k];
        }
    }

    /// Adds what was found for lane `l`, a tet with such corners, to the sums.
    #[inline]
    fn add(&self, l: usize, tet: [u32; 4], sums: &mut Sums<MOMENTS>) {
        for (part, i) in self.parts.iter().zip(tet) {
            sums.add(i, std::array::from_fn(|m| part[m][l]));
        }
    }
}

#[inline]
fn corners(edges: &Edges, t: u32) -> [[f64; 3]; 4] {
    edges.delaunay.vertices()[t as usize].map(|i| edges.delaunay.points()[i as usize].to_array())
}

/// The winding where the surface does not cross the Voronoi edge of a facet.
#[inline]
fn weights(edges: &Edges, t: u32) -> [f64; 4] {
    let (winding, marks) = (f64::from(edges.winding[t as usize]), edges.marks[t as usize]);
    [0, 1, 2, 3].map(|f| if marks >> f & 1 == 0 { winding } else { 0.0 })
}

/// Compiled for each width of vectors; the operations, and so the sums, are the same in each.
struct Find<'a> {
    blocks: &'a mut [Block],
}

impl pulp::WithSimd for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for Block { corners, weights, parts, clearance } in self.blocks {
            for l in 0..LANES {
                let corners = [0, 1, 2, 3].map(|k| [corners[k][0][l], corners[k][1][l], corners[k][2][l]]);
                let (found, clear) = shares(corners, [0, 1, 2, 3].map(|f| weights[f][l]));
                clearance[l] = clear;
                for k in 0..4 {
                    for m in 0..MOMENTS {
                        parts[k][m][l] = found[k][m];
                    }
                }
            }
        }
    }
}

/// What a tet adds to the cells of its corners, with such weights of the facets across from these; and a number that is
/// not above 0 where it is nearly flat.
#[inline(always)]
fn shares([a, b, c, d]: [[f64; 3]; 4], weights: [f64; 4]) -> ([[f64; MOMENTS]; 4], f64) {
    let [u, v, w] = [minus(b, a), minus(c, a), minus(d, a)];
    let [uv, uw, vw] = [minus(v, u), minus(w, u), minus(w, v)];
    let [ab, ac, ad, bc, bd, cd] = [dot(u, u), dot(v, v), dot(w, w), dot(uv, uv), dot(uw, uw), dot(vw, vw)];
    let [nb, nc, nd] = [cross(v, w), cross(w, u), cross(u, v)];
    let volume6 = dot(u, nb);
    let half = 0.5 / volume6;
    let center = [0, 1, 2].map(|n| (ab * nb[n] + ac * nc[n] + ad * nd[n]) * half);

    // Facet by facet, each across from the corner that it is named by.
    let [tb, tc, td] = [dot(center, nb), dot(center, nc), dot(center, nd)];
    let na = [0, 1, 2].map(|n| -(nb[n] + nc[n] + nd[n]));
    let fa = Facet::new(na, volume6 - (tb + tc + td), weights[0]);
    let fb = Facet::new(nb, tb, weights[1]);
    let fc = Facet::new(nc, tc, weights[2]);
    let fd = Facet::new(nd, td, weights[3]);
    let [a_bc, a_bd, a_cd] = fa.volumes(bc, bd, cd);
    let [b_ac, b_ad, b_cd] = fb.volumes(ac, ad, cd);
    let [c_ab, c_ad, c_bd] = fc.volumes(ab, ad, bd);
    let [d_ab, d_ac, d_bc] = fd.volumes(ab, ac, bc);

    // Corner by corner.
    let [v_ab, v_ac, v_ad] = [c_ab + d_ab, b_ac + d_ac, b_ad + c_ad];
    let [v_bc, v_bd, v_cd] = [a_bc + d_bc, a_bd + c_bd, a_cd + b_cd];
    let o = Corner { at: [0.0; 3], center };
    let [x, y, z] = [u, v, w].map(|at| Corner { at, center });
    let parts = [
        o.part(
            [(v_ab, u, ab), (v_ac, v, ac), (v_ad, w, ad)],
            [(b_ac + b_ad, fb), (c_ab + c_ad, fc), (d_ab + d_ac, fd)],
        ),
        x.part(
            [(v_ab, [0.0; 3], ab), (v_bc, v, bc), (v_bd, w, bd)],
            [(a_bc + a_bd, fa), (c_ab + c_bd, fc), (d_ab + d_bc, fd)],
        ),
        y.part(
            [(v_ac, [0.0; 3], ac), (v_bc, u, bc), (v_cd, w, cd)],
            [(a_bc + a_cd, fa), (b_ac + b_cd, fb), (d_ac + d_bc, fd)],
        ),
        z.part(
            [(v_ad, [0.0; 3], ad), (v_bd, u, bd), (v_cd, v, cd)],
            [(a_bd + a_cd, fa), (b_ad + b_cd, fb), (c_ad + c_bd, fc)],
        ),
    ];

    let longest = greater(greater(greater(ab, ac), greater(ad, bc)), greater(bd, cd));
    let least = -greater(greater(-fa.area2, -fb.area2), greater(-fc.area2, -fd.area2));
    let square = longest * longest;
    (parts, -greater(FLAT * square - least, FLAT * square * longest - volume6 * volume6))
}

/// Whether a number of [`shares`] says so.
#[inline]
fn is_flat(clearance: f64) -> bool {
    // Of a tet whose volume rounds to 0 it may be no number.
    clearance <= 0.0 || clearance.is_nan()
}

/// A facet of a tet.
#[derive(Clone, Copy)]
struct Facet {
    /// The square of twice its area.
    area2: f64,
    /// G, and its square.
    way: [f64; 3],
    way2: f64,
    /// The factor that all volumes have.
    factor: f64,
}

impl Facet {
    /// With such a normal N, t and a weight.
    #[inline(always)]
    fn new(normal: [f64; 3], t: f64, weight: f64) -> Facet {
        let area2 = dot(normal, normal);
        let ratio = t / area2;
        Facet { area2, way: normal.map(|x| x * ratio), way2: t * ratio, factor: weight * ratio / 48.0 }
    }

    /// V of its three edges, which have such squared lengths.
    #[inline(always)]
    fn volumes(&self, x: f64, y: f64, z: f64) -> [f64; 3] {
        let of = |x: f64, y: f64, z: f64| x * (y + z - x) * self.factor;
        [of(x, y, z), of(y, z, x), of(z, x, y)]
    }
}

/// A corner of a tet, and the circumcentre.
#[derive(Clone, Copy)]
struct Corner {
    at: [f64; 3],
    center: [f64; 3],
}

impl Corner {
    /// What its cell has: from the volumes at its edges with the other ends and squared lengths of these, and the volumes at its
    /// facets.
    #[inline(always)]
    fn part(&self, edges: [(f64, [f64; 3], f64); 3], facets: [(f64, Facet); 3]) -> [f64; MOMENTS] {
        let [(p, x, xx), (q, y, yy), (r, z, zz)] = edges;
        let [(i, f), (j, g), (k, h)] = facets;
        let volume = p + q + r;
        let moment = |n: usize| {
            let ends = p * x[n] + q * y[n] + r * z[n];
            let ways = i * f.way[n] + j * g.way[n] + k * h.way[n];
            0.25 * (0.5 * ends + volume * (2.0 * self.center[n] - 2.5 * self.at[n]) - ways)
        };
        let radius2 = dot(self.center, self.center);
        let ways2 = i * f.way2 + j * g.way2 + k * h.way2;
        let second = 0.075 * (p * xx + q * yy + r * zz) + 0.3 * radius2 * volume - 0.2 * ways2;
        [volume, moment(0), moment(1), moment(2), second]
    }
}

/// Adds the Voronoi edges of the facets of a tet that is nearly flat.
fn add_flat(edges: &Edges, t: u32, sums: &mut Sums<MOMENTS>) {
    let (vertices, neighbors) = (edges.delaunay.vertices(), edges.delaunay.neighbors());
    let mine = weights(edges, t);
    for f in (0..4).filter(|&f| mine[f] != 0.0) {
        let (n, slot) = (neighbors[t as usize][f].tet(), neighbors[t as usize][f].slot());
        let back = [0, 1, 2, 3].map(|g| if g == slot { -mine[f] } else { 0.0 });
        let (half, clearance) = shares(corners(edges, n), back);
        let is_flat = is_flat(clearance);
        if is_flat && n < t {
            continue;
        }
        let facet = FACET[f].map(|v| vertices[t as usize][v]);
        let [from, to] = [n, t].map(|t| edges.center(t as usize).to_array());
        let at = facet.map(|i| edges.delaunay.points()[i as usize].to_array());
        facet.into_iter().zip(interval(at, from, to, mine[f])).for_each(|(i, part)| sums.add(i, part));
        if !is_flat {
            vertices[n as usize].into_iter().zip(half).for_each(|(i, part)| sums.add(i, part));
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::cell::Cell;
    use super::super::crossings::Crossings;
    use super::super::voronoi_edges::{Even, Measure};
    use super::*;
    use crate::delaunay::Delaunay;
    use crate::geometry::frame::snap;
    use crate::rng::Rng;

    /// What `add` sums up, for the tets with their circumcentre in a ball, each Voronoi edge between two of these being one that
    /// the surface does not cross.
    fn cells(delaunay: &Delaunay, add: impl FnOnce(&Edges, &mut Sums<MOMENTS>)) -> Vec<Cell> {
        let tets = delaunay.vertices().iter().zip(delaunay.neighbors());
        let is_finite = |tet: &[u32; 4]| tet.iter().all(|&v| (v as usize) < delaunay.points().len());
        let center =
            |tet: &[u32; 4]| super::super::circumcenters::circumcenter(tet.map(|v| delaunay.points()[v as usize]));
        let winding: Vec<i32> =
            tets.clone().map(|(tet, _)| i32::from(is_finite(tet) && center(tet).length() < 0.4)).collect();
        let differs = |t: usize, n: u32| winding[t] != winding[n as usize];
        let marks: Vec<u8> = (tets.enumerate())
            .map(|(t, (_, n))| (0..4).fold(0, |marks, f| marks | u8::from(differs(t, n[f].tet())) << f))
            .collect();
        let crossings = Crossings::new(&[], delaunay.points().len());
        let mut sums = Sums::new(delaunay.points().len());
        let arch = pulp::Arch::new();
        add(
            &Edges { delaunay, crossings: &crossings, marks: &marks, crossed: &[], winding: &winding, arch },
            &mut sums,
        );
        let mut cells = vec![Cell::default(); delaunay.points().len()];
        let (seeds, found) = sums.take();
        seeds.into_iter().zip(found).for_each(|(i, part)| Even::add(&mut cells[i as usize], part));
        cells
    }

    /// Edge by edge, from one circumcentre to the other.
    fn add_whole(edges: &Edges, sums: &mut Sums<MOMENTS>) {
        for id in 0..4 * edges.winding.len() {
            let (t, f) = (id / 4, id % 4);
            let n = edges.delaunay.neighbors()[t][f].tet() as usize;
            if edges.winding[t] != 0 && edges.marks[t] >> f & 1 == 0 && t < n {
                let (facet, from, to) = edges.facet(id as u32);
                let at = facet.map(|i| edges.delaunay.points()[i as usize].to_array());
                let parts = interval(at, edges.center(from).to_array(), edges.center(to).to_array(), 1.0);
                facet.into_iter().zip(parts).for_each(|(i, part)| sums.add(i, part));
            }
        }
    }

    #[test]
    fn halves_add_up_to_voronoi_edges_also_where_tets_are_nearly_flat() {
        let mut rng = Rng::new(3, 0);
        let mut random: Vec<DVec3> = (0..2000).map(|_| rng.in_cube() * 0.5).collect();
        // Pairs of seeds much closer than others: needles.
        let close: Vec<DVec3> = random[..50].iter().map(|&p| p + rng.in_cube() * 1e-6).collect();
        random.extend(close);
        let grid = |shake: f64, rng: &mut Rng| -> Vec<DVec3> {
            let at = |i: usize| DVec3::new((i % 12) as f64, (i / 12 % 12) as f64, (i / 144) as f64) / 12.0 - 0.46;
            (0..1728).map(|i| at(i) + rng.in_cube() * shake).collect()
        };
        let grids = [0.0, 1e-12, 1e-6, 1e-3, 1e-2].map(|shake| grid(shake, &mut rng));
        let mut with_flat = 0;
        for (set, points) in [random].into_iter().chain(grids).enumerate() {
            let points: Vec<DVec3> = points.into_iter().map(snap).collect();
            let delaunay = Delaunay::build(&points).expect("distinct points");
            let mut flat = 0;
            let found = cells(&delaunay, |edges, sums| {
                let mut shares = Shares::default();
                shares.add(edges, 0..edges.winding.len(), sums);
                flat = shares.flat.len();
            });
            let expected = cells(&delaunay, add_whole);
            with_flat += usize::from(flat > 0);
            // Cells are some 0.1 wide.
            for (a, b) in found.iter().zip(&expected) {
                assert!(
                    (a.volume - b.volume).abs() < 1e-16 && (a.energy - b.energy).abs() < 1e-18,
                    "{set}: {a:?} {b:?}"
                );
                assert!(a.moment.distance(b.moment) < 1e-17, "{set}: {a:?} {b:?}");
            }
        }
        assert!(with_flat >= 3, "{with_flat} sets have nearly flat tets");
    }
}
