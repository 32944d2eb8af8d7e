//! Seeing, defocus and size as tables of one radial profile, on the pixels in which it is drawn.

use std::f64::consts::PI;

use super::blur::{Blur, BlurError, GREATEST_REACH_PIX};
use super::curve::Curve;
use super::disk::disk_mean;
use super::edge::EdgeTable;
use super::even::EVEN_PIX;
use super::integrals::{Grain, HARMONICS, Panels, along_line, angle, flux, harmonics, pixel_nodes};
use super::lanes::Lanes;
use super::lattice::Lattice;
use super::radii::Radii;
use super::wings::CutSeeing;

/// Half a pixel's diagonal: so much farther than the profile does its average over a pixel reach.
const HALF_DIAGONAL_PIX: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Angular harmonics below this share of the peak are left out.
const NEGLIGIBLE: f64 = 1e-6;

/// Pixels that must be drawn with a lattice for it to be worth its making: so many, and so many more for each of its places.
const PIXELS_PER_LATTICE: f64 = 3000.0;
const PIXELS_PER_NUMBER: f64 = 6.0;

/// Wings that reach so much farther than pixels have corners are worth a table of half lines.
const WINGS: f64 = 1.3;

/// A point's light as a function of the distance from its centre alone, of unit flux, on square pixels no wider than the seeing's
/// full width at half maximum.
///
/// Seeing, ring and disk are convolved by quadrature, each to better than 10⁻⁵ of the peak. The wings of the seeing are cut where 10⁻⁴ of
/// its flux lies beyond and a line has 10⁻⁵ of its brightness; what is cut is added to the outermost of what is left, where it is not felt: nothing is
/// lost, and 10⁻⁴ of the light lies nearer than it should. Beside the profile are kept its averages over a pixel ([`ProfileTables::pixel`]) and those along a line ([`ProfileTables::line`]); both depend on
/// the direction too, since pixels are squares, and are kept as harmonics of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileTables {
    blur: Blur,
    profile: Curve,
    pixel: [Curve; HARMONICS],
    /// The first two harmonics of a pixel, and the others.
    pixel_lanes: [Lanes<2>; HARMONICS / 2],
    felt_harmonics: usize,
    round_from_pix: f64,
    line: [Curve; HARMONICS],
    line_second_moment: Lanes,
    edge: Option<EdgeTable>,
    half_light_pix: f64,
    fwhm_pix: f64,
    variance_pix2: f64,
}

impl ProfileTables {
    /// Length over which light may be a cubic, pixels.
    pub const EVEN_PIX: f64 = EVEN_PIX;

    /// The profile of a blur whose numbers have been held to their ranges; takes from a third of a millisecond (seeing alone) to some milliseconds (a
    /// ring many pixels wide).
    ///
    /// # Errors
    /// [`BlurError::Reach`] for wings beyond 4000 pixels.
    pub(super) fn of(blur: &Blur) -> Result<Self, BlurError> {
        let fwhm = blur.seeing.narrowest_fwhm_pix();
        let flat = blur.flat_radius_pix();
        let panels = Panels::new();
        let seeing = CutSeeing::of(&blur.seeing, &panels);
        let reach = seeing.reach_pix + flat;
        if reach > GREATEST_REACH_PIX {
            return Err(BlurError::Reach { reach_pix: reach });
        }
        // Steps of at most a twelfth of the seeing's sigma as far out as there are edges.
        let core = flat + 2.0 * fwhm;
        let intervals = (48.0 * core / (0.425 * fwhm)).ceil().clamp(256.0, 8192.0) as usize;
        let grain = Grain { step_pix: 1.2 * fwhm, even_to_pix: flat + 2.5 * fwhm };
        let mut profile = blurred(blur, &seeing, core, intervals, grain, &panels);
        let sum = flux(&profile, grain, &panels);
        profile.scale(1.0 / sum);

        let nodes = pixel_nodes(if fwhm < 2.0 { 8 } else { 4 });
        let averaged = Radii::new(core, reach + HALF_DIAGONAL_PIX, intervals);
        let pixel = in_harmonics(averaged, |r, phi| {
            let (sin, cos) = phi.sin_cos();
            nodes
                .iter()
                .map(|([x, y], weight)| weight * profile.at(((r * cos + x).powi(2) + (r * sin + y).powi(2)).sqrt()))
                .sum()
        });
        let mut second = Vec::with_capacity(intervals + 1);
        let line_alone = Curve::of(profile.radii(), |v| {
            let [light, moment] = along_line(&profile, v, grain, &panels);
            // Second moments of profile and pixel add up; the pixel's is 1/12 along each axis.
            second.push(moment + light / 12.0);
            light
        });
        let line_second_moment = Lanes::of([&Curve::from_values(profile.radii(), second)]);
        let line = in_harmonics(averaged, |v, phi| {
            let (sin, cos) = phi.sin_cos();
            nodes.iter().map(|([x, y], weight)| weight * line_alone.at((v + x * sin - y * cos).abs())).sum()
        });
        let (half_light_pix, fwhm_pix) = (half_light(&profile, grain, &panels), full_width(&profile));
        let variance_pix2 = PI * panels.integrate(0.0, reach, 0.5 * fwhm, |r| r.powi(3) * profile.at(r));
        let (round_from_pix, felt_harmonics) = (felt_to(&pixel[1..], &pixel[0]), felt_count(&pixel));
        let from_pix = round_from_pix.max(EdgeTable::from_at_least_pix(fwhm, flat));
        let edge =
            (averaged.end_pix() > WINGS * from_pix).then(|| EdgeTable::of(&pixel[0], from_pix, line[0].values()[0]));
        let pixel_lanes = [[&pixel[0], &pixel[1]], [&pixel[2], &pixel[3]]].map(Lanes::of);
        Ok(Self {
            blur: *blur,
            profile,
            pixel,
            pixel_lanes,
            felt_harmonics,
            round_from_pix,
            line,
            line_second_moment,
            edge,
            half_light_pix,
            fwhm_pix,
            variance_pix2,
        })
    }

    /// Surface brightness at a distance from the centre, per square pixel.
    pub fn at(&self, r_pix: f64) -> f64 {
        self.profile.at(r_pix.abs())
    }

    /// Share of the light in a square pixel whose centre lies this far from the profile's.
    pub fn pixel(&self, dx_pix: f64, dy_pix: f64) -> f64 {
        let phi = dy_pix.atan2(dx_pix);
        let r = dx_pix.hypot(dy_pix);
        (0..HARMONICS).map(|m| (4.0 * m as f64 * phi).cos() * self.pixel[m].at(r)).sum()
    }

    /// Light in a square pixel of a long straight line of unit light per pixel of its length, at `angle_rad` from the rows (or from the
    /// columns: it is the same), that passes the pixel's centre at a distance.
    pub fn line(&self, across_pix: f64, angle_rad: f64) -> f64 {
        self.line_of(angle_rad)(across_pix)
    }

    /// [`ProfileTables::line`] at an angle, by the distance.
    pub fn line_of(&self, angle_rad: f64) -> impl Fn(f64) -> f64 {
        let shares: [f64; HARMONICS] = std::array::from_fn(|m| (4.0 * m as f64 * angle_rad).cos());
        move |across_pix| shares.iter().zip(&self.line).map(|(share, line)| share * line.at(across_pix.abs())).sum()
    }

    /// Full width at half of the greatest brightness, pixels; of a ring, its outer edges'.
    pub fn fwhm_pix(&self) -> f64 {
        self.fwhm_pix
    }

    /// Radius that holds half of the light, pixels.
    pub fn half_light_pix(&self) -> f64 {
        self.half_light_pix
    }

    /// Where the profile ends, pixels.
    pub fn reach_pix(&self) -> f64 {
        self.profile.radii().end_pix()
    }

    /// How far from its centre a point puts light into pixels, pixels.
    pub fn pixel_reach_pix(&self) -> f64 {
        self.reach_pix() + HALF_DIAGONAL_PIX
    }

    /// Variance along one axis, square pixels.
    pub fn variance_pix2(&self) -> f64 {
        self.variance_pix2
    }

    /// [`ProfileTables::line`] at one angle, as a table for loops.
    pub fn line_lanes(&self, angle_rad: f64) -> Lanes {
        Lanes::of([&self.line_curve(angle_rad)])
    }

    /// The same as a lattice over rows, at an angle to these in radians, where so many pixels are drawn with it; none where that is not worth its making.
    pub fn line_lattice(&self, angle_rad: f64, pixels: usize) -> Option<Lattice> {
        let (step_pix, reach_pix) = (angle_rad.sin().abs(), self.pixel_reach_pix());
        let numbers = Lattice::numbers(reach_pix, step_pix, self.phase_pix());
        (pixels as f64 > PIXELS_PER_LATTICE + PIXELS_PER_NUMBER * numbers)
            .then(|| Lattice::of(&self.line_curve(angle_rad), reach_pix, step_pix, self.phase_pix()))
    }

    /// How far an angle may be from that of [`ProfileTables::line_lattice`], radians: half a phase over [`Lattice::COLUMNS`].
    pub fn lattice_turn_rad(&self, angle_rad: f64) -> f64 {
        0.5 * self.phase_pix().min(angle_rad.sin().abs()) / Lattice::COLUMNS as f64
    }

    /// Steps h of distance within one of which to either side a line's light is a parabola: h³/(9 √3) L''' is 7·10⁻⁶ of the peak.
    fn phase_pix(&self) -> f64 {
        self.blur.seeing.narrowest_fwhm_pix() / 55.0
    }

    /// Its derivative by the angle, per radian.
    pub fn line_turned_lanes(&self, angle_rad: f64) -> Lanes {
        Lanes::of([&self.line_sum(|m| -4.0 * m * (4.0 * m * angle_rad).sin())])
    }

    fn line_curve(&self, angle_rad: f64) -> Curve {
        self.line_sum(|m| (4.0 * m * angle_rad).cos())
    }

    fn line_sum(&self, weight: impl Fn(f64) -> f64) -> Curve {
        let parts: [(f64, &Curve); HARMONICS] = std::array::from_fn(|m| (weight(m as f64), &self.line[m]));
        Curve::sum(&parts)
    }

    /// How far an angle may be from that of [`ProfileTables::line_lanes`] and [`ProfileTables::line_turned_lanes`] together for 10⁻⁵ of the peak, radians.
    pub fn line_most_turn_rad(&self) -> f64 {
        // d²/dφ² Σ A_m cos 4mφ is at most Σ (4m)² |A_m|.
        let (peak, bend) = self.line_harmonics(|m| (4.0 * m).powi(2));
        (2e-5 * peak / bend.max(1e-4 * peak)).sqrt()
    }

    /// The peak of a line, and the weighted sum of what each of its harmonics is at most.
    fn line_harmonics(&self, weight: impl Fn(f64) -> f64) -> (f64, f64) {
        let greatest = |m: usize| self.line[m].values().iter().map(|value| value.abs()).fold(0.0, f64::max);
        (greatest(0), (1..HARMONICS).map(|m| weight(m as f64) * greatest(m)).sum())
    }

    /// By how much the angle of [`ProfileTables::line_lanes`] may be wrong for 2·10⁻⁵ of the peak, radians.
    pub fn line_angle_step_rad(&self) -> f64 {
        // d/dφ Σ A_m cos 4mφ is at most Σ 4m |A_m|.
        let (peak, slope) = self.line_harmonics(|m| 4.0 * m);
        2e-5 * peak / slope.max(1e-4 * peak)
    }

    /// Second moment along a line of unit light, M₂(v) = ∫ u² P(u, v) du, square pixels: a line whose light per pixel is λ at the foot of a pixel
    /// and bends by λ'' puts λ L(v) + λ''/2 M₂(v) there.
    pub fn line_second_moment(&self) -> &Lanes {
        &self.line_second_moment
    }

    /// Light of half a line far from its end; none where the profile has no wings.
    pub fn edge(&self) -> Option<&EdgeTable> {
        self.edge.as_ref()
    }

    /// [`ProfileTables::pixel`] for `N` pixels at once, in single precision; `is_round` where all are farther than
    /// [`ProfileTables::round_from_pix`] from the centre.
    #[inline(always)]
    pub fn pixels<const N: usize>(&self, dx_pix: &[f32; N], dy_pix: &[f32; N], is_round: bool) -> [f32; N] {
        let [wide, narrow] = &self.pixel_lanes;
        let (mut x2, mut y2, mut r) = ([0.0_f32; N], [0.0_f32; N], [0.0_f32; N]);
        for lane in 0..N {
            x2[lane] = dx_pix[lane] * dx_pix[lane];
            y2[lane] = dy_pix[lane] * dy_pix[lane];
            r[lane] = (x2[lane] + y2[lane]).sqrt();
        }
        let [mut share, f4] = wide.all_at(&r);
        if is_round {
            return share;
        }
        let mut c = [0.0_f32; N];
        for lane in 0..N {
            // cos 4φ = 1 - 8 x²y² / r⁴
            let r2 = (x2[lane] + y2[lane]).max(1e-12);
            c[lane] = 1.0 - 8.0 * (x2[lane] / r2) * (y2[lane] / r2);
        }
        for lane in 0..N {
            share[lane] += c[lane] * f4[lane];
        }
        // Pixels narrow against the seeing have no more.
        if self.felt_harmonics > 2 {
            let [f8, f12] = narrow.all_at(&r);
            for lane in 0..N {
                let c = c[lane];
                share[lane] += (2.0 * c * c - 1.0) * f8[lane] + (4.0 * c * c - 3.0) * c * f12[lane];
            }
        }
        share
    }

    /// Beyond this distance from the centre a pixel's share is the same in all directions, to 10⁻⁶ of the peak, pixels.
    pub fn round_from_pix(&self) -> f64 {
        self.round_from_pix
    }

    /// Longest stretch that eight nodes of Gauss's rule sum at any distance from it, pixels.
    pub fn panel_pix(&self) -> f64 {
        self.blur.seeing.panel_pix()
    }

    /// Distance from which eight nodes of Gauss's rule sum a longer stretch as well, pixels; infinite where none is far enough.
    pub fn panel_from_pix(&self, length_pix: f64) -> f64 {
        let seeing = &self.blur.seeing;
        if length_pix > seeing.longest_panel_pix() {
            return f64::INFINITY;
        }
        // The nearest singularity of the wings lies no nearer than the distance itself: at half a half length it costs 5·10⁻⁴ of the wings' light,
        // which is a hundredth of the peak or less.
        self.blur.flat_radius_pix() + (2.5 * seeing.narrowest_fwhm_pix()).max(0.25 * length_pix)
    }
}

/// Seeing with ring and disk, of any flux.
fn blurred(blur: &Blur, cut: &CutSeeing, core: f64, intervals: usize, grain: Grain, panels: &Panels) -> Curve {
    let seeing_reach = cut.reach_pix;
    if blur.flat_radius_pix() == 0.0 {
        return Curve::of(Radii::new(core, seeing_reach, intervals), |r| cut.at(r));
    }
    // By its own nodes, twice as close as need be: read millions of times.
    let seeing = Curve::of(Radii::new(2.0 * grain.step_pix, seeing_reach, 512), |r| cut.at(r));
    let seeing = |r: f64| seeing.at(r);
    let (outer, inner) = (blur.outer_radius_pix, blur.inner_radius_pix);
    let radii = Radii::new(core, seeing_reach + outer, intervals);
    let ring = if outer > 0.0 {
        Curve::of(radii, |r| {
            // A ring is a disk without a smaller one.
            let disk = |a: f64| a * a * disk_mean(seeing, seeing_reach, grain.step_pix, a, r, panels);
            let hole = if inner > 0.0 { disk(inner) } else { 0.0 };
            (disk(outer) - hole) / (outer * outer - inner * inner)
        })
    } else {
        Curve::of(radii, seeing)
    };
    if blur.body_radius_pix == 0.0 {
        return ring;
    }
    let a = blur.body_radius_pix;
    let radii = Radii::new(core, seeing_reach + outer + a, intervals);
    Curve::of(radii, |r| disk_mean(|s| ring.at(s), ring.radii().end_pix(), grain.step_pix, a, r, panels))
}

/// The harmonics of a function of radius and angle.
fn in_harmonics(radii: Radii, function: impl Fn(f64, f64) -> f64) -> [Curve; HARMONICS] {
    let mut amplitudes: [Vec<f64>; HARMONICS] = Default::default();
    Curve::of(radii, |r| {
        let found = harmonics(std::array::from_fn(|j| function(r, angle(j))));
        for (column, amplitude) in amplitudes.iter_mut().zip(found) {
            column.push(amplitude);
        }
        0.0
    });
    amplitudes.map(|column| Curve::from_values(radii, column))
}

/// The radius beyond which all of some harmonics are negligible against the first, pixels.
fn felt_to(harmonics: &[Curve], round: &Curve) -> f64 {
    let least = NEGLIGIBLE * round.values()[0];
    let radii = round.radii();
    let is_felt = |node: &usize| harmonics.iter().any(|curve| curve.values()[*node].abs() > least);
    let last = (0..=radii.intervals()).rev().find(is_felt);
    last.map_or(0.0, |node| radii.radius((node + 1).min(radii.intervals())))
}

/// How many harmonics there are up to the last that is not negligible.
fn felt_count(pixel: &[Curve; HARMONICS]) -> usize {
    (1..HARMONICS).rev().find(|m| felt_to(&pixel[*m..=*m], &pixel[0]) > 0.0).map_or(1, |last| last + 1)
}

fn half_light(profile: &Curve, grain: Grain, panels: &Panels) -> f64 {
    let within = |to: f64| panels.integrate(0.0, to, 0.5 * grain.step_pix, |r| 2.0 * PI * r * profile.at(r));
    bisect(0.0, profile.radii().end_pix(), |r| within(r) > 0.5)
}

fn full_width(profile: &Curve) -> f64 {
    let half = 0.5 * profile.values().iter().copied().fold(0.0, f64::max);
    let radii = profile.radii();
    let inside = (0..=radii.intervals()).rev().find(|node| profile.values()[*node] > half).unwrap_or(0);
    let outside = radii.radius((inside + 1).min(radii.intervals()));
    2.0 * bisect(radii.radius(inside), outside, |r| profile.at(r) < half)
}

/// Where `is_beyond` turns true.
fn bisect(from: f64, to: f64, is_beyond: impl Fn(f64) -> bool) -> f64 {
    let mut bounds = [from, to];
    for _ in 0..40 {
        let middle = 0.5 * (bounds[0] + bounds[1]);
        bounds[usize::from(is_beyond(middle))] = middle;
    }
    bounds[1]
}
