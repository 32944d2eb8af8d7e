//! Records written as an MMT-9 table.

use std::io::Write;

use crate::output::format_utc;

use super::error::MeasuredError;
use super::record::Records;

/// Writes `Date,StdMag,Mag,Filter,Penumbra,Distance,Phase,Channel,Track,NORAD`: the columns of MMT-9's own CSV, and the catalogue number,
/// which the survey keeps in the head of one file a satellite. Digits are those of the survey: 0.1 µs of 1 s, 1e-5 mag, 1 m, 0.001°.
///
/// `StdMag` is the survey's own: `Mag - 5 log10(d / 1000 km) + 2.5 log10(1 + cos φ)`. Records without time, distance or phase are not
/// written.
///
/// # Errors
/// [`MeasuredError::Unwritable`].
pub fn write_mmt_csv(out: &mut dyn Write, records: &Records) -> Result<(), MeasuredError> {
    let failed = |error: std::io::Error| MeasuredError::Unwritable { problem: error.to_string() };
    writeln!(out, "Date,StdMag,Mag,Filter,Penumbra,Distance,Phase,Channel,Track,NORAD").map_err(failed)?;
    for record in &records.records {
        let (Some(epoch), (Some(range_km), Some(phase_rad))) = (record.epoch, record.sighting.distance_and_phase())
        else {
            continue;
        };
        let magnitude = record.magnitude.0;
        let standard = record.magnitude.to_standard(range_km).0 + 2.5 * (1.0 + phase_rad.cos()).log10();
        let date = format_utc(epoch, 6).replace('T', " ");
        let (penumbra, phase) = (u8::from(record.in_penumbra), phase_rad.to_degrees());
        let track = records.groups.get(record.group as usize).map_or("", String::as_str);
        let norad = record.norad_id.map(|id| id.to_string()).unwrap_or_default();
        let date = date.trim_end_matches('Z');
        writeln!(
            out,
            "{date},{standard:.3},{magnitude:.5},Clear,{penumbra},{range_km:.3},{phase:.3},0,{track},{norad}"
        )
        .map_err(failed)?;
    }
    out.flush().map_err(failed)
}
