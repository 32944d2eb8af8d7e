//! Roles of the images of a file: frames, companion planes of frames (masks, variances, maps), and other HDUs.

use super::super::header::Header;
use super::super::pixels::PixelPosition;
use super::super::wcs::Wcs;
use super::frame_file::FrameFile;
use crate::error::{Error, ErrorKind};

/// Content of a companion plane.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum PlaneKind {
    /// Bits or flags of each pixel.
    Mask,
    /// Variance of each pixel.
    Variance,
    /// Inverse of the variance of each pixel.
    InverseVariance,
    /// Standard deviation of each pixel.
    Error,
    /// Weight of each pixel; 0 for pixels without data.
    Weight,
    /// Other values that are not light of the sky, such as coverage or a part of the variance.
    Other,
}

/// Image that describes the pixels of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CompanionPlane {
    /// Number of its HDU, from 0.
    pub hdu: usize,
    /// Its EXTNAME or EXTTYPE; empty if it has none.
    pub name: String,
    /// HDU of the frame that it describes; `None` if the file does not determine it.
    pub of: Option<usize>,
    /// Content of the plane.
    pub kind: PlaneKind,
    /// Card that states that it is no frame, such as `PRODTYPE = 'WTMAP'`, if its name does not.
    pub card: Option<String>,
}

/// Images of a file by their roles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameImages {
    /// HDUs of the frames: images of the sky.
    pub frames: Vec<usize>,
    /// Companion planes.
    pub companions: Vec<CompanionPlane>,
    /// HDUs of distortion tables.
    pub tables: Vec<usize>,
    /// HDUs of frames with the shape and the world coordinates of an earlier frame.
    pub same_sky: Vec<usize>,
    /// HDUs of images with more than two axes, with a description, and how to get a frame from them.
    pub cubes: Vec<(usize, String, &'static str)>,
}

/// Words in names of planes that are not light of the sky, with their content.
const KINDS: &[(&str, PlaneKind)] = &[
    ("MASK", PlaneKind::Mask),
    ("MASKS", PlaneKind::Mask),
    ("MSK", PlaneKind::Mask),
    ("BPM", PlaneKind::Mask),
    ("BADPIX", PlaneKind::Mask),
    ("DQ", PlaneKind::Mask),
    ("DQM", PlaneKind::Mask),
    ("APERTURE", PlaneKind::Mask),
    ("QUAL", PlaneKind::Mask),
    ("QUALITY", PlaneKind::Mask),
    ("FLAG", PlaneKind::Mask),
    ("FLAGS", PlaneKind::Mask),
    ("FLG", PlaneKind::Mask),
    ("VAR", PlaneKind::Variance),
    ("VARIANCE", PlaneKind::Variance),
    ("IVAR", PlaneKind::InverseVariance),
    ("INVVAR", PlaneKind::InverseVariance),
    ("INVVARIANCE", PlaneKind::InverseVariance),
    ("ERR", PlaneKind::Error),
    ("ERRS", PlaneKind::Error),
    ("ERROR", PlaneKind::Error),
    ("ERRORS", PlaneKind::Error),
    ("UNCERT", PlaneKind::Error),
    ("UNCERTAINTY", PlaneKind::Error),
    ("SIGMA", PlaneKind::Error),
    ("STDDEV", PlaneKind::Error),
    ("NOISE", PlaneKind::Error),
    ("RMS", PlaneKind::Error),
    ("WEIGHT", PlaneKind::Weight),
    ("WEIGHTS", PlaneKind::Weight),
    ("WHT", PlaneKind::Weight),
    ("WGT", PlaneKind::Weight),
    ("COVERAGE", PlaneKind::Other),
    ("EXPMAP", PlaneKind::Other),
    ("FOOTPRINT", PlaneKind::Other),
    ("SEGMAP", PlaneKind::Other),
    ("CTX", PlaneKind::Other),
];

/// Parts of words that mark planes in combined names, such as `CHIPMASK` or `BADFLAGS`.
const PARTS: [&str; 7] = ["MASK", "VARIANCE", "VARMAP", "RMSMAP", "WEIGHT", "IVAR", "FLAG"];

/// Words in names of images that belong to a frame of another time, such as the template of a difference, or that have
/// a date of their own because another program wrote them.
const MAPS: [&str; 27] = [
    "AREA",
    "BACK",
    "BACKGROUND",
    "BGD",
    "BKG",
    "BKGD",
    "CON",
    "CONTEXT",
    "COV",
    "DARK",
    "DIFF",
    "DIFFERENCE",
    "EXPOSUREMAP",
    "FLAT",
    "MODEL",
    "OBJECTS",
    "REF",
    "REFERENCE",
    "RESIDUAL",
    "SEG",
    "SEGM",
    "SEGMENTATION",
    "SKY",
    "SNR",
    "TEMPLATE",
    "TEMPL",
    "TMPL",
];

/// Words of images of another time, whose masks and variances are not those of the frame.
const OTHER_IMAGES: [&str; 5] = ["REF", "REFERENCE", "TEMPLATE", "TEMPL", "TMPL"];

/// Names of images of the sky.
const SCIENCE: [&str; 5] = ["SCI", "SCIENCE", "IMAGE", "DATA", "IMG"];

/// Names of chips and amplifiers.
const CHIPS: [&str; 6] = ["CCD", "CHIP", "AMP", "DET", "DETECTOR", "IM"];

/// Beginnings of the names of distortion tables (HST and the FITS distortion paper).
const DISTORTION_TABLES: [&str; 4] = ["WCSDVARR", "D2IMARR", "NPOLARR", "DISTORTION"];

/// Largest distance between the positions of a pixel in two images with the same world coordinates, as a fraction of
/// the pixel scale.
const SAME_SKY_PIX: f64 = 0.1;

impl FrameFile {
    /// Returns the roles of the images: frames, their companion planes, and other images.
    ///
    /// # Errors
    /// An image that can be both a frame and a companion plane.
    #[doc(hidden)]
    pub fn frame_images(&self) -> Result<FrameImages, Error> {
        FrameImages::from_file(self)
    }
}

impl FrameImages {
    /// Determines the roles of the images of a file.
    ///
    /// An image with the shape and the world coordinates of an earlier frame is its companion plane, unless both have
    /// the name of a science image with another number or EXTVER. If it has a start of its own, it is a companion plane
    /// with the name of a background, a template or another map, a frame with a name like that of the earlier one, and
    /// ambiguous otherwise. An image of another shape or scale whose centre is in an earlier frame, or that contains
    /// the centre of one, is a companion plane, too, unless it has a start of its own: a binned copy, a background or a
    /// preview. Names of masks, variances and weights, and HDUCLAS2 of errors and flags, mark companion planes of any
    /// shape. Images with the names of distortion tables are never frames.
    ///
    /// # Errors
    /// An image that can be both a frame and a companion plane, because neither its name nor its world coordinates
    /// decide.
    fn from_file(file: &FrameFile) -> Result<Self, Error> {
        let mut found = Self::default();
        for info in file.hdus() {
            if let Some((words, remedy)) = info.cube.as_ref().filter(|_| info.is_image()) {
                found.cubes.push((info.index, words.clone(), remedy));
            }
        }
        let mut frames: Vec<Image> = Vec::new();
        let mut planes: Vec<(Image, PlaneKind)> = Vec::new();
        for hdu in file.images() {
            let image = Image::from_hdu(file, hdu)?;
            if DISTORTION_TABLES.iter().any(|table| image.name.starts_with(table)) {
                found.tables.push(hdu);
            } else if let Some(kind) = image.kind() {
                planes.push((image, kind));
            } else {
                match frames.iter().position(|frame| image.has_pixels_of(frame) || image.overlaps(frame)) {
                    None => frames.push(image),
                    Some(at) => match image.role_beside(&frames[at]) {
                        Role::Frame => {
                            let is_same = image.sky.is_some() && image.has_pixels_of(&frames[at]);
                            found.same_sky.extend((is_same && !image.has_other_date(&frames[at])).then_some(hdu));
                            frames.push(image);
                        }
                        Role::Plane => planes.push((image, PlaneKind::Other)),
                        Role::FrameInstead => {
                            let earlier = std::mem::replace(&mut frames[at], image);
                            planes.push((earlier, PlaneKind::Other));
                        }
                        Role::Unclear => {
                            let what = format!("HDU {hdu}{}", shown(&image.name));
                            let earlier = frames[at].hdu;
                            let given = format!(
                                "an image like HDU {earlier}{}: a frame or a companion plane",
                                shown(&frames[at].name)
                            );
                            let allowed = format!("--hdu {earlier}, --hdu {hdu} or --hdu {earlier},{hdu}");
                            return Err(Error::invalid(what, given, allowed).in_file("", file.path()));
                        }
                    },
                }
            }
        }
        frames.sort_by_key(|frame| frame.hdu);
        planes.sort_by_key(|(plane, _)| plane.hdu);
        let of: Vec<Option<usize>> = planes.iter().map(|(plane, kind)| plane.owner(*kind, &frames, &planes)).collect();
        found.companions = planes
            .into_iter()
            .zip(of)
            .map(|((plane, kind), of)| {
                let card = plane.class.filter(|_| kind_of(&plane.name).is_none()).map(|(_, card)| card);
                CompanionPlane { hdu: plane.hdu, name: plane.name, of, kind, card }
            })
            .collect();
        found.frames = frames.iter().map(|frame| frame.hdu).collect();
        Ok(found)
    }

    /// Returns which images are frames and which are not, in one line; `None` if all images are frames.
    pub fn summary(&self) -> Option<String> {
        if [self.companions.len(), self.tables.len(), self.cubes.len(), self.same_sky.len()] == [0; 4] {
            return None;
        }
        let numbers = |hdus: &[usize]| hdus.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let mut parts = vec![match &self.frames[..] {
            [] => "no frame".to_owned(),
            [hdu] => format!("the frame is HDU {hdu}"),
            several => format!("the frames are HDU {}", numbers(several)),
        }];
        if !self.same_sky.is_empty() {
            parts.push(format!(
                "HDU {} with the world coordinates of an earlier frame: if they are reads or amplifiers of one exposure, \
                 specify one with --hdu",
                numbers(&self.same_sky)
            ));
        }
        let shown_plane = |plane: &CompanionPlane| format!("{}{}", plane.hdu, shown(&plane.name));
        let planes: Vec<String> = self.companions.iter().map(shown_plane).collect();
        if !planes.is_empty() {
            parts.push(format!("companion planes, no frames: HDU {}", planes.join(", ")));
        }
        let is_unpaired = |plane: &&CompanionPlane| plane.of.is_none() && plane.kind != PlaneKind::Other;
        let unpaired: Vec<String> = self.companions.iter().filter(is_unpaired).map(shown_plane).collect();
        if !unpaired.is_empty() && !self.frames.is_empty() {
            parts.push(format!("frame unknown, not used: HDU {}", unpaired.join(", ")));
        }
        if !self.tables.is_empty() {
            parts.push(format!("distortion tables: HDU {}", numbers(&self.tables)));
        }
        parts.extend(self.cubes.iter().map(|(hdu, words, _)| format!("HDU {hdu} is {words} and is ignored")));
        Some(parts.join("; "))
    }

    /// Returns the number of frames of a file without any, with its first cube or companion plane, and what to do.
    pub fn no_frame(&self) -> (String, String) {
        if let Some((hdu, words, remedy)) = self.cubes.first() {
            return (format!("0; HDU {hdu} is {words}"), format!("1 or more images of two axes: {remedy}"));
        }
        let allowed = "1 or more (masks, weights and tables are ignored)";
        match self.companions.first() {
            Some(plane) => {
                let by = plane.card.as_ref().map_or_else(|| "its name".to_owned(), String::clone);
                let (hdu, name) = (plane.hdu, shown(&plane.name));
                (
                    format!("0; HDU {hdu}{name} is no frame by {by}"),
                    format!("{allowed}, or --hdu {hdu} to use it as a frame"),
                )
            }
            None => ("0".to_owned(), allowed.to_owned()),
        }
    }
}

/// Largest difference of MJD-OBS of one exposure, days: 0.1 s.
const SAME_MJD_DAY: f64 = 1e-6;

/// One image with the properties that determine its role.
struct Image {
    hdu: usize,
    name: String,
    /// Content that HDUCLAS2 and HDUCLAS3 (ESO's standard of data products) or keywords of archives state, and the card.
    class: Option<(PlaneKind, String)>,
    /// Form of an uncertainty that UTYPE, HDUCLAS3 or BUNIT states.
    form: Option<PlaneKind>,
    size: [usize; 2],
    version: Option<i64>,
    /// DATE-OBS, without zeros at the end of its seconds, and MJD-OBS.
    date: Option<String>,
    mjd: Option<f64>,
    sky: Option<Wcs>,
    /// Keywords of invalid world coordinates; empty if they are valid or missing.
    invalid_sky: String,
}

enum Role {
    Frame,
    Plane,
    /// The image is the frame, and the earlier image its companion plane.
    FrameInstead,
    Unclear,
}

impl Image {
    fn from_hdu(file: &FrameFile, hdu: usize) -> Result<Self, Error> {
        let header = file.header(hdu)?;
        let [name, of_type] =
            ["EXTNAME", "EXTTYPE"].map(|keyword| header.text(keyword).unwrap_or_default().to_ascii_uppercase());
        // The planes of compressed files of Rubin's pipelines have their name in EXTTYPE.
        let is_by_type = name.is_empty() || (kind_of(&name).is_none() && kind_of(&of_type).is_some());
        let sky = Wcs::from_header(header);
        let has_axes = !sky.as_ref().is_err_and(|error| error.kind() == ErrorKind::NoCoordinates);
        let invalid_sky = if sky.is_err() && has_axes { coordinates(header) } else { String::new() };
        Ok(Self {
            hdu,
            name: if is_by_type { of_type } else { name },
            form: form_of_uncertainty(header),
            class: kind_of_class(header).or_else(|| kind_of_product(&[header, file.header(0).ok()?])),
            size: file.image_size(hdu)?,
            date: header.text("DATE-OBS").map(|date| match date.split_once('.') {
                Some((whole, fraction)) => {
                    format!("{whole}.{fraction}").trim_end_matches(['0', 'Z']).trim_end_matches('.').to_owned()
                }
                None => date.trim_end_matches('Z').to_owned(),
            }),
            mjd: header.number("MJD-OBS"),
            version: header.integer("EXTVER"),
            sky: sky.ok(),
            invalid_sky,
        })
    }

    /// Returns the content that the name states, or else keywords; `None` for an image that may be a frame. Names such
    /// as UNCERT and ERR state an uncertainty, and keywords its form.
    fn kind(&self) -> Option<PlaneKind> {
        match kind_of(&self.name) {
            Some(PlaneKind::Error | PlaneKind::Variance | PlaneKind::InverseVariance) if self.form.is_some() => {
                self.form
            }
            kind => kind.or(self.class.as_ref().map(|(kind, _)| *kind)),
        }
    }

    fn has_sky(&self) -> bool {
        self.sky.is_some() || !self.invalid_sky.is_empty()
    }

    /// Returns true if the image has the shape of a frame, and its world coordinates or none.
    fn has_pixels_of(&self, frame: &Self) -> bool {
        let is_same_sky = match (&self.sky, &frame.sky) {
            (Some(own), Some(other)) => is_same_sky(own, other, self.size),
            (None, _) if !self.has_sky() => true,
            (None, None) => self.invalid_sky == frame.invalid_sky,
            _ => false,
        };
        self.size == frame.size && is_same_sky
    }

    /// Returns true if the centre of the image is in a frame, or that of the frame in the image.
    fn overlaps(&self, frame: &Self) -> bool {
        let has_centre_of = |image: &Self, other: &Self| {
            let [rows, columns] = other.size.map(|length| length as f64);
            let centre = PixelPosition { x: 0.5 * (columns - 1.0), y: 0.5 * (rows - 1.0) };
            let (Some(own), Some(sky)) = (&image.sky, &other.sky) else { return false };
            let Some(at) = sky.to_sky(centre).and_then(|direction| own.to_pixel(direction)) else { return false };
            let [rows, columns] = image.size.map(|length| length as f64);
            (-0.5..columns - 0.5).contains(&at.x) && (-0.5..rows - 0.5).contains(&at.y)
        };
        has_centre_of(self, frame) || has_centre_of(frame, self)
    }

    /// Returns true if the images state different dates.
    fn has_other_date(&self, other: &Self) -> bool {
        match (&self.date, &other.date) {
            (Some(own), Some(other)) => own != other,
            _ => self.mjd.zip(other.mjd).is_some_and(|(own, other)| (own - other).abs() > SAME_MJD_DAY),
        }
    }

    /// Returns the role of an image that has the pixels of an earlier frame or overlaps it.
    fn role_beside<'a>(&'a self, frame: &'a Self) -> Role {
        let has_same_sky = self.sky.is_some() && frame.sky.is_some() && self.has_pixels_of(frame);
        let is_science = |image: &Self| SCIENCE.contains(&stem(&image.name));
        if self.has_other_date(frame) {
            let first_word = |image: &'a Self| words_of(&image.name).next();
            let is_alike = first_word(self).is_some() && first_word(self) == first_word(frame);
            return if is_map(&self.name) && !is_map(&frame.name) {
                Role::Plane
            } else if is_alike || is_science(self) && is_science(frame) {
                Role::Frame
            } else if is_map(&frame.name) && is_science(self) {
                Role::FrameInstead
            } else if self.has_pixels_of(frame) {
                Role::Unclear
            } else {
                Role::Frame
            };
        }
        let has_other_version = match (self.version, frame.version) {
            (Some(own), Some(other)) => own != other,
            _ => false,
        };
        if !self.name.is_empty() && stem(&self.name) == stem(&frame.name) {
            // Two chips cannot have one sky: their images are planes, or one of them has wrong world coordinates.
            if has_same_sky && (self.name != frame.name || has_other_version) && !is_science(self) {
                return if CHIPS.contains(&stem(&self.name)) { Role::Unclear } else { Role::Plane };
            }
            return if self.name != frame.name || has_other_version { Role::Frame } else { Role::Unclear };
        }
        if is_science(self) && !is_science(frame) && self.has_sky() {
            return if frame.name.is_empty() { Role::Unclear } else { Role::FrameInstead };
        }
        // Without world coordinates of the frame, chips of a mosaic look like planes of one chip.
        let is_decided = frame.has_sky() && (!self.name.is_empty() || !self.has_sky());
        if is_decided { Role::Plane } else { Role::Unclear }
    }

    /// Returns true if the name of a mask or a variance has the name of another companion plane, as REF_MASK, or a word
    /// of [`OTHER_IMAGES`].
    fn is_of_other_image(&self, frames: &[Self], planes: &[(Self, PlaneKind)]) -> bool {
        let images = planes.iter().filter(|(other, kind)| *kind == PlaneKind::Other && other.hdu != self.hdu);
        let names: Vec<&str> = images.map(|(other, _)| other.name.as_str()).chain(OTHER_IMAGES).collect();
        let is_of_frame = |word: &str| frames.iter().any(|frame| words_of(&frame.name).any(|other| other == word));
        words_of(&self.name).any(|word| names.contains(&word) && !is_of_frame(word))
    }

    /// Returns the HDU of the frame to which a plane, one of `planes`, belongs.
    fn owner(&self, kind: PlaneKind, frames: &[Self], planes: &[(Self, PlaneKind)]) -> Option<usize> {
        if kind != PlaneKind::Other && self.is_of_other_image(frames, planes) {
            return None;
        }
        let same: Vec<&Self> = frames.iter().filter(|frame| frame.size == self.size).collect();
        // A property decides if it is that of one frame.
        let only = |is_frame: &dyn Fn(&Self) -> bool| {
            let mut found = same.iter().filter(|frame| is_frame(frame));
            found.next().filter(|_| found.next().is_none()).copied()
        };
        let by_sky = || only(&|frame| self.has_sky() && self.has_pixels_of(frame));
        let by_version = || only(&|frame| frame.version.is_some() && frame.version == self.version);
        let has_name = |frame: &Self| {
            self.name.ends_with(&frame.name)
                || self.name.split(|c: char| !c.is_ascii_alphanumeric()).any(|part| part == frame.name)
        };
        let by_name = || only(&|frame| !frame.name.is_empty() && has_name(frame));
        let by_number = || only(&|frame| number(&frame.name).is_some() && number(&frame.name) == number(&self.name));
        // As many planes of this content as frames have their order.
        let is_numbered = number(&self.name).is_some() && same.iter().all(|frame| number(&frame.name).is_some());
        let by_order = || {
            if is_numbered {
                return None;
            }
            let is_alike = |plane: &Self| plane.size == self.size && stem(&plane.name) == stem(&self.name);
            let mut alike: Vec<&Self> = planes.iter().map(|(plane, _)| plane).filter(|plane| is_alike(plane)).collect();
            alike.sort_by_key(|plane| (plane.version, plane.hdu));
            let at = alike.iter().position(|plane| plane.hdu == self.hdu)?;
            (alike.len() == same.len()).then(|| same[at])
        };
        // Planes without version follow their frame if they are between the frames.
        let is_between = same.last().is_some_and(|last| self.hdu < last.hdu);
        let by_place = || same.iter().rev().find(|frame| is_between && frame.hdu < self.hdu).copied();
        let found = only(&|_| true).or_else(by_sky).or_else(by_name).or_else(by_number).or_else(by_version);
        found.or_else(by_order).or_else(by_place).map(|frame| frame.hdu)
    }
}

/// Returns the number at the end of a name: 2 of `CCD_2`.
fn number(name: &str) -> Option<u32> {
    name[name.trim_end_matches(|c: char| c.is_ascii_digit()).len()..].parse().ok()
}

/// Returns the name without digits and separators at its end: `SCI` of `SCI_2`.
fn stem(name: &str) -> &str {
    name.trim_end_matches(|c: char| c.is_ascii_digit() || "_-[], ".contains(c))
}

fn words_of(name: &str) -> impl Iterator<Item = &str> {
    name.split(|c: char| !c.is_ascii_alphabetic()).filter(|word| !word.is_empty())
}

/// Returns true for the name of an image that is a companion plane whatever its date.
fn is_map(name: &str) -> bool {
    words_of(name).any(|word| MAPS.contains(&word))
}

/// Returns the content that a name states; `None` for other names.
fn kind_of(name: &str) -> Option<PlaneKind> {
    let words: Vec<&str> = words_of(name).collect();
    let kinds = words.iter().filter_map(|word| KINDS.iter().find(|(known, _)| known == word));
    let is_of_frame = |word: &&&str| SCIENCE.contains(*word) || CHIPS.contains(*word) || word.len() == 1;
    match kinds.map(|(_, kind)| *kind).next() {
        // A part of a variance, such as VAR_POISSON, is not the variance; that of a chip, such as DET11.RMS, is.
        Some(PlaneKind::Mask) => Some(PlaneKind::Mask),
        Some(kind) if words.len() == 1 + words.iter().filter(is_of_frame).count() => Some(kind),
        Some(_) => Some(PlaneKind::Other),
        None => PARTS.iter().any(|part| name.contains(part)).then_some(PlaneKind::Other),
    }
}

/// Returns the content that HDUCLAS2 and HDUCLAS3 state, with the card; `None` for data and without these keywords.
fn kind_of_class(header: &Header) -> Option<(PlaneKind, String)> {
    let [class, form] =
        ["HDUCLAS2", "HDUCLAS3"].map(|keyword| header.text(keyword).unwrap_or_default().to_ascii_uppercase());
    let kind = match (class.as_str(), form.as_str()) {
        ("ERROR", "MSE") => PlaneKind::Variance,
        ("ERROR", "INVMSE") => PlaneKind::InverseVariance,
        ("ERROR", _) => PlaneKind::Error,
        ("QUALITY", _) => PlaneKind::Mask,
        _ => return None,
    };
    Some((kind, format!("HDUCLAS2 = '{class}'")))
}

/// Returns the form of an uncertainty that keywords state: UTYPE of astropy's `CCDData`, HDUCLAS3, or BUNIT with the
/// power of one unit, such as `adu2`, `electron**2` or `adu-2`.
fn form_of_uncertainty(header: &Header) -> Option<PlaneKind> {
    let [of_astropy, class, unit] =
        ["UTYPE", "HDUCLAS3", "BUNIT"].map(|keyword| header.text(keyword).unwrap_or_default().to_ascii_uppercase());
    match (of_astropy.trim(), class.trim()) {
        ("STDDEVUNCERTAINTY", _) | ("", "RMSE") => return Some(PlaneKind::Error),
        ("VARIANCEUNCERTAINTY", _) | ("", "MSE") => return Some(PlaneKind::Variance),
        ("INVERSEVARIANCE", _) | ("", "INVMSE") => return Some(PlaneKind::InverseVariance),
        ("UNKNOWNUNCERTAINTY", _) => return Some(PlaneKind::Other),
        _ => {}
    }
    // Units of a standard deviation with several names may end in a power, as "erg/s/cm2".
    let power = unit.trim().trim_start_matches(|c: char| c.is_ascii_alphabetic());
    let is_one_unit = power.len() < unit.trim().len();
    match power.trim_start_matches(['*', '^', ' ']).trim_matches(['(', ')']) {
        "2" if is_one_unit => Some(PlaneKind::Variance),
        "-2" if is_one_unit => Some(PlaneKind::InverseVariance),
        _ => None,
    }
}

/// Returns the content that keywords of archives state for all images of a file, with the card: PRODTYPE (NOIRLab),
/// PRODCATG (ESO) and OBSTYPE (Las Cumbres Observatory); `None` for data and without these keywords.
fn kind_of_product(headers: &[&Header]) -> Option<(PlaneKind, String)> {
    ["PRODTYPE", "PRODCATG", "OBSTYPE"].into_iter().find_map(|keyword| {
        let text = headers.iter().find_map(|header| header.text(keyword))?.trim().to_ascii_uppercase();
        let kind = match (keyword, text.as_str()) {
            ("PRODTYPE", "DQMASK") | ("OBSTYPE", "BPM") => PlaneKind::Mask,
            ("PRODTYPE", "WTMAP") | ("PRODCATG", "ANCILLARY.WEIGHTMAP") => PlaneKind::Weight,
            ("PRODTYPE", "EXPMAP") => PlaneKind::Other,
            // Other files beside a product of ESO, such as ANCILLARY.IMAGE, may be images of the sky.
            ("PRODCATG", category) => kind_of(category.strip_prefix("ANCILLARY.")?)?,
            _ => return None,
        };
        Some((kind, format!("{keyword} = '{text}'")))
    })
}

/// Returns a name in brackets for messages.
fn shown(name: &str) -> String {
    if name.is_empty() { String::new() } else { format!(" ({name})") }
}

fn is_same_sky(own: &Wcs, other: &Wcs, [rows, columns]: [usize; 2]) -> bool {
    let (right, top) = (columns as f64 - 1.0, rows as f64 - 1.0);
    let corners = [(0.0, 0.0), (right, 0.0), (0.0, top), (right, top)].map(|(x, y)| PixelPosition { x, y });
    corners.into_iter().all(|corner| match (own.to_sky(corner), other.to_sky(corner)) {
        (Some(own_sky), Some(other_sky)) => {
            let apart_arcsec = own_sky.separation_rad(&other_sky).to_degrees() * 3600.0;
            apart_arcsec <= SAME_SKY_PIX * other.pixel_scale_arcsec(corner)
        }
        (None, None) => true,
        _ => false,
    })
}

/// Returns the main keywords of world coordinates as text.
fn coordinates(header: &Header) -> String {
    let keywords = ["CTYPE1", "CTYPE2", "CRVAL1", "CRVAL2", "CRPIX1", "CRPIX2", "CD1_1", "CD1_2", "CDELT1", "CDELT2"];
    keywords.iter().filter_map(|keyword| header.card(keyword)).map(|card| card.text()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_by_name() {
        for (name, kind) in [
            ("MASK", Some(PlaneKind::Mask)),
            ("MASK_S28", Some(PlaneKind::Mask)),
            ("DQ", Some(PlaneKind::Mask)),
            ("VAR", Some(PlaneKind::Variance)),
            ("VAR_POISSON", Some(PlaneKind::Other)),
            ("INVVAR", Some(PlaneKind::InverseVariance)),
            ("UNCERT", Some(PlaneKind::Error)),
            ("DATA_ERR", Some(PlaneKind::Error)),
            ("ERROR.CHIP1", Some(PlaneKind::Error)),
            ("3-4.F.RMS", Some(PlaneKind::Error)),
            ("REF_ERR", Some(PlaneKind::Other)),
            ("CHIPMASK", Some(PlaneKind::Other)),
            ("WHT", Some(PlaneKind::Weight)),
            ("S28", None),
            ("TERRA", None),
            ("SKY", None),
        ] {
            assert_eq!(kind_of(name), kind, "{name}");
        }
        assert_eq!((stem("SCI_2"), stem("SCI,2"), stem("IM1"), stem("S28")), ("SCI", "SCI", "IM", "S"));
    }

    #[test]
    fn forms_of_uncertainties() {
        for (cards, form) in [
            ("UTYPE   = 'VarianceUncertainty'\n", Some(PlaneKind::Variance)),
            ("UTYPE   = 'InverseVariance'\nBUNIT   = 'adu'\n", Some(PlaneKind::InverseVariance)),
            ("UTYPE   = 'StdDevUncertainty'\nBUNIT   = 'adu2'\n", Some(PlaneKind::Error)),
            ("UTYPE   = 'UnknownUncertainty'\n", Some(PlaneKind::Other)),
            ("HDUCLAS3= 'MSE'\n", Some(PlaneKind::Variance)),
            ("BUNIT   = 'adu2'\n", Some(PlaneKind::Variance)),
            ("BUNIT   = 'electron**2'\n", Some(PlaneKind::Variance)),
            ("BUNIT   = 'adu^-2'\n", Some(PlaneKind::InverseVariance)),
            ("BUNIT   = 'adu**(-2)'\n", Some(PlaneKind::InverseVariance)),
            ("BUNIT   = 'erg/s/cm2'\n", None),
            ("BUNIT   = 'adu'\n", None),
            ("", None),
        ] {
            assert_eq!(form_of_uncertainty(&Header::from_text(cards)), form, "{cards}");
        }
    }
}
