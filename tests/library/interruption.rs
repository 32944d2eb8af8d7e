//! Computations that are stopped by a watch: every query ends with the error `interrupted`, before and during its work.

use std::sync::mpsc;
use std::time::Duration;

use hifitime::Epoch;
use streakcast::forecast::{
    EphemerisRequest, ForecastRequest, Selection, StatisticsRequest, ephemeris, forecast, sky_counts,
};
use streakcast::frames::{Direction, parse_instant, seconds_after};
use streakcast::identify::{IdentifyOptions, MeasuredStreak, Timing, identify_streak};
use streakcast::maps::{BodyView, Earth, Grid, SkyView};
use streakcast::passes::{CountRequest, PassOptions, SnapshotOptions};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};
use streakcast::schedule::{
    FlagRequest, ScheduledExposure, WindowRequest, WindowTarget, clear_windows, flag_exposures, judge_exposures,
};
use streakcast::{Exposure, Field, Policy, Satellites, Site, Sky, Watch};

/// Bound on the time after which a test fails because a computation does not stop.
const DEADLOCK: Duration = Duration::from_secs(120);

fn dusk() -> Epoch {
    parse_instant("2026-08-14T23:20:00Z", None).unwrap()
}

fn sky() -> Sky {
    Sky::new(Satellites::synthetic("starlink-gen1", dusk()).unwrap(), Site::from_mpc("X05").unwrap())
}

fn exposures(number: usize, duration_s: f64) -> Vec<Exposure> {
    let exposure = |index: usize| Exposure {
        id: index.to_string(),
        start: seconds_after(dusk(), 30.0 * (index % 1000) as f64),
        duration_s,
        pointing: Direction::from_lon_lat_rad(3.3 + 0.7 * (index as f64).sin(), -0.3 + 0.2 * (index as f64).cos()),
        rotation_rad: 0.0,
    };
    (0..number).map(exposure).collect()
}

fn rows(number: usize) -> Vec<ScheduledExposure> {
    let row = |(row, exposure): (usize, Exposure)| ScheduledExposure {
        id: exposure.id.clone(),
        row,
        band: None,
        open_s: None,
        exposure: Ok(exposure),
    };
    exposures(number, 30.0).into_iter().enumerate().map(row).collect()
}

/// Query of a sky, whose result is only the error.
type Query<'a> = &'a (dyn Fn(&Sky) -> Result<(), streakcast::Error> + Sync);

/// Calls a function with each query of a sky and its name.
fn with_queries(check: &dyn Fn(&str, Query<'_>)) {
    let field = Field::circle_deg(3.5).unwrap();
    let (photometry, policy) = (PhotometryOptions::default(), Policy::limit_mag(7.0));
    let probable = Policy { min_probability: Some(0.1), ..policy.clone() };
    let options = PassOptions { min_probability: Some(0.1), ..PassOptions::default() };
    // Each query replaces the sky.
    let all = sky();
    let request = |policy| FlagRequest { sky: &all, field: &field, policy, telescope: None, photometry: &photometry };
    let night = seconds_after(dusk(), 30_000.0);
    let selection = Selection::default();
    let (many, rows) = (exposures(20_000, 30.0), rows(20_000));
    let rows: Vec<&ScheduledExposure> = rows.iter().collect();
    let targets: Vec<WindowTarget> =
        exposures(200, 30.0).into_iter().map(|exposure| WindowTarget { exposure, band: None }).collect();

    check("field_passes", &|sky| sky.field_passes(&many, &field, &options).map(drop));
    check("field_passes, one long exposure", &|sky| {
        sky.field_passes(&exposures(1, 80_000.0), &field, &options).map(drop)
    });
    check("field_crossings", &|sky| sky.field_crossings(&many, &field).map(drop));
    check("brute force", &|sky| sky.field_passes_by_brute_force(&many[..20], &field, &options).map(drop));
    check("crossing_probabilities", &|sky| sky.crossing_probabilities(&many, &field).map(drop));
    check("streak_counts", &|sky| {
        let directions: Vec<_> = (0..300).map(|index| Direction::from_lon_lat_rad(0.02 * index as f64, 0.8)).collect();
        let moments: Vec<Epoch> = (0..100).map(|index| seconds_after(dusk(), 60.0 * index as f64)).collect();
        let request = CountRequest {
            directions: &directions,
            moments: &moments,
            duration_s: 30.0,
            field: &field,
            photometry,
            limit_mag: None,
        };
        sky.streak_counts(&request).map(drop)
    });
    check("snapshots", &|sky| {
        let times_s: Vec<f64> = (0..3000).map(f64::from).collect();
        sky.snapshots(dusk(), &times_s, &SnapshotOptions::all_above(0.0)).map(drop)
    });
    check("flag_exposures", &|sky| flag_exposures(&rows, &FlagRequest { sky, ..request(&probable) }).map(drop));
    check("judge_exposures", &|sky| judge_exposures(&rows, &FlagRequest { sky, ..request(&policy) }).map(drop));
    check("clear_windows", &|sky| {
        let request = WindowRequest {
            conditions: FlagRequest { sky, ..request(&policy) },
            min_altitude_rad: 0.0,
            max_sun_altitude_rad: Some(-0.2),
        };
        clear_windows(&targets, dusk(), night, &request).map(drop)
    });
    check("forecast", &|sky| {
        let request = ForecastRequest { include_dark: true, ..ForecastRequest::new(dusk(), night) };
        forecast(sky, &request, &selection).map(drop)
    });
    check("ephemeris", &|sky| {
        let request = EphemerisRequest {
            times: (0..150).map(|index| seconds_after(dusk(), 60.0 * f64::from(index))).collect(),
            selection: selection.clone(),
            min_altitude_rad: None,
            photometry,
        };
        ephemeris(sky, &request).map(drop)
    });
    check("sky_counts", &|sky| {
        let request = StatisticsRequest {
            start: dusk(),
            end: night,
            sun_altitudes_rad: vec![-0.6],
            min_altitudes_rad: vec![0.0],
            field_rad: 0.05,
            field_sr: None,
            exposure_s: 30.0,
            moments: 1000,
            spread_s: 3000.0,
            limit_mag: None,
            photometry,
        };
        sky_counts(sky, &request).map(drop)
    });
}

#[track_caller]
fn assert_interrupted(name: &str, result: Result<(), streakcast::Error>) {
    let error = result.expect_err(name);
    assert_eq!(error.to_string(), "interrupted", "{name}");
}

#[test]
fn a_stopped_watch_stops_every_query() {
    let sky = sky();
    let stopped = Watch::default();
    stopped.stop();
    with_queries(&|name, query| assert_interrupted(name, query(&sky.watched(&stopped))));

    let ends = [Direction::from_lon_lat_rad(3.3, -0.3), Direction::from_lon_lat_rad(3.31, -0.3)];
    let streak = MeasuredStreak::from_ends(ends, (dusk(), 30.0), Timing::Whole, 1e-5, 0.1).unwrap();
    let identified = identify_streak(&sky.watched(&stopped), &streak, &IdentifyOptions::default());
    assert_interrupted("identify", identified.map(drop));

    let library = ModelLibrary::embedded();
    let model = library.get("starlink-v1.5").unwrap();
    let (grid, options) = (Grid::healpix(8).unwrap(), PhotometryOptions::default());
    let body = BodyView::new(&model, 0.3, 550.0, options).unwrap();
    let over_site = SkyView::new(&model, Earth::Sphere, 550.0, 0.0, -0.3, options).unwrap();
    assert!(body.map(grid).is_ok() && over_site.map(grid).is_ok());
    assert_interrupted("body", body.watched(&stopped).map(grid).map(drop));
    assert_interrupted("sky map", over_site.watched(&stopped).map(grid).map(drop));

    // The sky itself is not stopped.
    assert!(sky.field_passes(&exposures(1, 30.0), &Field::circle_deg(1.0).unwrap(), &PassOptions::default()).is_ok());
}

#[test]
fn a_running_query_is_stopped() {
    let sky = sky();
    with_queries(&|name, query| {
        let watch = Watch::default();
        let watched = sky.watched(&watch);
        let (sender, ended) = mpsc::channel();
        std::thread::scope(|scope| {
            scope.spawn(move || sender.send(query(&watched)));
            // None of the queries is this short, and all are much longer than their steps.
            let early = ended.recv_timeout(Duration::from_millis(20));
            watch.stop();
            let result = early.or_else(|_| ended.recv_timeout(DEADLOCK)).unwrap_or_else(|_| panic!("{name} continues"));
            // A fast machine may complete a query; it must not return another error.
            if let Err(error) = result {
                assert_eq!(error.to_string(), "interrupted", "{name}");
            }
        });
    });
}
