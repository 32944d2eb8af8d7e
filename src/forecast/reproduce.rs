//! Comparison with published numbers: published number, computed number with its assumptions, and difference.

use std::f64::consts::{FRAC_PI_2, PI};

use hifitime::Epoch;

use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
use crate::elements::{Constellation, Shell};
use crate::error::Error;
use crate::frames::seconds_after;
use crate::output::{Column, Kind, Table};
use crate::passes::{Exposure, Field, PassOptions, Sky, SnapshotOptions};
use crate::photometry::PhotometryOptions;

/// Largest difference at which a computed number agrees with the published one, percent.
const AGREES_PERCENT: f64 = 20.0;

/// Published number with the number computed here.
#[derive(Clone, Debug, PartialEq)]
pub struct Reproduced {
    /// Description of the quantity.
    pub quantity: String,
    /// Unit; empty for a number of satellites.
    pub unit: &'static str,
    /// Published number, or count in the data released by the authors; `None` if neither exists.
    pub published: Option<f64>,
    /// Result of the formula of the paper, if no number is published.
    pub by_method: Option<f64>,
    /// Number computed by this library.
    pub ours: f64,
    /// Standard deviation of the computed number from counting statistics, if it is a count.
    pub ours_sigma: Option<f64>,
    /// Source of the published number.
    pub source: &'static str,
    /// Assumptions of the computation.
    pub assumed: String,
    /// Explanation of the difference; empty if there is no published number.
    pub reason: &'static str,
}

impl Reproduced {
    /// Returns the difference computed - published (or computed - `by_method`), in percent of the latter.
    pub fn difference_percent(&self) -> Option<f64> {
        self.published.or(self.by_method).map(|theirs| 100.0 * (self.ours - theirs) / theirs)
    }
}

/// Visits of the first year of LSST with a streak, percent, without avoidance: Hu et al. (2022, ApJL 941, L15).
pub const HU2022: [(&str, f64); 3] = [("starlink-gen1", 1.66), ("starlink-gen2", 8.69), ("oneweb", 10.63)];
/// Visits with a streak among the first 10,000 (2023-10-01 to 13), percent, from the counts by visit that the authors
/// released with the paper: github.com/lsst-sims/satellite-dodging-ApJL,
/// `plots/satellite_sim_0.0_{slv1,slv2,onew}_v2.2_1yrs.npz`, rows with `observationId` below 10,000 and `n_streaks`
/// above 0. All 214,014 visits of these files reproduce the three numbers of [`HU2022`] to the last digit.
const HU2022_FIRST_VISITS: [(&str, f64); 3] = [("starlink-gen1", 1.44), ("starlink-gen2", 7.95), ("oneweb", 9.22)];
const HU2022_FIRST_SOURCE: &str =
    "Hu et al. 2022, counts by visit released with the paper (lsst-sims/satellite-dodging-ApJL), visits 0 to 9,999";
const HU2022_REASON: &str = "season: in the counts of the paper the share of visits with a Gen2 streak varies from 12.6 % to 5.7 % between twelfths of the year";
const HU2022_FIRST_REASON: &str = "other visits of the same nights (baseline v2.0 here, v2.2 in the paper), and exposures of 30 s here but visits of 34 s in the paper: \
with 34 s the computed numbers are 11 % (Gen1), 7 % (Gen2) and 8 % (OneWeb) higher";
const HU2022_SOURCE: &str = "Hu et al. 2022 (ApJL 941, L15), simulated first year without avoidance";

/// Fraction of the visible satellites that are brighter than 7 mag, percent: Lu (2024, arXiv 2403.11118), abstract.
const LU2024B_PERCENT: f64 = 69.33;
const LU2024B_REASON: &str = "the lowest counted altitude, which the abstract does not state (see the rows above 0 and 30 deg), and the photometry \
that the model was fitted to";
const LU2024B_SOURCE: &str = "Lu 2024 (arXiv 2403.11118), abstract";
/// The 11,908 satellites of Lu (2024b): Gen1 as filed, and 7,500 of Gen2 as granted in FCC 22-91 (525, 530 and 535 km).
/// The planes of Gen2 are not published; 25 planes of 100 satellites are assumed for each shell. As in the paper, every
/// satellite has the V1.5 brightness model; the name of the constellation selects it.
const LU2024B_SHELLS: &str = r#"
[[constellation]]
name = "starlink-gen1-and-2a"
satellites = 11908
source = "SpaceX, FCC 21-48 (4,408) and FCC 22-91 (7,500, planes assumed)"
shell = [
    { altitude_km = 550, inclination_deg = 53.0, planes = 72, satellites_per_plane = 22, phasing = 17 },
    { altitude_km = 540, inclination_deg = 53.2, planes = 72, satellites_per_plane = 22, phasing = 17 },
    { altitude_km = 570, inclination_deg = 70.0, planes = 36, satellites_per_plane = 20 },
    { altitude_km = 560, inclination_deg = 97.6, planes = 6, satellites_per_plane = 58 },
    { altitude_km = 560, inclination_deg = 97.6, planes = 4, satellites_per_plane = 43, node_offset_deg = 30.0 },
    { altitude_km = 525, inclination_deg = 53.0, planes = 25, satellites_per_plane = 100 },
    { altitude_km = 530, inclination_deg = 43.0, planes = 25, satellites_per_plane = 100 },
    { altitude_km = 535, inclination_deg = 33.0, planes = 25, satellites_per_plane = 100 },
]
"#;

const BASSA2022_SOURCE: &str =
    "Bassa et al. 2022 (A&A 657, A75), section 2: their density of a shell, summed over the sky here; no printed count";
const BASSA2022_REASON: &str =
    "the flattened Earth, and the regular pattern of a shell's satellites instead of the formula's smooth density";

/// Returns the constellations of Lu (2024b).
///
/// # Errors
/// Never for the built-in shells.
pub fn lu2024b_constellations() -> Result<Vec<Constellation>, Error> {
    Constellation::from_toml(LU2024B_SHELLS)
}

/// Returns the fraction of exposures crossed by at least one lit satellite, percent, with the fraction that Hu et al.
/// (2022) published for a constellation of [`HU2022`]: over their year and, if `is_first_visits`, over their first
/// 10,000 visits (`HU2022_FIRST_VISITS`).
///
/// # Errors
/// Same as [`Sky::field_passes`].
pub fn hu2022(
    constellation: &str,
    sky: &Sky,
    exposures: &[Exposure],
    field: &Field,
    is_first_visits: bool,
    assumed: &str,
) -> Result<Vec<Reproduced>, Error> {
    let crossings = sky.field_passes(exposures, field, &PassOptions::default())?;
    let streaked = crossings.by_exposure.iter().filter(|passes| !passes.is_empty()).count() as f64;
    let visits = exposures.len() as f64;
    let row_of = |which: &str, numbers: &[(&str, f64)], source, reason| Reproduced {
        quantity: format!("{which} streaked by {constellation} ({} satellites)", sky.elements().len()),
        unit: "%",
        published: numbers.iter().find(|(name, _)| *name == constellation).map(|(_, percent)| *percent),
        by_method: None,
        ours: 100.0 * streaked / visits,
        ours_sigma: Some(100.0 * (streaked * (1.0 - streaked / visits)).sqrt() / visits),
        source,
        assumed: assumed.to_owned(),
        reason,
    };
    let mut rows = vec![row_of("visits of a year", &HU2022, HU2022_SOURCE, HU2022_REASON)];
    if is_first_visits {
        rows.push(row_of("the first 10,000 visits", &HU2022_FIRST_VISITS, HU2022_FIRST_SOURCE, HU2022_FIRST_REASON));
    }
    Ok(rows)
}

/// Returns the fraction, percent, of the lit satellites above an altitude that are brighter than 7 mag, averaged over
/// many times. The published fraction is included if `is_lu2024b`, that is, if the satellites are those of the paper.
///
/// # Errors
/// Same as [`Sky::snapshots`].
pub fn lu2024b(
    sky: &Sky,
    moments: &[Epoch],
    min_altitude_rad: f64,
    is_lu2024b: bool,
    assumed: &str,
) -> Result<Reproduced, Error> {
    let (mut lit, mut bright) = (0.0_f64, 0.0_f64);
    for moment in moments {
        let (seen, _) = sky.snapshots(*moment, &[0.0], &SnapshotOptions::all_above(min_altitude_rad))?;
        for track in &seen {
            for snapshot in track.snapshots.iter().filter(|snapshot| snapshot.is_lit()) {
                lit += 1.0;
                let light = sky.brightness(track.element_index, &snapshot.point, &PhotometryOptions::default());
                bright += if light.is_some_and(|light| light.magnitude.0 < 7.0) { 1.0 } else { 0.0 };
            }
        }
    }
    Ok(Reproduced {
        quantity: format!("lit satellites above {:.0} deg that are brighter than 7 mag", min_altitude_rad.to_degrees()),
        unit: "%",
        published: is_lu2024b.then_some(LU2024B_PERCENT),
        by_method: None,
        ours: 100.0 * bright / lit.max(1.0),
        // The same satellites are counted at all times, so the counts are not independent and no counting error is
        // given.
        ours_sigma: None,
        source: LU2024B_SOURCE,
        assumed: assumed.to_owned(),
        reason: if is_lu2024b { LU2024B_REASON } else { "" },
    })
}

/// Returns the mean number of satellites of a constellation above an altitude, lit or not, over a day from `start`,
/// with the number expected from the density of Bassa et al. (2022).
///
/// # Errors
/// Same as [`Sky::snapshots`].
pub fn bassa2022(
    constellation: &Constellation,
    sky: &Sky,
    start: Epoch,
    min_altitude_rad: f64,
    assumed: &str,
) -> Result<Reproduced, Error> {
    const MOMENTS: usize = 144;
    let mut seen = 0.0;
    for moment in 0..MOMENTS {
        let epoch = seconds_after(start, 86_400.0 * moment as f64 / MOMENTS as f64);
        seen += sky.snapshots(epoch, &[0.0], &SnapshotOptions::all_above(min_altitude_rad))?.0.len() as f64;
    }
    let latitude_rad = sky.viewpoint().site().map_or(f64::NAN, |observer| observer.site().latitude_rad);
    let expected =
        constellation.shells.iter().map(|shell| expected_above(shell, latitude_rad, min_altitude_rad)).sum::<f64>();
    Ok(Reproduced {
        quantity: format!("{} satellites above {:.0} deg", constellation.name, min_altitude_rad.to_degrees()),
        unit: "",
        published: None,
        by_method: Some(expected),
        ours: seen / MOMENTS as f64,
        ours_sigma: None,
        source: BASSA2022_SOURCE,
        assumed: assumed.to_owned(),
        reason: BASSA2022_REASON,
    })
}

/// Returns the mean number of satellites of a shell above an altitude at a latitude: Bassa et al. (2022), section 2, on
/// a spherical Earth.
///
/// N satellites in circular orbits of inclination i have at latitude δ the density
///
/// ```text
/// n(δ) = N / (2π² √(sin² i - sin² δ))   satellites per steradian about the Earth's centre
/// ```
///
/// Satellites above the altitude h are within the angle ψ = acos(R cos h / r) - h of the site, seen from the Earth's
/// centre, for the Earth's radius R and the radius r of the orbits. With sin δ = sin i sin u, where u is the argument
/// of latitude from -π/2 to π/2, the square root cancels, and the number above h at latitude φ is
///
/// ```text
/// N(h) = N / π² ∫ Δλ(u) du,   cos Δλ = (cos ψ - sin φ sin δ) / (cos φ cos δ)
/// ```
fn expected_above(shell: &Shell, latitude_rad: f64, min_altitude_rad: f64) -> f64 {
    const STEPS: usize = 20_000;
    let satellites = f64::from(shell.planes) * f64::from(shell.satellites_per_plane);
    let radius_km = EARTH_EQUATORIAL_RADIUS_KM + shell.altitude_km;
    let reach_rad = (EARTH_EQUATORIAL_RADIUS_KM * min_altitude_rad.cos() / radius_km).acos() - min_altitude_rad;
    let sine_of_inclination = shell.inclination_deg.to_radians().sin();
    let width_rad = |u_rad: f64| {
        let latitude_of_satellite_rad = (sine_of_inclination * u_rad.sin()).asin();
        let (sin, cos) = latitude_of_satellite_rad.sin_cos();
        let cosine = (reach_rad.cos() - latitude_rad.sin() * sin) / (latitude_rad.cos() * cos);
        cosine.clamp(-1.0, 1.0).acos()
    };
    let step_rad = PI / STEPS as f64;
    let sum: f64 = (0..STEPS).map(|step| width_rad(-FRAC_PI_2 + (step as f64 + 0.5) * step_rad)).sum();
    satellites / (PI * PI) * sum * step_rad
}

const COLUMNS: [Column; 11] = [
    Column::new("quantity", Kind::Text, "Quantity counted."),
    Column::new("unit", Kind::Text, "Unit; empty for a number of satellites."),
    Column::real("published", "", 2, "Number in the paper, or in the data released with it."),
    Column::real("ours", "", 2, "Computed number."),
    Column::real("ours_sigma", "", 2, "One sigma of the computed number from counting statistics."),
    Column::real(
        "difference_percent",
        "",
        1,
        "Computed number minus the published one (or by_method), in percent of the latter.",
    ),
    Column::new("agrees", Kind::Boolean, "True if the difference is at most 20 percent."),
    Column::new("source", Kind::Text, "Source of the published number."),
    Column::new("assumed", Kind::Text, "Assumptions of the computation."),
    Column::real("by_method", "", 2, "Result of the paper's formula, computed here, if the paper prints no number."),
    Column::new("reason", Kind::Text, "Reason for the difference."),
];

/// Returns published and computed numbers as a table.
pub fn reproduced_table(rows: &[Reproduced]) -> Table {
    let row = |number: &Reproduced| {
        vec![
            number.quantity.as_str().into(),
            number.unit.into(),
            number.published.into(),
            number.ours.into(),
            number.ours_sigma.into(),
            number.difference_percent().into(),
            number.difference_percent().map(|percent| percent.abs() <= AGREES_PERCENT).into(),
            number.source.into(),
            number.assumed.as_str().into(),
            number.by_method.into(),
            Some(number.reason).filter(|reason| !reason.is_empty()).into(),
        ]
    };
    Table { columns: COLUMNS.to_vec(), rows: rows.iter().map(row).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_over_the_whole_sky_holds_all_its_satellites() {
        let shell = &lu2024b_constellations().expect("part of the library")[0].shells[2];
        // A cap with a radius of 180° contains every satellite.
        let everywhere = {
            let far = Shell { altitude_km: 5_000.0, ..shell.clone() };
            expected_above(&far, 0.0, -FRAC_PI_2 + 1e-9)
        };
        assert!((everywhere - 720.0).abs() < 1.0, "{everywhere}");
        // Polar shell and site at the pole: every orbit crosses the zenith, with two arcs of length ψ of the 2π of a
        // revolution.
        let polar = Shell { inclination_deg: 90.0, ..shell.clone() };
        let reach_rad = (EARTH_EQUATORIAL_RADIUS_KM / (EARTH_EQUATORIAL_RADIUS_KM + 570.0)).acos();
        let at_the_pole = expected_above(&polar, FRAC_PI_2 - 1e-6, 0.0);
        assert!((at_the_pole / (720.0 * reach_rad / PI) - 1.0).abs() < 1e-3, "{at_the_pole}");
    }
}
