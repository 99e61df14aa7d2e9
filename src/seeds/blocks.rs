//! Which blocks of space lie whole inside or whole outside a surface, so that only points near it need an exact test.
//!
//! Blocks that meet the bounding box of a triangle are mixed. The others fall into pieces joined by faces, which the
//! surface does not cut: one inside test answers for a whole piece.

use glam::DVec3;

use crate::geometry::bounding_box::BoundingBox;
use crate::surface::Surface;

/// Blocks at most.
const MOST: f64 = 2e7;

/// What is known of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Unknown,
    Mixed,
    Inside,
    Outside,
}

/// Blocks over the bounding box of a surface.
pub(super) struct Blocks {
    origin: DVec3,
    edge: f64,
    counts: [usize; 3],
    sides: Vec<Side>,
}

impl Blocks {
    /// Blocks with edges of about `edge`, larger where there would be too many.
    pub(super) fn new(surface: &Surface, bounds: &BoundingBox, edge: f64) -> Blocks {
        let extent = bounds.extent();
        let edge = edge.max((extent.element_product() / MOST).cbrt()).max(extent.max_element() / 4096.0);
        let counts = extent.to_array().map(|e| (e / edge) as usize + 1);
        let sides = vec![Side::Unknown; counts.iter().product()];
        let mut blocks = Blocks { origin: bounds.min, edge, counts, sides };
        for t in 0..surface.triangles().len() as u32 {
            let b = BoundingBox::of(surface.corners(t).iter());
            // A margin far above the rounding of the division.
            let (low, high) = (blocks.at(b.min - 1e-9 * edge), blocks.at(b.max + 1e-9 * edge));
            for z in low[2]..=high[2] {
                for y in low[1]..=high[1] {
                    let row = blocks.index([low[0], y, z]);
                    blocks.sides[row..=row + high[0] - low[0]].fill(Side::Mixed);
                }
            }
        }
        blocks.flood(surface);
        blocks
    }

    /// Whether `p` is inside, exactly.
    pub(super) fn is_inside(&self, surface: &Surface, p: DVec3) -> bool {
        match self.sides[self.index(self.at(p))] {
            Side::Inside => true,
            Side::Outside => false,
            Side::Mixed | Side::Unknown => surface.is_inside(p),
        }
    }

    fn flood(&mut self, surface: &Surface) {
        let steps = [1, self.counts[0], self.counts[0] * self.counts[1]];
        let mut stack = Vec::new();
        for start in 0..self.sides.len() {
            if self.sides[start] != Side::Unknown {
                continue;
            }
            let inside = surface.is_inside(self.center(start));
            let side = if inside { Side::Inside } else { Side::Outside };
            self.sides[start] = side;
            stack.push(start);
            while let Some(i) = stack.pop() {
                let at = [i % steps[1], i / steps[1] % self.counts[1], i / steps[2]];
                for axis in 0..3 {
                    let low = (at[axis] > 0).then(|| i - steps[axis]);
                    let high = (at[axis] + 1 < self.counts[axis]).then(|| i + steps[axis]);
                    for next in low.into_iter().chain(high) {
                        if self.sides[next] == Side::Unknown {
                            self.sides[next] = side;
                            stack.push(next);
                        }
                    }
                }
            }
        }
    }

    fn center(&self, i: usize) -> DVec3 {
        let (x, rest) = (i % self.counts[0], i / self.counts[0]);
        let (y, z) = (rest % self.counts[1], rest / self.counts[1]);
        self.origin + self.edge * (DVec3::new(x as f64, y as f64, z as f64) + 0.5)
    }

    /// The block of `p`; that of the nearest point of the box if it is outside.
    fn at(&self, p: DVec3) -> [usize; 3] {
        let c = (p - self.origin) / self.edge;
        std::array::from_fn(|k| (c[k].max(0.0) as usize).min(self.counts[k] - 1))
    }

    fn index(&self, at: [usize; 3]) -> usize {
        at[0] + self.counts[0] * (at[1] + self.counts[1] * at[2])
    }
}
