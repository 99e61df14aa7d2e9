//! How many seeds of each kind: one spacing, a total of exactly N.
//!
//! With edges of length h everywhere, measured as the mean over relaxed seeds,
//!
//! - a crease of length L has L / h edges;
//! - a surface seed has the hexagon of a triangular lattice, 0.866 h^2, and curve and corner seeds their share of it;
//! - an interior seed has the cell of a body-centred cubic lattice, whose 14 neighbours are 1.163 v^(1/3) away in the
//!   mean: v = 0.6357 h^3;
//! - the seeds on the surface own a layer of depth 0.2 h under it. (Between two parallel planes of seeds, relaxed, mean
//!   edges are then 1.01 h on the planes, 1.00 h inside and 1.03 h between the two; another depth moves the last two up
//!   or down together.) What lies deeper follows from Steiner's formula.
//!
//! Where sizes vary, h is the largest and s the size over it: volume, area and length count s^-3, s^-2 and s^-1 times, and
//! the formulas stay as they are.
//!
//! Where walls are thin the surface is sampled more finely (see `thickness`): h is then solved again, so that the seeds
//! come from elsewhere.

use glam::DVec3;

use super::curves::{self, CurveNeed};
use super::knots::{self, Closeness, Knot};
use crate::sizing::Sizing;
use crate::surface::features::Features;
use crate::surface::{Surface, edges};

/// Area of a surface seed's cell over h^2.
const HEXAGON: f64 = 0.866_025_403_784_438_6;
/// Volume of an interior seed's cell over h^3.
pub(super) const CELL: f64 = 0.6357;
/// Depth of the layer that the seeds on the surface own, over h.
const LAYER: f64 = 0.2;
/// Where seeds are scarce, spacings at thin walls may exceed what is safe by this factor.
const STRETCH: f64 = 2.5;
/// The spacing exceeds that below which thin walls were sought by this factor at most.
const WIDENING: f64 = 2.0;
/// Of what corners leave, the share that curves may take for the sake of following their bends.
const MOST_ON_CURVES: f64 = 0.5;
/// No spacing is more than so many diagonals of the surface's box.
const COARSEST: f64 = 8.0;
/// A solid with fewer seeds inside than this share of those on its surface is all sheets thinner than the spacing.
const ROOM: f64 = 0.2;
/// Seeds without which a shell is no closed surface.
const PER_SHELL: usize = 4;

/// What is measured once.
#[derive(Clone)]
pub(super) struct Demand<'a> {
    surface: &'a Surface,
    features: &'a Features,
    /// Sizes over the largest, at each vertex.
    relative: Vec<f64>,
    needs: Vec<CurveNeed>,
    /// Corners that are kept.
    corners: Vec<u32>,
    /// Volume, area, integral of mean curvature and of half the Gaussian curvature, each times its power of the relative
    /// sizes: Steiner's coefficients.
    steiner: [f64; 4],
    /// The area, times the inverse square of the relative sizes.
    area: f64,
    /// Cells' worth of area around the corners that creases reach.
    corner_cells: f64,
    /// The same for the tips of cones, which no crease reaches.
    tip_cells: f64,
    /// Seeds that each shell needs beside its corners and the least of its curves.
    shell_least: Vec<usize>,
    /// The largest spacing allowed at each vertex; infinite where nothing is thin.
    limits: Vec<f64>,
    /// The triangles with a limit at a vertex, ascending.
    thin: Vec<u32>,
    /// The spacing below which limits were sought.
    sought: f64,
}

/// How fine the mesh is to be.
#[derive(Clone, Copy, Debug)]
pub(super) enum Size {
    /// So many vertices.
    Count(usize),
    /// Edges of this length, in the frame.
    Length(f64),
}

/// The size and the counts that follow from it.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// Edge length where nothing is thin.
    pub(super) spacing: f64,
    /// Edge length at each of the surface's vertices.
    pub(super) sizes: Vec<f64>,
    /// Where each curve has its seeds, corners not counted.
    pub(super) curves: Vec<Vec<Knot>>,
    /// Seeds on the surface, off its creases.
    pub(super) surface: usize,
    /// Seeds inside.
    pub(super) interior: usize,
    /// Whether spacings at thin walls exceed their limits.
    pub(super) is_stretched: bool,
}

/// Too few seeds: how many would do, what cannot be kept, and the vertex where.
#[derive(Clone, Debug)]
pub(super) struct Shortage {
    pub(super) needed: usize,
    /// Whether thin walls are the cause.
    pub(super) thin: bool,
    pub(super) reason: String,
    pub(super) vertex: u32,
}

impl<'a> Demand<'a> {
    /// Measures `surface` for a mesh of so many vertices, or of edges of such a length; no limit is set yet.
    pub(super) fn measure(
        surface: &'a Surface,
        features: &'a Features,
        sizing: Option<&Sizing>,
        target: Size,
    ) -> Demand<'a> {
        let at = |&p: &DVec3| sizing.map_or(1.0, |s| s.relative(p));
        let relative: Vec<f64> = surface.points().iter().map(at).collect();
        let mut demand = Demand {
            surface,
            features,
            steiner: steiner(surface, sizing, &relative),
            area: weighted_area(surface, &relative),
            relative,
            needs: Vec::new(),
            corners: Vec::new(),
            corner_cells: 0.0,
            tip_cells: 0.0,
            shell_least: Vec::new(),
            limits: vec![f64::INFINITY; surface.points().len()],
            thin: Vec::new(),
            sought: COARSEST * surface.diagonal(),
        };
        let spacing = match target {
            Size::Length(h) => h,
            Size::Count(n) => demand.plain_spacing(n),
        };
        let has_room = demand.interior_wanted(spacing) > ROOM * demand.area / (HEXAGON * spacing * spacing);
        (demand.needs, demand.corners) =
            curves::needs(surface, features, has_room, |v| spacing * demand.relative[v as usize]);
        let mut on_crease: Vec<u32> = features.curves.iter().flat_map(|c| c.vertices.iter().copied()).collect();
        on_crease.sort_unstable();
        let (reached, tips): (Vec<u32>, Vec<u32>) =
            demand.corners.iter().partition(|&v| on_crease.binary_search(v).is_ok());
        demand.corner_cells = corner_cells(surface, &reached);
        demand.tip_cells = corner_cells(surface, &tips);
        demand.shell_least = demand.shell_deficits();
        demand
    }

    /// The spacing of `count` seeds if there were neither creases nor thin walls.
    pub(super) fn plain_spacing(&self, count: usize) -> f64 {
        let coarsest = self.widest();
        let plain = |h: f64| self.surface.area() / (HEXAGON * h * h) + self.interior_wanted(h);
        bisect(1e-6 * coarsest, coarsest, |h| plain(h) > count as f64)
    }

    /// Whether one size is asked for everywhere.
    pub(super) fn is_even(&self) -> bool {
        self.relative.iter().all(|&r| r == 1.0)
    }

    /// The corners that are kept.
    pub(super) fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Lowers the largest spacing allowed at each vertex to `limits`, sought below the spacing `sought`. Limits found before
    /// stay: those sought below a smaller spacing tell more of what is very thin.
    pub(super) fn limit(&mut self, limits: &[f64], sought: f64) {
        self.limits.iter_mut().zip(limits).for_each(|(old, new)| *old = old.min(*new));
        let is_thin = |t: &[u32; 3]| t.iter().any(|&v| self.limits[v as usize] < f64::INFINITY);
        self.thin.clear();
        self.thin.extend((0..).zip(self.surface.triangles()).filter(|(_, t)| is_thin(t)).map(|(t, _)| t));
        self.sought = sought;
    }

    /// The needs of the curves.
    pub(super) fn needs(&self) -> &[CurveNeed] {
        &self.needs
    }

    /// For each crease, whether the mesh is to have it whole.
    pub(super) fn whole(&self) -> Vec<bool> {
        self.needs.iter().map(|n| n.whole).collect()
    }

    /// Seeds of kind surface that each shell must get.
    pub(super) fn shell_least(&self) -> &[usize] {
        &self.shell_least
    }

    /// Vertices that a mesh with edges of length h has.
    pub(super) fn total(&self, h: f64, stretch: f64) -> f64 {
        let curves = self.curves_wanted(h, stretch).iter().sum();
        self.total_with(h, stretch, curves)
    }

    /// The same with so many seeds on curves.
    fn total_with(&self, h: f64, stretch: f64, curves: f64) -> f64 {
        let surface = self.surface_wanted(h, stretch, curves);
        self.corners.len() as f64 + curves + surface + self.interior_wanted(h)
    }

    /// The plan for exactly `count` seeds.
    ///
    /// Where walls are too thin for that, the shortage knows of limits down to [`super::thickness::FLOOR`] only.
    pub(super) fn plan(&self, count: usize) -> Result<Plan, Shortage> {
        self.refuse_hopeless(count)?;
        let n = count as f64;
        let (stretch, coarsest) = self.stretch(n)?;
        let h = bisect(1e-6 * coarsest, coarsest, |h| self.total(h, stretch) > n);
        let curves = self.place_on_curves(count, h, stretch);
        let on_curves: usize = curves.iter().map(Vec::len).sum();
        // Curves that bend take more seeds than their length says, and leave fewer for the rest.
        let h = bisect(h, coarsest, |h| self.total_with(h, stretch, on_curves as f64) > n);
        let sizes = self.sizes(h, stretch);
        // Where every place is thin, the spacing is that of the least thin.
        let spacing = sizes.iter().zip(&self.relative).map(|(s, r)| s / r).fold(0.0, f64::max);
        let left = count - self.corners.len() - on_curves;
        let shell_least: usize = self.shell_least.iter().sum();
        let surface = self.surface_wanted(spacing, stretch, on_curves as f64);
        let interior = self.interior_wanted(spacing);
        let share = if surface + interior > 0.0 { surface / (surface + interior) } else { 1.0 };
        let surface = if interior < 0.5 { left } else { (share * left as f64).round() as usize };
        let surface = surface.clamp(shell_least, left);
        Ok(Plan { spacing, sizes, curves, surface, interior: left - surface, is_stretched: stretch > 1.0 })
    }

    /// By how much spacings at thin walls exceed their limits for n vertices, and the largest spacing elsewhere. Where seeds are
    /// scarce, walls are stretched before the rest is coarser than it would be without walls.
    fn stretch(&self, n: f64) -> Result<(f64, f64), Shortage> {
        let widest = self.widest();
        if self.total(WIDENING * self.sought, 1.0) <= n {
            Ok((1.0, WIDENING * self.sought))
        } else if self.total(self.sought, STRETCH) <= n {
            Ok((bisect(1.0, STRETCH, |s| self.total(self.sought, s) > n), self.sought))
        } else if self.total(widest, STRETCH) <= n {
            Ok((STRETCH, widest))
        } else {
            Err(self.thin_shortage())
        }
    }

    /// No spacing is more.
    fn widest(&self) -> f64 {
        COARSEST * self.surface.diagonal()
    }

    /// The count that edges of length h need.
    pub(super) fn count_for(&self, h: f64) -> f64 {
        let least = self.corners.len() + self.least_of_curves() + self.shell_least.iter().sum::<usize>();
        self.total(h, 1.0).round().max(least.max(4) as f64)
    }

    /// The spacing at vertex `v`, where the largest is h.
    fn size(&self, v: u32, h: f64, stretch: f64) -> f64 {
        (stretch * self.limits[v as usize]).min(h * self.relative[v as usize])
    }

    fn sizes(&self, h: f64, stretch: f64) -> Vec<f64> {
        (0..self.limits.len() as u32).map(|v| self.size(v, h, stretch)).collect()
    }

    /// The sizes where nothing is thin, for the largest h.
    pub(super) fn plain_sizes(&self, h: f64) -> Vec<f64> {
        self.relative.iter().map(|r| h * r).collect()
    }

    fn least_of_curves(&self) -> usize {
        self.needs.iter().map(|n| n.least).sum()
    }

    fn curves_wanted(&self, h: f64, stretch: f64) -> Vec<f64> {
        let spacing = |v: u32| self.size(v, h, stretch);
        let wanted = |(c, n): (_, &CurveNeed)| n.wanted(curves::steps(c, spacing));
        self.features.curves.iter().zip(&self.needs).map(wanted).collect()
    }

    /// Cells' worth of area that `on_curves` seeds of creases and the corners cover: one each, but no more than a band
    /// along the creases, where corners crowd.
    fn covered(&self, h: f64, stretch: f64, on_curves: f64) -> f64 {
        let spacing = |v: u32| self.size(v, h, stretch);
        let kept = self.features.curves.iter().zip(&self.needs).filter(|(_, n)| n.kept);
        let band: f64 = kept.map(|(c, _)| curves::steps(c, spacing)).sum();
        self.tip_cells + (on_curves + self.corner_cells).min(band)
    }

    fn surface_wanted(&self, h: f64, stretch: f64, on_curves: f64) -> f64 {
        let mut cells = 0.0;
        let mut plain = self.area;
        for &t in &self.thin {
            let v = self.surface.triangles()[t as usize];
            let relative = v.map(|v| self.relative[v as usize]);
            if v.iter().zip(relative).all(|(&v, r)| stretch * self.limits[v as usize] >= h * r) {
                continue;
            }
            let area = 0.5 * self.surface.normal2(t).length();
            plain -= area * mean_inverse_square(relative);
            cells += area * mean_inverse_square(v.map(|v| self.size(v, h, stretch))) / HEXAGON;
        }
        cells += plain.max(0.0) / (HEXAGON * h * h);
        let least: usize = self.shell_least.iter().sum();
        (cells - self.covered(h, stretch, on_curves)).max(least as f64)
    }

    /// Volume deeper than the surface's own layer over the volume of a cell.
    fn interior_wanted(&self, h: f64) -> f64 {
        let [volume, area, mean, gauss] = self.steiner;
        let at = |d: f64| volume - d * (area - d * (mean - d * gauss));
        // The formula ends where the layers of opposite walls meet, at the latest where it stops falling.
        let turn = if mean > 0.0 { area / (2.0 * mean) } else { f64::INFINITY };
        let depth = LAYER * h;
        if depth >= turn { 0.0 } else { (at(depth).max(0.0)).min(volume) / (CELL * h * h * h) }
    }

    /// Places for the seeds of all curves, where the spacing is h: as the curves bend, or evenly where so many would be more
    /// than `count` allows.
    fn place_on_curves(&self, count: usize, h: f64, stretch: f64) -> Vec<Vec<Knot>> {
        let spacing = |v: u32| self.size(v, h, stretch);
        let points = self.surface.points();
        let room = count - self.corners.len() - self.shell_least.iter().sum::<usize>();
        let wanted = self.curves_wanted(h, stretch);
        let bent = |(i, need): (usize, &CurveNeed)| {
            let curve = &self.features.curves[i];
            if !need.kept {
                return Vec::new();
            }
            let both = |v: u32| [spacing(v), h * self.relative[v as usize]];
            let knots = knots::knots(curve, need.closed, Closeness::of(need.whole), points, both);
            // A short one may need more seeds than follow from its length, to be itself.
            let even = wanted[i].round() as usize;
            if knots.len() < need.least.max(even.min(1)) {
                return curves::even(curve, need.closed, even, spacing);
            }
            knots
        };
        let placed: Vec<Vec<Knot>> = self.needs.iter().enumerate().map(bent).collect();
        if placed.iter().map(Vec::len).sum::<usize>() as f64 <= MOST_ON_CURVES * room as f64 {
            return placed;
        }
        let even = |(i, n): (usize, usize)| curves::even(&self.features.curves[i], self.needs[i].closed, n, spacing);
        self.whole_counts(room, &wanted).into_iter().enumerate().map(even).collect()
    }

    /// Rounds the wanted counts of the curves, to no more than `room` in all.
    fn whole_counts(&self, room: usize, wanted: &[f64]) -> Vec<usize> {
        let mut curves: Vec<usize> = wanted.iter().map(|w| w.round() as usize).collect();
        // Rounding, or too few seeds: the crease that is sampled most finely for its length gives one up.
        let mut total: usize = curves.iter().sum();
        while total > room {
            let slack = |i: &usize| curves[*i] > self.needs[*i].least;
            let excess = |i: usize| curves[i] as f64 / (wanted[i] + 1.0);
            let most = (0..curves.len()).filter(slack).max_by(|&a, &b| excess(a).total_cmp(&excess(b)));
            let most = most.expect("the least of the curves fits: this is a bug in tetcvt");
            curves[most] -= 1;
            total -= 1;
        }
        curves
    }

    /// What no spacing brings below `count`: corners, the least of the curves, four seeds on each shell.
    fn refuse_hopeless(&self, count: usize) -> Result<(), Shortage> {
        let corners = self.corners.len();
        let least = corners + self.least_of_curves() + self.shell_least.iter().sum::<usize>();
        if least <= count {
            return Ok(());
        }
        if count < corners {
            let reason = format!("{corners} corners cannot all be kept");
            return Err(Shortage { needed: least, thin: false, reason, vertex: self.corners[count] });
        }
        let mut used = corners;
        for (c, n) in self.features.curves.iter().zip(&self.needs) {
            used += n.least;
            if used > count {
                let reason = format!("{corners} corners and {} creases cannot all be kept", self.needs.len());
                return Err(Shortage { needed: least, thin: false, reason, vertex: c.vertices[c.vertices.len() / 2] });
            }
        }
        let mut shell = 0;
        for (s, n) in self.shell_least.iter().enumerate() {
            used += n;
            if used > count {
                shell = s as u32;
                break;
            }
        }
        let t = self.surface.shell().iter().position(|&s| s == shell).unwrap_or(0);
        let reason = format!("{} shells cannot all be kept", self.shell_least.len());
        Err(Shortage { needed: least, thin: false, reason, vertex: self.surface.triangles()[t][0] })
    }

    fn thin_shortage(&self) -> Shortage {
        // Named where the most seeds go: the least limit of all.
        let least = (0..self.limits.len()).min_by(|&a, &b| self.limits[a].total_cmp(&self.limits[b])).unwrap_or(0);
        let length = self.surface.frame().length_to_model(self.limits[least]);
        let reason = format!("thin walls or narrow gaps need edges of about {length:.3e}");
        Shortage { needed: self.enough_for_limits(), thin: true, reason, vertex: least as u32 }
    }

    /// A count that keeps all limits.
    pub(super) fn enough_for_limits(&self) -> usize {
        let needed = self.total(self.widest(), 1.0).ceil() as usize;
        needed.saturating_add(needed / 50)
    }

    fn shell_deficits(&self) -> Vec<usize> {
        let mut have = vec![0usize; self.surface.shell_count()];
        let shell_of = self.shell_of_vertices();
        for &v in &self.corners {
            have[shell_of[v as usize] as usize] += 1;
        }
        for (c, n) in self.features.curves.iter().zip(&self.needs) {
            have[shell_of[c.vertices[0] as usize] as usize] += n.least;
        }
        have.iter().map(|&n| PER_SHELL.saturating_sub(n)).collect()
    }

    fn shell_of_vertices(&self) -> Vec<u32> {
        let mut shells = vec![0; self.surface.points().len()];
        for (t, v) in self.surface.triangles().iter().enumerate() {
            for v in v {
                shells[*v as usize] = self.surface.shell()[t];
            }
        }
        shells
    }
}

/// Where `more` turns false between `low` and `high`, on its false side.
fn bisect(mut low: f64, mut high: f64, more: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if more(middle) {
            low = middle;
        } else {
            high = middle;
        }
        if high <= low * (1.0 + 1e-9) {
            break;
        }
    }
    high
}

/// The mean over a triangle of the inverse square of what is linear on it, by the middles of the edges: exact where the
/// inverse square is of the second degree.
fn mean_inverse_square([a, b, c]: [f64; 3]) -> f64 {
    let middle = |a: f64, b: f64| 4.0 / ((a + b) * (a + b));
    (middle(a, b) + middle(b, c) + middle(c, a)) / 3.0
}

/// Coefficients of the volume at depth d: volume - area d + mean d^2 - gauss d^3. An edge whose normals turn by the
/// angle a counts for its length times tan(a / 2), the exact value of a sharp convex edge and that of a smooth surface
/// in the limit. Interfaces have a layer on both sides: their area counts twice, and the terms beyond cancel.
fn steiner(surface: &Surface, sizing: Option<&Sizing>, relative: &[f64]) -> [f64; 4] {
    let (mut mean, mut interfaces) = (0.0, 0.0);
    for pair in edges::sorted(surface.triangles()).chunks_exact(2) {
        let [a, b] = pair[0].0;
        let [t, u] = [0, 1].map(|k| edges::triangle_of(pair[k].1));
        if surface.is_interface(t) {
            // Each triangle has three edges.
            let size = 0.5 * (relative[a as usize] + relative[b as usize]);
            interfaces += [t, u].map(|t| surface.normal2(t).length() / 6.0).iter().sum::<f64>() / (size * size);
            continue;
        }
        let [n, m] = [t, u].map(|t| surface.normal2(t).normalize_or_zero());
        let (p, q) = (surface.points()[a as usize], surface.points()[b as usize]);
        let other = surface.triangles()[u as usize].into_iter().find(|v| *v != a && *v != b);
        let other = other.map_or(p, |v| surface.points()[v as usize]);
        let tangent = (n.cross(m).length() / (1.0 + n.dot(m)).max(1e-9)).min(2.0);
        let convex = if (other - p).dot(n) <= 0.0 { 1.0 } else { -1.0 };
        let size = 0.5 * (relative[a as usize] + relative[b as usize]);
        mean += convex * p.distance(q) * tangent / size;
    }
    // Cavities turn the other way, but at depths where this term counts they are not what is left.
    let gauss = 4.0 / 3.0 * std::f64::consts::PI * shells_less_handles(surface);
    let volume = sizing.map_or(surface.volume(), |s| s.inverse_cubes(surface));
    [volume, weighted_area(surface, relative) + interfaces, mean, gauss]
}

/// The area, times the inverse square of the relative sizes.
fn weighted_area(surface: &Surface, relative: &[f64]) -> f64 {
    if relative.iter().all(|&r| r == 1.0) {
        return surface.area();
    }
    let area = |(t, v): (u32, &[u32; 3])| {
        0.5 * surface.normal2(t).length() * mean_inverse_square(v.map(|v| relative[v as usize]))
    };
    (0..).zip(surface.triangles()).map(area).sum()
}

/// Number of shells less that of their handles, interfaces left out: half of Euler's characteristic.
fn shells_less_handles(surface: &Surface) -> f64 {
    let triangles = (0..surface.triangles().len()).filter(|&t| !surface.is_interface(t as u32));
    let mut used = vec![false; surface.points().len()];
    let faces = triangles.inspect(|&t| surface.triangles()[t].iter().for_each(|&v| used[v as usize] = true)).count();
    let vertices = used.iter().filter(|&&u| u).count();
    (vertices as f64 - faces as f64 / 2.0) / 2.0
}

/// Cells' worth of area around the corners: the angle of their fans over a full turn.
fn corner_cells(surface: &Surface, corners: &[u32]) -> f64 {
    let mut is_corner = vec![false; surface.points().len()];
    corners.iter().for_each(|&v| is_corner[v as usize] = true);
    let mut angles = 0.0;
    for v in surface.triangles() {
        for i in 0..3 {
            if is_corner[v[i] as usize] {
                let [a, b, c] = [0, 1, 2].map(|k| surface.points()[v[(i + k) % 3] as usize]);
                angles += (b - a).angle_between(c - a);
            }
        }
    }
    angles / std::f64::consts::TAU
}
