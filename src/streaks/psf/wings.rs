//! Seeing whose wings end somewhere, with all of its light.

use std::f64::consts::PI;

use super::integrals::{Grain, Panels};
use super::seeing::Seeing;

/// Share of the flux beyond which wings are cut: none of it is lost, so much lies nearer than it should.
const CUT_SHARE: f64 = 1e-4;

/// Brightness of a line across itself, of its middle, below which wings are cut; for a Gaussian this is the stricter one.
const CUT_BRIGHTNESS: f64 = 1e-5;

/// Seeing within a radius; what lay beyond is added to the outermost of what is left.
///
/// f(r) (1 + g (r/R)⁴) for r up to R, with g such that the flux is 1. Cores keep their brightness: for a Moffat profile of β 2.5 what is added at half the
/// radius is a fiftieth of what is there.
#[derive(Copy, Clone, Debug)]
pub(super) struct CutSeeing {
    seeing: Seeing,
    pub reach_pix: f64,
    gain: f64,
}

impl CutSeeing {
    pub fn of(seeing: &Seeing, panels: &Panels) -> Self {
        let reach_pix = seeing
            .radius_where(|r| seeing.beyond(r) <= CUT_SHARE && seeing.line(r) <= CUT_BRIGHTNESS * seeing.line(0.0));
        let fwhm = seeing.narrowest_fwhm_pix();
        let grain = Grain { step_pix: 0.6 * fwhm, even_to_pix: 2.5 * fwhm };
        let moment =
            panels.integrate_outwards(reach_pix, grain, |r| 2.0 * PI * r * (r / reach_pix).powi(4) * seeing.at(r));
        Self { seeing: *seeing, reach_pix, gain: seeing.beyond(reach_pix) / moment }
    }

    /// Surface brightness at a radius of at most the reach, per square pixel.
    pub fn at(&self, r_pix: f64) -> f64 {
        self.seeing.at(r_pix) * (1.0 + self.gain * (r_pix / self.reach_pix).powi(4))
    }
}
