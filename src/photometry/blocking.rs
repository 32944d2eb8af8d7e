//! What the chassis hides of the sail: from the Sun, from the observer, and from either.
//!
//! The sail stands on the chassis edge that looks away from the Sun, a hinge along y. In the plane of the sail let u
//! run along the hinge from its middle and v up the sail; in the body frame a point of it is
//!
//! ```text
//! P(u, v) = (-v sin POA, u, v cos POA)        normal n = (cos POA, 0, sin POA)
//! ```
//!
//! with the hinge as origin. The chassis is the rectangle 0 ≤ x ≤ l_base, |y| ≤ w_base/2, z = 0. The ray from P
//! towards a direction w (Sun or observer, unit vector) below the chassis plane meets z = 0 at
//!
//! ```text
//! x = v (n·w)/(-w_z)        y = u + v cos POA w_y/(-w_z)
//! ```
//!
//! so it is stopped where n·w > 0 (else it leaves the other way), v ≤ h, and |y| ≤ w_base/2, with
//!
//! ```text
//! h = l_base (-w_z)/(n·w)
//! ```
//!
//! That is a parallelogram standing on the hinge, sheared sideways; for the Sun w_y = 0 and it is a rectangle. With
//! w the Sun h is that of the paper's eq. 15, with w the observer it is y_p. **The paper's eq. 17 prints sin² δ_sun
//! where this derivation (and casting rays) gives sin² δ_obs**; the printed form errs by up to 0.74 in the blocked
//! fraction. The condition to be hidden is n·w > 0, not cos α > 0: with POA = -3° the latter is wrong by up to 0.86.
//!
//! The share of the sail lost is the area of shadow ∪ view, cut to the sail. At each height v the three shapes are
//! intervals in u, so the area is the integral of interval lengths that are piecewise linear in v, and is
//! taken in closed form: exact, with no polygon to clip. `PanelPolygon` draws the same shapes and clips them;
//! tests hold the two, and rays cast one by one, against each other.

use nalgebra::Vector3;

use super::polygon::PanelPolygon;

/// A rectangular sail hinged to the edge of a rectangular chassis; lengths in metres.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ChassisBlocking {
    sail_length_m: f64,
    sail_width_m: f64,
    base_length_m: f64,
    base_width_m: f64,
    sin_panel_offset: f64,
    cos_panel_offset: f64,
}

/// Shares of the sail's area that are lost to light.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Blocked {
    /// In the chassis' shadow or hidden behind it: BF of the paper, [0, 1].
    pub shadow_or_hidden: f64,
    /// In the chassis' shadow: BF' of the paper, [0, 1].
    pub shadow: f64,
}

impl ChassisBlocking {
    /// From the sizes and the panel offset angle (positive leans the sail away from the Sun), radians.
    ///
    /// `None` unless all lengths are positive and finite and the offset lies within ±π/2.
    pub fn new(
        sail_length_m: f64,
        sail_width_m: f64,
        base_length_m: f64,
        base_width_m: f64,
        panel_offset_rad: f64,
    ) -> Option<Self> {
        let lengths = [sail_length_m, sail_width_m, base_length_m, base_width_m];
        let sound =
            lengths.iter().all(|&l| l > 0.0 && l.is_finite()) && panel_offset_rad.abs() < std::f64::consts::FRAC_PI_2;
        let (sin_panel_offset, cos_panel_offset) = panel_offset_rad.sin_cos();
        sound.then_some(Self {
            sail_length_m,
            sail_width_m,
            base_length_m,
            base_width_m,
            sin_panel_offset,
            cos_panel_offset,
        })
    }

    /// Normal of the sail's front, in the body frame.
    pub fn sail_normal(&self) -> Vector3<f64> {
        Vector3::new(self.cos_panel_offset, 0.0, self.sin_panel_offset)
    }

    /// Width of the sail, along the hinge, m.
    pub fn sail_width_m(&self) -> f64 {
        self.sail_width_m
    }

    /// Width of the chassis, along the hinge, m.
    pub fn base_width_m(&self) -> f64 {
        self.base_width_m
    }

    /// Area of the sail, m².
    pub fn sail_area_m2(&self) -> f64 {
        self.sail_length_m * self.sail_width_m
    }

    /// Area of the chassis, m².
    pub fn base_area_m2(&self) -> f64 {
        self.base_length_m * self.base_width_m
    }

    /// The lost shares for unit vectors to Sun and observer in the body frame (the Sun's y is taken as 0).
    pub fn blocked(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> Blocked {
        let shade = self.cast(to_sun);
        let view = self.cast(to_observer);
        let narrow = self.sail_width_m.min(self.base_width_m);
        let half_sum = 0.5 * (self.sail_width_m + self.base_width_m);
        let shadow_m2 = narrow * shade.height_m;
        // |S ∪ V| = |S| + |V| - |S ∩ V|, each cut to the sail. S is an upright strip `narrow` wide about the middle;
        // V at height v is an interval of the chassis' width, off the middle by |shear| v.
        let view_m2 = overlap_area(half_sum, narrow, view.shear.abs(), view.height_m);
        let both_m2 = overlap_area(
            0.5 * (narrow + self.base_width_m),
            narrow,
            view.shear.abs(),
            view.height_m.min(shade.height_m),
        );
        let sail_m2 = self.sail_area_m2();
        Blocked {
            shadow_or_hidden: ((shadow_m2 + (view_m2 - both_m2)) / sail_m2).clamp(0.0, 1.0),
            shadow: (shadow_m2 / sail_m2).min(1.0),
        }
    }

    /// Outline on the sail (u, v in metres) of what the chassis stops on the way to `direction`, cut to the sail; empty
    /// where it stops nothing.
    pub fn outline(&self, direction: &Vector3<f64>) -> PanelPolygon {
        let cast = self.cast(direction);
        let (half, top) = (0.5 * self.base_width_m, cast.height_m);
        let shift = cast.shear * top;
        PanelPolygon::new(&[[-half, 0.0], [half, 0.0], [half + shift, top], [-half + shift, top]])
            .clipped_to_rectangle([-0.5 * self.sail_width_m, 0.5 * self.sail_width_m], [0.0, self.sail_length_m])
    }

    /// How far up the sail the chassis stops light to or from a direction, at most the sail's length, and how it leans.
    fn cast(&self, direction: &Vector3<f64>) -> Cast {
        let below = -direction.z;
        let facing = self.cos_panel_offset * direction.x + self.sin_panel_offset * direction.z;
        if below <= 0.0 || facing <= 0.0 {
            return Cast { height_m: 0.0, shear: 0.0 };
        }
        Cast {
            // h = l_base (-sin δ) / (n · w)                              Lu (2024), eqs. 15 and 17 (mended)
            height_m: (self.base_length_m * below / facing).min(self.sail_length_m),
            // x_p = l_base l cos δ sin α reached at height y_p           Lu (2024), eqs. 16, 18
            // (here leaning away from the observer; the paper draws the mirror image).
            shear: -self.cos_panel_offset * direction.y / below,
        }
    }
}

/// A parallelogram on the hinge: how high, and how far it leans in u for each metre of v.
struct Cast {
    height_m: f64,
    shear: f64,
}

/// ∫ clamp(reach - slope v, 0, flat) dv over 0 ≤ v ≤ height: the area that two strips share, one of which leans.
///
/// `reach` is half the sum of their widths, `flat` the smaller width; `reach` ≥ `flat` always holds.
fn overlap_area(reach: f64, flat: f64, slope: f64, height: f64) -> f64 {
    // Upright, or so nearly that the strips stay on one another: also keeps the quotients below finite.
    if slope * height <= reach - flat {
        return flat * height;
    }
    let full_until = (reach - flat) / slope;
    let none_from = (reach / slope).min(height);
    // Width where the ramp ends: 0, or what is left at the top.
    let last = reach - slope * none_from;
    flat * full_until + 0.5 * (flat + last.max(0.0)) * (none_from - full_until)
}
