//! Sizes by an expression in x, y and z.

use exmex::Express;
use exmex::FlatEx;
use glam::DVec3;

/// The variables, in the order in which values are passed.
const VARIABLES: [&str; 3] = ["x", "y", "z"];

/// A parsed expression.
pub(super) struct Expression {
    parsed: FlatEx<f64>,
    /// For each of its variables, the coordinate.
    axes: Vec<usize>,
}

impl Expression {
    /// Parses `text`.
    pub(super) fn parse(text: &str) -> Result<Expression, String> {
        let parsed: FlatEx<f64> = exmex::parse(text).map_err(|error| {
            format!("{text:?} is neither a file ending in .vtu or .vtk nor an expression in x, y and z: {error}")
        })?;
        let axis = |name: &String| {
            VARIABLES.iter().position(|v| v == name).ok_or_else(|| {
                format!("{text:?} has {name:?}, which is none of the coordinates x, y and z and no function")
            })
        };
        let axes = parsed.var_names().iter().map(axis).collect::<Result<_, _>>()?;
        Ok(Expression { parsed, axes })
    }

    /// Its value; not a number where it has none.
    pub(super) fn at(&self, p: DVec3) -> f64 {
        let mut values = [0.0; VARIABLES.len()];
        for (value, &axis) in values.iter_mut().zip(&self.axes) {
            *value = p[axis];
        }
        self.parsed.eval(&values[..self.axes.len()]).unwrap_or(f64::NAN)
    }
}

/// Whether `text` is an expression, or else why not.
///
/// # Errors
/// The reason, for a user.
pub fn check(text: &str) -> Result<(), String> {
    Expression::parse(text).map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_have_the_usual_meaning() {
        let p = DVec3::new(2.0, 3.0, -4.0);
        for (text, value) in [
            ("0.5", 0.5),
            ("z + 10*y - x", 24.0),
            ("x^2 + -z / 2", 6.0),
            ("sqrt(y*y + z*z)", 5.0),
            ("min(x, max(y, z))", 2.0),
            ("8/4*2", 4.0),
            ("abs(z) - exp(0) + sin(PI/2)", 4.0),
        ] {
            let found = Expression::parse(text).expect(text).at(p);
            assert!((found - value).abs() < 1e-12, "{text}: {found}");
        }
    }

    #[test]
    fn what_is_no_expression_is_refused() {
        for text in ["", "x +", "a * x", "size.txt", "1 2", "((x)"] {
            assert!(check(text).is_err(), "{text}");
        }
    }
}
