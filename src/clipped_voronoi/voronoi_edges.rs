//! What the Voronoi edges inside the solid add to the cells around them.
//!
//! The dual edge of the facet (p, q, r), from a to b, adds to the cell of each ordered pair (i, j) of its vertices the tet
//! (x_i, m_ij, a, b), m_ij the middle of the two. With a as origin, D = b - a, X = x - a:
//!
//! | of (i, j) and (j, i) | |
//! |---|---|
//! | volume, the same for both | d = D . (X_i x X_j) / 12 |
//! | first moment of i | d (X_j - 5 X_i + 2 D) / 8 |
//! | second moment, the same for both | d (9 (X_i² + X_j²) - 6 X_i . X_j - 6 (X_i + X_j) . D + 4 D²) / 40 |
//!
//! The last uses that a and b are as far from x_i as from x_j. Edges that the surface does not cross, nearly all, are
//! done many at a time in vectors.

use glam::DVec3;
use rayon::prelude::*;

use super::Crossing;
use super::cell::{Cell, Sums};
use super::crossings::{Crossings, FACET};
use crate::delaunay::Delaunay;
use crate::geometry::triples::{cross, dot, minus};

/// Tets in a block of the work: fixed, so that sums do not depend on the number of threads.
const BLOCK: usize = 8192;

/// Edges that are added at once.
const LANES: usize = 8;

/// Blocks of as many that are gathered in a row.
const BLOCKS: usize = 4;

/// What the edges are made of.
#[derive(Clone, Copy)]
pub(super) struct Edges<'a> {
    pub(super) delaunay: &'a Delaunay,
    pub(super) crossings: &'a Crossings<'a>,
    /// See [`Crossings::marks`].
    pub(super) marks: &'a [u8],
    pub(super) winding: &'a [i32],
    pub(super) centers: &'a [DVec3],
    pub(super) arch: pulp::Arch,
}

/// Two ends of the edges of the facets were found to disagree about what is inside.
#[derive(Debug)]
pub(super) struct NotClosed;

/// What a density makes of an edge: N numbers for each of its three cells.
pub(super) trait Measure<const N: usize>: Sync {
    /// Whether what is known at seeds and ends is asked for at all.
    const VARIES: bool;

    /// What is known at the seeds of a facet.
    fn at_seeds(&self, facet: [u32; 3]) -> [f64; 3];

    /// At the circumcentre of a tet.
    fn at_center(&self, tet: usize) -> f64;

    /// At a crossing.
    fn at_crossing(&self, crossing: &Crossing) -> f64;

    /// What the interval from `a` to `b` of the Voronoi edge of a facet adds to the cells of its three vertices, all times
    /// `weight`, with what is known at the seeds and at the ends.
    fn interval(
        facet: [[f64; 3]; 3],
        ends: [[f64; 3]; 2],
        weight: f64,
        at_seeds: [f64; 3],
        at_ends: [f64; 2],
    ) -> [[f64; N]; 3];

    /// Adds such numbers to a cell.
    fn add(cell: &mut Cell, numbers: [f64; N]);
}

/// The density 1: volume, first moment, second moment.
pub(super) struct Even;

/// How many they are.
const MOMENTS: usize = 5;

impl Measure<MOMENTS> for Even {
    const VARIES: bool = false;

    #[inline(always)]
    fn at_seeds(&self, _: [u32; 3]) -> [f64; 3] {
        [1.0; 3]
    }

    #[inline(always)]
    fn at_center(&self, _: usize) -> f64 {
        1.0
    }

    #[inline(always)]
    fn at_crossing(&self, _: &Crossing) -> f64 {
        1.0
    }

    #[inline(always)]
    fn interval(
        facet: [[f64; 3]; 3],
        ends: [[f64; 3]; 2],
        weight: f64,
        _: [f64; 3],
        _: [f64; 2],
    ) -> [[f64; MOMENTS]; 3] {
        interval(facet, ends[0], ends[1], weight)
    }

    fn add(cell: &mut Cell, [volume, x, y, z, energy]: [f64; MOMENTS]) {
        cell.volume += volume;
        cell.moment += DVec3::new(x, y, z);
        cell.energy += energy;
    }
}

/// Facets at hand, for one thread.
struct Lists<const N: usize> {
    sums: Sums<N>,
    /// Facets that the surface does not cross, with both ends inside: four times the tet, plus the facet.
    plain: Vec<u32>,
    crossed: Vec<u32>,
}

impl Edges<'_> {
    /// Adds, for every Voronoi edge, what its part inside the solid adds to the cells around it.
    pub(super) fn add<const N: usize, M: Measure<N>>(self, cells: &mut [Cell], measure: &M) -> Result<(), NotClosed> {
        let seeds = self.delaunay.points().len();
        let blocks = self.winding.len().div_ceil(BLOCK);
        let new_lists = || Lists { sums: Sums::new(seeds), plain: Vec::new(), crossed: Vec::new() };
        let found: Vec<_> = (0..blocks)
            .into_par_iter()
            .map_init(new_lists, |lists, block| {
                self.list(block * BLOCK..((block + 1) * BLOCK).min(self.winding.len()), lists)?;
                self.add_plain(measure, &lists.plain, &mut lists.sums);
                for &f in &lists.crossed {
                    self.add_crossed(measure, f, &mut lists.sums)?;
                }
                Ok(lists.sums.take())
            })
            .collect::<Result<_, NotClosed>>()?;
        for &(i, numbers) in found.iter().flatten() {
            M::add(&mut cells[i as usize], numbers);
        }
        Ok(())
    }

    /// Lists the facets of some tets, each at one of its two tets.
    fn list<const N: usize>(&self, tets: std::ops::Range<usize>, lists: &mut Lists<N>) -> Result<(), NotClosed> {
        let neighbors = self.delaunay.neighbors();
        lists.crossed.clear();
        lists.plain.clear();
        lists.plain.resize(4 * tets.len() + 1, 0);
        let mut count = 0;
        let mut wrong = false;
        for t in tets {
            let (here, marks) = (self.winding[t], self.marks[t]);
            for (f, facet) in neighbors[t].iter().enumerate() {
                let n = facet.tet() as usize;
                let id = (4 * t + f) as u32;
                let own = t < n;
                if marks >> f & 1 == 1 {
                    if own {
                        lists.crossed.push(id);
                    }
                    continue;
                }
                wrong |= here != self.winding[n];
                // Whether a facet is listed is hard to predict: write it in any case.
                lists.plain[count] = id;
                count += usize::from(own & (here != 0));
            }
        }
        lists.plain.truncate(count);
        if wrong { Err(NotClosed) } else { Ok(()) }
    }

    /// Adds the edges of facets that the surface does not cross.
    fn add_plain<const N: usize, M: Measure<N>>(&self, measure: &M, list: &[u32], sums: &mut Sums<N>) {
        // Vectors are read long after their numbers were written one by one: else each would wait for all of these.
        let mut plain: [Plain<N>; BLOCKS] = std::array::from_fn(|_| Plain::default());
        for ids in list.chunks(BLOCKS * LANES) {
            ids.iter().enumerate().for_each(|(n, &id)| plain[n / LANES].set(n % LANES, id, self, measure));
            self.arch.dispatch(Find::<N, M> { plain: &mut plain, measure: std::marker::PhantomData });
            (0..ids.len()).for_each(|n| plain[n / LANES].add(n % LANES, sums));
        }
    }

    /// Vertices of the facet `id`, and the tets at the beginning and at the end of its dual edge.
    #[inline(always)]
    fn facet(&self, id: u32) -> ([u32; 3], usize, usize) {
        let (t, f) = ((id / 4) as usize, (id % 4) as usize);
        let tet = self.delaunay.vertices()[t];
        (FACET[f].map(|v| tet[v]), self.delaunay.neighbors()[t][f].tet() as usize, t)
    }

    /// Adds an edge that crosses the surface.
    ///
    /// What an interval from a to b adds is the difference of what the ways from one base point to b and to a add, so that
    /// several crossings need no order along the edge. The base is the first crossing.
    fn add_crossed<const N: usize, M: Measure<N>>(
        &self,
        measure: &M,
        id: u32,
        sums: &mut Sums<N>,
    ) -> Result<(), NotClosed> {
        let (facet, from, to) = self.facet(id);
        let (crossings, even) = self.crossings.of(facet);
        let ends = [from, to].map(|t| self.winding[t]);
        if ends[0] + self.crossings.entered(facet) != ends[1] {
            return Err(NotClosed);
        }
        let (base, at_base) = (crossings[0].point, measure.at_crossing(&crossings[0]));
        let at_seeds = measure.at_seeds(facet);
        let corners = facet.map(|i| self.delaunay.points()[i as usize].to_array());
        let mut add = |to: DVec3, at_to: f64, weight: i32| {
            if weight != 0 {
                let ends = [base.to_array(), to.to_array()];
                let parts = M::interval(corners, ends, f64::from(weight), at_seeds, [at_base, at_to]);
                facet.iter().zip(parts).for_each(|(&i, part)| sums.add(i, part));
            }
        };
        add(self.centers[from], measure.at_center(from), -ends[0]);
        for c in &crossings[1..] {
            add(c.point, measure.at_crossing(c), if c.leaves == even { 1 } else { -1 });
        }
        add(self.centers[to], measure.at_center(to), ends[1]);
        Ok(())
    }
}

/// Edges wholly inside, as many as are added at once, number by number.
struct Plain<const N: usize> {
    facets: [[u32; 3]; LANES],
    /// The facet's three vertices and the two ends.
    at: [[[f64; LANES]; 3]; 5],
    /// What is known of the density there.
    known: [[f64; LANES]; 5],
    weights: [f64; LANES],
    /// What they add to the cells of the three.
    parts: [[[f64; LANES]; N]; 3],
}

impl<const N: usize> Default for Plain<N> {
    fn default() -> Plain<N> {
        Plain {
            facets: [[0; 3]; LANES],
            at: [[[0.0; LANES]; 3]; 5],
            known: [[0.0; LANES]; 5],
            weights: [0.0; LANES],
            parts: [[[0.0; LANES]; N]; 3],
        }
    }
}

impl<const N: usize> Plain<N> {
    /// Puts edge `id` into lane `l`.
    #[inline]
    fn set<M: Measure<N>>(&mut self, l: usize, id: u32, edges: &Edges, measure: &M) {
        let (points, centers) = (edges.delaunay.points(), edges.centers);
        let (facet, from, to) = edges.facet(id);
        let [p, q, r] = facet.map(|i| points[i as usize]);
        for (k, x) in [p, q, r, centers[from], centers[to]].into_iter().enumerate() {
            (self.at[k][0][l], self.at[k][1][l], self.at[k][2][l]) = (x.x, x.y, x.z);
        }
        self.weights[l] = f64::from(edges.winding[to]);
        if M::VARIES {
            let [p, q, r] = measure.at_seeds(facet);
            let all = [p, q, r, measure.at_center(from), measure.at_center(to)];
            all.into_iter().enumerate().for_each(|(k, x)| self.known[k][l] = x);
        }
        self.facets[l] = facet;
    }

    /// Adds what was found for lane `l` to the sums.
    #[inline]
    fn add(&self, l: usize, sums: &mut Sums<N>) {
        for (part, &i) in self.parts.iter().zip(&self.facets[l]) {
            sums.add(i, std::array::from_fn(|m| part[m][l]));
        }
    }
}

/// Finds the parts of many. Compiled for each width of vectors; the operations, and so the sums, are the same in each.
struct Find<'a, const N: usize, M> {
    plain: &'a mut [Plain<N>],
    measure: std::marker::PhantomData<M>,
}

impl<const N: usize, M: Measure<N>> pulp::WithSimd for Find<'_, N, M> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for Plain { at, known, weights, parts, .. } in self.plain {
            for l in 0..LANES {
                let [p, q, r, a, b] = [0, 1, 2, 3, 4].map(|k| [at[k][0][l], at[k][1][l], at[k][2][l]]);
                let [at_p, at_q, at_r, at_a, at_b] = [0, 1, 2, 3, 4].map(|k| known[k][l]);
                let found = M::interval([p, q, r], [a, b], weights[l], [at_p, at_q, at_r], [at_a, at_b]);
                for k in 0..3 {
                    for m in 0..N {
                        parts[k][m][l] = found[k][m];
                    }
                }
            }
        }
    }
}

/// What the interval from `a` to `b` of the Voronoi edge of a facet adds to the cells of its three vertices: volume, first
/// moment, second moment, all times `weight`.
#[inline(always)]
fn interval(facet: [[f64; 3]; 3], a: [f64; 3], b: [f64; 3], weight: f64) -> [[f64; MOMENTS]; 3] {
    let [p, q, r] = facet.map(|x| minus(x, a));
    let d = minus(b, a);
    let twelfth = weight / 12.0;
    let volumes = [dot(d, cross(p, q)) * twelfth, dot(d, cross(q, r)) * twelfth, dot(d, cross(r, p)) * twelfth];
    let squares =
        [9.0 * dot(p, p) - 6.0 * dot(p, d), 9.0 * dot(q, q) - 6.0 * dot(q, d), 9.0 * dot(r, r) - 6.0 * dot(r, d)];
    let last = 4.0 * dot(d, d);
    let second = |volume: f64, i: f64, j: f64, ij: f64| volume * (i + j - 6.0 * ij + last) / 40.0;
    let pq = second(volumes[0], squares[0], squares[1], dot(p, q));
    let qr = second(volumes[1], squares[1], squares[2], dot(q, r));
    let rp = second(volumes[2], squares[2], squares[0], dot(r, p));
    [
        of_vertex(p, d, q, volumes[0], r, volumes[2], pq + rp),
        of_vertex(q, d, r, volumes[1], p, volumes[0], qr + pq),
        of_vertex(r, d, p, volumes[2], q, volumes[1], rp + qr),
    ]
}

/// The share of vertex x, whose pairs with y and z have such volumes.
#[inline(always)]
fn of_vertex(
    x: [f64; 3],
    d: [f64; 3],
    y: [f64; 3],
    with_y: f64,
    z: [f64; 3],
    with_z: f64,
    second: f64,
) -> [f64; MOMENTS] {
    let volume = with_y + with_z;
    let moment = |k: usize| (with_y * y[k] + with_z * z[k] + volume * (2.0 * d[k] - 5.0 * x[k])) * 0.125;
    [volume, moment(0), moment(1), moment(2), second]
}
