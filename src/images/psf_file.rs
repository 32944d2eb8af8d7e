//! Point spread functions from files: an image, or the position-dependent set of images that PSFEx writes.
//!
//! An image (FITS, two axes) is that of a star on pixels of the frame or, with an oversampling N, on cells of 1/N of a
//! pixel, whose light is summed to pixels. The star is at the centroid of its light, not at the middle of the image, so
//! that images of any size and cut around any pixel can be used. The image is converted to samples of the light in a
//! pixel of the frame as a function of the distance of the pixel from the star.
//!
//! PSFEx (Bertin 2011, ASP Conf. 442, 435) stores such samples: `PSF_MASK` has one plane for each term of a polynomial
//! in the position, x^i y^j with i + j up to POLDEG1, in the order of j and then of i, where x = (X - POLZERO1) /
//! POLSCAL1 and y = (Y - POLZERO2) / POLSCAL2 with FITS pixels X, Y. The distance of the samples is PSF_SAMP pixels.

use std::path::{Path, PathBuf};

use super::fits::{BinaryCells, FrameFile, HduKind};
use super::header::Header;
use super::pixels::PixelPosition;
use crate::error::Error;
use crate::math::quantile::median;
use crate::message::Quoted;

/// Largest number of samples along a side, and largest side in pixels of the frame.
const MOST_SAMPLES: usize = 1025;
const MOST_PIXELS: f64 = 513.0;
/// Largest oversampling, and range of the distance of samples, pixels.
const MOST_OVERSAMPLING: usize = 16;
const STEPS_PIX: [f64; 2] = [0.05, 2.0];
/// Largest degree of a polynomial.
const MOST_DEGREE: usize = 10;
/// Keywords of the oversampling of an image. The first one that a header has counts.
const OVERSAMPLING: [&str; 4] = ["OVERSAMP", "OVERSMPL", "OSAMP", "DET_SAMP"];
/// Keyword of the side of a cell of an image, pixels of the frame.
const STEP: &str = "PSF_SAMP";

/// Point spread functions of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct PsfFile {
    /// Path of the file.
    pub path: PathBuf,
    /// One for all chips, or one for each chip of a frame, in order.
    grids: Vec<PsfGrid>,
    /// What an image states about itself; `None` for a file of PSFEx.
    stated: Option<StatedImage>,
}

/// Properties of an image that can be compared with the frame.
#[derive(Clone, Debug, PartialEq)]
struct StatedImage {
    /// Keyword and side of a cell on the sky, arcseconds; `None` if the header has none or the user gave the
    /// oversampling.
    scale: Option<(&'static str, f64)>,
    /// Keyword of the oversampling, if the header has one.
    oversampling: Option<&'static str>,
    /// Light of the border relative to the peak.
    border: f64,
    /// Share of the sum that a sky as bright as the border has.
    sky_share: f64,
}

/// Samples of the light in a pixel as a function of its distance from a star.
#[derive(Clone, Debug, PartialEq)]
pub struct PsfGrid {
    /// Rows and columns.
    pub size: [usize; 2],
    /// Row and column of the star, samples from 0.
    pub star: [f64; 2],
    /// Distance between samples, pixels of the frame.
    pub step_pix: f64,
    /// Samples, one set for each term of the polynomial.
    terms: Vec<Vec<f64>>,
    polynomial: Option<Polynomial>,
}

#[derive(Copy, Clone, Debug, PartialEq)]
struct Polynomial {
    zero: [f64; 2],
    scale: [f64; 2],
    degree: usize,
}

impl PsfFile {
    /// Returns true for the name of such a file: it ends in .fits, .fit, .fts, .fz or .psf.
    pub fn is_name(text: &str) -> bool {
        let end = Path::new(text).extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        ["fits", "fit", "fts", "fz", "psf"].contains(&end.as_str())
    }

    /// Reads a file. `oversampling` replaces that in the header of an image, which is 1 if it is missing.
    ///
    /// # Errors
    /// The file cannot be read, has no image with a positive sum, finite values and a border without light, or a
    /// keyword is out of range.
    pub fn read(path: &Path, oversampling: Option<usize>) -> Result<Self, Error> {
        let file = FrameFile::open(path)?;
        let of_psfex: Vec<usize> = file
            .hdus()
            .iter()
            .filter(|hdu| hdu.kind == HduKind::Table)
            .map(|hdu| hdu.index)
            .filter(|&hdu| file.header(hdu).is_ok_and(|header| header.integer("PSFAXIS1").is_some()))
            .collect();
        let (grids, stated) = if of_psfex.is_empty() {
            let (grid, stated) = image(&file, oversampling)?;
            (vec![grid], Some(stated))
        } else if oversampling.is_some() {
            let allowed = "an image (PSF_SAMP is the sampling)";
            return Err(Error::invalid("--psf-oversampling", "given for a file of PSFEx", allowed).in_file("", path));
        } else {
            let read = |hdu| psfex(&file, hdu).map_err(|error| error.in_hdu(path, hdu));
            (of_psfex.into_iter().map(read).collect::<Result<_, _>>()?, None)
        };
        Ok(Self { path: path.to_owned(), grids, stated })
    }

    /// Checks that an image has the scale of a frame, in arcseconds per pixel, with the oversampling in its header.
    ///
    /// # Errors
    /// The scale in its header is another one.
    pub fn check_scale(&self, frame_arcsec: f64) -> Result<(), Error> {
        /// Largest difference of the scales, which may be nominal ones.
        const MOST: f64 = 0.1;
        let Some(StatedImage { scale: Some((keyword, cell_arcsec)), oversampling, .. }) = &self.stated else {
            return Ok(());
        };
        let is_near = |arcsec: f64| (arcsec / frame_arcsec).ln().abs() <= (1.0 + MOST).ln();
        // With an oversampling in the header, the scale may be that of a cell or that of a pixel.
        let number = (1.0 / self.step_pix()).round();
        if is_near(cell_arcsec * number) || (oversampling.is_some() && is_near(*cell_arcsec)) {
            return Ok(());
        }
        let given = format!("{} arcsec, with an oversampling of {number}", rounded(*cell_arcsec));
        let allowed = format!(
            "{} arcsec for the frame of {} arcsec per pixel; specify --psf-oversampling, the number of pixels of the \
             image along a pixel of the frame",
            rounded(frame_arcsec / number),
            rounded(frame_arcsec)
        );
        let what = format!("scale {keyword} of the point spread function");
        Err(Error::invalid(what, given, allowed).in_file("", &self.path))
    }

    /// Returns a warning about a border with light, which may be that of a sky or of wings that are cut off.
    pub fn border_warning(&self) -> Option<String> {
        /// Largest light of the border relative to the peak without a warning, and the same of its share.
        const MOST: f64 = 0.001;
        const MOST_SHARE: f64 = 0.02;
        let stated = self.stated.as_ref()?;
        (stated.border.abs() > MOST && stated.sky_share.abs() > MOST_SHARE).then(|| {
            format!(
                "{}: the border of the point spread function has {:.2} % of its peak (median): if this is a sky, {:.0} % of \
                 the light is that of the sky; subtract it, or use an image with more of the wings",
                self.path.display(),
                100.0 * stated.border,
                100.0 * stated.sky_share
            )
        })
    }

    /// Returns the distance between samples, pixels of the frame: that of the first chip.
    pub fn step_pix(&self) -> f64 {
        self.grids.first().map_or(1.0, |grid| (grid.step_pix * 1e6).round() / 1e6)
    }

    /// Returns the point spread function of the chip in an HDU, which is one of the `chosen` of `all` images of a
    /// frame.
    ///
    /// # Errors
    /// The file has neither one set for all chips nor one for each.
    pub fn of_chip(&self, hdu: usize, chosen: &[usize], all: &[usize]) -> Result<&PsfGrid, Error> {
        if let [only] = &self.grids[..] {
            return Ok(only);
        }
        let place = |hdus: &[usize]| hdus.iter().position(|of| *of == hdu).filter(|_| hdus.len() == self.grids.len());
        place(chosen).or_else(|| place(all)).map(|index| &self.grids[index]).ok_or_else(|| {
            let allowed = match all.len() {
                1 => "1".to_owned(),
                count => format!("1, or {count}, one for each image"),
            };
            Error::invalid("number of tables PSF_MASK", self.grids.len(), allowed).in_file("", &self.path)
        })
    }
}

impl PsfGrid {
    /// Returns true if the point spread function depends on the position.
    pub fn is_variable(&self) -> bool {
        self.polynomial.is_some()
    }

    /// Returns the distance of the star from the farther edge of the samples along rows and columns, samples.
    pub fn reach(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.star[axis].max(self.size[axis] as f64 - 1.0 - self.star[axis]))
    }

    /// Returns the farthest pixel from the star that has light, pixels.
    pub fn reach_pix(&self) -> f64 {
        let [rows, columns] = self.reach();
        self.step_pix * (rows.max(columns) + 0.5) + 1.0
    }

    /// Returns the samples at a position in the frame; `None` if their sum is not positive there.
    pub fn at(&self, position: PixelPosition) -> Option<Vec<f64>> {
        let samples = match self.polynomial {
            None => self.terms[0].clone(),
            Some(Polynomial { zero, scale, degree }) => {
                let fits = position.fits();
                let [x, y] = [0, 1].map(|axis| (fits[axis] - zero[axis]) / scale[axis]);
                let powers = (0..=degree).flat_map(|j| (0..=degree - j).map(move |i| [i, j]));
                let mut samples = vec![0.0; self.terms[0].len()];
                for (term, [i, j]) in self.terms.iter().zip(powers) {
                    let factor = x.powi(i as i32) * y.powi(j as i32);
                    samples.iter_mut().zip(term).for_each(|(sum, value)| *sum += factor * value);
                }
                samples
            }
        };
        (samples.iter().sum::<f64>() > 0.0).then_some(samples)
    }
}

fn image(file: &FrameFile, given: Option<usize>) -> Result<(PsfGrid, StatedImage), Error> {
    let Some(&hdu) = file.images().first() else {
        let allowed = "an image with two axes, or a table PSF_MASK of PSFEx";
        return Err(Error::invalid("point spread function", "missing", allowed).in_file("", file.path()));
    };
    let [rows, columns] = file.image_size(hdu)?;
    if rows.max(columns) > MOST_SAMPLES {
        let given = format!("{columns} by {rows} pixels");
        let allowed = format!("sides up to {MOST_SAMPLES} pixels");
        return Err(Error::invalid("size of the point spread function", given, allowed).in_hdu(file.path(), hdu));
    }
    let headers = [file.header(hdu)?, file.header(0)?];
    let stated = headers.iter().find_map(|header| stated_oversampling(header));
    let oversampling = match (given, stated) {
        (Some(number), _) => number as f64,
        (None, stated) => stated.map_or(1.0, |(_, number)| number),
    };
    let is_whole = oversampling.fract() == 0.0 && (1.0..=MOST_OVERSAMPLING as f64).contains(&oversampling);
    if !is_whole {
        let allowed = format!("a whole number from 1 to {MOST_OVERSAMPLING}");
        return Err(
            Error::invalid("oversampling of the point spread function", oversampling, allowed).in_file("", file.path())
        );
    }
    let plane = file.read_plane(hdu)?;
    let cells: Vec<f64> = plane.values().iter().map(|value| f64::from(*value)).collect();
    let border =
        check_values(&cells).and_then(|()| border(&cells, columns)).map_err(|error| error.in_hdu(file.path(), hdu))?;
    let stated = StatedImage {
        scale: headers.iter().find_map(|header| stated_scale(header)).filter(|_| given.is_none()),
        oversampling: stated.map(|(keyword, _)| keyword),
        border: border / peak(&cells),
        sky_share: border * cells.len() as f64 / cells.iter().sum::<f64>(),
    };
    let centroid = centroid(&cells, columns);
    let (samples, size) = summed(cells, [rows, columns], oversampling as usize);
    // The samples extend beyond the cells evenly on all sides.
    let star = [0, 1].map(|axis| centroid[axis] + 0.5 * (size[axis] - [rows, columns][axis]) as f64);
    let grid = PsfGrid { size, star, step_pix: 1.0 / oversampling, terms: vec![samples], polynomial: None };
    check_extent(&grid).map_err(|error| error.in_file("", file.path()))?;
    Ok((grid, stated))
}

/// Returns the oversampling in a header with its keyword; NaN if it is no number.
fn stated_oversampling(header: &Header) -> Option<(&'static str, f64)> {
    let number = |keyword| header.number(keyword).unwrap_or(f64::NAN);
    let found = OVERSAMPLING.into_iter().find(|keyword| header.contains(keyword));
    found.map(|keyword| (keyword, number(keyword))).or_else(|| {
        // 0.3333 is a third.
        let inverse = 1.0 / number(STEP);
        let whole = inverse.round();
        header.contains(STEP).then_some((STEP, if (inverse - whole).abs() < 0.01 { whole } else { inverse }))
    })
}

/// Returns the side of a pixel on the sky in a header with its keyword, arcseconds.
fn stated_scale(header: &Header) -> Option<(&'static str, f64)> {
    let in_arcsec = ["PIXELSCL", "PIXSCALE"].into_iter().map(|keyword| (keyword, header.number(keyword)));
    let unit_arcsec = match header.text("CUNIT1").as_deref() {
        None | Some("deg") => 3600.0,
        Some("arcsec") => 1.0,
        Some("mas") => 1e-3,
        Some("rad") => 180.0 / std::f64::consts::PI * 3600.0,
        Some(_) => f64::NAN,
    };
    let axis = header.text("CTYPE1").unwrap_or_default();
    let is_sky = ["RA", "DEC", "GL", "EL"].iter().any(|start| axis.starts_with(start)) || header.contains("CUNIT1");
    /// Largest scale that counts without a unit or type of the axes, degrees: 1 is that of plain pixels.
    const MOST_DEG: f64 = 0.01;
    let in_units = |number: f64| Some(number).filter(|number| is_sky || *number < MOST_DEG).map(|it| it * unit_arcsec);
    let matrix = header.number("CD1_1").map(|first| first.hypot(header.number("CD2_1").unwrap_or(0.0)));
    let step = header.number("CDELT1").map(f64::abs);
    in_arcsec
        .chain([("CD1_1", matrix.and_then(in_units)), ("CDELT1", step.and_then(in_units))])
        .find_map(|(keyword, arcsec)| Some((keyword, arcsec.filter(|arcsec| arcsec.is_finite() && *arcsec > 0.0)?)))
}

fn rounded(number: f64) -> f64 {
    (number * 1e4).round() / 1e4
}

fn peak(cells: &[f64]) -> f64 {
    cells.iter().copied().fold(0.0, f64::max)
}

/// Returns the weights of the cells around a cell in a pixel of `number` cells along an axis.
fn cell_weights(number: usize) -> Vec<f64> {
    if !number.is_multiple_of(2) {
        return vec![1.0; number];
    }
    // The edges of the pixel are in the middle of cells. The light up to the middle of cell 0 is the integral of the
    // polynomial of degree 5 through the sums up to the six nearest edges of cells:
    // a_0 / 2 + 22 (a_-1 - a_1) / 256 - 3 (a_-2 - a_2) / 256
    const INNER: [f64; 5] = [3.0 / 256.0, -22.0 / 256.0, 0.5, 22.0 / 256.0, -3.0 / 256.0];
    let mut weights = vec![0.0; number + 5];
    weights[3..number + 2].fill(1.0);
    for (index, weight) in INNER.into_iter().enumerate() {
        weights[index] += weight;
        weights[number + 4 - index] += weight;
    }
    weights
}

/// Returns the light in a pixel of `number` by `number` cells around each cell. The image becomes larger by a pixel.
fn summed(cells: Vec<f64>, [rows, columns]: [usize; 2], number: usize) -> (Vec<f64>, [usize; 2]) {
    let weights = cell_weights(number);
    let half = weights.len() / 2;
    let (wide, high) = (columns + 2 * half, rows + 2 * half);
    let mut along = vec![0.0; rows * wide];
    for row in 0..rows {
        for column in 0..columns {
            for (shift, weight) in weights.iter().enumerate() {
                along[row * wide + column + shift] += weight * cells[row * columns + column];
            }
        }
    }
    let mut samples = vec![0.0; high * wide];
    for row in 0..rows {
        for (shift, weight) in weights.iter().enumerate() {
            for column in 0..wide {
                samples[(row + shift) * wide + column] += weight * along[row * wide + column];
            }
        }
    }
    (samples, [high, wide])
}

fn psfex(file: &FrameFile, hdu: usize) -> Result<PsfGrid, Error> {
    let of_table = |error: Error| error.at("PSF_MASK");
    let header: &Header = file.header(hdu)?;
    let whole = |name: &str, range: std::ops::RangeInclusive<usize>| -> Result<usize, Error> {
        let found = header.integer(name).and_then(|number| usize::try_from(number).ok());
        found.filter(|number| range.contains(number)).ok_or_else(|| {
            let given = header.integer(name).map_or_else(|| "missing".to_owned(), |number| number.to_string());
            Error::invalid(name, given, format!("{} to {}", range.start(), range.end()))
        })
    };
    let number = |name: &str, [least, most]: [f64; 2]| -> Result<f64, Error> {
        let found = header.number(name);
        found.filter(|number| (least..=most).contains(number)).ok_or_else(|| {
            let given = found.map_or_else(|| "missing".to_owned(), |number| number.to_string());
            Error::invalid(name, given, format!("{least} to {most}"))
        })
    };
    let size = [whole("PSFAXIS2", 1..=MOST_SAMPLES)?, whole("PSFAXIS1", 1..=MOST_SAMPLES)?];
    check_size(size).map_err(of_table)?;
    let planes = if header.integer("PSFNAXIS").unwrap_or(3) > 2 { whole("PSFAXIS3", 1..=66)? } else { 1 };
    let step_pix = number("PSF_SAMP", STEPS_PIX)?;
    let polynomial = match whole("POLNAXIS", 0..=2)? {
        0 => None,
        2 => {
            for (name, axis) in [("POLNAME1", 'X'), ("POLNAME2", 'Y')] {
                let given = header.text(name).unwrap_or_default();
                if !(given.starts_with(axis) && given.ends_with("_IMAGE")) {
                    let allowed = format!("a position in the image, such as {axis}_IMAGE");
                    return Err(Error::invalid(name, format!("'{}'", Quoted::new(&given)), allowed));
                }
            }
            whole("POLNGRP", 1..=1)?;
            let degree = whole("POLDEG1", 0..=MOST_DEGREE)?;
            let far = [-1e7, 1e7];
            let scale = [number("POLSCAL1", [1e-6, 1e7])?, number("POLSCAL2", [1e-6, 1e7])?];
            let zero = [number("POLZERO1", far)?, number("POLZERO2", far)?];
            (degree > 0).then_some(Polynomial { zero, scale, degree })
        }
        axes => return Err(Error::invalid("POLNAXIS", axes, "0 or 2, a polynomial in x and y")),
    };
    let expected = polynomial.map_or(1, |polynomial| (polynomial.degree + 1) * (polynomial.degree + 2) / 2);
    if planes != expected {
        let allowed = format!("{expected}, the number of terms of the polynomial");
        return Err(Error::invalid("PSFAXIS3", planes, allowed));
    }
    let column = file.read_table(hdu)?.into_iter().find(|column| column.name.eq_ignore_ascii_case("PSF_MASK"));
    let Some(BinaryCells::Numbers { values, .. }) = column.map(|column| column.cells) else {
        return Err(Error::invalid("PSF_MASK", "missing or not of numbers", "a column of numbers"));
    };
    let samples = size[0] * size[1];
    if values.len() != planes * samples {
        let allowed = format!("{}, one row of {planes} planes", planes * samples);
        return Err(Error::invalid("number of values in PSF_MASK", values.len(), allowed));
    }
    if let Some(bad) = values.iter().find(|value| !value.is_finite()) {
        return Err(Error::invalid("PSF_MASK", bad, "finite values"));
    }
    check_values(&values[..samples]).map_err(of_table)?;
    let terms = values.chunks_exact(samples).map(<[f64]>::to_vec).collect();
    // PSFEx has the star at the middle sample.
    let star = size.map(|side| 0.5 * (side as f64 - 1.0));
    let grid = PsfGrid { size, star, step_pix, terms, polynomial };
    check_extent(&grid).map_err(of_table)?;
    Ok(grid)
}

fn check_size([rows, columns]: [usize; 2]) -> Result<(), Error> {
    if [rows, columns].iter().any(|side| side % 2 == 0 || *side > MOST_SAMPLES) {
        let given = format!("{columns} by {rows} pixels");
        let allowed = format!("odd numbers up to {MOST_SAMPLES}, so that the star is at the middle pixel");
        return Err(Error::invalid("size of the point spread function", given, allowed));
    }
    Ok(())
}

fn check_values(values: &[f64]) -> Result<(), Error> {
    if let Some(bad) = values.iter().find(|value| !value.is_finite()) {
        return Err(Error::invalid("point spread function", bad, "finite values"));
    }
    /// Smallest sum relative to that of the absolute values. A smaller one is that of noise.
    const LEAST_SHARE: f64 = 0.1;
    let (sum, all): (f64, f64) = (values.iter().sum(), values.iter().map(|value| value.abs()).sum());
    if sum <= LEAST_SHARE * all {
        let allowed = format!("above 0, and above {LEAST_SHARE} of the sum of the absolute values, {all}");
        return Err(Error::invalid("sum of the point spread function", sum, allowed));
    }
    Ok(())
}

/// Returns the median of the outermost cells, or an error if they have light: they are those of a sky, or the wings are
/// cut off.
fn border(cells: &[f64], columns: usize) -> Result<f64, Error> {
    /// Largest light of the border relative to the peak.
    const MOST: f64 = 0.01;
    let rows = cells.len() / columns;
    let is_border = |at: usize| {
        let (row, column) = (at / columns, at % columns);
        row == 0 || column == 0 || row + 1 == rows || column + 1 == columns
    };
    let border = median((0..cells.len()).filter(|at| is_border(*at)).map(|at| cells[at]).collect());
    let share = border / peak(cells);
    if share.abs() > MOST {
        let given = format!("{:.1} % of its peak (median)", 100.0 * share);
        let allowed = format!(
            "at most {} %: subtract the sky from the image of the star, or use one with more of its wings",
            100.0 * MOST
        );
        return Err(Error::invalid("border of the point spread function", given, allowed));
    }
    Ok(border)
}

/// Returns the centroid (row, column) of the light above 5 % of the peak: fainter wings have more noise than light.
fn centroid(cells: &[f64], columns: usize) -> [f64; 2] {
    let least = 0.05 * peak(cells);
    let [mut light, mut row, mut column] = [0.0; 3];
    for (at, value) in cells.iter().enumerate() {
        // Without a step at the threshold, which would depend on the place of the star within its cell.
        let above = (value - least).max(0.0);
        light += above;
        row += above * (at / columns) as f64;
        column += above * (at % columns) as f64;
    }
    [row / light, column / light]
}

fn check_extent(grid: &PsfGrid) -> Result<(), Error> {
    let side = grid.step_pix * grid.size[0].max(grid.size[1]) as f64;
    if side > MOST_PIXELS + 1.0 {
        let given = format!("{side:.0} pixels of the frame");
        return Err(Error::invalid("side of the point spread function", given, format!("at most {MOST_PIXELS}")));
    }
    Ok(())
}
