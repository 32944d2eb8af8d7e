//! Plots of nights, fields, light curves, rates, and passes over a site.

use streakcast::geometry::Site;
use streakcast::math::healpix::{cell_count, ring_centre_rad};
use streakcast::plot::{
    FieldChart, FieldStreak, FinderChart, LightCurve, LocalClock, NightTimeline, SkyChart, SkyRate, SkyTrack,
    SunAltitude, field_chart, finder_chart, light_curve, night_timeline, sky_chart, sky_rate, sun_altitude,
};

use super::{close, has, near, pixels, words};

/// Returns two hours of exposures, one per minute; every fifth is crossed by a satellite.
fn night(magnitude: impl Fn(usize) -> f64) -> [Vec<f64>; 4] {
    let n = 120;
    let start = (0..n).map(|k| 60_536.0 + k as f64 / 1440.0).collect();
    let magnitude: Vec<f64> = (0..n).map(|k| if k % 5 == 0 { magnitude(k) } else { f64::NAN }).collect();
    let streaks = (0..n).map(|k| if k % 5 == 0 { 1.0 + (k % 3) as f64 } else { 0.0 }).collect();
    [start, vec![30.0; n], streaks, magnitude]
}

fn timeline<'a>([start, duration, streaks, magnitude]: &'a [Vec<f64>; 4], sun: &'a [(f64, f64)]) -> NightTimeline<'a> {
    NightTimeline {
        title: "Night",
        caption: "Test.",
        start_mjd: start,
        duration_s: duration,
        n_streaks: streaks,
        brightest_mag: magnitude,
        limit_mag: Some(6.5),
        sun,
        local: Some(LocalClock { ahead_of_utc_h: -4.0, name: "UTC−4".to_owned() }),
    }
}

#[test]
fn verif_a_night_shows_its_exposures_in_their_colours() {
    let columns = night(|k| 5.0 + k as f64 / 40.0);
    let sun = [(60_535.9, 5.0), (60_536.2, -25.0)];
    let picture = night_timeline(&timeline(&columns, &sun)).unwrap();
    let counts = "120 exposures, 24 with streaks (20.0 %), 12 with a mean magnitude brighter than the limit. Test.";
    has(&picture, &[counts, "UTC, 2024-08-13/14", "UTC−4, 2024-08-13", "01:00", "21:00", "limit 6.5 mag", "nautical"]);
    let image = pixels(&picture);
    let scale = picture.scales()[0];
    // The strip with exposure 60, which is crossed at 6.5 mag, and the next one. The axis extends by 1.2 % at both
    // ends.
    let span = (119.0 * 60.0 + 30.0) / 86_400.0;
    let across = |k: f64| 92.0 + (0.012 * span + (k + 0.25) / 1440.0) / (1.024 * span) * (1040.0 - 92.0);
    let at = |k: f64| image.get_pixel(across(k) as u32, 551).0;
    near(at(60.0), scale.colour(6.5));
    assert_eq!(at(61.0), [208, 208, 208]);
    // Brighter is higher: the first dot is above the last.
    let dot = |k: f64, colour: [u8; 3]| {
        let column: Vec<u32> = (112..430).filter(|y| close(image.get_pixel(across(k) as u32, *y).0, colour)).collect();
        column.iter().sum::<u32>() as f64 / column.len() as f64
    };
    let (first, last) = (dot(0.0, scale.colour(5.0)), dot(115.0, scale.colour(7.875)));
    assert!(first + 100.0 < last, "{first} {last}");
    // Without positions of the Sun there are no twilight bands and no labels for them.
    let without = night_timeline(&NightTimeline { sun: &[], local: None, ..timeline(&columns, &[]) }).unwrap();
    assert!(!words(&without).iter().any(|words| words.contains("twilight") || words.contains("UTC−4")));
}

#[test]
fn verif_empty_nights_are_labelled_and_invalid_ones_rejected() {
    let [start, duration, _, magnitude] = night(|_| f64::NAN);
    let clear = [start.clone(), duration.clone(), vec![0.0; 120], magnitude.clone()];
    has(&night_timeline(&timeline(&clear, &[])).unwrap(), &["no exposure of this night has a streak"]);
    let unknown = night(|_| f64::NAN);
    let picture = night_timeline(&timeline(&unknown, &[])).unwrap();
    has(&picture, &["no streak of this night has a magnitude", "streak, no magnitude"]);
    let refused =
        |columns: &[Vec<f64>; 4]| night_timeline(&timeline(columns, &[])).map(|_| ()).unwrap_err().to_string();
    assert!(refused(&Default::default()).contains("nothing to draw: no exposures"));
    let mut long = clear.clone();
    long[0][119] += 3.0;
    assert!(refused(&long).contains("allowed: at most 2 d"));
    let mut uneven = clear.clone();
    uneven[3].pop();
    assert!(refused(&uneven).contains("brightest magnitudes: 119 values; allowed: 120"));
    let mut wrong = clear;
    wrong[0][3] = f64::NAN;
    assert!(refused(&wrong).contains("value 3 (counted from 0) is NaN"));
    // A single exposure is drawn.
    let one = [vec![60_536.0], vec![15.0], vec![1.0], vec![4.2]];
    pixels(&night_timeline(&timeline(&one, &[])).unwrap());
}

fn streak(name: &str, from: [f64; 2], to: [f64; 2], magnitude: f64) -> FieldStreak {
    let name = name.to_owned();
    let [enter_mjd, exit_mjd] = [1801.0, 1804.5].map(|seconds| 60_536.0 + seconds / 86_400.0);
    FieldStreak { name, track_deg: vec![from, to], enter_mjd, exit_mjd, magnitude, sigma_mag: 0.4 }
}

#[test]
fn verif_east_is_left_and_north_is_up_in_a_field() {
    let outlines = [vec![[11.0, -1.0], [11.0, 1.0], [9.0, 1.0], [9.0, -1.0]]];
    // Streaks from the centre to the east, and from the centre to the north.
    let streaks = [streak("EAST", [10.0, 0.0], [10.8, 0.0], 4.0), streak("NORTH", [10.0, 0.0], [10.0, 0.8], 7.0)];
    let chart = |outlines: &[Vec<[f64; 2]>], streaks: &[FieldStreak]| {
        field_chart(&FieldChart { title: "Field", caption: "Test.", ra_deg: 10.0, dec_deg: 0.0, outlines, streaks })
    };
    let picture = chart(&outlines, &streaks).unwrap();
    // The list is sorted by brightness, independent of the input order.
    let turned = [streaks[1].clone(), streaks[0].clone()];
    assert_eq!(chart(&outlines, &turned).unwrap().to_svg().unwrap(), picture.to_svg().unwrap());
    has(&picture, &["EAST", "NORTH", "4.0 ±0.4", "00:30:01.0", "00:30:04.5", "N", "E", "0.5°", "0h40m", "−0°30′"]);
    let (image, scale) = (pixels(&picture), picture.scales()[0]);
    let (bright, faint) = (scale.colour(4.0), scale.colour(7.0));
    // Plot area; its centre is at (432, 412).
    let of = |colour: [u8; 3]| -> Vec<(f64, f64)> {
        let all = image.enumerate_pixels().filter(|(x, y, _)| (92..772).contains(x) && (72..752).contains(y));
        all.filter(|(.., pixel)| close(pixel.0, colour)).map(|(x, y, _)| (f64::from(x), f64::from(y))).collect()
    };
    let mean = |all: &[(f64, f64)]| {
        let n = all.len() as f64;
        (all.iter().map(|place| place.0).sum::<f64>() / n, all.iter().map(|place| place.1).sum::<f64>() / n)
    };
    let ((east_x, east_y), (north_x, north_y)) = (mean(&of(bright)), mean(&of(faint)));
    assert!(east_x < 370.0 && (east_y - 412.0).abs() < 6.0, "{east_x} {east_y}");
    assert!(north_y < 350.0 && (north_x - 432.0).abs() < 6.0, "{north_x} {north_y}");

    let empty = chart(&outlines, &[]).unwrap();
    has(&empty, &["no streak crosses this field"]);
    let refused = |outlines: &[Vec<[f64; 2]>], streaks: &[FieldStreak]| {
        chart(outlines, streaks).map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused(&[], &[]).contains("no outline of the field"));
    assert!(refused(&[], &[streak("FAR", [10.0, 0.0], [100.0, 0.0], 4.0)]).contains("at most 75°"));
    assert!(refused(&[], &[streak("NOWHERE", [10.0, 0.0], [10.0, 91.0], 4.0)]).contains("a position of the chart"));
    // Thirty streaks are drawn, and the number of the others is stated.
    let many: Vec<FieldStreak> =
        (0..30).map(|k| streak("MANY", [9.5, -0.9], [10.5, -0.9 + 0.06 * f64::from(k)], 5.0)).collect();
    has(&chart(&outlines, &many).unwrap(), &["and 8 more, in the data"]);
    // Small fields are labelled in arcminutes. A streak in the shadow has no magnitude.
    let small = [vec![[10.01, 0.0], [10.0, 0.06], [9.99, 0.0]]];
    has(&chart(&small, &[streak("DARK", [10.0, 0.0], [10.0, 0.02], f64::NAN)]).unwrap(), &["+0°02′", "not visible"]);
}

/// The caption explains the band with its smallest and largest width, and the line is dashed where the geometry is
/// outside that of the fitted measurements.
#[test]
fn verif_a_light_curve_explains_its_band() {
    let n = 101;
    let time: Vec<f64> = (0..n).map(|k| 60_536.0 + f64::from(k) / 86_400.0).collect();
    let magnitude: Vec<f64> = (0..n).map(|k| 6.0 + 0.005 * f64::from(k)).collect();
    let sigma: Vec<f64> = (0..n).map(|k| if k < 50 { 0.3 } else { 0.8 }).collect();
    let curve = |in_fitted_range: &[bool]| {
        light_curve(&LightCurve {
            title: "Curve",
            caption: "Test.",
            time_mjd: &time,
            magnitude: &magnitude,
            sigma_mag: &sigma,
            in_fitted_range,
            in_field: &[],
            shutter: None,
            limit_mag: None,
            local: None,
        })
    };
    let fitted: Vec<bool> = (0..n).map(|k| k < 50).collect();
    let (marked, unmarked) = (curve(&fitted).unwrap(), curve(&[]).unwrap());
    assert!(words(&marked).join(" ").contains("one sigma of a single measurement, ±0.3 to ±0.8 mag"));
    has(&marked, &["outside the fitted geometry"]);
    assert!(!words(&unmarked).iter().any(|text| text == "outside the fitted geometry"));
    // The line has the same pixels in the first half, and gaps in the second.
    let (marked, unmarked) = (pixels(&marked), pixels(&unmarked));
    let line = |image: &image::RgbImage, columns: std::ops::Range<u32>| {
        columns.filter(|x| (130..535).any(|y| close(image.get_pixel(*x, y).0, [0, 114, 178]))).count()
    };
    assert_eq!(line(&marked, 120..560), line(&unmarked, 120..560));
    assert!(line(&marked, 620..1060) < line(&unmarked, 620..1060) - 50);
    assert!(curve(&fitted[1..]).map(|_| ()).unwrap_err().to_string().contains("marks of the fitted range: 100 values"));
}

#[test]
fn verif_a_light_curve_has_its_band_and_its_marks() {
    let n = 101;
    let time: Vec<f64> = (0..n).map(|k| 60_536.0 + k as f64 / 86_400.0).collect();
    let magnitude: Vec<f64> = (0..n).map(|k| if k > 80 { f64::NAN } else { 6.0 + 0.01 * k as f64 }).collect();
    let sigma = vec![0.4; n];
    let second = 1.0 / 86_400.0;
    let curve = |time: &[f64], magnitude: &[f64], sigma: &[f64]| {
        light_curve(&LightCurve {
            title: "Curve",
            caption: "Test.",
            time_mjd: time,
            magnitude,
            sigma_mag: sigma,
            in_fitted_range: &[],
            in_field: &[[60_536.0 + 40.0 * second, 60_536.0 + 50.0 * second]],
            shutter: Some([60_536.0 + 30.0 * second, 60_536.0 + 60.0 * second]),
            limit_mag: Some(7.0),
            local: None,
        })
    };
    let picture = curve(&time, &magnitude, &sigma).unwrap();
    has(
        &picture,
        &[
            "enter",
            "exit",
            "magnitude, ±1σ",
            "in the field",
            "shutter open",
            "not visible",
            "limit 7.0 mag",
            "UTC, 2024-08-13/14",
        ],
    );
    let image = pixels(&picture);
    // Pixel columns of the track at 20 s: the line, and the band of two sigmas.
    let x = (92.0 + 998.0 * (0.015 + 0.2) / 1.03) as u32;
    let shade: Vec<u32> =
        (118..540).filter(|y| image.get_pixel(x, *y).0[2] > image.get_pixel(x, *y).0[0].saturating_add(20)).collect();
    let (least, most) = (5.6 - 0.112, 7.2 + 0.112);
    let expected = 0.8 / (most - least) * 422.0;
    assert!((shade.len() as f64 - expected).abs() < 6.0, "{} {expected}", shade.len());
    let refused = |time: &[f64], magnitude: &[f64], sigma: &[f64]| {
        curve(time, magnitude, sigma).map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused(&time, &vec![f64::NAN; n], &sigma).contains("nothing to draw: no magnitudes along the track"));
    assert!(refused(&time, &magnitude[..50], &sigma).contains("magnitudes: 50 values; allowed: 101"));
    assert!(refused(&[], &[], &[]).contains("nothing to draw: no points along the track"));
    assert!(refused(&[1.0, 1.0], &[5.0; 2], &[0.1; 2]).contains("each later than the one before"));
}

#[test]
fn verif_a_rate_has_its_colour_at_its_position() {
    let cells: Vec<(u64, f64)> = (0..cell_count(8))
        .filter_map(|cell| Some((cell, ring_centre_rad(8, cell)?)))
        .filter(|(_, (_, altitude))| *altitude > 0.4)
        .map(|(cell, (azimuth, _))| (cell, 1.0 + azimuth.sin()))
        .collect();
    let (cells, rate): (Vec<u64>, Vec<f64>) = cells.into_iter().unzip();
    let drawn = |nside: u32, cells: &[u64], rate: &[f64]| {
        sky_rate(&SkyRate {
            title: "Rate",
            subtitle: "Sun",
            caption: "Test.",
            nside,
            cells,
            rate,
            sun_azimuth_deg: 250.0,
        })
    };
    let picture = drawn(8, &cells, &rate).unwrap();
    has(&picture, &["Rate", "N", "E", "S", "W", "streaks", "not computed", "0.0", "2.0"]);
    let (image, scale) = (pixels(&picture), picture.scales()[0]);
    // The maximum is in the east, left of the centre (336, 414).
    near(image.get_pixel(336 - 130, 410).0, scale.colour(2.0));
    near(image.get_pixel(336 + 130, 410).0, scale.colour(0.0));
    near(image.get_pixel(336 + 250, 410).0, [205, 205, 205]);
    let refused = |nside, cells: &[u64], rate: &[f64]| drawn(nside, cells, rate).map(|_| ()).unwrap_err().to_string();
    assert!(refused(8, &[], &[]).contains("nothing to draw: no rates"));
    assert!(refused(8, &[1], &[-1.0]).contains("0 streaks per exposure or more"));
    assert!(refused(8, &[1, 1], &[1.0; 2]).contains("each once"));
    assert!(refused(1, &[12], &[1.0]).contains("a cell is 12"));
    assert!(refused(0, &[1], &[1.0]).contains("nside is 0"));
    assert!(refused(8, &[1, 2], &[1.0]).contains("cells: 2 values"));
}

#[test]
fn verif_trails_against_the_sun_go_from_day_to_night() {
    let sun: Vec<f64> = (0..600).map(|k| -0.1 * f64::from(k)).collect();
    let trails: Vec<f64> = sun.iter().map(|altitude| if *altitude > -30.0 { 3.0 } else { 1.0 }).collect();
    let bright = vec![0.5; 600];
    let drawn = |sun: &[f64], trails: &[f64], bin_deg: f64| {
        let n_bright = Some((&bright[..trails.len().min(600)], 7.0));
        sun_altitude(&SunAltitude {
            title: "Trails",
            caption: "Test.",
            sun_altitude_deg: sun,
            n_trails: trails,
            n_bright,
            bin_deg,
        })
    };
    let picture = drawn(&sun, &trails, 2.0).unwrap();
    has(
        &picture,
        &[
            "600 exposures, 2.00 trails per exposure on average. Test.",
            "altitude of the Sun, °",
            "civil",
            "brighter than 7 mag",
        ],
    );
    let image = pixels(&picture);
    // The line of means is high for a high Sun (left), and low for a low Sun.
    let blue = |x: u32| (62..430).filter(|y| close(image.get_pixel(x, *y).0, [0, 114, 178])).min().unwrap();
    assert!(blue(250) + 100 < blue(850), "{} {}", blue(250), blue(850));
    let refused = |sun: &[f64], trails: &[f64], bin| drawn(sun, trails, bin).map(|_| ()).unwrap_err().to_string();
    assert!(refused(&[], &[], 2.0).contains("nothing to draw: no exposures"));
    assert!(refused(&sun, &trails[..3], 2.0).contains("numbers of trails: 3 values"));
    assert!(refused(&sun, &trails, 0.0).contains("allowed: 0.1 to 30°"));
    assert!(refused(&[-100.0], &[1.0], 2.0).contains("allowed: -90 to 90°"));
    pixels(&drawn(&[-5.0], &[0.0], 2.0).unwrap());
}

/// Returns a pass from west through the zenith to east in ten minutes, which fades into the shadow.
fn pass(name: &str) -> SkyTrack {
    let points = 41;
    let share = |k: usize| k as f64 / (points - 1) as f64;
    SkyTrack {
        name: name.to_owned(),
        time_mjd: (0..points).map(|k| 60_536.0 + (5.0 + 600.0 * share(k)) / 86_400.0).collect(),
        azimuth_deg: (0..points).map(|k| if share(k) < 0.5 { 270.0 } else { 90.0 }).collect(),
        altitude_deg: (0..points).map(|k| 10.0 + 80.0 * (1.0 - (2.0 * share(k) - 1.0).abs())).collect(),
        magnitude: (0..points).map(|k| if share(k) > 0.7 { f64::NAN } else { 5.0 - 2.0 * share(k) }).collect(),
        sigma_mag: vec![0.4; points],
        time_sigma_s: 0.5,
    }
}

#[test]
fn verif_a_sky_chart_shows_names_times_and_magnitudes() {
    let one = [pass("SAMPLE 1")];
    let drawn = |tracks: &[SkyTrack]| {
        sky_chart(&SkyChart { title: "A night", caption: "Invented.", tracks, local: None, site: None })
    };
    let picture = drawn(&one).unwrap();
    // A single pass has minute marks, end times in seconds, and its brightest magnitude.
    has(&picture, &["A night", "N", "E", "S", "W", "30°", "60°", "00:01", "SAMPLE 1", "00:00:05", "00:10:05"]);
    // The list has time and altitude of the brightest point.
    has(&picture, &["brightest", "alt", "00:07", "58°", "3.6 ±0.4"]);
    assert!(words(&picture).join(" ").contains("magnitude of its brightest point. Invented."));
    pixels(&picture);
    let many: Vec<SkyTrack> = (1..=30).map(|k| pass(&format!("SAMPLE {k}"))).collect();
    let picture = drawn(&many).unwrap();
    has(&picture, &["SAMPLE 22", "22"]);
    assert!(words(&picture).join(" ").contains("The 22 brightest of 30 passes."));
    // The brightest passes are kept, in their original order.
    let mut one_bright = many.clone();
    one_bright[29].magnitude[0] = -3.0;
    let picture_of_it = drawn(&one_bright).unwrap();
    has(&picture_of_it, &["SAMPLE 21", "SAMPLE 30", "−3.0 ±0.4"]);
    assert!(!words(&picture_of_it).iter().any(|words| words == "SAMPLE 22"));
    assert!(!words(&picture).iter().any(|words| words == "00:01"));
    pixels(&picture);
    // Passes without magnitudes, and a night without passes, can be drawn.
    let dark = SkyTrack { magnitude: vec![f64::NAN; 41], ..pass("DARK") };
    has(&drawn(&[dark]).unwrap(), &["not visible"]);
    has(&drawn(&[]).unwrap(), &["no pass", "30°"]);
}

/// The stars of a site are at their azimuths and altitudes at the middle of the pass, and the caption states the time.
#[test]
fn verif_a_sky_chart_of_a_site_has_stars() {
    // Middle of the chart and radius of its horizon, pixels.
    const MIDDLE: (f64, f64) = (408.0, 424.0);
    const RADIUS: f64 = 330.0;
    let site = Site::new_deg("north", 70.0, 20.0, 0.0).unwrap();
    let tracks = [pass("SAMPLE 1")];
    let chart = |site| SkyChart { title: "", caption: "", tracks: &tracks, local: None, site };
    let (with, without) = (sky_chart(&chart(Some(&site))).unwrap(), sky_chart(&chart(None)).unwrap());
    let sentence = "Stars to V = 6 mag and constellations at 00:05 UTC.";
    assert!(words(&with).join(" ").contains(sentence) && !words(&without).join(" ").contains(sentence));
    // Constellations around the pole are high, Orion is below the horizon.
    has(&with, &["URSA MAJOR", "PERSEUS", "LYRA", "Capella", "Polaris"]);
    assert!(!words(&with).iter().any(|words| words == "SCORPIUS") && !words(&without).iter().any(|w| w == "LYRA"));
    let (with, without) = (pixels(&with), pixels(&without));
    // Polaris is 0.74 degrees from the celestial pole, which is north at the altitude of the latitude. Tolerance,
    // pixels: these 0.74 degrees of 3.7 pixels each, and the radius of its dot.
    let near_pole = 2.7 + 2.2;
    let up = MIDDLE.1 - RADIUS * 20.0 / 90.0;
    let changed = |x: u32, y: u32| with.get_pixel(x, y) != without.get_pixel(x, y);
    let close = |x: u32, y: u32| (f64::from(x) + 0.5 - MIDDLE.0).hypot(f64::from(y) + 0.5 - up) < near_pole;
    let all = || (0..with.width()).flat_map(|x| (0..780).map(move |y| (x, y)));
    assert!(all().any(|(x, y)| close(x, y) && changed(x, y)), "no star near the pole");
    // All stars are inside the horizon.
    let outside = |x: u32, y: u32| (f64::from(x) - MIDDLE.0).hypot(f64::from(y) - MIDDLE.1) > RADIUS + 4.0;
    assert!(!all().any(|(x, y)| outside(x, y) && changed(x, y)), "a star below the horizon");
    // Half of the 5044 stars are above the horizon, most of them with one or more pixels of their own.
    assert!(all().filter(|&(x, y)| changed(x, y)).count() > 2000);
    // A night without passes has no time, and so no stars.
    let empty = sky_chart(&SkyChart { title: "", caption: "", tracks: &[], local: None, site: Some(&site) }).unwrap();
    assert!(!words(&empty).join(" ").contains("stars"));
}

/// Times are those of the given clock, and not finer than their error.
#[test]
fn verif_times_of_a_sky_chart_are_local_and_rounded_to_their_error() {
    let local = Some(LocalClock { ahead_of_utc_h: 2.0, name: "local time (UTC+2)".to_owned() });
    let drawn = |time_sigma_s: f64| {
        let mut track = SkyTrack { time_sigma_s, ..pass("SAMPLE 1") };
        track.time_mjd.iter_mut().for_each(|mjd| *mjd += 2.0 / 86_400.0);
        let tracks = [track];
        sky_chart(&SkyChart { title: "", caption: "", tracks: &tracks, local: local.clone(), site: None }).unwrap()
    };
    has(&drawn(0.9), &["02:00:07", "02:07", "02:10:07", "02:01", "rise"]);
    has(&drawn(8.0), &["02:00:10", "02:07", "02:10:10"]);
    for unknown in [40.0, f64::NAN] {
        let picture = drawn(unknown);
        has(&picture, &["02:07", "02:10"]);
        assert!(!words(&picture).iter().any(|text| text.starts_with("02:07:") || text.starts_with("02:10:")));
    }
}

/// Labels of passes that are close to one another have leader lines, so that no minute of a high pass is without time.
#[test]
fn verif_close_passes_have_leader_lines() {
    let shifted = |name: &str, by: f64| {
        let one = pass(name);
        SkyTrack { azimuth_deg: one.azimuth_deg.iter().map(|azimuth| azimuth + by).collect(), ..one }
    };
    let chart = |tracks: &[SkyTrack]| {
        sky_chart(&SkyChart { title: "", caption: "", tracks, local: None, site: None }).unwrap().to_svg().unwrap()
    };
    let times = |svg: &str| svg.matches("font-size").count();
    let (alone, three) = (chart(&[pass("A")]), chart(&[shifted("A", 0.0), shifted("B", 3.0), shifted("C", 6.0)]));
    // The three tracks have more labels than one alone, though only the outer sides are free.
    assert!(times(&three) > times(&alone) + 8, "{} {}", times(&three), times(&alone));
}

#[test]
fn verif_a_finder_chart_has_stars_and_a_table() {
    let site = Site::new_deg("north", 70.0, 20.0, 0.0).unwrap();
    let track = pass("SAMPLE 1");
    let drawn = |track: &SkyTrack, site| {
        finder_chart(&FinderChart { title: "Pass of SAMPLE 1", caption: "Invented.", track, local: None, site })
    };
    let picture = drawn(&track, Some(&site)).unwrap();
    let events = ["start", "highest", "last visible, brightest", "end"];
    has(
        &picture,
        &[&["Pass of SAMPLE 1", "URSA MAJOR", "time", "altitude", "azimuth", "magnitude"][..], &events].concat(),
    );
    // Start, brightest point and end, and a round time: west before and east after the zenith.
    has(&picture, &["00:00:05", "00:07", "00:10:05", "00:02:00", "270° W", "90° E", "10°", "3.6 ±0.4", "not visible"]);
    let text = words(&picture).join(" ");
    // Events between the ends of the pass are known to the interval between its points.
    for part in [
        "Times: UTC, known to 0.50 s (one sigma). Events between start and end: within 15 s (the step of the light curve).",
        "Dashed: not visible. Stars to V = 5 mag. Invented.",
    ] {
        assert!(text.contains(part), "{text}");
    }
    // Points 15 s apart do not limit times that are known to 20 s.
    let late = drawn(&SkyTrack { time_sigma_s: 20.0, ..track.clone() }, None).unwrap();
    assert!(!words(&late).join(" ").contains("the step of the light curve"));
    // The picture has no colours, and a white background.
    let image = pixels(&picture);
    assert!(image.pixels().all(|pixel| pixel.0[0] == pixel.0[1] && pixel.0[1] == pixel.0[2]));
    assert_eq!(image.get_pixel(20, 60).0, [255; 3]);
    // Times of unknown error are written in minutes, and rows are not closer.
    let unknown = drawn(&SkyTrack { time_sigma_s: f64::NAN, ..track.clone() }, None).unwrap();
    has(&unknown, &["00:07", "00:10"]);
    assert!(!words(&unknown).iter().any(|text| text.starts_with("00:0") && text.len() == 8));
    assert!(words(&unknown).join(" ").contains("of unknown error"));
    // A pass without magnitudes can be drawn.
    let dark = SkyTrack { magnitude: vec![f64::NAN; 41], ..track.clone() };
    assert!(!words(&drawn(&dark, None).unwrap()).iter().any(|text| text.contains("brightest")));
    let short = SkyTrack { sigma_mag: vec![0.4], ..track };
    assert!(drawn(&short, None).map(|_| ()).unwrap_err().to_string().contains("sigmas of SAMPLE 1: 1 values"));
}

#[test]
fn verif_a_sky_chart_rejects_invalid_input() {
    let error_of = |track: SkyTrack| {
        let tracks = [track];
        sky_chart(&SkyChart { title: "", caption: "", tracks: &tracks, local: None, site: None })
            .map(|_| ())
            .unwrap_err()
            .to_string()
    };
    assert!(error_of(SkyTrack { sigma_mag: vec![0.4], ..pass("A") }).contains("sigmas of A: 1 values"));
    assert!(error_of(SkyTrack { altitude_deg: vec![-5.0; 41], ..pass("A") }).contains("allowed: 0 to 90 deg"));
    assert!(
        error_of(SkyTrack { time_mjd: vec![60_536.0; 41], ..pass("A") }).contains("each later than the one before")
    );
    assert!(error_of(SkyTrack { azimuth_deg: vec![f64::NAN; 41], ..pass("A") }).contains("allowed: a finite number"));
}

#[test]
fn verif_an_svg_contains_its_font() {
    let one = [vec![60_536.0], vec![15.0], vec![1.0], vec![4.2]];
    let text = night_timeline(&timeline(&one, &[])).unwrap().to_svg().unwrap();
    assert!(text.contains("@font-face{font-family:\"DejaVu Sans\";src:url(data:font/ttf;base64,AAEAAAA"));
    assert!(!text.contains("http://") || text.matches("http").count() == 2, "only the two names of SVG itself");
}
