//! How long edges are to be where: a field of sizes over the solid, out of what the user asks for.
//!
//! 1. Sizes asked for: an expression in x, y and z, or numbers on a mesh ([`SizeField`]); a share of the surface's radius
//!    of curvature (`curvature.rs`); a largest size. The least of them counts.
//! 2. An octree samples them so finely that it is exact to 2 % (`octree.rs`).
//! 3. The result is the largest field below them that grows by no more than [`Sizes::grade`] per length (`grading.rs`).
//!
//! Without a field of sizes nor curvature there is no [`Sizing`], and nothing of this is computed.

use std::sync::Arc;

use glam::DVec3;

use crate::error::Error;
use crate::rng::Rng;
use crate::surface::Surface;
use crate::surface::features::Features;

mod curvature;

mod expression;

mod grading;

pub mod mesh_field;

mod octree;

pub use expression::check as check_expression;
pub use mesh_field::SizeMesh;

use expression::Expression;
use grading::Grading;
use octree::Octree;

/// Growth of sizes per length where none is chosen: edges then grow by about a third from one to the next.
pub const DEFAULT_GRADE: f64 = 0.3;

/// The spacing of seeds over the size asked for: the spacing is the mean of edge lengths, and their median is so much less
/// (0.955 to 0.975 of it on a cube of one size and of sizes 1 to 5, on a sphere and on a bunny).
pub const MEAN_OVER_MEDIAN: f64 = 1.04;

/// The steepest growth: what is steeper, no chain of tets can follow.
const STEEPEST: f64 = 1.0;

/// With curvature alone, the largest size over the diagonal.
const LARGEST: f64 = 0.05;

/// Curvature asks for no less than this share of the largest size: what is finer is noise of scans, or needs an expression.
const LEAST_OF_CURVATURE: f64 = 0.05;

/// Sizes vary over the solid by this factor at most.
const WIDEST_RANGE: f64 = 1e3;

/// The sizes that a user gives.
#[derive(Clone, Debug, PartialEq)]
pub enum SizeField {
    /// Of the coordinates x, y and z of the model, in its units, such as `0.1 + 0.05 * x`.
    Expression(String),
    /// Numbers on the points of a mesh of tets, in the units of the model: linear in each, that of the nearest point
    /// outside.
    Mesh(Arc<SizeMesh>),
}

/// What sizes are to depend on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sizes {
    /// Sizes over space.
    pub field: Option<SizeField>,
    /// So many edges to a radius of the surface's curvature.
    pub curvature: Option<f64>,
    /// Sizes grow by at most so much per length; [`DEFAULT_GRADE`] if not given.
    pub grade: Option<f64>,
}

impl Sizes {
    /// Whether they depend on anything.
    pub fn vary(&self) -> bool {
        self.field.is_some() || self.curvature.is_some()
    }

    /// Refuses what no run could honour.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn validate(&self) -> Result<(), Error> {
        if let Some(SizeField::Expression(text)) = &self.field {
            check_expression(text).map_err(|reason| refused("size-field", reason))?;
        }
        if let Some(k) = self.curvature
            && !(k > 0.0 && k <= 1e3)
        {
            return Err(refused("curvature", format!("{k} is not over 0 and at most 1000 edges to a radius")));
        }
        match self.grade {
            Some(g) if !(g > 0.0 && g <= STEEPEST) => {
                Err(refused("grade", format!("{g} is not over 0 and at most {STEEPEST}")))
            }
            Some(_) if !self.vary() => {
                Err(refused("grade", "nothing varies: it goes with --size-field or --curvature".to_owned()))
            }
            _ => Ok(()),
        }
    }
}

fn refused(option: &'static str, reason: String) -> Error {
    Error::Parameter { option, reason }
}

/// Sizes over the solid, in the frame: as asked for, whether or not so many seeds will make all of them larger or smaller.
#[derive(Debug)]
pub struct Sizing {
    octree: Octree,
    largest: f64,
}

impl Sizing {
    /// The sizes that `sizes` ask for over the solid, at most `cap` (in the frame); `None` where they do not vary.
    ///
    /// # Errors
    /// [`Error::Parameter`] where a size is not positive or not finite within the solid, or the mesh that holds them does
    /// not cover it.
    pub fn new(
        surface: &Surface,
        features: &Features,
        sizes: &Sizes,
        cap: Option<f64>,
    ) -> Result<Option<Arc<Sizing>>, Error> {
        if !sizes.vary() {
            return Ok(None);
        }
        let asked = Asked::new(surface, sizes, cap)?;
        let largest = cap.unwrap_or(LARGEST * surface.diagonal());
        let fine = match sizes.curvature {
            Some(k) => curvature::sizes(surface, features, k, [LEAST_OF_CURVATURE * largest, largest]),
            None => Vec::new(),
        };
        let grade = sizes.grade.unwrap_or(DEFAULT_GRADE);
        let octree = Grading::new(surface, &asked, &fine, grade).octree()?;
        let [least, largest] = octree.range();
        if largest > WIDEST_RANGE * least {
            let [least, largest] = [least, largest].map(|s| surface.frame().length_to_model(s));
            let reason = format!("sizes from {least:.3e} to {largest:.3e} differ by more than {WIDEST_RANGE:.0} times");
            return Err(refused("size-field", reason));
        }
        Ok(Some(Arc::new(Sizing { octree, largest })))
    }

    /// The size asked for at a point of the solid.
    pub fn at(&self, p: DVec3) -> f64 {
        self.octree.at(p)
    }

    /// The largest of all.
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// The size over the largest.
    pub fn relative(&self, p: DVec3) -> f64 {
        self.octree.at(p) / self.largest
    }

    /// The integral over the solid of the inverse cube of [`Sizing::relative`].
    pub fn inverse_cubes(&self, surface: &Surface) -> f64 {
        let largest = self.largest;
        self.octree.integral(surface, |size| {
            let relative = size / largest;
            1.0 / (relative * relative * relative)
        })
    }

    /// So many random points of the solid and what is just around it, in the density of the inverse cube of sizes.
    pub(crate) fn draw(&self, count: usize, rng: &mut Rng) -> Vec<DVec3> {
        self.octree.draw(count, rng)
    }

    /// Edges of the surface along which sizes vary by more than this are split: what is linear between vertices is then
    /// right to a few percent.
    pub fn refined(&self, surface: &Surface) -> Surface {
        const VARIES: f64 = 1.15;
        const BENDS: f64 = 0.04;
        const SHORT: f64 = 0.9;
        surface.refined(|p, q| {
            let [a, m, b] = [p, (p + q) * 0.5, q].map(|x| self.at(x));
            let varies = a.max(b).max(m) > VARIES * a.min(b).min(m) || (m - 0.5 * (a + b)).abs() > BENDS * m;
            let long = p.distance(q) / m;
            // Between the ends and the middle there may be more, where the edge spans many sizes.
            long > SHORT && (varies || (1..8).any(|i| long > 4.0 && self.bends(p, q, f64::from(i) / 8.0, [a, b])))
        })
    }

    /// Whether the size at a share of the way from p to q is far from linear between the ends.
    fn bends(&self, p: DVec3, q: DVec3, share: f64, [a, b]: [f64; 2]) -> bool {
        let linear = a + share * (b - a);
        (self.at(p.lerp(q, share)) / linear - 1.0).abs() > 0.05
    }
}

/// The spacing of seeds over the solid: even, or as a field says.
#[derive(Clone, Debug)]
pub struct Spacing {
    /// The largest, in the frame.
    pub largest: f64,
    /// Where it varies.
    pub field: Option<Arc<Sizing>>,
}

impl From<f64> for Spacing {
    fn from(largest: f64) -> Spacing {
        Spacing { largest, field: None }
    }
}

impl Spacing {
    /// Over the largest.
    pub fn relative(&self, p: DVec3) -> f64 {
        self.field.as_ref().map_or(1.0, |f| f.relative(p))
    }

    /// The spacing at a point.
    pub fn at(&self, p: DVec3) -> f64 {
        self.largest * self.relative(p)
    }
}

/// The sizes asked for, before they are graded.
struct Asked<'a> {
    surface: &'a Surface,
    field: Option<Source<'a>>,
    /// The largest.
    cap: f64,
}

enum Source<'a> {
    Expression(Expression),
    Mesh(mesh_field::Located<'a>),
}

impl<'a> Asked<'a> {
    fn new(surface: &'a Surface, sizes: &'a Sizes, cap: Option<f64>) -> Result<Asked<'a>, Error> {
        let field = match &sizes.field {
            None => None,
            Some(SizeField::Expression(text)) => {
                let parsed = Expression::parse(text).map_err(|reason| refused("size-field", reason))?;
                Some(Source::Expression(parsed))
            }
            Some(SizeField::Mesh(mesh)) => Some(Source::Mesh(mesh.located(surface)?)),
        };
        let cap = match (&field, cap) {
            (_, Some(cap)) => cap,
            (Some(_), None) => f64::INFINITY,
            (None, None) => LARGEST * surface.diagonal(),
        };
        Ok(Asked { surface, field, cap })
    }

    /// The size at a point; infinite where there is none, which only may be outside the solid.
    fn at(&self, p: DVec3) -> Result<f64, Error> {
        let frame = self.surface.frame();
        let at = frame.to_model(p);
        let size = match &self.field {
            None => return Ok(self.cap),
            Some(Source::Expression(expression)) => expression.at(at),
            Some(Source::Mesh(mesh)) => mesh.at(p),
        };
        if size.is_finite() && size > 0.0 {
            return Ok((size * frame.scale).min(self.cap));
        }
        if self.surface.is_inside(p) || self.surface.tree().closest(p).distance2 == 0.0 {
            let [x, y, z] = at.to_array();
            let reason = format!("the size at ({x}, {y}, {z}), in the solid, is {size}, not a positive number");
            return Err(refused("size-field", reason));
        }
        Ok(f64::INFINITY)
    }
}
