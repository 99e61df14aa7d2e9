//! Whether a triangulation is the Delaunay triangulation: combinatorics, orientation, empty spheres.

use glam::DVec3;

use super::Delaunay;
use super::facet::{Facet, INFINITE};
use crate::geometry::predicates::{Sign, insphere_perturbed, orient3d};

impl Delaunay {
    /// Verifies that this is the Delaunay triangulation of its points; names the first violation.
    ///
    /// 1. The arrays fit, no tet has a vertex twice, the infinite vertex is in the last slot or nowhere.
    /// 2. Facets are mutual: both sides name each other and have the same three vertices, in opposite turns.
    /// 3. Every point is a vertex, and the whole is a 3-sphere as far as Euler's formula tells:
    ///    vertices - edges + facets - tets = 0, the infinite vertex included.
    /// 4. Every finite tet is positive; for every facet the perturbed sphere of one side excludes the apex of the other;
    ///    the hull is convex. Local tests suffice: Delaunay's lemma.
    pub fn check(&self) -> Result<(), String> {
        self.check_shape()?;
        for t in 0..self.vertices.len() as u32 {
            for i in 0..4 {
                self.check_mirror(t, i)?;
            }
        }
        self.check_euler()?;
        for t in 0..self.vertices.len() as u32 {
            self.check_tet(t)?;
        }
        Ok(())
    }

    fn check_shape(&self) -> Result<(), String> {
        if self.vertices.len() != self.neighbors.len() {
            return Err(format!("{} tets have neighbours of {}", self.vertices.len(), self.neighbors.len()));
        }
        let mut used = vec![false; self.points.len()];
        for (t, &tet) in self.vertices.iter().enumerate() {
            for (i, &v) in tet.iter().enumerate() {
                if tet[..i].contains(&v) {
                    return Err(format!("tet {t} = {tet:?} has vertex {v} twice"));
                }
                match used.get_mut(v as usize) {
                    Some(u) => *u = true,
                    None if v == INFINITE && i == 3 => {}
                    None => return Err(format!("tet {t} = {tet:?} has vertex {v} in slot {i}")),
                }
            }
        }
        match used.iter().position(|u| !u) {
            Some(v) => Err(format!("no tet has vertex {v}, at {}", self.points[v])),
            None => Ok(()),
        }
    }

    fn check_mirror(&self, t: u32, i: usize) -> Result<(), String> {
        let there = self.neighbors[t as usize][i];
        let here = Facet::new(t, i);
        let Some(&back) = self.neighbors.get(there.tet() as usize).map(|n| &n[there.slot()]) else {
            return Err(format!("facet {here:?} leads to {there:?}, past the last tet"));
        };
        if back != here {
            return Err(format!("facet {here:?} leads to {there:?}, but that to {back:?}"));
        }
        // The tet with its vertex i replaced by the apex across is turned around by one swap of two slots.
        let (a, b) = (self.vertices[t as usize], self.vertices[there.tet() as usize]);
        let mut glued = b;
        glued[there.slot()] = a[i];
        if a.iter().all(|v| glued.contains(v)) {
            let places = a.map(|v| glued.iter().position(|&w| w == v).unwrap_or(0));
            let inversions =
                (0..4).flat_map(|x| (x + 1..4).map(move |y| (x, y))).filter(|&(x, y)| places[x] > places[y]).count();
            if inversions % 2 == 1 {
                return Ok(());
            }
        }
        Err(format!("facet {here:?} of {a:?} and {there:?} of {b:?} are not one facet in opposite turns"))
    }

    fn check_euler(&self) -> Result<(), String> {
        let vertices = self.points.len() + 1;
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(6 * self.vertices.len());
        for tet in &self.vertices {
            for i in 0..4 {
                edges.extend(tet[..i].iter().map(|&v| [v.min(tet[i]), v.max(tet[i])]));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let tets = self.vertices.len();
        // Every facet belongs to two tets.
        if vertices + 2 * tets != edges.len() + tets {
            return Err(format!(
                "{vertices} vertices - {} edges + {} facets - {tets} tets is not 0",
                edges.len(),
                2 * tets
            ));
        }
        Ok(())
    }

    fn check_tet(&self, t: u32) -> Result<(), String> {
        let tet = self.vertices[t as usize];
        let at = |v: u32| self.points[v as usize];
        if tet[3] == INFINITE {
            return self.check_hull(t);
        }
        let corners = tet.map(at);
        let [a, b, c, d] = corners;
        if orient3d(a, b, c, d) != Sign::Positive {
            return Err(format!("tet {t} = {tet:?} is not positive"));
        }
        for i in 0..4 {
            let apex = self.apex(t, i);
            if apex == INFINITE {
                continue;
            }
            if insphere_perturbed(a, b, c, d, at(apex)) != Sign::Negative {
                return Err(format!("vertex {apex} is inside the sphere of tet {t} = {tet:?}"));
            }
        }
        Ok(())
    }

    /// A hull facet and its three neighbours along the hull: convex, and flat only where the circle of one excludes
    /// the other.
    fn check_hull(&self, t: u32) -> Result<(), String> {
        let tet = self.vertices[t as usize];
        let at = |v: u32| self.points[v as usize];
        let [a, b, c] = [at(tet[0]), at(tet[1]), at(tet[2])];
        let behind = self.apex(t, 3);
        if behind == INFINITE {
            return Err(format!("infinite tets lie on both sides of hull facet {tet:?}"));
        }
        for i in 0..3 {
            let other = self.apex(t, i);
            if other == INFINITE {
                return Err(format!("infinite tet {t} has the infinite vertex across facet {i}"));
            }
            let conflict = match orient3d(a, b, c, at(other)) {
                Sign::Positive => true,
                Sign::Negative => false,
                Sign::Zero => {
                    let finite: [DVec3; 4] = self.vertices[self.neighbor(t, 3) as usize].map(at);
                    insphere_perturbed(finite[0], finite[1], finite[2], finite[3], at(other)) == Sign::Positive
                }
            };
            if conflict {
                return Err(format!("hull facet {tet:?} is seen from vertex {other}"));
            }
        }
        Ok(())
    }

    /// The vertex beyond facet `i` of tet `t`.
    fn apex(&self, t: u32, i: usize) -> u32 {
        let across = self.neighbors[t as usize][i];
        self.vertices[across.tet() as usize][across.slot()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two tets on a triangle, and a point apart.
    fn sound() -> Delaunay {
        let points =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.1, 0.2, 1.0], [0.3, 0.1, -1.0], [2.0, 2.0, 2.0]];
        Delaunay::build(&points.map(DVec3::from_array)).expect("these points have tets")
    }

    fn complaint(spoil: impl Fn(&mut Delaunay)) -> String {
        let mut delaunay = sound();
        assert_eq!(delaunay.check(), Ok(()));
        spoil(&mut delaunay);
        delaunay.check().expect_err("spoilt")
    }

    #[test]
    fn each_kind_of_violation_is_named() {
        assert!(complaint(|d| d.vertices[0][0] = d.vertices[0][1]).contains("twice"));
        assert!(complaint(|d| d.vertices[0][0] = 77).contains("has vertex 77"));
        assert!(complaint(|d| d.points.push(DVec3::splat(9.0))).contains("no tet has vertex 6"));
        assert!(complaint(|d| d.neighbors[0].swap(0, 1)).contains("leads to"));
        let finite = |d: &Delaunay| d.vertices.iter().position(|t| t[3] != INFINITE).expect("there are finite tets");
        assert!(
            complaint(|d| {
                let t = finite(d);
                d.vertices[t].swap(0, 1);
            })
            .contains("opposite turns")
        );
        // A point moved into the tets: still a complex, no longer Delaunay.
        let moved = complaint(|d| d.points[5] = DVec3::new(0.2, 0.2, 0.1));
        assert!(moved.contains("not positive") || moved.contains("inside the sphere"), "{moved}");
        let hull = complaint(|d| d.points[5] = DVec3::new(0.3, 0.3, 0.4));
        assert!(["not positive", "inside the sphere", "is seen from"].iter().any(|s| hull.contains(s)), "{hull}");
    }
}
