//! Distribution of single magnitudes about the default models on held-out points: the common shape of its wings, and
//! the reliability of median, sigma and probabilities.
//!
//! `cargo test --test fitting -- --ignored write_error_distributions` fits the shape again, writes it into
//! `src/photometry/error_distribution.rs`, and writes the tables `TABLES` in `docs/tables`. `docs/brightness.py` draws
//! the figure.
//!
//! Requires the data folder; skipped with a message without it.

use std::path::Path;

use streakcast::fit::{HeldOutPoint, weighted_quantile};
use streakcast::photometry::{ErrorDistribution, ModelLibrary, NormalPart};

use super::survey::{GroupMean, SURVEYS, Weighted, density, log_density, mean_of, median_and_sigma_mag};

/// Tables in `docs/tables`: probabilities by tenth; reliability of each kind.
const TABLES: [&str; 2] = ["brightness", "brightness-kinds"];
/// Magnitude limits at 1000 km for which probabilities are compared, in quarters of a magnitude: 3 to 10 mag.
const LIMITS: std::ops::RangeInclusive<i32> = 12..=40;
/// Number of evenly spaced quantiles of the residuals that represent a kind in the common shape.
const QUANTILES: usize = 400;
/// Least width of a part of the shape, in sigmas.
const LEAST_WIDTH: f64 = 0.15;
const MOST_ITERATIONS: usize = 20_000;
const CONVERGED: f64 = 1e-6;
/// Largest difference between a parameter of the shape in the source and its fit here, in sigmas or as a share.
const SHAPE_TOLERANCE: f64 = 0.03;
/// Largest difference between the sigma in a model file and that of the held-out points here, and largest median, mag.
/// The files were fitted to all points of a survey.
const FILE_TOLERANCE_MAG: f64 = 0.03;
/// Model of which more than 95 % of the points are in the interval of 95 %.
const LIGHT_WINGS: &str = "oneweb-panels";
/// Largest difference between stated and observed shares of any tenth, for all kinds together.
const POOLED_TOLERANCE: f64 = 0.05;

/// Held-out points of the default model of one kind.
struct HeldOut {
    kind: String,
    model: &'static str,
    groups: usize,
    effective: f64,
    sigma_mag: f64,
    file_sigma_mag: f64,
    median_mag: f64,
    /// Residuals are from the median.
    points: Vec<HeldOutPoint>,
}

impl HeldOut {
    /// Returns evenly spaced quantiles of the residuals in sigmas.
    fn quantiles(&self) -> Vec<f64> {
        let mut pairs: Vec<(f64, f64)> =
            self.points.iter().map(|one| (one.residual_mag() / self.sigma_mag, one.weight)).collect();
        (0..QUANTILES).map(|i| weighted_quantile(&mut pairs, (i as f64 + 0.5) / QUANTILES as f64)).collect()
    }

    fn within(&self, sigmas: f64) -> GroupMean {
        mean_of(&self.points, |one| f64::from(u8::from(one.residual_mag().abs() < sigmas * self.sigma_mag)))
    }
}

fn held_out(data: &Path) -> Vec<HeldOut> {
    let library = ModelLibrary::embedded();
    let of = |survey: &super::survey::Survey| {
        let model = survey.models[0].name;
        let mut points = survey.held_out(&survey.models[0], &survey.points(data));
        let [median_mag, sigma_mag] = median_and_sigma_mag(points.iter());
        points.iter_mut().for_each(|one| one.predicted_mag += median_mag);
        HeldOut {
            kind: survey.kind.to_string(),
            model,
            groups: points.iter().map(|one| one.group).collect::<std::collections::BTreeSet<_>>().len(),
            effective: points.iter().map(|one| one.weight).sum(),
            sigma_mag,
            file_sigma_mag: library.get(model).unwrap().sigma_mag(),
            median_mag,
            points,
        }
    };
    SURVEYS.iter().map(of).collect()
}

/// Fits normal distributions to values by expectation maximisation (Dempster, Laird and Rubin 1977, J. R. Stat. Soc.
/// B 39, 1), from a start. Parts with a share of 0 remain unused.
pub fn mixture(values: &[f64], start: [NormalPart; 3]) -> ErrorDistribution {
    let unused = NormalPart { share: 0.0, centre: 0.0, width: 1.0 };
    let mut now = ErrorDistribution { parts: start };
    for _ in 0..MOST_ITERATIONS {
        let mut sums = [[0.0_f64; 3]; 3];
        for x in values {
            let densities = now.parts.map(|of| {
                if of.share > 0.0 { density(&ErrorDistribution { parts: [of, unused, unused] }, *x) } else { 0.0 }
            });
            let total: f64 = densities.iter().sum::<f64>().max(f64::MIN_POSITIVE);
            for (sums, density) in sums.iter_mut().zip(densities) {
                let share = density / total;
                sums[0] += share;
                sums[1] += share * x;
                sums[2] += share * x * x;
            }
        }
        let next = sums.map(|[weight, sum, squares]| {
            if weight == 0.0 {
                return unused;
            }
            let centre = sum / weight;
            let width = (squares / weight - centre * centre).max(0.0).sqrt().max(LEAST_WIDTH);
            NormalPart { share: weight / values.len() as f64, centre, width }
        });
        let change = next
            .iter()
            .zip(now.parts)
            .map(|(a, b)| (a.share - b.share).abs().max((a.centre - b.centre).abs()).max((a.width - b.width).abs()));
        let largest = change.fold(0.0, f64::max);
        now.parts = next;
        if largest < CONVERGED {
            break;
        }
    }
    now
}

/// Fits three normal distributions to values.
fn shape(values: &[f64]) -> ErrorDistribution {
    let part = |share, centre, width| NormalPart { share, centre, width };
    // A wing of moderate width and far flares; other starts end in a narrow second part of similar likelihood.
    let now = mixture(values, [part(0.7, 0.2, 0.7), part(0.28, -1.1, 1.6), part(0.02, -3.4, 5.0)]);
    let likelihood = values.iter().map(|x| density(&now, *x).ln()).sum::<f64>() / values.len() as f64;
    println!("mean logarithm of the likelihood {likelihood:.5}");
    // Three decimals are more than the residuals determine.
    let rounded = |x: f64| (x * 1000.0).round() / 1000.0;
    let [core, wing, flares] = now.parts.map(|one| part(rounded(one.share), rounded(one.centre), rounded(one.width)));
    let core = NormalPart { share: rounded(1.0 - wing.share - flares.share), ..core };
    ErrorDistribution { parts: [core, wing, flares] }
}

/// Returns the shape of the held-out points of all kinds, optionally without one default model.
pub fn common_shape(data: &Path, without: Option<&str>) -> ErrorDistribution {
    common(&held_out(data), without)
}

/// Returns the shape of all kinds, optionally without one of them.
fn common(all: &[HeldOut], without: Option<&str>) -> ErrorDistribution {
    let counted = all.iter().filter(|one| Some(one.model) != without);
    shape(&counted.flat_map(HeldOut::quantiles).collect::<Vec<_>>())
}

/// Reliability of one kind, with the shape of the other kinds.
struct Row<'a> {
    of: &'a HeldOut,
    absolute_mag: GroupMean,
    /// Mean probability of a fainter magnitude than observed; 0.5 for a calibrated prediction.
    pit: GroupMean,
    within: [GroupMean; 3],
    /// Mean log score, and its difference from that of a normal distribution with the same sigma.
    log: GroupMean,
    over_normal: GroupMean,
    /// Tenths of the stated probability, with the shape of the other kinds and with a normal distribution.
    tenths: [Tenths; 2],
}

/// Weight, stated probability and observed share of each tenth of the stated probability, summed.
type Tenths = [[f64; 3]; 10];

/// Half widths that contain 50, 68.3 and 95 % of a shape, in sigmas.
fn half_widths(shape: &ErrorDistribution) -> [f64; 3] {
    [0.5, 0.6827, 0.95].map(|share| {
        let (mut low, mut high) = (0.0, 20.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let inside = shape.cumulative(middle, 0.0) - shape.cumulative(-middle, 0.0);
            if inside < share { low = middle } else { high = middle }
        }
        low
    })
}

fn row<'a>(of: &'a HeldOut, all: &[HeldOut]) -> Row<'a> {
    let others = common(all, Some(of.model));
    let sigma = of.sigma_mag;
    let log = |one: &HeldOutPoint| log_density(&others, one.residual_mag(), sigma);
    let normal = |one: &HeldOutPoint| log_density(&ErrorDistribution::NORMAL, one.residual_mag(), sigma);
    let tenths = [others, ErrorDistribution::NORMAL].map(|shape| {
        let mut tenths = [[0.0; 3]; 10];
        for one in &of.points {
            for limit_mag in LIMITS.map(|quarter| 0.25 * f64::from(quarter)) {
                let stated = shape.cumulative((limit_mag - one.predicted_mag) / sigma, 0.0);
                let observed = f64::from(u8::from(one.observed_mag < limit_mag));
                let tenth: &mut [f64; 3] = &mut tenths[((10.0 * stated) as usize).min(9)];
                for (sum, value) in tenth.iter_mut().zip([1.0, stated, observed]) {
                    *sum += one.weight / of.effective * value;
                }
            }
        }
        tenths
    });
    Row {
        of,
        absolute_mag: mean_of(&of.points, |one| one.residual_mag().abs()),
        pit: mean_of(&of.points, |one| others.cumulative(one.residual_mag() / sigma, 0.0)),
        within: half_widths(&others).map(|width| of.within(width)),
        log: mean_of(&of.points, log),
        over_normal: GroupMean::of(of.points.iter().map(|one| Weighted {
            value: log(one) - normal(one),
            weight: one.weight,
            group: one.group,
        })),
        tenths,
    }
}

/// Returns stated and observed shares of all kinds together, by tenth, with one of the two distributions.
fn pooled(rows: &[Row<'_>], distribution: usize) -> [[f64; 2]; 10] {
    std::array::from_fn(|tenth| {
        let sum = |k: usize| rows.iter().map(|row| row.tenths[distribution][tenth][k]).sum::<f64>();
        [sum(1) / sum(0), sum(2) / sum(0)]
    })
}

/// Returns the contents of [`TABLES`].
fn tables(rows: &[Row<'_>]) -> [String; 2] {
    let mut tenths = "| stated probability | shape of the other kinds: stated, observed | normal: stated, observed |\n|---|---|---|\n".to_owned();
    let of = [0, 1].map(|distribution| pooled(rows, distribution));
    for tenth in 0..10 {
        let (from, to) = (0.1 * tenth as f64, 0.1 * (tenth + 1) as f64);
        let [others, normal] = of.map(|of| {
            let [stated, observed] = of[tenth];
            format!("{:.1} %, {:.1} %", 100.0 * stated, 100.0 * observed)
        });
        tenths += &format!("| {from:.1} to {to:.1} | {others} | {normal} |\n");
    }
    let mut kinds = "| model | groups, effective points | sigma, mag | mean absolute residual, mag | PIT | within 50 % | within 68 % | within 95 % | log score over normal |\n|---|---|---|---|---|---|---|---|---|\n".to_owned();
    for row in rows {
        let percent = |of: GroupMean| format!("{:.0} +- {:.0} %", 100.0 * of.mean, 100.0 * of.error);
        let [half, one_sigma, most] = row.within.map(percent);
        kinds += &format!(
            "| {} | {}, {:.0} | {:.3} | {:.3} +- {:.3} | {:.3} +- {:.3} | {half} | {one_sigma} | {most} | {:+.3} +- {:.3} |\n",
            row.of.model,
            row.of.groups,
            row.of.effective,
            row.of.sigma_mag,
            row.absolute_mag.mean,
            row.absolute_mag.error,
            row.pit.mean,
            row.pit.error,
            row.over_normal.mean,
            row.over_normal.error,
        );
    }
    [tenths, kinds]
}

fn print(all: &[HeldOut], rows: &[Row<'_>]) {
    println!("{}", tables(rows).join("\n"));
    println!("shape {:?}", common(all, None));
    for row in rows {
        let HeldOut { kind, median_mag, sigma_mag, file_sigma_mag, .. } = row.of;
        println!(
            "{kind}: median {median_mag:+.3}, sigma {sigma_mag:.3} ({file_sigma_mag:.3} in the file), log score {:.3} +- {:.3}",
            row.log.mean, row.log.error
        );
    }
}

#[test]
fn valid_median_sigma_and_probabilities_hold_on_unseen_points() {
    let Some(data) = crate::common::data_dir() else { return };
    let all = held_out(&data);
    let rows: Vec<Row> = all.iter().map(|one| row(one, &all)).collect();
    print(&all, &rows);
    for (name, table) in TABLES.into_iter().zip(tables(&rows)) {
        crate::common::assert_is_documented(&format!("{name}.md"), &table);
    }
    for row in &rows {
        let model = row.of.model;
        assert!(row.pit.is(0.5), "{model}: {:?}", row.pit);
        for (within, share) in row.within.iter().zip([0.5, 0.6827, 0.95]) {
            // OneWeb has fewer flares than the kinds from which the shape is fitted.
            let is_wide = model == LIGHT_WINGS && share == 0.95;
            assert!(is_wide == (within.mean > share && !within.is_share(share)), "{model}: {within:?} for {share}");
            assert!(is_wide || within.is_share(share), "{model}: {within:?} for {share}");
        }
        // The file has the median and the sigma of these points.
        assert!(row.of.median_mag.abs() < FILE_TOLERANCE_MAG, "{model}: {}", row.of.median_mag);
        assert!((row.of.sigma_mag - row.of.file_sigma_mag).abs() < FILE_TOLERANCE_MAG, "{model}: {}", row.of.sigma_mag);
    }
    for [stated, observed] in pooled(&rows, 0) {
        assert!((stated - observed).abs() < POOLED_TOLERANCE, "{stated} {observed}");
    }
    // The wings improve the score of all kinds together.
    assert!(rows.iter().map(|row| row.over_normal.mean).sum::<f64>() > 0.0);
    // The shape in the source is that of this fit.
    let fitted = common(&all, None);
    for (source, fitted) in ErrorDistribution::SATELLITES.parts.iter().zip(fitted.parts) {
        let worst = (source.share - fitted.share)
            .abs()
            .max((source.centre - fitted.centre).abs())
            .max((source.width - fitted.width).abs());
        assert!(
            worst < SHAPE_TOLERANCE,
            "{fitted:?}: cargo test --test fitting -- --ignored write_error_distributions"
        );
    }
}

#[test]
#[ignore = "writes into the source"]
fn write_error_distributions() {
    let data = crate::common::data_dir().expect("the data folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let all = held_out(&data);
    let [core, wing, flares] =
        common(&all, None).parts.map(|one| format!("part({:?}, {:?}, {:?})", one.share, one.centre, one.width));
    let path = root.join("src/photometry/error_distribution.rs");
    let text = std::fs::read_to_string(&path).unwrap();
    let beginning = "        Self { parts: [part(";
    let line = |old: &str| match old.starts_with(beginning) {
        true => format!("        Self {{ parts: [{core}, {wing}, {flares}] }};"),
        false => old.to_owned(),
    };
    let text = text.lines().map(line).collect::<Vec<_>>().join("\n") + "\n";
    std::fs::write(&path, text).unwrap();
    let rows: Vec<Row> = all.iter().map(|one| row(one, &all)).collect();
    print(&all, &rows);
    for (name, table) in TABLES.into_iter().zip(tables(&rows)) {
        std::fs::write(root.join(format!("docs/tables/{name}.md")), table).unwrap();
    }
}
