//! Headers and compressed tiles that could crash CFITSIO are rejected before it reads them, with a clear error.

use std::fs;
use std::path::{Path, PathBuf};

use streakcast::images::{FrameCopy, FrameFile, HduKind, ImageValues, NewImage, Pixels, Rice, write_frame};
use tempfile::TempDir;

use crate::common::mutated::Reader;

/// Returns the bytes of a compressed frame of 80 by 64 pixels with one row per tile: integers, or floats with noise.
fn compressed(folder: &TempDir, is_floating: bool) -> Vec<u8> {
    let mut random = crate::common::random::Random(3);
    let noise = (0..80 * 64).map(|_| 500.0 + 20.0 * random.uniform());
    let pixels = if is_floating {
        Pixels::F32(noise.map(|value| value as f32).collect())
    } else {
        Pixels::I32(noise.map(|value| value as i32).collect())
    };
    let values = ImageValues::new(80, pixels).expect("rows");
    let path = folder.path().join("good.fits.fz");
    write_frame(&path, &[NewImage { name: "", values: &values, cards: &[], rice: Some(Rice::default()) }])
        .expect("written");
    fs::read(path).expect("bytes")
}

/// Returns the byte offset of a card in the header of HDU 1.
fn card_at(file: &[u8], keyword: &str) -> usize {
    let start = format!("{keyword:<8}=");
    let place = file[2880..].chunks_exact(80).position(|card| card.starts_with(start.as_bytes()));
    2880 + 80 * place.unwrap_or_else(|| panic!("no {keyword}"))
}

/// Returns a copy of the file in which one card is replaced.
fn with_card(file: &[u8], keyword: &str, card: &str) -> Vec<u8> {
    let (mut bytes, at) = (file.to_vec(), card_at(file, keyword));
    bytes[at..at + 80].copy_from_slice(format!("{card:<80}").as_bytes());
    bytes
}

/// Opens a file, reads its images and adds light to them. Returns the first error.
fn used(path: &Path) -> Result<(), String> {
    let to_text = |error: streakcast::Error| error.to_string();
    let file = FrameFile::open(path).map_err(to_text)?;
    for hdu in file.images() {
        file.read_plane(hdu).map_err(to_text)?;
        let target = tempfile::tempdir().expect("a folder");
        let mut copy = FrameCopy::begin(&file, &target.path().join("out.fits")).map_err(to_text)?;
        copy.add(hdu, 0, 0, &[5.0]).map_err(to_text)?;
        copy.finish().map_err(to_text)?;
    }
    Ok(())
}

/// See tests/library/mutated_files.rs for the other readers.
#[test]
fn mutated_frames_are_read_or_rejected() {
    let folder = tempfile::tempdir().expect("a folder");
    let plain = folder.path().join("plain.fits");
    let values = ImageValues::new(20, Pixels::I16((0..20 * 10).collect())).expect("rows");
    write_frame(&plain, &[NewImage { name: "", values: &values, cards: &[], rice: None }]).expect("written");
    let seeds = vec![compressed(&folder, false), compressed(&folder, true), fs::read(&plain).expect("bytes")];
    let read = |bytes: &[u8]| {
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        fs::write(file.path(), bytes).expect("written");
        used(file.path())
    };
    Reader { name: "frames", seeds, read: Box::new(read) }.check();
}

fn refused(folder: &TempDir, bytes: &[u8]) -> String {
    let path: PathBuf = folder.path().join("hostile.fits.fz");
    fs::write(&path, bytes).expect("written");
    let error = used(&path).expect_err("refused");
    assert!(error.starts_with(&path.display().to_string()) && error.contains("HDU 1"), "{error}");
    error
}

#[test]
fn verif_headers_of_compressed_images_are_checked_before_they_are_read() {
    let folder = TempDir::new().expect("a folder");
    let [whole, floating] = [false, true].map(|is_floating| compressed(&folder, is_floating));
    used(&folder.path().join("good.fits.fz")).expect("a sound frame");
    for (keyword, card, expected) in [
        ("ZTILE2", "ZTILE2  =                  0.0", "ZTILE2 is 0.0; allowed: a whole number from 1 to 4096"),
        ("ZTILE2", "ZTILE2  =              1.0E-20", "ZTILE2 is 1.0E-20; allowed: a whole number from 1 to 4096"),
        ("ZTILE2", "ZTILE2  =               1E-308", "ZTILE2 is 1E-308"),
        ("ZTILE1", "ZTILE1  =                  -80", "ZTILE1 is -80"),
        ("ZTILE1", "ZTILE1  =           2000000000", "ZTILE1 is 2000000000; allowed: a whole number from 1 to 4096"),
        (
            "ZTILE1",
            "ZTILE1  =                   79",
            "NAXIS2 is 64; allowed: 128, the number of tiles of [79, 1] pixels",
        ),
        ("ZNAXIS1", "ZNAXIS1 =           2000000000", "NAXIS2 is 64; allowed: 1600000000, the number of tiles"),
        ("ZNAXIS1", "ZNAXIS1 =                    0", "ZNAXIS1 is 0; allowed: a whole number from 1 to 2147483647"),
        ("ZNAXIS", "ZNAXIS  =                   99", "ZNAXIS is 99; allowed: a whole number from 1 to 6"),
        ("ZBITPIX", "ZBITPIX =                   64", "ZBITPIX is 64; allowed: 8, 16, 32, -32 or -64"),
        ("ZCMPTYPE", "ZCMPTYPE= 'RICE_9  '", "ZCMPTYPE is \"RICE_9\"; allowed: RICE_1, RICE_ONE, GZIP_1"),
        ("ZVAL1", "ZVAL1   =                1E308", "ZVAL1 is 1E308; allowed: a whole number from 1 to 4096"),
        ("ZVAL2", "ZVAL2   = 'AAAAAAAAAAAAAAA'", "ZVAL2 is 'AAAAAAAAAAAAAAA'; allowed: 1, 2 or 4"),
        ("TFORM1", "TFORM1  = '1PZ(70) '", "TFORM1 is \"1PZ(70)\"; allowed: a form of a binary table"),
        ("TFORM1", "TFORM1  = '2PB(70) '", "NAXIS1 is 8; allowed: 16, the sum of the widths of the columns"),
        ("TTYPE1", "TTYPE1  = 'SOMETHING'", "TTYPEn is missing; allowed: a column COMPRESSED_DATA"),
        ("ZNAME1", "ZTILE2  =                    0", "ZTILE2 is given twice; allowed: once in the header"),
        ("GCOUNT", "GCOUNT  =                    2", "GCOUNT is 2; allowed: a whole number from 1 to 1"),
        ("ZCMPTYPE", "ZCMPTYPE= 'HCOMPRESS_1'", "of tile 1: the compressed stream does not match"),
        ("ZCMPTYPE", "ZCMPTYPE= 'PLIO_1  '", "of tile 1: the compressed stream does not match"),
    ] {
        let error = refused(&folder, &with_card(&whole, keyword, card));
        assert!(error.contains(expected), "{card}: {error}");
    }
    let error = refused(&folder, &with_card(&floating, "ZDITHER0", "ZDITHER0=                   -7"));
    assert!(error.contains("ZDITHER0 is -7; allowed: a whole number from 1 to 10000"), "{error}");
    // An image has more pixels than its compressed bytes can contain, with consistent header values.
    let mut large = whole.clone();
    for (keyword, card) in [("ZNAXIS1", "ZNAXIS1 =           1000000000"), ("ZTILE1", "ZTILE1  =           1000000000")]
    {
        large = with_card(&large, keyword, card);
    }
    assert!(refused(&folder, &large).contains("compressed bytes can contain"));
}

#[test]
fn verif_tiles_that_are_not_in_the_heap_are_refused() {
    let folder = TempDir::new().expect("a folder");
    let good = compressed(&folder, false);
    let file = FrameFile::open(&folder.path().join("good.fits.fz")).expect("a frame");
    assert_eq!(file.hdus()[1].kind, HduKind::CompressedImage("RICE_1".into()));
    let end = 2880 + 80 * good[2880..].chunks_exact(80).position(|card| card.starts_with(b"END     ")).expect("END");
    let table = end.next_multiple_of(2880);
    // Length and offset of the third tile are invalid.
    for (at, number) in [(16, 2_000_000_000u32), (20, 2_000_000_000), (16, u32::MAX)] {
        let mut bytes = good.clone();
        bytes[table + at..table + at + 4].copy_from_slice(&number.to_be_bytes());
        let error = refused(&folder, &bytes);
        assert!(error.contains("COMPRESSED_DATA of tile 3:") && error.contains("not in the heap"), "{error}");
    }
    // The compressed bytes are replaced: CFITSIO reports an error, or decodes some pixels.
    let mut bytes = good;
    let heap = table + 64 * 8;
    bytes[heap..].iter_mut().for_each(|byte| *byte = !*byte);
    let path = folder.path().join("noise.fits.fz");
    fs::write(&path, &bytes).expect("written");
    if let Err(error) = used(&path) {
        assert!(error.contains("CFITSIO"), "{error}");
    }
}

#[test]
fn verif_a_malformed_table_before_an_image_is_named() {
    let folder = TempDir::new().expect("a folder");
    let good = compressed(&folder, false);
    // Without ZIMAGE it is an ordinary table, which is not read. A table of invalid width precedes the next image.
    let table = with_card(&good, "ZIMAGE", "ZIMAGE  =                    F");
    let table = with_card(&table, "TFORM1", "TFORM1  = '9PB(70) '");
    let bytes = [&table[..], &good[2880..]].concat();
    let path = folder.path().join("table.fits");
    fs::write(&path, bytes).expect("written");
    let file = FrameFile::open(&path).expect("the headers");
    let error = file.read_plane(2).expect_err("refused").to_string();
    assert!(error.contains("HDU 1: NAXIS1 is 8; allowed: 72, the sum of the widths of the columns"), "{error}");
}

/// Single changed bytes for which CFITSIO divides by zero, corrupts memory, or allocates gigabytes.
#[test]
fn valid_the_folder_of_hostile_frames() {
    let Some(data) = crate::common::data_dir() else { return };
    let Ok(folder) = fs::read_dir(data.join("hostile")) else { return };
    let mut refused = 0;
    for entry in folder {
        let path = entry.expect("an entry").path();
        match used(&path) {
            Ok(()) => {}
            Err(error) => {
                assert!(error.starts_with(&path.display().to_string()), "{error}");
                refused += 1;
            }
        }
    }
    assert!(refused > 0);
}
