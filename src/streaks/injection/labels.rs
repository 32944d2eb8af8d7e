//! Labels of injected streaks, with which detectors of streaks are trained: COCO, YOLO with oriented boxes, and DS9.
//!
//! The outline of a streak is the part of it in the image, widened by its full width at half maximum on both sides and
//! at both ends. Streaks of which only the wings reach the image have no label.
//!
//! Images of COCO and YOLO have their origin at the corner of the first pixel of the file, and y increases with the
//! rows of the file. This is the order of the rows of the array that astropy returns. A picture with the first row at
//! the bottom, as DS9 shows it, needs height - y.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::super::chip::Chip;
use super::super::drawn::DrawnStreak;
use super::super::masking::{Cell, polygons};
use super::super::regions::{Region, region_text};
use crate::error::Error;
use crate::images::PixelPosition;
use crate::output::write_atomically;

/// Smallest distance of the outline from the middle of the streak, pixels.
const LEAST_HALF_WIDTH_PIX: f64 = 1.0;

/// Format of labels.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum LabelFormat {
    /// One JSON file of all frames: images, annotations with polygons, categories.
    Coco,
    /// One text file for each image, with oriented boxes (`class x1 y1 x2 y2 x3 y3 x4 y4`).
    Yolo,
    /// One region file for each image.
    Ds9,
}

/// Outlines of the streaks on one chip.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelledImage {
    /// HDU of the chip.
    pub hdu: usize,
    /// False if the frame has several chips.
    pub is_only: bool,
    /// Rows and columns.
    pub size: [usize; 2],
    /// The streaks.
    pub labels: Vec<Label>,
}

/// Outline of one streak.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Name of the source.
    pub name: String,
    /// Brightest magnitude.
    pub magnitude: Option<f64>,
    /// Ends of the streak, pixels.
    pub ends: [PixelPosition; 2],
    /// Polygons around the streak, pixels; several for a bent streak.
    pub outline: Vec<Vec<PixelPosition>>,
}

/// File of labels.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelFile {
    /// Path.
    pub path: PathBuf,
    /// Content.
    pub text: String,
}

impl LabelFormat {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Coco, Self::Yolo, Self::Ds9];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Coco => "coco",
            Self::Yolo => "yolo",
            Self::Ds9 => "ds9",
        }
    }

    /// Returns a format by its name.
    ///
    /// # Errors
    /// An unknown name.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        let found = Self::ALL.into_iter().find(|format| format.name().eq_ignore_ascii_case(name.trim()));
        found.ok_or_else(|| {
            Error::invalid("format of labels", format!("{name:?}"), Self::ALL.map(Self::name).join(", "))
        })
    }

    /// Returns the path of the labels of an image of a frame, beside the frame; for COCO, that of all `frames`.
    pub fn path(self, frame: &Path, frames: usize, hdu: Option<usize>) -> PathBuf {
        let name = file_name(frame);
        let lower = name.to_ascii_lowercase();
        let end = [".fits.fz", ".fits", ".fit", ".fts", ".fz"].into_iter().find(|end| lower.ends_with(end));
        let stem = &name[..name.len() - end.map_or(0, str::len)];
        let chip = hdu.map_or_else(String::new, |hdu| format!("-hdu{hdu}"));
        frame.with_file_name(match self {
            Self::Coco if frames > 1 => "coco.json".to_owned(),
            Self::Coco => format!("{stem}.coco.json"),
            Self::Yolo => format!("{stem}{chip}.txt"),
            Self::Ds9 => format!("{stem}{chip}.reg"),
        })
    }
}

impl LabelledImage {
    /// Returns the outlines of the streaks on a chip.
    pub fn new(chip: &Chip, is_only: bool, streaks: &[DrawnStreak<'_>]) -> Self {
        // The parts of a satellite that are drawn separately are one streak.
        let mut groups: Vec<Vec<&DrawnStreak<'_>>> = Vec::new();
        for streak in streaks.iter().filter(|streak| streak.hdu == chip.hdu && !streak.points.is_empty()) {
            match groups.iter_mut().find(|group| group.iter().any(|other| is_part(streak, other))) {
                Some(group) => group.push(streak),
                None => groups.push(vec![streak]),
            }
        }
        Self {
            hdu: chip.hdu,
            is_only,
            size: [chip.rows, chip.columns],
            labels: groups.iter().filter_map(|group| Label::from_parts(chip, group)).collect(),
        }
    }
}

/// Returns true if two streaks are of parts of one source at the same time.
fn is_part(streak: &DrawnStreak<'_>, other: &DrawnStreak<'_>) -> bool {
    let [Some([from, to]), Some([first, last])] = [streak, other].map(DrawnStreak::ends) else { return false };
    std::ptr::eq(streak.source, other.source)
        && streak.part != other.part
        && from.epoch <= last.epoch
        && first.epoch <= to.epoch
}

impl Label {
    /// Returns the label of one streak, whose parts may be drawn separately.
    fn from_parts(chip: &Chip, parts: &[&DrawnStreak<'_>]) -> Option<Self> {
        let brightest = parts.iter().min_by(|a, b| {
            let magnitude = |streak: &DrawnStreak<'_>| streak.peak_magnitude.unwrap_or(f64::INFINITY);
            magnitude(a).total_cmp(&magnitude(b))
        })?;
        let ends = brightest.ends()?.map(|point| point.at);
        let mut outline = Vec::new();
        for streak in parts {
            let radius_pix = streak.width_pix.max(LEAST_HALF_WIDTH_PIX);
            let cells = (0..).zip(streak.points.windows(2)).map(|(number, pair)| Cell {
                ends: [pair[0].at, pair[1].at],
                radius_pix,
                light_pix: radius_pix,
                times_s: [f64::from(number), f64::from(number + 1)],
            });
            let cells: Vec<Cell> = cells.collect();
            outline.extend(polygons(&cells, &chip.light_area));
        }
        (!outline.is_empty()).then(|| Self {
            name: brightest.source.name.to_string(),
            magnitude: brightest.peak_magnitude,
            ends,
            outline,
        })
    }

    /// Returns the area in any of the polygons, which are convex and may overlap, square pixels: the sum of their
    /// chords along equidistant rows.
    fn area_pix(&self) -> f64 {
        /// Distance of the rows, pixels.
        const STEP_PIX: f64 = 0.125;
        let [[_, low], [_, high]] = self.bounds();
        let chord = |corners: &Vec<PixelPosition>, y: f64| -> Option<[f64; 2]> {
            let sides = corners.iter().zip(corners.iter().cycle().skip(1));
            let crossings = sides.filter(|(a, b)| (a.y > y) != (b.y > y));
            let at = crossings.map(|(a, b)| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
            let range = at.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| [least.min(x), most.max(x)]);
            (range[0] < range[1]).then_some(range)
        };
        let rows = ((high - low) / STEP_PIX).ceil().max(1.0);
        let step = (high - low) / rows;
        let of_row = |row: usize| {
            let y = low - 0.5 + (row as f64 + 0.5) * step;
            let mut chords: Vec<[f64; 2]> = self.outline.iter().filter_map(|corners| chord(corners, y)).collect();
            chords.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let mut reached = f64::NEG_INFINITY;
            let mut length = 0.0;
            for [from, to] in chords {
                length += (to - from.max(reached)).max(0.0);
                reached = reached.max(to);
            }
            step * length
        };
        (0..rows as usize).map(of_row).sum()
    }

    fn corners(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.outline.iter().flatten().map(|at| from_corner(*at))
    }

    /// Returns the smallest and the largest coordinates of the outline.
    fn bounds(&self) -> [[f64; 2]; 2] {
        let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for corner in self.corners() {
            for axis in 0..2 {
                bounds[0][axis] = bounds[0][axis].min(corner[axis]);
                bounds[1][axis] = bounds[1][axis].max(corner[axis]);
            }
        }
        bounds
    }

    /// Returns the corners of the rectangle along the line between the ends that contains the outline.
    fn oriented_box(&self) -> [[f64; 2]; 4] {
        let [from, to] = self.ends;
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let length = dx.hypot(dy);
        let [ex, ey] = if length > 0.0 { [dx / length, dy / length] } else { [1.0, 0.0] };
        let (mut along, mut across) = ([f64::INFINITY, f64::NEG_INFINITY], [f64::INFINITY, f64::NEG_INFINITY]);
        for [x, y] in self.corners() {
            let (u, v) = (x * ex + y * ey, y * ex - x * ey);
            along = [along[0].min(u), along[1].max(u)];
            across = [across[0].min(v), across[1].max(v)];
        }
        let corner = |u: f64, v: f64| [u * ex - v * ey, u * ey + v * ex];
        [
            corner(along[0], across[0]),
            corner(along[1], across[0]),
            corner(along[1], across[1]),
            corner(along[0], across[1]),
        ]
    }
}

/// Converts a position, counted from the centre of the first pixel, to one from its outer corner.
fn from_corner(at: PixelPosition) -> [f64; 2] {
    [at.x + 0.5, at.y + 0.5]
}

/// Returns the files of labels of several frames.
pub fn label_files(formats: &[LabelFormat], frames: &[(&Path, &[LabelledImage])]) -> Vec<LabelFile> {
    let mut files = Vec::new();
    for &format in formats {
        if format == LabelFormat::Coco {
            let first = frames.first().map(|(path, _)| format.path(path, frames.len(), None));
            files.extend(first.map(|path| LabelFile { path, text: coco(frames) }));
            continue;
        }
        for (path, images) in frames {
            files.extend(images.iter().map(|image| LabelFile {
                path: format.path(path, frames.len(), (!image.is_only).then_some(image.hdu)),
                text: if format == LabelFormat::Yolo { yolo(image) } else { ds9(image) },
            }));
        }
    }
    files
}

/// Writes files of labels.
///
/// # Errors
/// A file cannot be written.
pub fn write_labels(files: &[LabelFile]) -> Result<(), Error> {
    for LabelFile { path, text } in files {
        write_atomically(path, |out| out.write_all(text.as_bytes())).map_err(Error::io(path))?;
    }
    Ok(())
}

/// Returns the name of a file without its folder.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn rounded(number: f64) -> f64 {
    (number * 1000.0).round() / 1000.0
}

fn coco(frames: &[(&Path, &[LabelledImage])]) -> String {
    let (mut images, mut annotations) = (Vec::new(), Vec::<Value>::new());
    for (path, of_frame) in frames {
        for LabelledImage { hdu, size: [rows, columns], labels, .. } in *of_frame {
            let image_id = images.len() + 1;
            images.push(json!({
                "id": image_id, "file_name": file_name(path), "hdu": hdu, "width": columns, "height": rows,
            }));
            for label in labels {
                let polygon = |corners: &Vec<PixelPosition>| -> Vec<f64> {
                    corners.iter().flat_map(|at| from_corner(*at)).map(rounded).collect()
                };
                let segmentation: Vec<Vec<f64>> = label.outline.iter().map(polygon).collect();
                let (magnitude, area) = (label.magnitude.map(rounded), rounded(label.area_pix()));
                let [[left, low], [right, high]] = label.bounds();
                let bounds = [left, low, right - left, high - low].map(rounded);
                annotations.push(json!({
                    "id": annotations.len() + 1,
                    "image_id": image_id,
                    "category_id": 1,
                    "segmentation": segmentation,
                    "area": area,
                    "bbox": bounds,
                    "iscrowd": 0,
                    "streak": label.name,
                    "magnitude": magnitude,
                }));
            }
        }
    }
    let description = format!(
        "streakcast {}: injected streaks; y increases with the rows of the FITS file",
        env!("CARGO_PKG_VERSION")
    );
    let document = json!({
        "info": { "description": description },
        "images": images,
        "annotations": annotations,
        "categories": [{ "id": 1, "name": "streak", "supercategory": "streak" }],
    });
    document.to_string() + "\n"
}

/// Returns the lines of an image: class 0, and the corners of the oriented box as fractions of width and height. The
/// two sides along the streak are cut at the edges of the image, because the format has no coordinates outside of 0 to
/// 1.
fn yolo(image: &LabelledImage) -> String {
    let [rows, columns] = image.size.map(|count| count as f64);
    let line = |label: &Label| {
        let [a, b, c, d] = label.oriented_box().map(|[x, y]| [x / columns, y / rows]);
        let ([a, b], [d, c]) = (within_image(a, b), within_image(d, c));
        let corners = [a, b, c, d].into_iter().flatten();
        format!("0{}\n", corners.map(|share| format!(" {share:.6}")).collect::<String>())
    };
    image.labels.iter().map(line).collect()
}

/// Returns the part of a line in an image whose sides are 1; of a line outside of it, the ends moved to its edges.
fn within_image(from: [f64; 2], to: [f64; 2]) -> [[f64; 2]; 2] {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (from, to) in from.into_iter().zip(to).filter(|(from, to)| from != to) {
        let [a, b] = [0.0, 1.0].map(|edge| (edge - from) / (to - from));
        (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
    }
    let [first, last] = if first < last { [first, last] } else { [0.0, 1.0] };
    [first, last].map(|share| [0, 1].map(|axis| (from[axis] + share * (to[axis] - from[axis])).clamp(0.0, 1.0)))
}

fn ds9(image: &LabelledImage) -> String {
    let regions = image.labels.iter().flat_map(|label| {
        label.outline.iter().map(|polygon| Region {
            corners: polygon.iter().map(|at| at.fits()).collect(),
            name: label.name.clone(),
            tag: format!("HDU {}", image.hdu),
        })
    });
    region_text("labels", "image", 3, regions)
}

#[cfg(test)]
mod tests {
    use super::within_image;

    #[test]
    fn sides_of_boxes_are_cut_at_the_edges() {
        assert_eq!(within_image([0.25, 0.5], [1.25, 1.0]), [[0.25, 0.5], [1.0, 0.875]]);
        assert_eq!(within_image([-0.5, -1.0], [0.5, 1.0]), [[0.0, 0.0], [0.5, 1.0]]);
        assert_eq!(within_image([0.5, -0.25], [0.5, 1.5]), [[0.5, 0.0], [0.5, 1.0]]);
        // A side beside the image.
        assert_eq!(within_image([0.25, 1.25], [0.75, 1.5]), [[0.25, 1.0], [0.75, 1.0]]);
    }
}
