//! Simulated photometry of satellites with a brightness model over MMT-9, and its table.

use std::io::Write;

use streakcast::elements::History;
use streakcast::fit::measurements::Records;
pub use streakcast::fit::{Simulation, SimulationOptions};
use streakcast::geometry::Site;
use streakcast::output::format_utc;
use streakcast::photometry::{BrightnessModel, Earthshine};

/// Simulates photometry without earthshine.
pub fn simulate(model: &BrightnessModel, history: &History, options: &SimulationOptions) -> Simulation {
    simulate_with(model, Earthshine::Off, history, options)
}

/// Simulates photometry with or without earthshine.
pub fn simulate_with(
    model: &BrightnessModel,
    earthshine: Earthshine,
    history: &History,
    options: &SimulationOptions,
) -> Simulation {
    let site = Site::by_name("MMT-9").expect("a known site");
    let law = |geometry: &_| model.standard_magnitude_with(geometry, earthshine);
    streakcast::fit::simulate(&law, &site, history, options, &|| ()).expect("valid nights")
}

/// Writes records as an MMT-9 table with the catalogue number as an additional column, with the digits of the survey.
///
/// `StdMag` is computed as in the survey: `Mag - 5 log10(d / 1000 km) + 2.5 log10(1 + cos φ)`.
pub fn write_mmt_csv(out: &mut dyn Write, records: &Records) -> std::io::Result<()> {
    writeln!(out, "Date,StdMag,Mag,Filter,Penumbra,Distance,Phase,Channel,Track,NORAD")?;
    for record in &records.records {
        let (Some(epoch), (Some(range_km), Some(phase_rad))) = (record.epoch, record.sighting.distance_and_phase())
        else {
            continue;
        };
        let magnitude = record.magnitude.0;
        let standard = record.magnitude.to_standard(range_km).0 + 2.5 * (1.0 + phase_rad.cos()).log10();
        let date = format_utc(epoch, 6).replace('T', " ");
        let (date, phase_deg) = (date.trim_end_matches('Z'), phase_rad.to_degrees());
        let track = &records.groups[record.group as usize];
        let norad = record.norad_id.map(|id| id.to_string()).unwrap_or_default();
        writeln!(out, "{date},{standard:.3},{magnitude:.5},Clear,0,{range_km:.3},{phase_deg:.3},0,{track},{norad}")?;
    }
    out.flush()
}
