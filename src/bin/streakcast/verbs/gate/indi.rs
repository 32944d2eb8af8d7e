//! A client of INDI: asks a server where its mount points and stands. Plain XML over TCP, nothing is ever set.

use std::io::{self, BufReader, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use hifitime::Epoch;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use streakcast::frames::parse_instant;
use streakcast::frames::{Direction, Gcrs, OfDate, seconds_between};
use streakcast::geometry::{Site, icrs_of_apparent};

use super::clock::Clock;
use super::status::{Fault, FaultKind};

const PORT: u16 = 7624;
/// A server that says more than this before it says where the mount points is none, bytes.
const MOST_BYTES: usize = 16 << 20;
/// How long the place of the observatory, and a second mount, are waited for once a mount's pointing is known.
const GRACE: Duration = Duration::from_millis(700);
/// Clocks this far apart are told, seconds: INDI gives whole seconds, and networks have their moments.
const CLOCK_TOLERANCE_S: f64 = 3.0;

/// What a mount says of itself.
#[derive(Debug)]
pub struct Mount {
    pub device: String,
    /// Where it points.
    pub pointing: Direction<Gcrs>,
    /// Where it stands, where it says so.
    pub site: Option<Site>,
    /// The server's clock less ours, seconds, where it is wrong.
    pub clock_wrong_s: Option<f64>,
}

/// Asks a server, at most so long.
pub fn ask(address: &str, device: Option<&str>, timeout: Duration, clock: &Clock) -> Result<Mount, Fault> {
    let fault = |what: String| Fault::new(FaultKind::Indi, format!("INDI server {address}: {what}"));
    let deadline = Instant::now() + timeout;
    let mut stream = connect(address, timeout).map_err(|error| fault(error.to_string()))?;
    stream
        .set_write_timeout(Some(timeout))
        .and_then(|()| stream.write_all(b"<getProperties version=\"1.7\"/>\n"))
        .map_err(|error| fault(error.to_string()))?;
    let mut heard = Heard { wanted: device.map(str::to_owned), ..Heard::default() };
    let ended = heard.listen(Patient { stream, deadline, left: MOST_BYTES }, clock);
    heard.mount(clock).map_err(|what| match ended {
        Some(error) => fault(format!("{what} ({error})")),
        None => fault(what),
    })
}

fn connect(address: &str, timeout: Duration) -> io::Result<TcpStream> {
    let with_port = if address.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok()) {
        address.to_owned()
    } else {
        format!("{address}:{PORT}")
    };
    let mut last = io::Error::new(io::ErrorKind::NotFound, "no such host");
    for place in with_port.to_socket_addrs()? {
        match TcpStream::connect_timeout(&place, timeout) {
            Ok(stream) => return Ok(stream),
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// A stream that ends at a deadline, however slowly it trickles, and after so many bytes.
struct Patient {
    stream: TcpStream,
    deadline: Instant,
    left: usize,
}

impl Read for Patient {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let rest = self.deadline.saturating_duration_since(Instant::now());
        if rest.is_zero() {
            return Err(io::Error::new(io::ErrorKind::TimedOut, "no answer in time"));
        }
        if self.left == 0 {
            return Err(io::Error::other("it does not stop talking"));
        }
        self.stream.set_read_timeout(Some(rest))?;
        let read = self.stream.read(buffer).map_err(|error| match error.kind() {
            io::ErrorKind::WouldBlock => io::Error::new(io::ErrorKind::TimedOut, "no answer in time"),
            _ => error,
        })?;
        self.left = self.left.saturating_sub(read);
        Ok(read)
    }
}

/// One vector of numbers on its way.
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

/// What was heard so far.
#[derive(Debug, Default)]
struct Heard {
    wanted: Option<String>,
    devices: Vec<String>,
    pointings: Vec<Pointing>,
    /// Device, latitude, longitude, height: degrees and metres.
    sites: Vec<(String, f64, f64, f64)>,
    clock_wrong_s: Option<f64>,
}

impl Heard {
    /// Listens until all is known that is needed, the server stops, or the time is over; why it ended early.
    fn listen(&mut self, stream: Patient, clock: &Clock) -> Option<String> {
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
                Event::Eof => return Some("it closed the connection".to_owned()),
                _ => {}
            }
            if let Some(pointing) = self.settled() {
                let has_site = self.sites.iter().any(|(device, ..)| *device == pointing.device);
                if has_site && self.wanted.is_some() {
                    return None;
                }
                // Properties come in one breath: a site, or a second mount, that has not come soon will not come.
                let patient = reader.get_mut().get_mut();
                patient.deadline = patient.deadline.min(Instant::now() + GRACE);
            }
        }
    }

    fn take(&mut self, vector: &Vector, clock: &Clock) {
        if !self.devices.contains(&vector.device) {
            self.devices.push(vector.device.clone());
        }
        if self.wanted.as_ref().is_some_and(|wanted| *wanted != vector.device) {
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
            if let Some(theirs) = vector.timestamp.filter(|_| clock.is_real()) {
                // The stamp is cut to whole seconds: half a second is added on the average.
                let offset_s = seconds_between(clock.now(), theirs) + 0.5;
                self.clock_wrong_s = Some(offset_s).filter(|offset_s| offset_s.abs() > CLOCK_TOLERANCE_S);
            }
        }
        if vector.name == "GEOGRAPHIC_COORD"
            && let (Some(latitude), Some(longitude)) = (vector.number("LAT"), vector.number("LONG"))
        {
            self.sites.retain(|(device, ..)| *device != vector.device);
            self.sites.push((vector.device.clone(), latitude, longitude, vector.number("ELEV").unwrap_or(0.0)));
        }
    }

    /// The pointing of a mount that is not on its way to another.
    fn settled(&self) -> Option<&Pointing> {
        self.pointings.iter().find(|pointing| matches!(pointing.state.as_str(), "Idle" | "Ok" | ""))
    }

    fn mount(&self, clock: &Clock) -> Result<Mount, String> {
        let mut mounts: Vec<&str> = self.pointings.iter().map(|pointing| pointing.device.as_str()).collect();
        mounts.sort_unstable();
        mounts.dedup();
        if mounts.len() > 1 {
            return Err(format!("several mounts ({}); say which with --indi-device", mounts.join(", ")));
        }
        let Some(pointing) = self.settled() else {
            return Err(match (self.pointings.first(), &self.wanted) {
                (Some(moving), _) => format!("{} is {}, not at rest", moving.device, moving.state),
                (None, Some(wanted)) => format!("no coordinates of {wanted}; is it connected?"),
                (None, None) if self.devices.is_empty() => "no mount answers".to_owned(),
                (None, None) => format!("no mount among {}; is it connected?", self.devices.join(", ")),
            });
        };
        let (right_ascension_deg, declination_deg) = (15.0 * pointing.right_ascension_h, pointing.declination_deg);
        if !(-360.0..=720.0).contains(&right_ascension_deg) || !(-90.0..=90.0).contains(&declination_deg) {
            return Err(format!(
                "{} points at {} h, {declination_deg} deg",
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
        // A mount that was never told where it stands says 0, 0: no observatory is there.
        let site = site
            .filter(|(_, latitude, longitude, _)| *latitude != 0.0 || *longitude != 0.0)
            .map(|(device, latitude, longitude, height)| Site::new_deg(device, *latitude, *longitude, *height))
            .transpose()
            .map_err(|error| error.to_string())?;
        let device = pointing.device.clone();
        Ok(Mount { device, pointing: pointing_icrs, site, clock_wrong_s: self.clock_wrong_s })
    }
}

fn begin(element: &BytesStart<'_>) -> Vector {
    let text = |name: &str| attribute(element, name).unwrap_or_default();
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
    let found = element.attributes().with_checks(false).flatten().find(|one| one.key.as_ref() == name)?;
    Some(found.value.to_string())
}

/// A number as INDI writes it: `5.5`, `5:30`, `5 30 00`, `-0:30:00`.
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
