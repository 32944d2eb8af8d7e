//! Plots: texts and numbers, sizes, colours, and errors for invalid input.

mod fits;
mod layers;
mod observers;

use image::RgbImage;
use streakcast::plot::Picture;

/// Tolerance of colours, of 255: four pixels are averaged and rounded.
const COLOUR_STEPS: u8 = 2;

fn pixels(picture: &Picture) -> RgbImage {
    let image = image::load_from_memory(&picture.to_png().unwrap()).unwrap().to_rgb8();
    let (width, height) = picture.size();
    assert_eq!((image.width() as usize, image.height() as usize), (width, height));
    assert!(width <= 1600 && height <= 1600, "{width} {height}");
    image
}

/// Returns the texts of an SVG file, one per line. The file must be well-formed, and no text may be cut off at the
/// right edge. A character of the font is wider than half of the font size on average.
fn words(picture: &Picture) -> Vec<String> {
    let text = picture.to_svg().unwrap();
    let mut reader = quick_xml::Reader::from_str(&text);
    let (mut words, mut tag) = (Vec::new(), String::new());
    let attribute = |tag: &str, name: &str| {
        let value = tag.split(&format!(" {name}=\"")).nth(1)?;
        value.split('"').next().map(str::to_owned)
    };
    let number = |tag: &str, name: &str| attribute(tag, name).and_then(|value| value.parse::<f64>().ok());
    let view_box = attribute(&text, "viewBox").expect("a viewBox");
    let width: f64 = view_box.split(' ').nth(2).and_then(|width| width.parse().ok()).expect("a width");
    loop {
        match reader.read_event().unwrap() {
            quick_xml::events::Event::Eof => return words,
            quick_xml::events::Event::Start(start) => tag = start.to_string(),
            quick_xml::events::Event::Text(text) if !text.contains("@font-face") && !text.trim().is_empty() => {
                let text = text.trim().to_owned();
                if attribute(&tag, "text-anchor").as_deref() == Some("start") && !tag.contains("transform") {
                    let (x, size) = (number(&tag, "x").unwrap(), number(&tag, "font-size").unwrap());
                    let end = x + 0.5 * size * text.chars().count() as f64;
                    assert!(end <= width, "'{text}' is cut off: it ends at {end:.0} of {width:.0}");
                }
                words.push(text);
            }
            _ => {}
        }
    }
}

fn has(picture: &Picture, expected: &[&str]) {
    let words = words(picture);
    for one in expected {
        assert!(words.iter().any(|words| words == one), "{one} is not in {words:?}");
    }
}

fn close(a: [u8; 3], b: [u8; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= COLOUR_STEPS)
}

#[track_caller]
fn near(a: [u8; 3], b: [u8; 3]) {
    assert!(close(a, b), "{a:?} {b:?}");
}
