//! INDI client that reads pointing and site of a mount from a server (XML over TCP). It does not set any property.

use std::fmt;
use std::io::{self, BufReader, Read, Write};
use std::net::{Ipv6Addr, TcpStream, ToSocketAddrs};
use std::str::FromStr;
use std::time::{Duration, Instant};

use hifitime::Epoch;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use streakcast::frames::parse_instant;
use streakcast::frames::{Direction, Gcrs, OfDate, seconds_between};
use streakcast::geometry::{Site, icrs_of_apparent};

use super::clock::Clock;
use super::deadline::left;
use super::status_file::{Fault, FaultKind, clipped};

const PORT: u16 = 7624;
/// Largest number of addresses of a server that are tried.
const MOST_ADDRESSES: usize = 8;
/// Shortest timeout of the system's calls, which do not accept 0.
const SHORTEST: Duration = Duration::from_millis(1);
/// Longest name of a device, and largest number of names in a message.
const LONGEST_NAME: usize = 60;
const NAMED: usize = 8;
/// Largest number of bytes read from a server.
const MAX_BYTES: usize = 16 << 20;
/// Time to wait, after the pointing of a mount has arrived, for its site and for a second mount.
const GRACE: Duration = Duration::from_millis(700);
/// Difference between the clocks above which a fault is reported, seconds. INDI time stamps have whole seconds.
const CLOCK_TOLERANCE_S: f64 = 3.0;

/// Pointing and site of a mount.
#[derive(Debug)]
pub struct Mount {
    pub device: String,
    pub pointing: Direction<Gcrs>,
    /// Site, if the mount reports it.
    pub site: Option<Site>,
    /// Clock of the server minus that of this machine, seconds; `None` if it is within the tolerance.
    pub clock_error_s: Option<f64>,
}

/// Reads pointing and site of a mount from a server within `timeout`.
pub fn read_mount(address: &Address, device: Option<&str>, timeout: Duration, clock: &Clock) -> Result<Mount, Fault> {
    let fault = |what: String| Fault::new(FaultKind::Indi, format!("INDI server {address}: {what}"));
    let deadline = Instant::now() + timeout;
    let mut stream = connect(address, deadline).map_err(|error| fault(error.to_string()))?;
    stream
        .set_write_timeout(Some(left(deadline, timeout).max(SHORTEST)))
        .and_then(|()| stream.write_all(b"<getProperties version=\"1.7\"/>\n"))
        .map_err(|error| fault(error.to_string()))?;
    let mut properties =
        Properties { requested_device: device.map(|name| clipped(name, LONGEST_NAME)), ..Properties::default() };
    let ended = properties.read(LimitedStream { stream, deadline, left: MAX_BYTES }, clock);
    properties.mount(clock).map_err(|what| match ended {
        Some(error) => fault(format!("{what} ({error})")),
        None => fault(what),
    })
}

/// Host and port of a server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    host: String,
    port: u16,
}

impl FromStr for Address {
    type Err = String;

    /// Parses `HOST` or `HOST:PORT`; an IPv6 address with a port is in brackets.
    fn from_str(text: &str) -> Result<Self, String> {
        let (host, port) = match text.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
            Some((host, port)) => (host, port),
            None if text.parse::<Ipv6Addr>().is_ok() => (text, ""),
            None => text.split_at(text.find(':').unwrap_or(text.len())),
        };
        let port = match port.strip_prefix(':') {
            None if port.is_empty() => Some(PORT),
            digits => digits.and_then(|digits| digits.parse().ok()).filter(|&port| port > 0),
        };
        match port {
            Some(port) if !host.is_empty() && !host.contains(|c: char| c.is_whitespace() || c == '/') => {
                Ok(Self { host: host.to_owned(), port })
            }
            _ => Err("allowed: HOST or HOST:PORT with a port from 1 to 65535, for example 10.0.0.2:7624".to_owned()),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { host, port } = self;
        if host.contains(':') { write!(formatter, "[{host}]:{port}") } else { write!(formatter, "{host}:{port}") }
    }
}

/// Connects to a server. If its name has several addresses, each has an equal share of the time that is left.
fn connect(address: &Address, deadline: Instant) -> io::Result<TcpStream> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, "no such host");
    let sockets: Vec<_> = (address.host.as_str(), address.port).to_socket_addrs()?.take(MOST_ADDRESSES).collect();
    for (index, socket) in sockets.iter().enumerate() {
        let share = left(deadline, Duration::MAX) / (sockets.len() - index) as u32;
        match TcpStream::connect_timeout(socket, share.max(SHORTEST)) {
            Ok(stream) => return Ok(stream),
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Stream with a deadline and a limit on the number of bytes.
struct LimitedStream {
    stream: TcpStream,
    deadline: Instant,
    left: usize,
}

impl Read for LimitedStream {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let rest = self.deadline.saturating_duration_since(Instant::now());
        if rest.is_zero() {
            return Err(io::Error::new(io::ErrorKind::TimedOut, "no response in time"));
        }
        if self.left == 0 {
            return Err(io::Error::other("response too long"));
        }
        self.stream.set_read_timeout(Some(rest))?;
        let read = self.stream.read(buffer).map_err(|error| match error.kind() {
            io::ErrorKind::WouldBlock => io::Error::new(io::ErrorKind::TimedOut, "no response in time"),
            _ => error,
        })?;
        self.left = self.left.saturating_sub(read);
        Ok(read)
    }
}

/// INDI number vector; its values are added while the XML is read.
#[derive(Debug, Default)]
struct Vector {
    device: String,
    name: String,
    state: String,
    timestamp: Option<Epoch>,
    numbers: Vec<(String, f64)>,
}

impl Vector {
    fn number(&self, name: &str) -> Option<f64> {
        self.numbers.iter().find(|(known, _)| known == name).map(|(_, number)| *number)
    }
}

#[derive(Debug)]
struct Pointing {
    device: String,
    of_date: bool,
    state: String,
    right_ascension_h: f64,
    declination_deg: f64,
}

/// Properties received so far.
#[derive(Debug, Default)]
struct Properties {
    requested_device: Option<String>,
    devices: Vec<String>,
    pointings: Vec<Pointing>,
    /// Device, latitude and longitude in degrees, height in metres.
    sites: Vec<(String, f64, f64, f64)>,
    clock_error_s: Option<f64>,
}

impl Properties {
    /// Reads until all required properties have arrived. If the stream ends earlier, the reason is returned.
    fn read(&mut self, stream: LimitedStream, clock: &Clock) -> Option<String> {
        let mut reader = Reader::from_reader(BufReader::new(stream));
        let (mut vector, mut item, mut text) = (None::<Vector>, None::<String>, String::new());
        let mut buffer = Vec::new();
        loop {
            buffer.clear();
            let event = match reader.read_event_into(&mut buffer) {
                Ok(event) => event,
                Err(error) => return Some(error.to_string()),
            };
            match event {
                Event::Start(element) => match element.name().as_ref() {
                    "defNumberVector" | "setNumberVector" => vector = Some(begin(&element)),
                    "defNumber" | "oneNumber" => {
                        item = attribute(&element, "name");
                        text.clear();
                    }
                    _ => {}
                },
                Event::Text(piece) => text.push_str(&piece),
                Event::End(element) => match element.name().as_ref() {
                    "defNumber" | "oneNumber" => {
                        if let (Some(vector), Some(name), Some(number)) = (&mut vector, item.take(), sexagesimal(&text))
                        {
                            vector.numbers.push((name, number));
                        }
                    }
                    "defNumberVector" | "setNumberVector" => {
                        if let Some(vector) = vector.take() {
                            self.take(&vector, clock);
                        }
                    }
                    _ => {}
                },
                Event::Eof => return Some("connection closed by the server".to_owned()),
                _ => {}
            }
            if let Some(pointing) = self.settled() {
                let has_site = self.sites.iter().any(|(device, ..)| *device == pointing.device);
                if has_site && self.requested_device.is_some() {
                    return None;
                }
                // Servers send all properties at once: a site or a second mount arrives soon after the pointing, or not
                // at all.
                let limited = reader.get_mut().get_mut();
                limited.deadline = limited.deadline.min(Instant::now() + GRACE);
            }
        }
    }

    fn take(&mut self, vector: &Vector, clock: &Clock) {
        if !self.devices.contains(&vector.device) {
            self.devices.push(vector.device.clone());
        }
        if self.requested_device.as_ref().is_some_and(|device| *device != vector.device) {
            return;
        }
        let of_date = vector.name == "EQUATORIAL_EOD_COORD";
        if of_date || vector.name == "EQUATORIAL_COORD" {
            if let (Some(right_ascension_h), Some(declination_deg)) = (vector.number("RA"), vector.number("DEC")) {
                self.pointings.retain(|known| known.device != vector.device || known.of_date != of_date);
                self.pointings.push(Pointing {
                    device: vector.device.clone(),
                    of_date,
                    state: vector.state.clone(),
                    right_ascension_h,
                    declination_deg,
                });
            }
            if let Some(server_time) = vector.timestamp.filter(|_| clock.is_real()) {
                // Time stamps are truncated to whole seconds, by 0.5 s on average.
                let offset_s = seconds_between(clock.now(), server_time) + 0.5;
                self.clock_error_s = Some(offset_s).filter(|offset_s| offset_s.abs() > CLOCK_TOLERANCE_S);
            }
        }
        if vector.name == "GEOGRAPHIC_COORD"
            && let (Some(latitude), Some(longitude)) = (vector.number("LAT"), vector.number("LONG"))
        {
            self.sites.retain(|(device, ..)| *device != vector.device);
            self.sites.push((vector.device.clone(), latitude, longitude, vector.number("ELEV").unwrap_or(0.0)));
        }
    }

    /// Returns the pointing of a mount that is not slewing; `None` if it is slewing or unknown.
    fn settled(&self) -> Option<&Pointing> {
        self.pointings.iter().find(|pointing| matches!(pointing.state.as_str(), "Idle" | "Ok" | ""))
    }

    fn mount(&self, clock: &Clock) -> Result<Mount, String> {
        let mut mounts: Vec<&str> = self.pointings.iter().map(|pointing| pointing.device.as_str()).collect();
        mounts.sort_unstable();
        mounts.dedup();
        if mounts.len() > 1 {
            return Err(format!("several mounts ({}); specify one with --indi-device", first_of(&mounts)));
        }
        let Some(pointing) = self.settled() else {
            return Err(match (self.pointings.first(), &self.requested_device) {
                (Some(moving), _) => format!("{} is {}; allowed: a mount at rest", moving.device, moving.state),
                (None, Some(device)) => format!("no coordinates of {device}; check its connection"),
                (None, None) if self.devices.is_empty() => "no mount".to_owned(),
                (None, None) => format!("no mount among {}; check its connection", first_of(&self.devices)),
            });
        };
        let (right_ascension_deg, declination_deg) = (15.0 * pointing.right_ascension_h, pointing.declination_deg);
        if !(-360.0..=720.0).contains(&right_ascension_deg) || !(-90.0..=90.0).contains(&declination_deg) {
            return Err(format!(
                "invalid pointing of {}: {} h, {declination_deg} deg",
                pointing.device, pointing.right_ascension_h
            ));
        }
        let (longitude_rad, latitude_rad) = (right_ascension_deg.to_radians(), declination_deg.to_radians());
        let pointing_icrs = if pointing.of_date {
            icrs_of_apparent(&Direction::<OfDate>::from_lon_lat_rad(longitude_rad, latitude_rad), clock.now())
        } else {
            // J2000 and ICRS differ by 0.02".
            Direction::<Gcrs>::from_lon_lat_rad(longitude_rad, latitude_rad)
        };
        let site = self.sites.iter().find(|(device, ..)| *device == pointing.device);
        // A mount without a configured site reports latitude 0 and longitude 0.
        let site = site
            .filter(|(_, latitude, longitude, _)| *latitude != 0.0 || *longitude != 0.0)
            .map(|(device, latitude, longitude, height)| Site::new_deg(device, *latitude, *longitude, *height))
            .transpose()
            .map_err(|error| error.to_string())?;
        let device = pointing.device.clone();
        Ok(Mount { device, pointing: pointing_icrs, site, clock_error_s: self.clock_error_s })
    }
}

/// Returns the first names of a list, separated by commas.
fn first_of(names: &[impl AsRef<str>]) -> String {
    let shown: Vec<&str> = names.iter().take(NAMED).map(AsRef::as_ref).collect();
    let more = names.len().saturating_sub(NAMED);
    if more > 0 { format!("{} and {more} more", shown.join(", ")) } else { shown.join(", ") }
}

fn begin(element: &BytesStart<'_>) -> Vector {
    let text = |name: &str| clipped(&attribute(element, name).unwrap_or_default(), LONGEST_NAME);
    let stamp = text("timestamp");
    Vector {
        device: text("device"),
        name: text("name"),
        state: text("state"),
        timestamp: parse_instant(&format!("{}Z", stamp.trim_end_matches('Z')), None).ok(),
        numbers: Vec::new(),
    }
}

fn attribute(element: &BytesStart<'_>, name: &str) -> Option<String> {
    let found = element.attributes().with_checks(false).flatten().find(|attribute| attribute.key.as_ref() == name)?;
    Some(found.value.to_string())
}

/// Parses a number in the formats of INDI: `5.5`, `5:30`, `5 30 00`, `-0:30:00`.
fn sexagesimal(text: &str) -> Option<f64> {
    let text = text.trim();
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1.0, digits),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let mut parts = digits.split(|c: char| c == ':' || c == ';' || c.is_whitespace()).filter(|part| !part.is_empty());
    let mut value: f64 = parts.next()?.parse().ok()?;
    for unit in [60.0, 3600.0] {
        if let Some(part) = parts.next() {
            value += part.parse::<f64>().ok()? / unit;
        }
    }
    (parts.next().is_none() && value.is_finite()).then_some(sign * value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_of_servers() {
        for (text, address) in [
            ("localhost", "localhost:7624"),
            ("10.0.0.2:80", "10.0.0.2:80"),
            ("::1", "[::1]:7624"),
            ("[fe80::1]", "[fe80::1]:7624"),
            ("[::1]:65535", "[::1]:65535"),
        ] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), address);
        }
        for text in [
            "",
            ":7624",
            "localhost:",
            "localhost:0",
            "localhost:65536",
            "localhost:x",
            "a b",
            "http://a",
            "[::1]7",
            "a:1:2",
        ] {
            assert!(text.parse::<Address>().is_err(), "{text}");
        }
    }

    #[test]
    fn numbers_as_indi_writes_them() {
        for (text, number) in [("\n 5.5\n", 5.5), ("5:30:00", 5.5), ("-0:30", -0.5), ("5 30 36", 5.51), ("+1e1", 10.0)]
        {
            assert!((sexagesimal(text).unwrap() - number).abs() < 1e-12, "{text}");
        }
        for text in ["", "x", "1:2:3:4", "nan", "5:x"] {
            assert_eq!(sexagesimal(text), None, "{text}");
        }
    }
}
