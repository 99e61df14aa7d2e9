//! Brings any finite points into the range in which predicates are exact.
//!
//! Predicates are exact for multiples of 2^-200 up to 2^60. Each coordinate is therefore rounded to a multiple of 2^-200,
//! which changes nothing from 2^-148 up; and only if the largest coordinate is beyond 2^60 or below 2^-60, all are
//! first multiplied by the power of two that makes the largest about one.

use glam::DVec3;

/// Points are scaled only if their largest coordinate is beyond this or below its inverse.
const COMFORT: f64 = (1u64 << 60) as f64;

/// From here on, every number is a multiple of 2^-200.
const LEAST: f64 = f64::from_bits((1023 - 149) << 52);

/// The power of two by which points whose largest coordinate is `reach` are held.
pub fn scale_for(reach: f64) -> f64 {
    if reach == 0.0 || (1.0 / COMFORT..=COMFORT).contains(&reach) {
        return 1.0;
    }
    // Clamped so that the power itself is a normal number; the range is wide enough for what is left.
    2f64.powi((-reach.log2().floor() as i32).clamp(-1000, 1000))
}

/// The nearest multiple of 2^-200.
#[inline]
pub fn flush(x: f64) -> f64 {
    /// Neighbours of numbers in [2^-148, 2^-147] are 2^-200 apart; 1.5 times its lower end.
    const SHIFT: f64 = f64::from_bits((1023 - 148) << 52 | 1 << 51);
    if x.abs() >= LEAST || x == 0.0 { x } else { (x + SHIFT) - SHIFT }
}

/// Whether [`hold`] would hold points just as they are.
pub fn are_held_as_they_are(points: &[DVec3]) -> bool {
    let (mut reach, mut fit) = (0.0, true);
    for p in points {
        for x in p.to_array() {
            let size = x.abs();
            reach = if size > reach { size } else { reach };
            // False for NaN too.
            fit &= (LEAST..=COMFORT).contains(&size) | (size == 0.0);
        }
    }
    fit && scale_for(reach) == 1.0
}

/// Whether a set that is held unscaled still is when this point comes in.
pub fn may_join(p: DVec3) -> bool {
    p.abs().max_element() <= COMFORT
}

/// Whether this point alone keeps a set of points that may join unscaled.
pub fn holds_scale(p: DVec3) -> bool {
    p.abs().max_element() >= 1.0 / COMFORT
}

/// Points as they are held: scaled and flushed.
pub fn hold(points: &[DVec3]) -> (Vec<DVec3>, f64) {
    let reach = points.iter().fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
    let scale = scale_for(reach);
    let held = |p: &DVec3| {
        let p = if scale == 1.0 { *p } else { *p * scale };
        DVec3::new(flush(p.x), flush(p.y), flush(p.z))
    };
    (points.iter().map(held).collect(), scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flush_changes_only_what_is_tiny() {
        for x in [0.0, -0.0, 1.0, -3.7, 2f64.powi(-52), 1e-44, -1e-44, 1e300] {
            assert_eq!(flush(x).to_bits(), x.to_bits(), "{x}");
        }
        let unit = 2f64.powi(-200);
        assert_eq!(flush(unit), unit);
        assert_eq!(flush(-1.25 * unit), -unit);
        assert_eq!(flush(1.75 * unit), 2.0 * unit);
        assert_eq!(flush(0.25 * unit), 0.0);
        assert_eq!(flush(5e-324), 0.0);
        let x = 2f64.powi(-150) + unit * 0.25;
        assert_eq!(flush(x), 2f64.powi(-150));
    }

    #[test]
    fn any_reach_is_brought_into_range() {
        for reach in [5e-324, 1e-310, 1e-200, 1e-30, 1e-15, 1.0, 1e15, 1e30, 1e200, f64::MAX] {
            let scale = scale_for(reach);
            let held = reach * scale;
            assert!((2f64.powi(-80)..=COMFORT).contains(&held), "{reach} {held}");
            assert_eq!(held / scale, reach);
        }
        assert_eq!(scale_for(0.5), 1.0);
        assert_eq!(scale_for(1e-15), 1.0);
        assert_eq!(scale_for(0.0), 1.0);
    }
}
