//! Tets that nothing helped: they need not be tried again until something changes at their vertices. What changes farther away
//! hardly ever helps, and where many tets are stuck, as in thin walls, something always does.

use super::complex::Complex;

/// For each tet, by slot, one more than the commits there were when nothing helped it; 0 where that is not known.
#[derive(Clone, Debug, Default)]
pub(super) struct Hopeless {
    since: Vec<u32>,
}

impl Hopeless {
    /// Notes that nothing helped a tet.
    pub(super) fn add(&mut self, complex: &Complex, t: u32) {
        self.since.resize(complex.tets.len(), 0);
        self.since[t as usize] = complex.commits() + 1;
    }

    /// Whether nothing helped a tet and nothing changed at its vertices since.
    pub(super) fn has(&self, complex: &Complex, t: u32) -> bool {
        let since = self.since.get(t as usize).copied().unwrap_or(0);
        since > 0 && !complex.tets[t as usize].into_iter().any(|v| complex.changed_at(v, since - 1))
    }

    /// Lets every tet be tried again.
    pub(super) fn clear(&mut self) {
        self.since.clear();
    }
}
