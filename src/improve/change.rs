//! A change of some tets and boundary facets for others, worked out before it is made.

use super::complex::{Complex, Facet};

/// What goes and what comes.
#[derive(Clone, Debug, Default)]
pub(super) struct Change {
    pub old_tets: Vec<u32>,
    /// With their qualities.
    pub new_tets: Vec<([u32; 4], f64)>,
    pub old_facets: Vec<u32>,
    pub new_facets: Vec<Facet>,
    /// The least quality among the new tets.
    pub worst: f64,
}

impl Change {
    /// Nothing.
    pub(super) fn clear(&mut self) {
        self.old_tets.clear();
        self.new_tets.clear();
        self.old_facets.clear();
        self.new_facets.clear();
        self.worst = f64::INFINITY;
    }

    /// Makes the change.
    pub(super) fn apply(&self, complex: &mut Complex) {
        self.old_tets.iter().for_each(|&t| complex.remove_tet(t));
        self.old_facets.iter().for_each(|&f| complex.remove_facet(f));
        for &(tet, quality) in &self.new_tets {
            complex.add_tet(tet, quality);
        }
        self.new_facets.iter().for_each(|&f| complex.add_facet(f));
    }
}
