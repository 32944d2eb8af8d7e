//! What numbers are of, for the provenance of every answer.

use crate::output::Provenance;
use crate::photometry::PhotometryOptions;

/// Time scale and what magnitudes are of, as every answer states them.
pub fn state_scales(provenance: &mut Provenance, time_scale: &str, photometry: &PhotometryOptions) {
    provenance.state("time_scale", time_scale);
    provenance.state("band", photometry.band.name());
    provenance.state("mag_system", photometry.system.to_string());
    provenance.state("earthshine", photometry.earthshine.name());
    if let Some(extinction) = photometry.extinction_mag_per_airmass {
        provenance.state("extinction_mag_per_airmass", extinction);
    }
    if photometry.sun_distance {
        provenance.state("sun_distance", "of the day");
    }
}
