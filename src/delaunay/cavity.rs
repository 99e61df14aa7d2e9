//! The conflict zone of a point, and the star that fills it.
//!
//! 1. Carve: spread over the tets in conflict with the point, and collect the facets around them.
//! 2. Number the new tets, one per facet, in place of those of the zone.
//! 3. Label the vertices around the cavity, so that what follows works on small tables.
//! 4. Glue: each new tet to the tet outside, and to the new tet across each edge of its facet.
//!
//! The steps are functions of their own, never inlined: it costs nothing, and profiles name them.

use glam::DVec3;

use super::facet::{Facet, OTHERS};
use super::insert::{Construction, Obstacle};
use super::locate::Conflict;
use super::tets::{DEAD, MARGIN, Spoke, Tet, sphere};

/// Most vertices of a cavity that the table of edges has room for.
const TABLE_SIDE: usize = 64;

/// Buffers of an insertion, used again by the next. A list with a length of its own is written past that length.
pub struct Scratch {
    /// Tets in conflict with the new point.
    zone: Vec<u32>,
    zone_len: usize,
    /// Facets between the zone and the rest.
    gates: Vec<Gate>,
    gates_len: usize,
    /// The same, made ready.
    rim: Vec<RimFacet>,
    /// Vertices of the cavity, relative to the new point, by label.
    spokes: Vec<Spoke>,
    spokes_len: usize,
    /// New tet and slot across each directed edge of the rim, by labels.
    edges: Box<[u16; TABLE_SIDE * TABLE_SIDE]>,
    /// Edges of a rim that is too large for the table.
    edge_list: Vec<(u64, Facet)>,
    /// Numbers of the new tets.
    ids: Vec<u32>,
    /// Counts insertions.
    stamp: u32,
}

impl Default for Scratch {
    fn default() -> Scratch {
        Scratch {
            zone: vec![0; 256],
            zone_len: 0,
            gates: vec![Gate::BLANK; 256],
            gates_len: 0,
            rim: Vec::new(),
            spokes: Vec::new(),
            spokes_len: 0,
            edges: Box::new([0; TABLE_SIDE * TABLE_SIDE]),
            edge_list: Vec::new(),
            ids: Vec::new(),
            stamp: 0,
        }
    }
}

/// A facet between the conflict zone and the rest, from both sides.
#[derive(Clone, Copy)]
struct Gate {
    inner: Facet,
    outer: Facet,
}

impl Gate {
    const BLANK: Gate = Gate { inner: Facet::BLANK, outer: Facet::BLANK };
}

/// A facet of the rim of a cavity, made ready for its new tet.
#[derive(Clone, Copy)]
struct RimFacet {
    /// The new tet: that of the zone, with the new point in place of the vertex opposite the facet.
    vertices: [u32; 4],
    /// Labels of the vertices but that of the new point.
    labels: [u32; 4],
    /// The facet as seen from outside.
    outer: Facet,
    /// Slot of the new point.
    slot: u32,
}

impl RimFacet {
    const BLANK: RimFacet = RimFacet { vertices: [0; 4], labels: [0; 4], outer: Facet::BLANK, slot: 0 };
}

impl Construction {
    /// Marks all tets in conflict with `vertex`, spreading from `start`, as dead, and collects the facets around them.
    ///
    /// The four neighbours of a tet are compared with the point before any of the answers is acted upon, so that their
    /// cache lines are fetched at once; and the lists are written without branches on the answers, which no
    /// processor can foresee.
    #[inline(never)]
    pub(super) fn carve(&mut self, start: u32, vertex: u32, scratch: &mut Scratch) {
        let p = self.position(vertex);
        let Scratch { zone, gates, .. } = scratch;
        self.tets[start as usize].radius2 = DEAD;
        zone[0] = start;
        let (mut done, mut found, mut walled) = (0, 1, 0);
        while done < found {
            let tet = zone[done];
            done += 1;
            if zone.len() < found + 4 {
                zone.resize(2 * zone.len(), 0);
            }
            if gates.len() < walled + 4 {
                gates.resize(2 * gates.len(), Gate::BLANK);
            }
            let (zone, gates) = (&mut zone[found..found + 4], &mut gates[walled..walled + 4]);
            let mirrors = self.tets[tet as usize].mirrors;
            let distances2 = mirrors.map(|f| (p - self.tets[f.tet() as usize].center).length_squared());
            let (mut inside_here, mut outside_here) = (0, 0);
            for slot in 0..4 {
                let outer = mirrors[slot];
                let next = &mut self.tets[outer.tet() as usize];
                let radius2 = next.radius2;
                let mut inside = distances2[slot] < radius2 * (1.0 - MARGIN);
                let dead = next.is_dead();
                let mut outside = !dead & (distances2[slot] > radius2 * (1.0 + MARGIN));
                next.radius2 = if inside { DEAD } else { radius2 };
                if !(inside | outside | dead) {
                    inside = self.conflict(outer.tet(), p) == Conflict::Yes;
                    outside = !inside;
                    if inside {
                        self.tets[outer.tet() as usize].radius2 = DEAD;
                    }
                }
                zone[inside_here & 3] = outer.tet();
                inside_here += usize::from(inside);
                gates[outside_here & 3] = Gate { inner: Facet::new(tet, slot), outer };
                outside_here += usize::from(outside);
            }
            found += inside_here;
            walled += outside_here;
        }
        scratch.zone_len = found;
        scratch.gates_len = walled;
    }

    /// Fills the cavity with tets from `vertex` to the facets of the rim.
    pub(super) fn fill(&mut self, vertex: u32, scratch: &mut Scratch) -> Result<(), Obstacle> {
        let p = self.position(vertex);
        self.number(scratch)?;
        self.label(vertex, scratch);
        if scratch.spokes_len <= TABLE_SIDE {
            self.glue_by_table(p, scratch);
        } else {
            self.glue_by_sorting(p, scratch);
        }
        Ok(())
    }

    /// Numbers the new tets: those of the zone first, then other dead ones, then new ones.
    #[inline(never)]
    fn number(&mut self, scratch: &mut Scratch) -> Result<(), Obstacle> {
        let wanted = scratch.gates_len;
        let zone = &scratch.zone[..scratch.zone_len];
        let (reused, spare) = zone.split_at(wanted.min(zone.len()));
        scratch.ids.clear();
        scratch.ids.extend_from_slice(reused);
        self.free.extend_from_slice(spare);
        while scratch.ids.len() < wanted {
            let id = match self.free.pop() {
                Some(id) => id,
                None => {
                    if self.tets.len() == Facet::MAX_TETS {
                        return Err(Obstacle::TooMany);
                    }
                    let mirrors = [Facet::BLANK; 4];
                    self.tets.push(Tet { vertices: [0; 4], mirrors, center: DVec3::ZERO, radius2: DEAD });
                    (self.tets.len() - 1) as u32
                }
            };
            scratch.ids.push(id);
        }
        Ok(())
    }

    /// Numbers the vertices of the rim, measures their spokes, and makes the facets of the rim ready.
    #[inline(never)]
    fn label(&mut self, vertex: u32, scratch: &mut Scratch) {
        let p = self.position(vertex);
        scratch.stamp += 1;
        let stamp = scratch.stamp;
        let gates = &scratch.gates[..scratch.gates_len];
        // A closed surface of f triangles has f / 2 + 2 vertices; one more is written but not counted.
        if scratch.spokes.len() < gates.len() + 4 {
            scratch.spokes.resize(2 * (gates.len() + 4), Spoke::new(p, p));
        }
        if scratch.rim.len() < gates.len() {
            scratch.rim.resize(2 * gates.len(), RimFacet::BLANK);
        }
        let mut count = 0;
        for (facet, gate) in scratch.rim.iter_mut().zip(gates) {
            // Fields are written where they stay: a copy assembled elsewhere would be read back before it is written.
            let tet = &self.tets[gate.inner.tet() as usize];
            let slot = gate.inner.slot();
            facet.vertices = tet.vertices;
            facet.vertices[slot] = vertex;
            facet.outer = gate.outer;
            facet.slot = slot as u32;
            for (j, _, _) in OTHERS[slot] {
                let site = &mut self.sites[tet.vertices[j] as usize];
                // Without a branch on whether the vertex is new: that cannot be foreseen.
                scratch.spokes[count] = Spoke::new(p, site.position);
                let fresh = site.stamp != stamp;
                let label = if fresh { count as u32 } else { site.label };
                (site.stamp, site.label) = (stamp, label);
                facet.labels[j] = label;
                count += usize::from(fresh);
            }
        }
        scratch.spokes_len = count;
    }

    /// Makes the new tets, glued along edges of the rim by a table over pairs of labels. Every directed edge of the rim is
    /// written before it is read, so the table is never cleared.
    #[inline(never)]
    fn glue_by_table(&mut self, p: DVec3, scratch: &mut Scratch) {
        let rim = &scratch.rim[..scratch.gates_len];
        for (n, facet) in rim.iter().enumerate() {
            for (j, k, l) in OTHERS[facet.slot as usize & 3] {
                let edge = facet.labels[k] as usize * TABLE_SIDE + facet.labels[l] as usize;
                scratch.edges[edge % (TABLE_SIDE * TABLE_SIDE)] = (n << 2 | j) as u16;
            }
        }
        let ids = &scratch.ids[..rim.len()];
        for (facet, &id) in rim.iter().zip(ids) {
            let mirrors = &mut self.complete(p, facet, id, &scratch.spokes).mirrors;
            for (j, k, l) in OTHERS[facet.slot as usize & 3] {
                let edge = facet.labels[l] as usize * TABLE_SIDE + facet.labels[k] as usize;
                let across = scratch.edges[edge % (TABLE_SIDE * TABLE_SIDE)];
                mirrors[j] = Facet::new(ids[usize::from(across >> 2)], usize::from(across & 3));
            }
        }
        self.last = self.finite_of(scratch.ids[0]);
    }

    /// As [`Construction::glue_by_table`], for cavities with many vertices.
    #[cold]
    fn glue_by_sorting(&mut self, p: DVec3, scratch: &mut Scratch) {
        let rim = &scratch.rim[..scratch.gates_len];
        scratch.edge_list.clear();
        for (n, facet) in rim.iter().enumerate() {
            self.complete(p, facet, scratch.ids[n], &scratch.spokes);
            for (j, k, l) in OTHERS[facet.slot as usize & 3] {
                let (a, b) = (u64::from(facet.labels[k]), u64::from(facet.labels[l]));
                scratch.edge_list.push((a.min(b) << 32 | a.max(b), Facet::new(scratch.ids[n], j)));
            }
        }
        scratch.edge_list.sort_unstable();
        // Every edge of the rim belongs to two facets.
        for pair in scratch.edge_list.chunks_exact(2) {
            debug_assert_eq!(pair[0].0, pair[1].0);
            for (here, there) in [(pair[0].1, pair[1].1), (pair[1].1, pair[0].1)] {
                self.tets[here.tet() as usize].mirrors[here.slot()] = there;
            }
        }
        self.last = self.finite_of(scratch.ids[0]);
    }

    /// Writes a new tet but for its facets on other new tets, and tells the tet outside of it.
    #[inline(always)]
    fn complete(&mut self, p: DVec3, facet: &RimFacet, id: u32, spokes: &[Spoke]) -> &mut Tet {
        let slot = facet.slot as usize & 3;
        let [a, b, c] = OTHERS[slot].map(|(j, _, _)| spokes[facet.labels[j] as usize]);
        self.tets[facet.outer.tet() as usize].mirrors[facet.outer.slot()] = Facet::new(id, slot);
        let tet = &mut self.tets[id as usize];
        (tet.center, tet.radius2) = sphere(p, a, b, c);
        tet.vertices = facet.vertices;
        tet.mirrors[slot] = facet.outer;
        tet
    }

    /// The tet itself if it is finite, else the finite tet behind its hull facet.
    fn finite_of(&self, tet: u32) -> u32 {
        let here = &self.tets[tet as usize];
        if here.vertices[3] == self.infinite() { here.mirrors[3].tet() } else { tet }
    }
}
