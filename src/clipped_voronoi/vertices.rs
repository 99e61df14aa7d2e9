//! Which vertices of the surface the triangles of one seed have, so that each is looked at once.

use glam::DVec3;

/// The corners of the triangles of one seed, each once.
#[derive(Default)]
pub(super) struct Vertices {
    /// Their numbers on the sheet.
    ids: Vec<u32>,
    pub(super) at: Vec<DVec3>,
    pub(super) from_seed: Vec<DVec3>,
    pub(super) owners: Vec<u32>,
    /// For each vertex of the sheet, where it is in these, if it is.
    place: Vec<u32>,
}

impl Vertices {
    /// None, of a sheet with so many vertices.
    pub(super) fn new(count: usize) -> Vertices {
        Vertices { place: vec![0; count], ..Vertices::default() }
    }

    /// Takes all out.
    pub(super) fn clear(&mut self) {
        self.ids.clear();
        self.at.clear();
        self.from_seed.clear();
        self.owners.clear();
    }

    /// The place of vertex `v` of the sheet, which is added where it is not there; with its position, its owner, and the position
    /// of the seed.
    #[inline]
    pub(super) fn add(&mut self, v: u32, at: DVec3, owner: u32, seed: DVec3) -> u32 {
        let place = self.place[v as usize];
        if self.ids.get(place as usize) == Some(&v) {
            return place;
        }
        let place = self.ids.len() as u32;
        self.place[v as usize] = place;
        self.ids.push(v);
        self.owners.push(owner);
        self.at.push(at);
        self.from_seed.push(at - seed);
        place
    }
}
