//! The conflict zone of a point, and the star that fills it.

use glam::DVec3;

use super::facet::{Facet, OTHERS};
use super::insert::{Construction, Obstacle};
use super::locate::Conflict;
use super::tets::{DEAD, Side, Spoke, Tet, sphere};

/// Most vertices of a cavity that the table of edges has room for.
const TABLE_SIDE: usize = 64;

/// Buffers of an insertion, used again by the next.
pub struct Scratch {
    /// Tets in conflict with the new point.
    zone: Vec<u32>,
    /// Facets between the zone and the rest.
    rim: Vec<RimFacet>,
    /// Vertices of the cavity, relative to the new point.
    spokes: Vec<Spoke>,
    /// New tet and slot across each directed edge of the rim, by labels.
    edges: Box<[u16; TABLE_SIDE * TABLE_SIDE]>,
    /// Edges of a rim that is too large for the table.
    edge_list: Vec<(u64, u32)>,
    /// Numbers of the new tets.
    ids: Vec<u32>,
    /// Counts insertions.
    stamp: u32,
}

impl Default for Scratch {
    fn default() -> Scratch {
        Scratch {
            zone: Vec::new(),
            rim: Vec::new(),
            spokes: Vec::new(),
            edges: Box::new([0; TABLE_SIDE * TABLE_SIDE]),
            edge_list: Vec::new(),
            ids: Vec::new(),
            stamp: 0,
        }
    }
}

/// A facet of the rim of a cavity.
#[derive(Clone, Copy)]
struct RimFacet {
    /// The new tet: that of the zone, with the new point in place of the vertex opposite the facet.
    vertices: [u32; 4],
    /// The facet as seen from outside.
    outer: Facet,
    /// Slot of the new point.
    slot: u32,
    /// Labels of the vertices but that of the new point.
    labels: [u32; 4],
}

impl Construction {
    /// Marks all tets in conflict with `vertex`, spreading from `start`, as dead, and collects the rim.
    pub(super) fn carve(&mut self, start: u32, vertex: u32, scratch: &mut Scratch) {
        let p = self.position(vertex);
        let Scratch { zone, rim, .. } = scratch;
        zone.clear();
        rim.clear();
        self.tets[start as usize].radius2 = DEAD;
        zone.push(start);
        let mut done = 0;
        while done < zone.len() {
            let tet = zone[done];
            done += 1;
            let Tet { vertices, mirrors, .. } = self.tets[tet as usize];
            for slot in 0..4 {
                let outer = mirrors[slot];
                let next = &self.tets[outer.tet() as usize];
                if next.is_dead() {
                    continue;
                }
                let inside = match next.side(p) {
                    Side::Inside => true,
                    Side::Outside => false,
                    Side::Unknown => self.conflict(outer.tet(), p) == Conflict::Yes,
                };
                if inside {
                    self.tets[outer.tet() as usize].radius2 = DEAD;
                    zone.push(outer.tet());
                } else {
                    let mut vertices = vertices;
                    vertices[slot] = vertex;
                    rim.push(RimFacet { vertices, outer, slot: slot as u32, labels: [0; 4] });
                }
            }
        }
    }

    /// Fills the cavity with tets from `vertex` to the facets of the rim.
    pub(super) fn fill(&mut self, vertex: u32, scratch: &mut Scratch) -> Result<(), Obstacle> {
        let p = self.position(vertex);
        self.number(scratch)?;
        self.label(p, scratch);
        if scratch.spokes.len() <= TABLE_SIDE {
            self.glue_by_table(p, scratch);
        } else {
            self.glue_by_sorting(p, scratch);
        }
        Ok(())
    }

    /// Numbers the new tets: those of the zone first, then other dead ones, then new ones.
    fn number(&mut self, scratch: &mut Scratch) -> Result<(), Obstacle> {
        let wanted = scratch.rim.len();
        scratch.ids.clear();
        let reused = wanted.min(scratch.zone.len());
        scratch.ids.extend_from_slice(&scratch.zone[..reused]);
        self.free.extend_from_slice(&scratch.zone[reused..]);
        while scratch.ids.len() < wanted {
            let id = match self.free.pop() {
                Some(id) => id,
                None => {
                    if self.tets.len() == Facet::MAX_TETS {
                        return Err(Obstacle::TooMany);
                    }
                    let blank = Facet::new(0, 0);
                    self.tets.push(Tet { vertices: [0; 4], mirrors: [blank; 4], center: DVec3::ZERO, radius2: DEAD });
                    (self.tets.len() - 1) as u32
                }
            };
            scratch.ids.push(id);
        }
        Ok(())
    }

    /// Numbers the vertices of the rim, and measures their spokes.
    fn label(&mut self, p: DVec3, scratch: &mut Scratch) {
        scratch.spokes.clear();
        scratch.stamp += 1;
        for facet in &mut scratch.rim {
            for (j, _, _) in OTHERS[facet.slot as usize & 3] {
                let site = &mut self.sites[facet.vertices[j] as usize];
                if site.stamp != scratch.stamp {
                    site.stamp = scratch.stamp;
                    site.label = scratch.spokes.len() as u32;
                    scratch.spokes.push(Spoke::new(p, site.position));
                }
                facet.labels[j] = site.label;
            }
        }
    }

    /// Makes the new tets, glued along edges of the rim by a table over pairs of labels. Every directed edge of the rim is
    /// written before it is read, so the table is never cleared.
    fn glue_by_table(&mut self, p: DVec3, scratch: &mut Scratch) {
        for (n, facet) in scratch.rim.iter().enumerate() {
            for (j, k, l) in OTHERS[facet.slot as usize & 3] {
                let edge = facet.labels[k] as usize * TABLE_SIDE + facet.labels[l] as usize;
                scratch.edges[edge % (TABLE_SIDE * TABLE_SIDE)] = (n << 2 | j) as u16;
            }
        }
        for (n, facet) in scratch.rim.iter().enumerate() {
            let id = scratch.ids[n];
            let slot = facet.slot as usize & 3;
            let mut mirrors = [facet.outer; 4];
            for (j, k, l) in OTHERS[slot] {
                let edge = facet.labels[l] as usize * TABLE_SIDE + facet.labels[k] as usize;
                let across = scratch.edges[edge % (TABLE_SIDE * TABLE_SIDE)];
                mirrors[j] = Facet::new(scratch.ids[usize::from(across >> 2)], usize::from(across & 3));
            }
            self.complete(p, facet, id, mirrors, &scratch.spokes);
        }
        self.last = self.finite_of(scratch.ids[0]);
    }

    /// As [`Construction::glue_by_table`], for cavities with many vertices.
    #[cold]
    fn glue_by_sorting(&mut self, p: DVec3, scratch: &mut Scratch) {
        scratch.edge_list.clear();
        for (n, facet) in scratch.rim.iter().enumerate() {
            for (j, k, l) in OTHERS[facet.slot as usize & 3] {
                let (a, b) = (u64::from(facet.labels[k]), u64::from(facet.labels[l]));
                scratch.edge_list.push((a.min(b) << 32 | a.max(b), (n << 2 | j) as u32));
            }
        }
        scratch.edge_list.sort_unstable();
        // Every edge of the rim belongs to two facets.
        for pair in scratch.edge_list.chunks_exact(2) {
            debug_assert_eq!(pair[0].0, pair[1].0);
        }
        let mut mirrors: Vec<[Facet; 4]> = scratch.rim.iter().map(|f| [f.outer; 4]).collect();
        for pair in scratch.edge_list.chunks_exact(2) {
            let [a, b] = [pair[0].1, pair[1].1];
            for (from, to) in [(a, b), (b, a)] {
                mirrors[from as usize >> 2][from as usize & 3] =
                    Facet::new(scratch.ids[to as usize >> 2], to as usize & 3);
            }
        }
        for (n, facet) in scratch.rim.iter().enumerate() {
            self.complete(p, facet, scratch.ids[n], mirrors[n], &scratch.spokes);
        }
        self.last = self.finite_of(scratch.ids[0]);
    }

    /// Writes a new tet, and tells the tet outside of it.
    #[inline(always)]
    fn complete(&mut self, p: DVec3, facet: &RimFacet, id: u32, mirrors: [Facet; 4], spokes: &[Spoke]) {
        let slot = facet.slot as usize & 3;
        let [a, b, c] = OTHERS[slot].map(|(j, _, _)| spokes[facet.labels[j] as usize]);
        let (center, radius2) = sphere(p, a, b, c);
        self.tets[id as usize] = Tet { vertices: facet.vertices, mirrors, center, radius2 };
        self.tets[facet.outer.tet() as usize].mirrors[facet.outer.slot()] = Facet::new(id, slot);
    }

    /// The tet itself if it is finite, else the finite tet behind its hull facet.
    fn finite_of(&self, tet: u32) -> u32 {
        let here = &self.tets[tet as usize];
        if here.vertices[3] == self.infinite() { here.mirrors[3].tet() } else { tet }
    }
}
