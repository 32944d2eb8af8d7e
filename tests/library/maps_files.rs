//! Map files: FITS files contain the values of the table in HEALPix cells, and pictures have the expected content.

use crate::common::maps::{options, v15};
#[cfg(all(feature = "fits", unix))]
use streakcast::maps::Grid;
use streakcast::maps::{BodyView, Earth, PAPER_FIGURES, SkyView};

#[cfg(all(feature = "fits", unix))]
#[test]
fn verif_fits_contains_the_table() {
    use fitsio::FitsFile;
    let model = v15();
    let view = SkyView::new(&model, Earth::Sphere, 550.0, 0.0, -0.3, options()).unwrap();
    let map = view.map(Grid::healpix(8).unwrap()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.fits");
    std::fs::write(&path, map.to_fits(folder.path()).unwrap()).unwrap();
    // The temporary folder was deleted.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let mut file = FitsFile::open(&path).unwrap();
    let hdu = file.hdu(1).unwrap();
    let text = |file: &mut FitsFile, key: &str| hdu.read_key::<String>(file, key).unwrap();
    assert_eq!(text(&mut file, "PIXTYPE"), "HEALPIX");
    assert_eq!(text(&mut file, "ORDERING"), "RING");
    assert_eq!(text(&mut file, "COORDSYS"), "HORIZON");
    assert_eq!(text(&mut file, "MODEL"), "brdf:starlink-v1.5");
    assert_eq!(hdu.read_key::<i64>(&mut file, "NSIDE").unwrap(), 8);
    assert!((hdu.read_key::<f64>(&mut file, "SUNALT").unwrap() + 0.3_f64.to_degrees()).abs() < 1e-6);
    let magnitudes: Vec<f64> = hdu.read_col(&mut file, "magnitude").unwrap();
    let ranges: Vec<f64> = hdu.read_col(&mut file, "range_km").unwrap();
    assert_eq!((magnitudes.len(), ranges.len()), (768, 768));
    for (cell, (magnitude, range)) in magnitudes.iter().zip(&ranges).enumerate() {
        let point = map.points.get(cell);
        assert_eq!(*magnitude, point.and_then(|point| point.magnitude).map_or(-1.6375e30, |magnitude| magnitude.0));
        assert_eq!(*range, point.map_or(-1.6375e30, |point| point.range_km));
    }
    let regular = view.map(Grid::regular(5.0).unwrap()).unwrap().to_fits(folder.path()).unwrap_err().to_string();
    assert!(regular.contains("nside"), "{regular}");
    // Brackets are part of the file name.
    let bracket = folder.path().join("a[b]");
    std::fs::create_dir(&bracket).unwrap();
    assert_eq!(map.to_fits(&bracket).unwrap(), std::fs::read(&path).unwrap());
}

/// Names in headers are transliterated to ASCII; shortened text is marked.
#[cfg(all(feature = "fits", unix))]
#[test]
fn verif_fits_headers_accept_names_of_any_language() {
    use fitsio::FitsFile;
    let model = v15();
    let folder = tempfile::tempdir().unwrap();
    let long = format!("O'Higgins {}", "x".repeat(80));
    let cut = format!("O'Higgins {}...", "x".repeat(54));
    for (name, card) in [("Côte d’Azur, Ondřejov", "Cote d'Azur, Ondrejov"), (&long, &cut)] {
        let site = streakcast::geometry::Site::new_deg(name, 43.7, 7.3, 650.0).unwrap();
        let view = SkyView::new(&model, Earth::Ellipsoid(site), 550.0, 0.0, -0.3, options()).unwrap();
        let path = folder.path().join("map.fits");
        std::fs::write(&path, view.map(Grid::healpix(2).unwrap()).unwrap().to_fits(folder.path()).unwrap()).unwrap();
        let mut file = FitsFile::open(&path).unwrap();
        let hdu = file.hdu(1).unwrap();
        assert_eq!(hdu.read_key::<String>(&mut file, "SITE").unwrap(), card);
    }
}

#[cfg(feature = "plot")]
mod pictures {
    use super::*;
    use streakcast::geometry::ShadowModel;
    use streakcast::photometry::{Earthshine, ModelLibrary, PhotometryOptions};
    use streakcast::plot::{Picture, PictureFormat, body_picture, paper_picture, sky_picture};

    /// Returns the pixels of a PNG.
    fn pixels(bytes: &[u8]) -> image::RgbImage {
        image::load_from_memory(bytes).unwrap().to_rgb8()
    }

    #[test]
    fn verif_a_sky_chart_shows_shadow_bright_cells_and_texts() {
        let model = v15();
        let view = SkyView::new(&model, Earth::Sphere, 550.0, 0.0, -16_f64.to_radians(), options()).unwrap();
        let picture = sky_picture(&view);
        let image = pixels(&picture.to_png().unwrap());
        let (width, height) = picture.size();
        assert_eq!((image.width() as usize, image.height() as usize), (width, height));
        // The centre of the disk follows from the layout: a margin of 66 and a radius of 270 on each side, 78 at the
        // top.
        let at = |azimuth: f64, altitude: f64| {
            let distance = 270.0 * (90.0 - altitude) / 90.0;
            let (sin, cos) = azimuth.to_radians().sin_cos();
            image.get_pixel((336.0 - distance * sin) as u32, (414.0 - distance * cos) as u32).0
        };
        for (azimuth, altitude) in [(12.0, 50.0), (150.0, 55.0), (70.0, 40.0), (300.0, 20.0)] {
            let magnitude = view.at(f64::to_radians(azimuth), f64::to_radians(altitude)).magnitude.unwrap().0;
            let expected = picture.scales()[0].colour(magnitude);
            let shown = at(azimuth, altitude);
            let apart = shown.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max().unwrap();
            assert!(apart <= 6, "{azimuth} {altitude}: {shown:?} for {expected:?}");
        }
        assert_eq!(at(180.0, 15.0), [150, 150, 150]);
        // Texts are dark pixels in the line of the title and at the colour bar.
        let dark = |left: u32, top: u32, right: u32, bottom: u32| {
            (left..right).flat_map(|x| (top..bottom).map(move |y| (x, y))).any(|(x, y)| image.get_pixel(x, y).0[0] < 90)
        };
        assert!(dark(100, 10, 700, 40) && dark(720, 200, 790, 700));
    }

    /// Returns all texts of a picture, joined.
    fn words(picture: &Picture) -> String {
        let text = String::from_utf8(picture.to_bytes(PictureFormat::Svg).unwrap()).unwrap();
        let lines = text.split('<').filter_map(|tag| Some(tag.split_once('>')?.1.trim()));
        lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
    }

    /// Unusual options of atmosphere and light are written below the map; default options are not.
    #[test]
    fn verif_a_chart_lists_unusual_options() {
        let model = v15();
        let notes = [" 0.2 mag per airmass.", "Sunlight only.", "Shadow of the Earth without its atmosphere."];
        let sky = |options: PhotometryOptions, shadow| {
            let view = SkyView::new(&model, Earth::Sphere, 550.0, 0.0, -0.3, options).unwrap().with_shadow(shadow);
            words(&sky_picture(&view))
        };
        let plain = sky(options(), ShadowModel::Atmosphere);
        assert!(notes.iter().all(|part| !plain.contains(part)));
        let other =
            PhotometryOptions { extinction_mag_per_airmass: Some(0.2), earthshine: Earthshine::Off, ..options() };
        let all = sky(other, ShadowModel::Geometric);
        assert!(notes.iter().all(|part| all.contains(part)), "{all}");
        let body = words(&body_picture(&BodyView::new(&model, -0.2, 550.0, other).unwrap()));
        assert!(body.contains(notes[1]) && !body.contains(notes[0]));
    }

    /// Magnitudes that are faint near the horizon because of extinction do not determine the colour scale.
    #[test]
    fn verif_extinction_does_not_change_the_colour_scale() {
        let model = ModelLibrary::embedded().get("oneweb").unwrap();
        let sky = |k: Option<f64>| {
            let options = PhotometryOptions { extinction_mag_per_airmass: k, ..options() };
            SkyView::new(&model, Earth::Sphere, 550.0, 0.0, 0.3, options).unwrap()
        };
        let (clear, air) = (sky(None), sky(Some(0.3)));
        let scale = sky_picture(&air).scales()[0];
        let at_10_deg = air.at(0.0, 10_f64.to_radians()).magnitude.unwrap().0;
        assert!(scale.greatest >= at_10_deg - 0.1 && scale.greatest < at_10_deg + 1.0, "{scale:?} {at_10_deg}");
        assert!(scale.has_higher && !scale.has_lower, "{scale:?}");
        // Without extinction, the whole sky is included: the range of a mean model is determined by the distances.
        let horizon = clear.at(0.0, 0.0).magnitude.unwrap().0;
        assert!(sky_picture(&clear).scales()[0].greatest >= horizon - 0.1);
        // The whole sky is lit and visible.
        let text = words(&sky_picture(&air));
        assert!(text.contains("≥ ") && !text.contains("not lit"));
        let image = pixels(&sky_picture(&air).to_png().unwrap());
        // Centre and radius of the disk are as above; the line of the edge is 1.6 wide.
        let shown = image.get_pixel(336 - 267, 414).0;
        assert_eq!(shown, scale.colour(30.0), "{shown:?}");
    }

    /// Magnitudes at 1000 km are compared with those for an observer directly below.
    #[test]
    fn verif_the_line_of_a_body_map_is_the_limit_at_its_height() {
        let model = v15();
        for (height_km, line) in [(550.0, "8.3 mag: 7 mag from straight below"), (1000.0, "7.0 mag: 7 mag from")] {
            let view = BodyView::new(&model, -0.2, height_km, options()).unwrap();
            let text = words(&body_picture(&view));
            assert!(text.contains(line), "{height_km}");
        }
        let sky = SkyView::new(&model, Earth::Sphere, 550.0, 0.0, -0.2, options()).unwrap();
        let text = words(&sky_picture(&sky));
        assert!(text.contains("7 mag") && !text.contains("straight below"));
    }

    #[test]
    fn verif_svg_is_complete_and_contains_the_texts() {
        let model = v15();
        let view = BodyView::new(&model, -14_f64.to_radians(), 550.0, options()).unwrap();
        let picture = body_picture(&view);
        let text = String::from_utf8(picture.to_bytes(PictureFormat::Svg).unwrap()).unwrap();
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
        for part in ["data:image/png;base64,iVBOR", "brdf:starlink-v1.5", "Sun at latitude −14°", "7 mag", "polyline"]
        {
            assert!(text.contains(part), "{part}");
        }
        // The SVG is well-formed: an XML reader reaches its end.
        let mut reader = quick_xml::Reader::from_str(&text);
        let mut elements = 0;
        loop {
            match reader.read_event().unwrap() {
                quick_xml::events::Event::Eof => break,
                quick_xml::events::Event::Empty(_) => elements += 1,
                _ => {}
            }
        }
        assert!(elements > 50, "{elements}");
    }

    #[test]
    fn verif_every_figure_of_the_paper_is_drawn() {
        let model = v15();
        let mut panels = 0;
        for figure in &PAPER_FIGURES {
            let picture = paper_picture(figure, &model, options()).unwrap();
            let image = pixels(&picture.to_png().unwrap());
            assert!(image.width() > 1500, "figure {}", figure.number);
            panels += figure.panels.len();
        }
        assert_eq!(panels, 12);
    }
}
