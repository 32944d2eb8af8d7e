//! The light of a long straight line in the pixels of rows: what neighbouring columns have lies side by side.

use super::curve::Curve;

/// The light of a straight line at one angle, for all ways in which it may lie among the pixels of a row.
///
/// From one column to the next a pixel's distance from the line grows by the same step. Rows differ in where among the columns the line passes: of this
/// "phase" there are several, each with the light in all columns; between them it is a parabola. Reading needs no look-up by distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    first_pix: f32,
    step_pix: f32,
    phase_pix: f32,
    per_step: f32,
    per_phase: f32,
    last_phase: i32,
    columns: usize,
    /// All columns of the first phase, of the second, ... and of the first again, a column on: of each phase light, then its first and second power of the way from there, in phases.
    powers: Vec<f32>,
}

/// Columns in the dark on either side. Pixels that are drawn lie at most twice a chord's sagitta beyond the reach of its light; chords of up to 256 pixels that may share a
/// lattice turn by half a phase over [`Lattice::COLUMNS`], so that this is a phase or less, and half a phase more is what they turn by as they are read.
const MARGIN: f64 = 3.0;

impl Lattice {
    /// Columns that may be read at a time where a path turns by as much as it may.
    pub const COLUMNS: usize = 64;

    /// About how many places it has; infinite for a line along the rows.
    pub(super) fn numbers(reach_pix: f64, step_pix: f64, phase_pix: f64) -> f64 {
        ((step_pix / phase_pix).ceil() + 1.0) * 2.0 * reach_pix / step_pix
    }

    /// Of a line whose light ends at `reach_pix`, `step_pix` farther from each column, phases at most `phase_pix` apart.
    pub(super) fn of(line: &Curve, reach_pix: f64, step_pix: f64, phase_pix: f64) -> Self {
        let phases = (step_pix / phase_pix).ceil().max(1.0) as isize;
        let phase_pix = step_pix / phases as f64;
        // From the middle of the line as many columns to either side; all distances are whole numbers of phases.
        let half = (reach_pix / step_pix + MARGIN).ceil() as isize;
        let columns = 2 * half as usize + 1;
        let fine: Vec<f32> =
            (0..(half + 1) * phases + 2).map(|place| line.at(place as f64 * phase_pix) as f32).collect();
        let light = |place: isize| fine[place.unsigned_abs()];
        // With L₋, L₀, L₊ a phase apart: L₀ + t (L₊ - L₋)/2 + t² ((L₊ + L₋)/2 - L₀)
        let mut powers = Vec::with_capacity(3 * (phases as usize + 1) * columns);
        for phase in 0..=phases {
            let places = (-half..=half).map(|column| column * phases + phase);
            powers.extend(places.clone().map(light));
            powers.extend(places.clone().map(|at| 0.5 * (light(at + 1) - light(at - 1))));
            powers.extend(places.map(|at| 0.5 * (light(at + 1) + light(at - 1)) - light(at)));
        }
        let first = -half as f64 * step_pix;
        let [first_pix, step_pix, phase_pix] = [first, step_pix, phase_pix].map(|length| length as f32);
        Self {
            first_pix,
            step_pix,
            phase_pix,
            per_step: 1.0 / step_pix,
            per_phase: 1.0 / phase_pix,
            last_phase: phases as i32,
            columns,
            powers,
        }
    }

    /// From one column to the next, pixels.
    #[inline(always)]
    pub fn step_pix(&self) -> f32 {
        self.step_pix
    }

    /// Phases in a pixel of distance.
    #[inline(always)]
    pub fn phases_per_pix(&self) -> f32 {
        self.per_phase
    }

    /// Columns and nearest phases for `N` pixels at distances from the line, with their signs, and the distances that these have, pixels.
    #[inline(always)]
    pub fn places<const N: usize>(&self, across_pix: &[f32; N]) -> ([[i32; 2]; N], [f32; N]) {
        let (mut places, mut known_pix) = ([[0; 2]; N], [0.0; N]);
        for lane in 0..N {
            let since = across_pix[lane] - self.first_pix;
            let column = (since * self.per_step) as i32;
            let rest = since - column as f32 * self.step_pix;
            let phase = ((rest * self.per_phase + 0.5) as i32).clamp(0, self.last_phase);
            places[lane] = [column, phase];
            known_pix[lane] = self.first_pix + phase as f32 * self.phase_pix + column as f32 * self.step_pix;
        }
        (places, known_pix)
    }

    /// Light of a line of unit light per pixel in `count` neighbouring columns of a row from a place on, each nearly a step farther from the line than the one before: powers of the distance from
    /// that phase, in phases, good as far as the next one to either side. None where they lie beyond the lattice, in the dark.
    #[inline(always)]
    pub fn light(&self, [column, phase]: [i32; 2], count: usize) -> Option<[&[f32]; 3]> {
        let column = usize::try_from(column).ok().filter(|column| column + count <= self.columns)?;
        let at = 3 * phase as usize * self.columns + column;
        let [light, first, second] = [0, 1, 2].map(|power| {
            let at = at + power * self.columns;
            self.powers.get(at..at + count)
        });
        Some([light?, first?, second?])
    }
}

#[cfg(test)]
mod tests {
    use crate::streaks::psf::{Blur, Lattice, RadialProfile, Seeing};

    #[test]
    fn verif_a_lattice_holds_the_light_of_a_line() {
        // Of the peak: a parabola between phases, 7e-6, the table it is made from and single precision.
        const TOLERANCE: f64 = 2e-5;
        /// Enough for a lattice to be worth its making.
        const PIXELS: usize = 1_000_000;
        let ring = Blur {
            seeing: Seeing::Gaussian { fwhm_pix: 3.5 },
            outer_radius_pix: 7.8,
            inner_radius_pix: 4.8,
            body_radius_pix: 0.5,
        };
        let moffat = |fwhm_pix, beta| Blur::seeing(Seeing::Moffat { fwhm_pix, beta });
        for blur in [ring, moffat(1.0, 4.765), moffat(3.5, 2.5)] {
            let profile = RadialProfile::of(&blur).unwrap();
            let profile = profile.tables();
            let peak = profile.line(0.0, 0.0).max(profile.line(6.0, 0.0));
            assert!(profile.line_lattice(1e-4, PIXELS).is_none() && profile.line_lattice(0.0, PIXELS).is_none());
            for angle in [0.02, 0.7, 1.5, 2.6, -0.4] {
                let lattice = profile.line_lattice(angle, PIXELS).unwrap();
                let step = angle.sin().abs();
                // One that turns by as much as a chord may, either way.
                for turned in [-1.0, 1.0].map(|side| step + side * profile.lattice_turn_rad(angle)) {
                    for number in 0..300 {
                        let first = -profile.pixel_reach_pix() * (1.0 - 2.0 * f64::from(number) / 300.0);
                        let ([place], [known_pix]) = lattice.places(&[first as f32]);
                        let lit = ((profile.pixel_reach_pix() - first) / turned) as usize + 1;
                        let count = lit.min(Lattice::COLUMNS);
                        let [light, slope, bend] = lattice.light(place, count).expect("what is lit is known");
                        for column in 0..count {
                            let across = first + column as f64 * turned;
                            let known = known_pix + column as f32 * lattice.step_pix();
                            let way = (across as f32 - known) * lattice.phases_per_pix();
                            let found = light[column] + way * (slope[column] + way * bend[column]);
                            let error = f64::from(found) - profile.line(across, angle);
                            assert!(error.abs() < TOLERANCE * peak, "{blur:?} {angle} {across}: {}", error / peak);
                        }
                    }
                }
            }
        }
    }
}
