//! Sizes by an expression in x, y and z, parsed and evaluated by `exmex`.
//!
//! Departure: calls of two arguments and more are put in its infix form first, as it loses count of parentheses where such
//! calls are nested: `min(a, b, c)` becomes `(((a) min (b)) min (c))`.

use exmex::Express;
use exmex::FlatEx;
use glam::DVec3;

/// The variables, in the order in which values are passed.
const VARIABLES: [&str; 3] = ["x", "y", "z"];

/// Functions of two arguments, of which the first may have more.
const CALLS: [&str; 3] = ["min", "max", "atan2"];

/// Bytes at most: no field of sizes needs more.
const LONGEST: usize = 10_000;

/// A parsed expression.
pub(super) struct Expression {
    parsed: FlatEx<f64>,
    /// For each of its variables, the coordinate.
    axes: Vec<usize>,
}

impl Expression {
    /// Parses `text`.
    pub(super) fn parse(text: &str) -> Result<Expression, String> {
        if text.len() > LONGEST {
            return Err(format!("its {} bytes are more than an expression may have, {LONGEST}", text.len()));
        }
        let parsed: FlatEx<f64> = exmex::parse(&infix(text)).map_err(|error| {
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

/// `text` with every call of [`CALLS`] in infix form. What is not balanced is left for the parser to refuse.
fn infix(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(open) = rest.find('(') {
        let Some((inner, after)) = closed(&rest[open + 1..]) else { break };
        let before = rest[..open].trim_end();
        let head = before.trim_end_matches(|c: char| c.is_alphanumeric() || c == '_');
        let (name, arguments) = (&before[head.len()..], split(inner));
        let many = arguments.len() == 2 || arguments.len() > 2 && name != CALLS[2];
        if CALLS.contains(&name) && many {
            let arguments = arguments.iter().map(|a| format!("({})", infix(a)));
            out.push_str(head);
            out.extend(arguments.reduce(|first, next| format!("({first} {name} {next})")));
        } else {
            out.push_str(&rest[..=open]);
            out.push_str(&infix(inner));
            out.push(')');
        }
        rest = after;
    }
    out.push_str(rest);
    out
}

/// What comes before the parenthesis that closes the one just before `text`, and what after it.
fn closed(text: &str) -> Option<(&str, &str)> {
    let mut depth = 1;
    for (i, c) in text.char_indices() {
        depth += i32::from(c == '(') - i32::from(c == ')');
        if depth == 0 {
            return Some((&text[..i], &text[i + 1..]));
        }
    }
    None
}

/// The parts of `text` between the commas that are in no parentheses.
fn split(text: &str) -> Vec<&str> {
    let (mut parts, mut from, mut depth) = (Vec::new(), 0, 0);
    for (i, c) in text.char_indices() {
        depth += i32::from(c == '(') - i32::from(c == ')');
        if c == ',' && depth == 0 {
            parts.push(&text[from..i]);
            from = i + 1;
        }
    }
    parts.push(&text[from..]);
    parts
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
            ("1 + min(1, max(0, 40*(sqrt((x - 2)^2 + (y - 3)^2) - 0.1))) * 2", 1.0),
            ("2*min (5, y, max(z, -1)) + max(x, (y))", 1.0),
            ("atan2(0, x) + x", 2.0),
            ("abs(z) - exp(0) + sin(PI/2)", 4.0),
        ] {
            let found = Expression::parse(text).expect(text).at(p);
            assert!((found - value).abs() < 1e-12, "{text}: {found}");
        }
    }

    #[test]
    fn what_is_no_expression_is_refused() {
        for text in ["", "x +", "a * x", "size.txt", "1 2", "((x)", "min(x, y", "atan2(1, 2, 3)", "(x, y)"] {
            assert!(check(text).is_err(), "{text}");
        }
    }
}
