//! Time to copy a frame file with five added streaks, compared with a plain copy of the file; and time to compute pixel
//! positions of directions.
//!
//!     cargo bench --bench frame_files
//!
//! Rounds of the two kinds of copies are interleaved, because the speed of the machine varies; the ratio of the medians
//! is printed.

use std::fs;
use std::hint::black_box;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;
use streakcast::images::{FrameCopy, FrameFile, Header, NewImage, PixelPosition, Plane, Rice, Wcs, write_frame};
use streakcast::streaks::{Blur, RadialProfile, Seeing};
use streakcast::streaks::{PathNode, StreakPath, draw};

const SIDE: usize = 4096;
const ROUNDS: usize = 9;

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Angles between streaks and rows, radians. Streaks at the angles `ACROSS` touch nearly all rows, those at the angles
/// `ALONG` about a hundred.
const ACROSS: [f64; 5] = [0.3, 0.55, 0.8, 1.05, 1.3];
const ALONG: [f64; 5] = [-0.002, -0.001, 0.0, 0.001, 0.002];

/// Adds five streaks to the frame.
fn inject(source: &Path, target: &Path, hdu: usize, angles_rad: [f64; 5]) {
    let frame = FrameFile::open(source).expect("a frame");
    let mut copy = FrameCopy::begin(&frame, target).expect("a copy");
    let seeing = Seeing::Moffat { fwhm_pix: 3.5, beta: 3.5 };
    let profile = RadialProfile::new(&Blur::seeing(seeing)).expect("a profile");
    let patches: Vec<_> = angles_rad
        .into_par_iter()
        .map(|angle_rad| {
            let (sin, cos) = angle_rad.sin_cos();
            let node = |side: f64| {
                let at = PixelPosition { x: 2047.8 + side * 2000.0 * cos, y: 2047.4 + side * 2000.0 * sin };
                PathNode::new(0.5 + 0.5 * side, at, 4e6)
            };
            draw(&StreakPath::new(vec![node(-1.0), node(1.0)]).expect("a path"), &profile, SIDE, SIDE)
        })
        .collect();
    for span in patches.iter().flat_map(|patch| patch.iter()) {
        copy.add(hdu, span.row, span.first_column, span.values).expect("a change");
    }
    copy.add_history(hdu, "five streaks").expect("history");
    copy.finish().expect("finished");
}

fn timed(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e3
}

fn files(folder: &Path) {
    let values: Vec<f32> = (0..SIDE * SIDE).map(|n| 1000.0 + ((n * 7919) % 1013) as f32 * 0.1).collect();
    let plane = Plane::from_values(SIDE, SIDE, values).expect("a plane").into();
    let (plain, packed) = (folder.join("plain.fits"), folder.join("packed.fits"));
    let image = NewImage { name: "", values: &plane, cards: &[], rice: None };
    write_frame(&plain, &[image]).expect("written");
    println!(
        "RICE of {SIDE} x {SIDE} f32, made by CFITSIO: {:.0} ms",
        timed(|| write_frame(&packed, &[NewImage { rice: Some(Rice::default()), ..image }]).expect("written"))
    );
    let target = folder.join("out.fits");
    let (mut bare, mut with_streaks, mut few_rows, mut synced, mut replaced, mut read) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        bare.push(timed(|| {
            fs::copy(&plain, &target).expect("copied");
        }));
        fs::remove_file(&target).expect("removed");
        with_streaks.push(timed(|| inject(&plain, &target, 0, ACROSS)));
        fs::remove_file(&target).expect("removed");
        few_rows.push(timed(|| inject(&plain, &target, 0, ALONG)));
        // Replaces an existing file. The library flushes the new file to disk before it replaces the old one.
        synced.push(timed(|| {
            fs::copy(&plain, &target).expect("copied");
            fs::File::options().append(true).open(&target).expect("open").sync_all().expect("synced");
        }));
        replaced.push(timed(|| inject(&plain, &target, 0, ACROSS)));
        fs::remove_file(&target).expect("removed");
        read.push(timed(|| {
            drop(black_box(FrameFile::open(&plain).and_then(|file| file.read_plane(0)).expect("read")))
        }));
    }
    let [bare, with_streaks, few_rows, synced, replaced, read] =
        [bare, with_streaks, few_rows, synced, replaced, read].map(median);
    println!(
        "a new file: bare copy {bare:.0} ms, copy with five streaks {with_streaks:.0} ms: {:.2} of it",
        with_streaks / bare
    );
    println!("a new file: five streaks along the rows {few_rows:.0} ms: {:.2} of the bare copy", few_rows / bare);
    println!(
        "over an old file, brought to the disk: bare copy {synced:.0} ms, copy with five streaks {replaced:.0} ms: {:.2} of it",
        replaced / synced
    );
    println!("read into a plane {read:.0} ms");
    println!(
        "compressed copy with five streaks (4096 tiles packed again) {:.0} ms",
        timed(|| inject(&packed, &target, 1, ACROSS))
    );
}

/// Measures the time to compute pixel positions of directions, ns each.
fn places(name: &str, wcs: &Wcs) {
    let [columns, rows] = wcs.size();
    let directions: Vec<_> = (0..1000)
        .filter_map(|n| wcs.to_sky(PixelPosition { x: (n * 37 % columns) as f64, y: (n * 91 % rows) as f64 }))
        .collect();
    let rounds = 200;
    let to_pixel_ms = timed(|| {
        for _ in 0..rounds {
            for direction in &directions {
                black_box(wcs.to_pixel(*direction));
            }
        }
    });
    let to_sky_ms = timed(|| {
        for n in 0..rounds * directions.len() {
            black_box(wcs.to_sky(PixelPosition { x: (n % columns) as f64, y: (n % rows) as f64 }));
        }
    });
    let each = 1e6 / (rounds * directions.len()) as f64;
    println!("{name}: to pixel {:.0} ns, to sky {:.0} ns", to_pixel_ms * each, to_sky_ms * each);
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    files(folder.path());
    let headers = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/wcs");
    for name in [
        "tan-fk5.hdr",
        "sip-no-suffix-no-inverse.hdr",
        "tpv-radial-dec-first.hdr",
        "tnx-chebyshev.hdr",
        "car-lonpole.hdr",
        "zpn.hdr",
    ] {
        let header = Header::from_text(&fs::read_to_string(headers.join(name)).expect("a header"));
        places(name, &Wcs::from_header(&header).expect("a frame"));
    }
    let _ = std::io::stdout().flush();
}
