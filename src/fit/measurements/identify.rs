//! Which satellite each track of a survey is of, where one stands out.

use rayon::prelude::*;

use crate::elements::History;
use crate::frames::EopTable;
use crate::output::{Column, Kind, Table, Value};

use super::associate::{AssociationOptions, Candidate, associate};
use super::record::Records;

/// When the best candidate of a track is taken to be its satellite.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Credible {
    /// Its ranges are no farther off (root mean square), km.
    pub max_range_rms_km: f64,
    /// Its phase angles, where they are recorded, are no farther off (root mean square), radians.
    pub max_phase_rms_rad: f64,
    /// The score of the next best is greater by at least so much (it is a χ²).
    pub least_lead: f64,
}

impl Default for Credible {
    /// 10 km, 3° and a lead of 9: three sigma.
    fn default() -> Self {
        Self { max_range_rms_km: 10.0, max_phase_rms_rad: 3_f64.to_radians(), least_lead: 9.0 }
    }
}

/// A track with its best candidates.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// Name of the track.
    pub track: String,
    /// The best candidate; `None` where no satellite was anywhere near.
    pub best: Option<Candidate>,
    /// The next best.
    pub next: Option<Candidate>,
    /// True where the best one is credible and the next one is not as good.
    pub is_sure: bool,
}

/// All tracks of the records, in their order, each against the whole catalogue.
pub fn identify(
    records: &Records,
    history: &History,
    eop: &EopTable,
    options: &AssociationOptions,
    credible: &Credible,
) -> Vec<Identification> {
    let tracks: Vec<(&String, Vec<_>)> = records.groups.iter().zip(records.by_group()).collect();
    let one = |(track, rows): &(&String, Vec<_>)| {
        let mut candidates = associate(rows, &records.sites, history, eop, options).into_iter();
        let (best, next) = (candidates.next(), candidates.next());
        let is_near = |best: &Candidate| {
            best.range_rms_km <= credible.max_range_rms_km
                && best.phase_rms_rad.is_none_or(|phase| phase <= credible.max_phase_rms_rad)
                && next.is_none_or(|next| next.score - best.score >= credible.least_lead)
        };
        Identification { track: (*track).clone(), best, next, is_sure: best.as_ref().is_some_and(is_near) }
    };
    tracks.par_iter().map(one).collect()
}

const COLUMNS: [Column; 9] = [
    Column::new("track", Kind::Text, "Name of the track."),
    Column::new("norad", Kind::Integer, "Its satellite; empty where none stands out."),
    Column::new("best", Kind::Integer, "The satellite that explains it best, sure or not."),
    Column::real(
        "range_rms_km",
        "km",
        3,
        "Root mean square of the differences of range, once its lateness is taken out.",
    ),
    Column::real("phase_rms_deg", "deg", 3, "The same of the phase angle."),
    Column::real("offset_s", "s", 2, "The satellite is where its element set has it so many seconds later."),
    Column::real("element_age_days", "d", 2, "From the element set's epoch to the track."),
    Column::new("next", Kind::Integer, "The next best satellite."),
    Column::real("lead", "", 2, "By how much the next best explains it worse (chi square)."),
];

/// One row a track: what [`Placement::identified`](super::Placement::identified) is made of.
pub fn identification_table(tracks: &[Identification]) -> Table {
    let number = |candidate: Option<&Candidate>| {
        candidate.map_or(Value::Null, |candidate| Value::Integer(i64::from(candidate.norad_id.0)))
    };
    let row = |one: &Identification| {
        let (best, next) = (one.best.as_ref(), one.next.as_ref());
        vec![
            one.track.as_str().into(),
            number(best.filter(|_| one.is_sure)),
            number(best),
            best.map(|best| best.range_rms_km).into(),
            best.and_then(|best| best.phase_rms_rad).map(f64::to_degrees).into(),
            best.map(|best| best.offset_s).into(),
            best.map(|best| best.element_age_days).into(),
            number(next),
            best.zip(next).map(|(best, next)| next.score - best.score).into(),
        ]
    };
    Table { columns: COLUMNS.to_vec(), rows: tracks.iter().map(row).collect() }
}
