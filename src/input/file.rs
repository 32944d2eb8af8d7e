//! Input files: only regular files of bounded size are read, so that no input blocks a run or exhausts the memory.

use std::fs::{self, File, FileType};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use serde_json::error::Category;

use crate::error::Error;

/// Largest number of bytes that are read from a file, or decompressed from one: 2 GB, above any catalogue or schedule.
/// Files are read into memory as a whole.
pub const LARGEST_INPUT: u64 = 2_000_000_000;

/// Opens a regular file, or an open stream of the process (see [`is_stream`]). Other code does not open input files
/// (`tests/imports.rs`).
///
/// # Errors
/// The file is a pipe, device, socket or directory, or the system reports an error.
pub fn open(path: &Path) -> io::Result<File> {
    if is_stream(path) {
        return File::open(path);
    }
    // The type is checked before, because opening a device can have an effect, and after, because another file can have
    // taken the name.
    check_regular(path)?;
    let mut options = File::options();
    // Opening does not wait for the writer of a pipe.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, rustix::fs::OFlags::NONBLOCK.bits() as i32);
    let file = options.read(true).open(path)?;
    check_kind(file.metadata()?.file_type())?;
    Ok(file)
}

/// Reads a file of at most [`LARGEST_INPUT`] bytes.
///
/// # Errors
/// The errors of [`open`], and a file that is too large.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    check_size(&file)?;
    read_at_most(file, LARGEST_INPUT)
}

/// Reads a text file in UTF-8 of at most [`LARGEST_INPUT`] bytes, without its byte order mark.
///
/// # Errors
/// The errors of [`read`], and invalid UTF-8, with its line.
pub fn read_to_string(path: &Path) -> io::Result<String> {
    text_of(read(path)?).map(without_mark)
}

/// Returns a text without the byte order mark with which some programs begin it.
pub fn without_mark(text: String) -> String {
    text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text)
}

/// Returns the text of a file.
///
/// # Errors
/// Invalid UTF-8, with its line.
pub fn text_of(bytes: Vec<u8>) -> io::Result<String> {
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..valid].iter().filter(|&&byte| byte == b'\n').count();
        invalid(format!(
            "invalid UTF-8 in line {line} (byte {valid}); convert a Latin-1 file with iconv -f LATIN1 -t UTF-8"
        ))
    })
}

pub(super) fn invalid(what: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, what)
}

/// Reads all bytes of a reader, for example of a decoder, if they are at most `limit`.
///
/// # Errors
/// [`ErrorKind::FileTooLarge`] above the limit, and the errors of the reader.
pub fn read_at_most(reader: impl Read, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit { Err(too_large(limit)) } else { Ok(bytes) }
}

/// Checks the size of a regular file before any of it is read.
///
/// # Errors
/// More than [`LARGEST_INPUT`] bytes, or the system reports an error.
pub fn check_size(file: &File) -> io::Result<()> {
    if file.metadata()?.len() > LARGEST_INPUT { Err(too_large(LARGEST_INPUT)) } else { Ok(()) }
}

/// Returns true for the names of streams that the process has open: standard input, and the descriptors that shells
/// give as `<(command)`. Reading them can take as long as their writer takes.
pub fn is_stream(path: &Path) -> bool {
    path == Path::new("/dev/stdin") || path.starts_with("/dev/fd") || path.starts_with("/proc/self/fd")
}

/// Checks that a path is a regular file, without opening it: opening a named pipe waits for its writer.
///
/// # Errors
/// A pipe, device, socket or directory, or the system reports an error.
pub fn check_regular(path: &Path) -> io::Result<()> {
    let file = fs::metadata(path).map_err(|error| if is_address(path) { address() } else { error })?;
    check_kind(file.file_type())
}

/// Returns true for addresses of the web, which nothing in the library reads.
fn is_address(path: &Path) -> bool {
    let scheme = path.to_str().and_then(|text| text.split_once("://")).map(|(scheme, _)| scheme.to_ascii_lowercase());
    scheme.is_some_and(|scheme| ["http", "https", "ftp"].contains(&scheme.as_str()))
}

fn address() -> io::Error {
    let why = "is a web address; allowed: a file on this machine (streakcast fetch downloads element sets)";
    io::Error::new(ErrorKind::NotFound, why)
}

fn check_kind(kind: FileType) -> io::Result<()> {
    if kind.is_file() {
        return Ok(());
    }
    let error = if kind.is_dir() { ErrorKind::IsADirectory } else { ErrorKind::InvalidInput };
    Err(io::Error::new(error, format!("is a {}; allowed: a file", kind_name(kind))))
}

#[cfg(unix)]
fn kind_name(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    if kind.is_dir() {
        "directory"
    } else if kind.is_fifo() {
        "named pipe"
    } else if kind.is_socket() {
        "socket"
    } else {
        "device"
    }
}

#[cfg(not(unix))]
fn kind_name(kind: FileType) -> &'static str {
    if kind.is_dir() { "directory" } else { "device" }
}

fn too_large(limit: u64) -> io::Error {
    io::Error::new(ErrorKind::FileTooLarge, format!("more than {limit} bytes; allowed: at most {limit}"))
}

/// Returns the error of a parser of TOML with the number of the line in the text.
pub fn toml_error(error: &toml::de::Error, text: &str) -> Error {
    let what = in_words(&error.message().split_whitespace().collect::<Vec<_>>().join(" "));
    match error.span() {
        Some(span) => {
            let number = text.get(..span.start.min(text.len())).map_or(1, |before| before.matches('\n').count() + 1);
            let line = text.lines().nth(number - 1).unwrap_or_default();
            let hint = match what.as_str() {
                "duplicate key" => format!(" '{}'; allowed: once", line.split('=').next().unwrap_or_default().trim()),
                _ => decimal_comma(line),
            };
            Error::format(what + &hint).on_line(number)
        }
        None => Error::format(what),
    }
}

/// Returns the error of a parser of JSON with the number of the line in the text.
pub fn json_error(error: &serde_json::Error) -> Error {
    let sentence = json_value_error(error);
    // Without a text, as for a value that is read already, the line is 0.
    if error.line() > 0 { sentence.on_line(error.line()) } else { sentence }
}

/// Returns the error of a parser of JSON without its place, for a text that was generated.
pub fn json_value_error(error: &serde_json::Error) -> Error {
    let text = error.to_string();
    let what = text.rsplit_once(" at line ").map_or(&*text, |(what, _)| what);
    Error::format(match error.classify() {
        Category::Data => in_words(what),
        Category::Eof => "the text ends before the end of the JSON document; allowed: a complete document".to_owned(),
        Category::Syntax | Category::Io => {
            let allowed = "JSON: texts in double quotes, numbers, true, false, null, arrays and objects";
            format!("column {}: {what}; allowed: {allowed}", error.column())
        }
    })
}

/// Returns the message of a parser of TOML or JSON as an error of this crate, which states what is given and allowed.
fn in_words(message: &str) -> String {
    let Some((what, expected)) = message.rsplit_once(", expected ") else {
        return message.replace("missing field", "missing key").replace('`', "'");
    };
    let given = what.strip_prefix("invalid type: ").or_else(|| what.strip_prefix("invalid value: "));
    let what = match given {
        Some("map") => "invalid value, a table of keys".to_owned(),
        Some("sequence") => "invalid value, a list".to_owned(),
        // The value is in quotes after its type.
        Some(given) => format!("invalid value {}", given.find(['"', '`']).map_or(given, |start| &given[start..])),
        None if what.contains("must be quoted") => "invalid value".to_owned(),
        None => what.replace("unknown field", "unknown key").replace("unknown variant", "unknown value"),
    };
    let is_integer =
        |name: &str| name.strip_prefix(['u', 'i']).is_some_and(|end| end == "size" || end.parse::<u8>().is_ok());
    let allowed = match expected {
        "f64" | "f32" => "a number",
        "a string" => "a text in quotes",
        // The value has no form of TOML.
        "literal string" => "a text in quotes, a number, true, false, or a date",
        "a TOML datetime" => "a date without quotes, such as 2026-01-01",
        "a boolean" => "true, false",
        "a sequence" => "a list",
        "a map" => "a table of keys",
        table if table.starts_with("struct ") => "a table of keys",
        integer if is_integer(integer) => "a whole number",
        others => others.strip_prefix("one of ").unwrap_or(others),
    };
    format!("{}; allowed: {}", what.replace('`', "'"), allowed.replace('`', ""))
}

/// Returns a hint if the value in a line of TOML is a number with a decimal comma.
fn decimal_comma(line: &str) -> String {
    let value = line.split_once('=').map_or("", |(_, value)| value.split('#').next().unwrap_or_default().trim());
    let with_point = value.replacen(',', ".", 1);
    let is_decimal = value != with_point && with_point.parse::<f64>().is_ok();
    if is_decimal { format!("; allowed: a decimal point in place of the comma ({with_point})") } else { String::new() }
}

/// Returns the line of a key in a TOML text, from 1; `path` are the names of its tables and its own name, in which
/// hyphens and underscores are equivalent. `None` if the text lacks the key.
pub fn toml_line(text: &str, path: &[&str]) -> Option<usize> {
    let document = toml::de::DeTable::parse(text).ok()?;
    let (last, tables) = path.split_last()?;
    let find = |table: &toml::de::DeTable<'_>, name: &str| {
        table.iter().position(|(key, _)| key.get_ref().replace('-', "_") == name.replace('-', "_"))
    };
    let mut table = document.get_ref();
    for name in tables {
        table = table.iter().nth(find(table, name)?)?.1.get_ref().as_table()?;
    }
    let (key, _) = table.iter().nth(find(table, last)?)?;
    Some(text.get(..key.span().start)?.matches('\n').count() + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_their_lines() {
        let text = "lat = 3\n\n[plot.night]\nfov = '1deg'\ntime-zone = 'UTC'\n";
        let line = |path: &[&str]| toml_line(text, path);
        assert_eq!([line(&["lat"]), line(&["plot", "night", "time_zone"])], [Some(1), Some(5)]);
        assert_eq!([line(&["lon"]), line(&["lat", "x"])], [None, None]);
    }

    #[test]
    fn decimal_commas_are_named() {
        let error = |text: &str| toml_error(&toml::from_str::<toml::Table>(text).unwrap_err(), text).to_string();
        for text in ["a = 1\nlat = 47,37\n", "a = 1\nlat = 47,37 # Zurich"] {
            let error = error(text);
            assert!(error.starts_with("line 2: ") && error.ends_with("in place of the comma (47.37)"), "{error}");
        }
        assert!(error("[forecast]\nmax-mag = -1,5").ends_with("(-1.5)"));
        for text in ["a = 1, 2", "a = b,c"] {
            assert!(!error(text).contains("decimal point"), "{}", error(text));
        }
    }

    #[test]
    fn messages_state_what_is_allowed() {
        for (message, expected) in [
            ("invalid type: string \"x\", expected f64", "invalid value \"x\"; allowed: a number"),
            ("invalid value: integer `-1`, expected usize", "invalid value '-1'; allowed: a whole number"),
            ("invalid type: map, expected a string", "invalid value, a table of keys; allowed: a text in quotes"),
            (
                "invalid type: string \"x\", expected a TOML datetime",
                "invalid value \"x\"; allowed: a date without quotes, such as 2026-01-01",
            ),
            ("unknown field `a`, expected one of `b`, `c`", "unknown key 'a'; allowed: b, c"),
            ("unknown variant `a`, expected `b` or `c`", "unknown value 'a'; allowed: b or c"),
            ("missing field `a`", "missing key 'a'"),
        ] {
            assert_eq!(in_words(message), expected);
        }
        let error = |text: &str| toml_error(&toml::from_str::<toml::Table>(text).unwrap_err(), text).to_string();
        assert_eq!(error("a = 1\nb = 2\na = 3"), "line 3: duplicate key 'a'; allowed: once");
        assert!(
            error("a = x").ends_with("allowed: a text in quotes, a number, true, false, or a date"),
            "{}",
            error("a = x")
        );
    }

    #[test]
    fn text_in_other_encodings_has_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        fs::write(&path, b"a,b\n1,2\nM\xfcnchen,3\n").unwrap();
        let error = read_to_string(&path).unwrap_err().to_string();
        assert!(error.starts_with("invalid UTF-8 in line 3 (byte 9); convert"), "{error}");
    }

    #[test]
    fn texts_have_no_byte_order_mark() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        for (bytes, text) in [("\u{feff}a,b", "a,b"), ("a\u{feff}", "a\u{feff}"), ("", "")] {
            fs::write(&path, bytes).unwrap();
            assert_eq!(read_to_string(&path).unwrap(), text);
        }
    }

    #[test]
    fn verif_endless_readers_are_cut_off() {
        assert_eq!(read_at_most(io::repeat(0).take(1000), 1000).unwrap().len(), 1000);
        let error = read_at_most(io::repeat(0), 1000).unwrap_err();
        assert_eq!(error.to_string(), "more than 1000 bytes; allowed: at most 1000");
    }
}
