//! The light of a long straight line in the pixels of rows: what neighbouring columns have lies side by side.

use super::lanes::Lanes;

/// The light of a straight line at one angle, for all ways in which it may lie among the pixels of a row.
///
/// From one column to the next a pixel's distance from the line grows by the same step. Rows differ in where among the columns the line passes: of this
/// "phase" there are many, each with the light in all columns, linear from one to the next. Reading needs no look-up by distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    first_pix: f32,
    step_pix: f32,
    phase_pix: f32,
    per_step: f32,
    per_phase: f32,
    last_phase: i32,
    columns: usize,
    /// All columns of the first phase, of the second, ... and of the first again, a column on.
    light: Vec<f32>,
}

/// Values made at a time.
const LANES: usize = 16;

impl Lattice {
    /// Columns that may be read at a time: over them a path may turn.
    pub const COLUMNS: usize = 64;

    /// Of a line whose light ends at `reach_pix`, `step_pix` farther from each column, phases at most `phase_pix` apart.
    pub(super) fn of(line: &Lanes, reach_pix: f64, step_pix: f64, phase_pix: f64) -> Self {
        let phases = (step_pix / phase_pix).ceil().max(1.0) as usize;
        let margin = Self::COLUMNS as f64 * step_pix;
        let first = -reach_pix - margin;
        let columns = (2.0 * (reach_pix + margin) / step_pix).ceil() as usize + 1;
        let phase_pix = step_pix / phases as f64;
        let mut light = Vec::with_capacity((phases + 1) * columns);
        for phase in 0..=phases {
            for block in (0..columns).step_by(LANES) {
                let distance = |lane: usize| first + phase as f64 * phase_pix + (block + lane) as f64 * step_pix;
                let values = line.at::<LANES>(&std::array::from_fn(|lane| distance(lane).abs() as f32));
                light.extend_from_slice(&values[..LANES.min(columns - block)]);
            }
        }
        let [first_pix, step_pix, phase_pix] = [first, step_pix, phase_pix].map(|length| length as f32);
        let last_phase = phases as i32 - 1;
        Self {
            first_pix,
            step_pix,
            phase_pix,
            per_step: 1.0 / step_pix,
            per_phase: 1.0 / phase_pix,
            last_phase,
            columns,
            light,
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

    /// Column and phase for a pixel at a distance from the line, with its sign, and the distance that these have, pixels.
    #[inline(always)]
    pub fn place(&self, across_pix: f32) -> ([i32; 2], f32) {
        let since = across_pix - self.first_pix;
        let column = (since * self.per_step) as i32;
        let rest = since - column as f32 * self.step_pix;
        let phase = ((rest * self.per_phase) as i32).clamp(0, self.last_phase);
        ([column, phase], self.first_pix + phase as f32 * self.phase_pix + column as f32 * self.step_pix)
    }

    /// Light in at most [`Lattice::COLUMNS`] neighbouring columns of a row from a place on, each nearly a step farther from the line than the one before, at that phase
    /// and the next; none where they lie beyond the lattice, in the dark.
    #[inline(always)]
    pub fn light(&self, [column, phase]: [i32; 2], count: usize) -> Option<[&[f32]; 2]> {
        let column = usize::try_from(column).ok().filter(|column| column + count <= self.columns)?;
        let at = phase as usize * self.columns + column;
        let [first, second] = [at, at + self.columns].map(|at| self.light.get(at..at + count));
        Some([first?, second?])
    }
}

#[cfg(test)]
mod tests {
    use crate::camera::psf::{Blur, Lattice, RadialProfile, Seeing};

    #[test]
    fn verif_a_lattice_holds_the_light_of_a_line() {
        // Of the peak: linear between phases, 6e-6, six times as much where columns lie half a phase off, and single precision.
        const TOLERANCE: f64 = 4e-5;
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
            assert!(profile.line_lattice(1e-4).is_none());
            for angle in [0.02, 0.7, 1.5, 2.6, -0.4] {
                let lattice = profile.line_lattice(angle).unwrap();
                let step = angle.sin().abs();
                // One that turns by as much as a chord may.
                let turned = step + profile.lattice_turn_rad();
                for number in 0..300 {
                    let first = -profile.pixel_reach_pix() * (1.0 - 2.0 * f64::from(number) / 300.0);
                    let (place, known_pix) = lattice.place(first as f32);
                    let [before, after] = lattice.light(place, Lattice::COLUMNS).unwrap();
                    for (column, (before, after)) in before.iter().zip(after).enumerate() {
                        let across = first + column as f64 * turned;
                        let known = known_pix + column as f32 * lattice.step_pix();
                        let found = before + (across as f32 - known) * lattice.phases_per_pix() * (after - before);
                        let error = f64::from(found) - profile.line(across, angle);
                        assert!(error.abs() < TOLERANCE * peak, "{blur:?} {angle} {across}: {}", error / peak);
                    }
                }
            }
        }
    }
}
