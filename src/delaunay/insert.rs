//! Incremental construction: locate, carve, fill, one point after another.
//!
//! - A. Bowyer, *Computing Dirichlet tessellations*, The Computer Journal 24(2), 1981, doi 10.1093/comjnl/24.2.162.
//! - D. F. Watson, *Computing the n-dimensional Delaunay tessellation with application to Voronoi polytopes*, The
//!   Computer Journal 24(2), 1981, doi 10.1093/comjnl/24.2.167.
//!
//! 1. Number the points along a Hilbert curve, and insert them in random rounds along it (`order.rs`).
//! 2. The first tet: the first four points that are not on a plane.
//! 3. For each further point: walk from the last tet to one in conflict with the point (`locate.rs`), spread from it over
//!    all tets in conflict, and fill the hole with the star of the point (`cavity.rs`).
//! 4. Copy what is alive into the arrays of the result, in the order of least vertices along the curve.
//!
//! Departures: the conflict zone is found from any tet in conflict, so the walk ends there; spheres are stored
//! (`tets.rs`).

use glam::DVec3;

use super::cavity::Scratch;
use super::facet::{Facet, INFINITE};
use super::order::insertion_rounds;
use super::tets::{Site, Spoke, Tet, sphere};
use super::{Delaunay, DelaunayError};
use crate::geometry::hilbert::hilbert_order;
use crate::geometry::predicates::{Sign, collinear, orient3d};

/// A triangulation under construction.
pub struct Construction {
    /// The points along the curve; after them the infinite vertex.
    pub sites: Vec<Site>,
    /// Tets, dead ones among them.
    pub tets: Vec<Tet>,
    /// Dead tets to be used again.
    pub free: Vec<u32>,
    /// A finite tet near the last point inserted.
    pub last: u32,
}

/// Vertices and facets of each tet.
pub type TetArrays = (Vec<[u32; 4]>, Vec<[Facet; 4]>);

/// Why the construction stopped.
pub enum Obstacle {
    /// The points are all on one line or at one place.
    Line,
    /// The points are all on one plane.
    Plane,
    /// Two points are at the same place.
    Duplicate,
    /// More tets than can be numbered.
    TooMany,
}

impl Construction {
    /// Triangulates `points`, four at least.
    pub fn of(points: impl ExactSizeIterator<Item = DVec3>) -> Result<Construction, Obstacle> {
        let count = points.len();
        let infinite = Site { position: DVec3::NAN, stamp: 0, label: 0 };
        let mut sites = Vec::with_capacity(count + 1);
        sites.extend(points.map(|position| Site { position, ..infinite }));
        sites.push(infinite);
        // A random set of points has about 6.77 tets per point.
        let tets = Vec::with_capacity(count.saturating_mul(7).min(Facet::MAX_TETS));
        let mut construction = Construction { sites, tets, free: Vec::new(), last: 0 };
        let mut scratch = Scratch::default();
        let order = insertion_rounds(count);
        let first = construction.first_tet(&order)?;
        for &vertex in order.iter().filter(|v| !first.contains(v)) {
            construction.insert(vertex, &mut scratch)?;
        }
        Ok(construction)
    }

    /// The number that stands for the infinite vertex.
    #[inline(always)]
    pub fn infinite(&self) -> u32 {
        (self.sites.len() - 1) as u32
    }

    /// Position of a vertex.
    #[inline(always)]
    pub fn position(&self, vertex: u32) -> DVec3 {
        self.sites[vertex as usize].position
    }

    /// Positions of the vertices of a tet.
    #[inline(always)]
    pub fn corners(&self, vertices: [u32; 4]) -> [DVec3; 4] {
        vertices.map(|v| self.position(v))
    }

    /// Starts with the tet of the first four points in `order` that are not on a plane.
    fn first_tet(&mut self, order: &[u32]) -> Result<[u32; 4], Obstacle> {
        let at = |v: u32| self.position(v);
        let mut rest = order.iter().copied();
        let a = rest.next().ok_or(Obstacle::Line)?;
        let b = rest.find(|&v| at(v) != at(a)).ok_or(Obstacle::Line)?;
        let c = rest.find(|&v| !collinear(at(a), at(b), at(v))).ok_or(Obstacle::Line)?;
        let d = rest.find(|&v| orient3d(at(a), at(b), at(c), at(v)) != Sign::Zero).ok_or(Obstacle::Plane)?;
        let tet = match orient3d(at(a), at(b), at(c), at(d)) {
            Sign::Positive => [a, b, c, d],
            _ => [b, a, c, d],
        };
        self.start_with(tet);
        Ok(tet)
    }

    /// The triangulation of a single positive tet: itself, and an infinite tet across each facet.
    fn start_with(&mut self, vertices: [u32; 4]) {
        let [q, a, b, c] = self.corners(vertices);
        let (center, radius2) = sphere(q, Spoke::new(q, a), Spoke::new(q, b), Spoke::new(q, c));
        // Facet i of tet 0 carries infinite tet i + 1, whose facet 3 it is.
        let mirrors = std::array::from_fn(|i| Facet::new(i as u32 + 1, 3));
        self.tets.push(Tet { vertices, mirrors, center, radius2 });
        for i in 0..4 {
            // The facet, turned so that a positive apex would lie beyond it.
            let (j, k, l) = super::facet::OTHERS[i][0];
            let slots = [j, k, l];
            let hull = [vertices[j], vertices[k], vertices[l], self.infinite()];
            // Opposite the vertex of slot s lies the infinite tet of the facet opposite that same vertex.
            let mirrors = std::array::from_fn(|s| {
                if s == 3 {
                    return Facet::new(0, i);
                }
                let other = slots[s];
                // There, the one vertex that this tet lacks is vertex i.
                let (j, k, l) = super::facet::OTHERS[other][0];
                let slot =
                    [j, k, l].iter().position(|&x| x == i).expect("i differs from other: this is a bug in tetcvt");
                Facet::new(other as u32 + 1, slot)
            });
            self.tets.push(Tet { vertices: hull, mirrors, center: DVec3::ZERO, radius2: f64::NAN });
        }
    }

    /// Inserts a vertex.
    fn insert(&mut self, vertex: u32, scratch: &mut Scratch) -> Result<(), Obstacle> {
        let start = self.locate(self.position(vertex)).ok_or(Obstacle::Duplicate)?;
        self.carve(start, vertex, scratch);
        self.fill(vertex, scratch)
    }

    /// The arrays of the result: vertices and facets of the tets that are alive, by least vertex. `names` gives each
    /// vertex its number in the result.
    #[inline(never)]
    pub fn finish(self, names: &[u32]) -> TetArrays {
        let infinite = self.infinite();
        let least = |t: &Tet| t.vertices.iter().fold(u32::MAX, |m, &v| m.min(v)) as usize;
        let mut starts = vec![0u32; self.sites.len() + 1];
        for tet in self.tets.iter().filter(|t| !t.is_dead()) {
            starts[least(tet) + 1] += 1;
        }
        for v in 1..starts.len() {
            starts[v] += starts[v - 1];
        }
        // From here on the scratch number of a tet is its place in the result.
        let alive = starts[starts.len() - 1] as usize;
        let mut places = vec![0u32; self.tets.len()];
        for (tet, place) in self.tets.iter().zip(&mut places).filter(|(t, _)| !t.is_dead()) {
            let start = &mut starts[least(tet)];
            *place = *start;
            *start += 1;
        }
        let mut vertices = vec![[0; 4]; alive];
        let mut neighbors = vec![[Facet::new(0, 0); 4]; alive];
        for (tet, &place) in self.tets.iter().zip(&places).filter(|(t, _)| !t.is_dead()) {
            vertices[place as usize] = tet.vertices.map(|v| if v == infinite { INFINITE } else { names[v as usize] });
            neighbors[place as usize] = tet.mirrors.map(|f| Facet::new(places[f.tet() as usize], f.slot()));
        }
        (vertices, neighbors)
    }
}

impl Delaunay {
    /// Builds from points in range.
    pub(super) fn construct(points: &[DVec3]) -> Result<TetArrays, DelaunayError> {
        let names = hilbert_order(points);
        let along_curve = names.iter().map(|&i| points[i as usize]);
        match Construction::of(along_curve) {
            Ok(construction) => Ok(construction.finish(&names)),
            Err(obstacle) => Err(DelaunayError::explain(obstacle, points)),
        }
    }
}
