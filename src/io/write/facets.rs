//! Which tet a boundary triangle belongs to, and which of its facets it is.

use crate::geometry::tetrahedron::FACETS;
use crate::geometry::triangle::from_least;
use crate::tet_mesh::TetMesh;

/// For each boundary triangle the tet behind it and the corner of that tet that it lies opposite to.
pub(super) fn behind(mesh: &TetMesh) -> Vec<(u32, u8)> {
    let mut wanted: Vec<([u32; 3], u32)> = mesh.boundary.iter().map(|b| from_least(b.vertices)).zip(0..).collect();
    wanted.sort_unstable();
    let mut on_boundary = vec![false; mesh.points.len()];
    mesh.boundary.iter().flat_map(|b| b.vertices).for_each(|v| on_boundary[v as usize] = true);
    let mut found = vec![(u32::MAX, 0); mesh.boundary.len()];
    for (t, tet) in (0..).zip(&mesh.tets) {
        for (i, facet) in (0..).zip(FACETS) {
            let facet = facet.map(|k| tet[k]);
            if !facet.iter().all(|&v| on_boundary[v as usize]) {
                continue;
            }
            // Seen from this tet the facet turns as the triangle does; from the one in front it turns the other way.
            let key = from_least(facet);
            if let Ok(place) = wanted.binary_search_by_key(&key, |w| w.0) {
                found[wanted[place].1 as usize] = (t, i);
            }
        }
    }
    found
}
