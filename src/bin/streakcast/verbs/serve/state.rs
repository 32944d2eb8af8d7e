//! Inputs and verdicts of the server. They are computed at the start, and again if the element files change.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Deref;
use std::sync::{Arc, Mutex, PoisonError};

use hifitime::Epoch;
use streakcast::Watch;
use streakcast::config::{Config, LoadedInputs, ObservationPlan, PreparedSky};
use streakcast::elements::Deployment;
use streakcast::geometry::Site;
use streakcast::orbit::LeftOut;
use streakcast::output::Provenance;
use streakcast::passes::{PassOptions, Sky, VisiblePasses};
use streakcast::photometry::ModelLibrary;
use streakcast::schedule::{FlagRequest, MagnitudeLimit, Policy, ScheduledExposure, Verdict, evening_mjd};

use super::problem::Problem;
use super::query::{Parameter, Query, number, optional};
use super::workers::ResponseCache;
use crate::local_time::LocalTime;
use streakcast::Error;

/// Parameter that [`ServerState::policy`] reads.
pub const LIMIT_MAG: Parameter = optional(
    "limit_mag",
    number(-30.0, 40.0, " mag"),
    "Limiting magnitude of the policy; default: that of the server.",
);

/// Statements of the provenance that depend on the period of constellations that grow.
const OF_SATELLITES: [&str; 4] = ["elements", "shells", "satellites", "models"];

/// Schedule with its verdicts, satellites and site.
pub struct ServerState {
    pub config: Config,
    pub skies: Skies,
    /// Site of all responses except those of the SatChecker paths.
    pub site: Site,
    pub plan: ObservationPlan,
    /// Rows of the schedule; empty without a schedule.
    pub exposures: Vec<ScheduledExposure>,
    /// Start of the server.
    pub started: Epoch,
    /// Verdicts, one for each row of the schedule.
    pub flags: Vec<Verdict>,
    /// Warnings about the verdicts, and number of satellites whose position cannot be computed.
    pub caveats: Caveats,
    /// Provenance without attached lists (rejected records), which may be long.
    pub provenance: Provenance,
    pub library: ModelLibrary,
    /// Rows of each night, by the MJD of its evening.
    pub nights: BTreeMap<i64, Vec<usize>>,
    /// Bands that an exposure may have.
    pub bands: BTreeSet<String>,
    /// Responses computed from these inputs.
    pub cache: ResponseCache,
    /// Local time of the page; by the longitude of the site if `None`.
    pub local_time: Option<LocalTime>,
}

/// Satellites over the site: one sky for all times, or with constellations that grow one for each of their periods.
pub enum Skies {
    One(Arc<PreparedSky>),
    Growing(Box<GrowingSkies>),
}

/// Largest number of skies of other periods that are kept.
const MOST_OTHER_SKIES: usize = 2;

/// Skies of constellations that grow, by the number of periods that have begun.
pub struct GrowingSkies {
    pub deployment: Deployment,
    pub inputs: LoadedInputs,
    /// Sky of requests without a time: that of the first row of the schedule, or of the start of the server.
    pub first: Arc<PreparedSky>,
    /// Skies of the nights of the schedule, or of the night in which the server was started.
    pub of_schedule: BTreeMap<usize, Arc<PreparedSky>>,
    /// The last skies of other periods.
    pub others: Mutex<Vec<OtherSky>>,
}

/// Sky of a period without a night of the schedule. Its satellites are those of the UTC day of the request, so that the
/// same request has the same response.
pub struct OtherSky {
    period: usize,
    day_mjd: i64,
    sky: Arc<PreparedSky>,
}

impl Skies {
    /// Returns the sky of requests without a time.
    pub fn first(&self) -> Arc<PreparedSky> {
        match self {
            Self::One(sky) => Arc::clone(sky),
            Self::Growing(skies) => Arc::clone(&skies.first),
        }
    }
}

impl GrowingSkies {
    fn at(&self, epoch: Epoch, evening_mjd: i64) -> Result<Arc<PreparedSky>, Error> {
        let period = self.deployment.periods_begun(evening_mjd);
        if let Some(sky) = self.of_schedule.get(&period) {
            return Ok(Arc::clone(sky));
        }
        let day_mjd = epoch.to_mjd_utc_days().floor() as i64;
        let find = |others: &[OtherSky]| {
            let found = others.iter().find(|other| (other.period, other.day_mjd) == (period, day_mjd));
            found.map(|other| Arc::clone(&other.sky))
        };
        let lock = || self.others.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(sky) = find(&lock()) {
            return Ok(sky);
        }
        // The lock is not held while a sky is prepared: a waiting pool thread may start another request, which would
        // wait for the lock.
        let sky = Arc::new(self.inputs.prepare(epoch, epoch)?);
        let mut others = lock();
        if let Some(existing) = find(&others) {
            return Ok(existing);
        }
        others.push(OtherSky { period, day_mjd, sky: Arc::clone(&sky) });
        let surplus = others.len().saturating_sub(MOST_OTHER_SKIES);
        others.drain(..surplus);
        Ok(sky)
    }
}

/// Warnings about a response, and number of satellites whose position cannot be computed.
pub struct Caveats {
    /// Warnings, as on the command line.
    pub warnings: Vec<String>,
    /// Number of satellites whose position cannot be computed.
    pub left_out_count: usize,
}

/// State of the server for one request. The queries of its sky stop when the client leaves or a time limit has passed.
pub struct RequestState {
    shared: Arc<ServerState>,
    watch: Watch,
    prepared: Arc<PreparedSky>,
    sky: Sky,
}

impl Deref for RequestState {
    type Target = ServerState;

    fn deref(&self) -> &ServerState {
        &self.shared
    }
}

impl RequestState {
    /// Creates the state with the sky of the first night.
    pub fn new(shared: Arc<ServerState>, watch: &Watch) -> Self {
        Self::with_sky(shared.skies.first(), shared, watch)
    }

    fn with_sky(prepared: Arc<PreparedSky>, shared: Arc<ServerState>, watch: &Watch) -> Self {
        Self { sky: prepared.sky.watched(watch), prepared, shared, watch: watch.clone() }
    }

    /// Returns the state with the satellites of the night at a time.
    ///
    /// # Errors
    /// The night is before the first period of constellations that grow.
    pub fn at(&self, epoch: Epoch) -> Result<Self, Problem> {
        let prepared = match &self.skies {
            Skies::One(sky) => Ok(Arc::clone(sky)),
            Skies::Growing(skies) => skies.at(epoch, evening_mjd(epoch, self.site.longitude_rad)),
        };
        let prepared = prepared?;
        Ok(Self::with_sky(prepared, Arc::clone(&self.shared), &self.watch))
    }

    /// Returns the number of periods of constellations that have begun in the night at a time; 0 if none grow.
    pub fn period(&self, epoch: Epoch) -> usize {
        match &self.skies {
            Skies::One(_) => 0,
            Skies::Growing(skies) => skies.deployment.periods_begun(evening_mjd(epoch, self.site.longitude_rad)),
        }
    }

    pub fn sky(&self) -> &Sky {
        &self.sky
    }

    pub fn prepared(&self) -> &PreparedSky {
        &self.prepared
    }

    /// Returns the provenance of a response with the satellites of this state.
    pub fn provenance(&self) -> Provenance {
        let mut provenance = self.shared.provenance.clone();
        if let Skies::Growing(_) = &self.skies {
            for (name, value) in self.prepared.provenance.entries().filter(|(name, _)| OF_SATELLITES.contains(name)) {
                provenance.state(name, value.clone());
            }
        }
        provenance
    }

    /// Returns the caveats of a response for times from `first` to `last`; `left_out` are the satellites whose position
    /// cannot be computed.
    ///
    /// # Errors
    /// No satellite has a position, or positions are unknown; an empty response would be misleading.
    pub fn caveats_at(&self, first: Epoch, last: Epoch, left_out: &[LeftOut]) -> Result<Caveats, Problem> {
        self.prepared.check_known(first, last, None)?;
        self.caveats_of_verdict(first, last, left_out)
    }

    /// Returns the caveats of passes, which may be those before the decay of the only satellite.
    ///
    /// # Errors
    /// No satellite has a position, or positions are unknown.
    pub fn caveats_of_passes(&self, first: Epoch, last: Epoch, found: &VisiblePasses) -> Result<Caveats, Problem> {
        self.prepared.check_known(first, last, None)?;
        let left_out = self.prepared.left_out_warning_of_times(&found.left_out, first, found.has_passes())?;
        let warnings = self.prepared.warnings_at(first, last).into_iter().chain(left_out).collect();
        Ok(Caveats { warnings, left_out_count: found.left_out.len() })
    }

    /// Returns the caveats of a response with a verdict, which states whether positions are unknown.
    ///
    /// # Errors
    /// No satellite has a position.
    pub fn caveats_of_verdict(&self, first: Epoch, last: Epoch, left_out: &[LeftOut]) -> Result<Caveats, Problem> {
        let of_left_out = self.prepared.left_out_warning(left_out, first);
        let mut warnings = self.prepared.warnings_at(first, last);
        warnings.extend(of_left_out?);
        Ok(Caveats { warnings, left_out_count: left_out.len() })
    }

    /// Returns a request for verdicts with this policy.
    pub fn request<'a>(&'a self, policy: &'a Policy) -> FlagRequest<'a> {
        FlagRequest { policy, ..self.plan.request(self.sky()) }
    }
}

impl ServerState {
    /// Returns local time minus UTC at a time, hours; by default the longitude of the site (15° per hour), rounded to
    /// whole hours.
    pub fn utc_offset_h(&self, epoch: Epoch) -> f64 {
        let by_longitude = || (self.site.longitude_rad.to_degrees() / 15.0).round();
        self.local_time.as_ref().map_or_else(by_longitude, |zone| zone.ahead_of_utc_h(epoch))
    }

    /// Returns the values of local time minus UTC in a range: the times from which they hold, and the values, hours.
    /// The first time is `from`.
    pub fn utc_offsets(&self, from: Epoch, to: Epoch) -> Vec<(Epoch, f64)> {
        let changes = self.local_time.as_ref().map(|zone| zone.changes(from, to)).unwrap_or_default();
        std::iter::once((from, self.utc_offset_h(from))).chain(changes).collect()
    }

    /// Checks the band of an exposure.
    ///
    /// # Errors
    /// The band is unknown: it has no magnitudes, no limits, and no exposures in the schedule.
    pub fn check_band(&self, name: &str, band: &str) -> Result<(), Problem> {
        let allowed = || self.bands.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        if self.bands.contains(band) { Ok(()) } else { Err(Problem::parameter(name, band, &allowed())) }
    }

    /// Returns the policy with the limiting magnitude of the query, if it has one.
    pub fn policy(&self, query: &Query) -> Policy {
        let mut policy = self.plan.policy.clone();
        if let Some(limit_mag) = query.number(LIMIT_MAG.name) {
            policy.limit_mag = Some(MagnitudeLimit::All(limit_mag));
        }
        policy
    }

    /// Returns the same pass options as `passes` uses, with `samples` points along each track.
    pub fn pass_options(&self, samples: usize) -> PassOptions {
        PassOptions {
            include_dark: false,
            min_probability: self.plan.policy.min_probability,
            samples,
            photometry: self.plan.photometry,
            ..PassOptions::default()
        }
    }
}

/// Returns the rows of each night, by the MJD of its evening. Invalid rows are in the first night.
pub fn nights_of(exposures: &[ScheduledExposure], site: &Site) -> BTreeMap<i64, Vec<usize>> {
    let mut nights: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    let mut invalid = Vec::new();
    for (index, row) in exposures.iter().enumerate() {
        match &row.exposure {
            Ok(exposure) => nights.entry(evening_mjd(exposure.start, site.longitude_rad)).or_default().push(index),
            Err(_) => invalid.push(index),
        }
    }
    if let Some(mut first) = nights.first_entry() {
        first.get_mut().extend(invalid);
        first.get_mut().sort_unstable();
    }
    nights
}
