//! The normalised frame that all of the computation happens in.
//!
//! A power-of-two scale and a shift bring the model into the cube [-1/2, 1/2]^3; every coordinate is then rounded to a
//! multiple of 2^-52. In such a frame the difference of any two coordinates is an exact `f64`, and no predicate can
//! overflow or underflow, whatever the scale and offset of the model were.

use glam::DVec3;

use super::bounding_box::BoundingBox;

/// The map between the model's coordinates and the normalised frame: `frame = (model - shift) * scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Point of the model that becomes the origin, in model units.
    pub shift: DVec3,
    /// Frame units per model unit, a power of two.
    pub scale: f64,
}

impl Frame {
    /// The frame in which `bounds` (finite, not empty) lies within [-1/2, 1/2]^3.
    ///
    /// The shift is a coarse multiple of the frame's unit, so that coordinates with few digits survive the way there
    /// and back to the last bit.
    pub fn around(bounds: &BoundingBox) -> Frame {
        // Halved before they are subtracted: the box may span more than the largest f64.
        let half = bounds.max * 0.5 - bounds.min * 0.5;
        let reach = half.max_element();
        if reach == 0.0 {
            return Frame { shift: bounds.min, scale: 1.0 };
        }
        // 2^exponent > 2.25 * reach leaves room for the rounding of the shift.
        let exponent = (reach.log2() + 1.17).ceil().clamp(-1000.0, 1020.0) as i32;
        let scale = 2f64.powi(-exponent);
        let grain = 2f64.powi((exponent - 5).max(-1021));
        let center = bounds.center();
        let shift = (center / grain).round() * grain;
        let shift = if shift.is_finite() { shift } else { center };
        Frame { shift, scale }
    }

    /// A point of the model in the frame, on its grid.
    pub fn to_frame(&self, p: DVec3) -> DVec3 {
        snap((p - self.shift) * self.scale)
    }

    /// A point of the frame in the model's coordinates.
    pub fn to_model(&self, p: DVec3) -> DVec3 {
        p / self.scale + self.shift
    }

    /// A length in the frame, in model units.
    pub fn length_to_model(&self, length: f64) -> f64 {
        length / self.scale
    }
}

/// Rounds each coordinate, at most 1/2 in size, to the nearest multiple of 2^-52.
pub fn snap(p: DVec3) -> DVec3 {
    // 1.5 + x lies in [1, 2], where neighbouring f64 are 2^-52 apart.
    let shift = DVec3::splat(1.5);
    (p + shift) - shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_box_lands_in_the_unit_cube_at_any_scale_and_offset() {
        for scale in [1e-300, 1e-12, 1.0, 3.7, 1e12, 1e38, 1e300] {
            for offset in [0.0, 1.0, -1e7] {
                let min = DVec3::new(-1.0, 0.0, 2.0) * scale + DVec3::splat(offset * scale);
                let max = DVec3::new(1.0, 3.0, 2.5) * scale + DVec3::splat(offset * scale);
                let frame = Frame::around(&BoundingBox { min, max });
                for p in [min, max] {
                    let q = frame.to_frame(p);
                    assert!(q.abs().max_element() <= 0.5, "{scale} {offset}: {q}");
                }
                let extent = frame.to_frame(max) - frame.to_frame(min);
                assert!(extent.max_element() > 0.2, "{scale} {offset}: {extent}");
            }
        }
    }

    #[test]
    fn short_coordinates_survive_the_way_there_and_back() {
        let frame = Frame::around(&BoundingBox { min: DVec3::splat(-1.0), max: DVec3::new(1.0, 2.0, 0.75) });
        for p in [DVec3::new(-1.0, 2.0, 0.75), DVec3::new(0.125, -0.5, 1.0)] {
            assert_eq!(frame.to_model(frame.to_frame(p)), p);
        }
    }
}
