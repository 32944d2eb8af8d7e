//! Requests to a source, and the account for them. A request is sent once.

use std::io::ErrorKind;
use std::path::Path;
use std::time::Duration;

use anyhow::anyhow;
use ureq::http::Response;
use ureq::{Agent, Body, Timeout};

use super::arguments::SpaceTrackArguments;
use super::sources::{Login, Wanted};
use super::verify::first_words;
use crate::notices::Notices;

/// What a refusal says is read this far, bytes.
const REFUSAL_BYTES: u64 = 2_000;
/// A connection stands after this time, or there is none.
const LONGEST_CONNECT: Duration = Duration::from_secs(30);

/// How the question is put.
pub struct Manner {
    pub timeout: Duration,
    pub max_bytes: u64,
    /// Addresses without TLS are taken: for tests alone.
    pub plain: bool,
}

/// What the cached file came with.
#[derive(Default)]
pub struct Known {
    pub etag: Option<String>,
    pub last_modified: Option<String>,
}

/// What came of it.
pub enum Answer {
    Came {
        bytes: Vec<u8>,
        known: Known,
    },
    NotModified,
    /// Anything else that was answered, in words: a status, half an answer, a hang-up on the question.
    Refused(String),
    /// The question came to nobody: no address for the name, no connection, no TLS. It was not asked, in words.
    Unreached(String),
}

/// Asks once. Redirects are not followed: a source that has moved is for its user to know.
pub fn ask(wanted: &Wanted, manner: &Manner, known: &Known, credentials: Option<&Credentials>) -> Answer {
    // Shorter than the whole, so that a network which swallows connections is told from a source that does not answer.
    let connect = manner.timeout.mul_f64(0.75).min(LONGEST_CONNECT);
    let agent: Agent = Agent::config_builder()
        .timeout_global(Some(manner.timeout))
        .timeout_resolve(Some(connect))
        .timeout_connect(Some(connect))
        .max_redirects(0)
        .max_redirects_will_error(false)
        .http_status_as_error(false)
        .https_only(!manner.plain)
        .user_agent(concat!("streakcast/", env!("CARGO_PKG_VERSION")))
        .build()
        .into();
    let cookie = match (&wanted.login, credentials) {
        (Some(login), Some(credentials)) => match log_in(&agent, login, credentials) {
            Ok(cookie) => Some(cookie),
            Err(answer) => return answer,
        },
        _ => None,
    };
    let answer = question(&agent, &wanted.url, manner, known, cookie.as_deref());
    if let (Some(login), Some(cookie)) = (&wanted.login, &cookie) {
        // A session left open is no harm: what came counts.
        let _ = agent.get(&login.logout_url).header("Cookie", cookie).call();
    }
    answer
}

fn question(agent: &Agent, url: &str, manner: &Manner, known: &Known, cookie: Option<&str>) -> Answer {
    let mut request = agent.get(url);
    for (name, value) in [
        ("If-None-Match", known.etag.as_deref()),
        ("If-Modified-Since", known.last_modified.as_deref()),
        ("Cookie", cookie),
    ] {
        if let Some(value) = value {
            request = request.header(name, value);
        }
    }
    let response = match request.call() {
        Ok(response) => response,
        Err(error) => return no_answer("no answer", &error),
    };
    match response.status().as_u16() {
        200 => came(response, manner.max_bytes),
        304 if known.etag.is_some() || known.last_modified.is_some() => Answer::NotModified,
        _ => Answer::Refused(refusal(response)),
    }
}

/// Whether the question was heard: a service that was reached and hung up, or kept silent, has been asked.
fn no_answer(what: &str, error: &ureq::Error) -> Answer {
    let is_unreached = match error {
        ureq::Error::HostNotFound
        | ureq::Error::ConnectionFailed
        | ureq::Error::ConnectProxyFailed(_)
        | ureq::Error::InvalidProxyUrl
        | ureq::Error::Tls(_)
        | ureq::Error::Rustls(_)
        | ureq::Error::TlsRequired
        | ureq::Error::Timeout(Timeout::Resolve | Timeout::Connect) => true,
        // A name without an address has no kind of its own in the standard library, and a certificate that is not the source's is bad data:
        // what is named here are the ends of connections that stood.
        ureq::Error::Io(error) => !matches!(
            error.kind(),
            ErrorKind::UnexpectedEof
                | ErrorKind::ConnectionReset
                | ErrorKind::ConnectionAborted
                | ErrorKind::BrokenPipe
                | ErrorKind::TimedOut
        ),
        _ => false,
    };
    if is_unreached {
        Answer::Unreached(format!("not reached: {error}"))
    } else {
        Answer::Refused(format!("{what}: {error}"))
    }
}

fn came(mut response: Response<Body>, max_bytes: u64) -> Answer {
    let known = Known { etag: header(&response, "etag"), last_modified: header(&response, "last-modified") };
    // One byte more than is taken tells that there is more; a body shorter than its Content-Length is an error of its own.
    match response.body_mut().with_config().limit(max_bytes.saturating_add(1)).read_to_vec() {
        Ok(bytes) if bytes.len() as u64 > max_bytes => {
            Answer::Refused(format!("200, with more than the {max_bytes} bytes that are taken"))
        }
        Ok(bytes) => Answer::Came { bytes, known },
        Err(ureq::Error::BodyExceedsLimit(_)) => {
            Answer::Refused(format!("200, with more than the {max_bytes} bytes that are taken"))
        }
        Err(error) => Answer::Refused(format!("200, and the answer broke off: {error}")),
    }
}

/// Status, where it points to, and the first words of what it says.
fn refusal(mut response: Response<Body>) -> String {
    let status = response.status();
    let mut words =
        format!("{} {}", status.as_u16(), status.canonical_reason().unwrap_or_default()).trim_end().to_owned();
    if let Some(place) = header(&response, "location") {
        words += &format!(" to {place} (not followed)");
    }
    if let Ok(bytes) = response.body_mut().with_config().limit(REFUSAL_BYTES).read_to_vec()
        && !bytes.is_empty()
    {
        words += &format!("; {}", first_words(&bytes));
    }
    words
}

fn header(response: &Response<Body>, name: &str) -> Option<String> {
    // What cannot be said again in a request is not kept.
    response.headers().get(name)?.to_str().ok().map(str::to_owned)
}

/// Space-Track's session: a cookie against user name and password. A wrong password is answered with 200 too.
fn log_in(agent: &Agent, login: &Login, credentials: &Credentials) -> Result<String, Answer> {
    let refused = |words: String| Err(Answer::Refused(words));
    let form = [("identity", credentials.identity.as_str()), ("password", credentials.password.as_str())];
    let response =
        agent.post(&login.login_url).send_form(form).map_err(|error| no_answer("no answer to the login", &error))?;
    if response.status().as_u16() != 200 {
        return refused(format!("login: {}", refusal(response)));
    }
    let cookies: Vec<String> = response
        .headers()
        .get_all("set-cookie")
        .iter()
        .filter_map(|cookie| cookie.to_str().ok()?.split(';').next().map(str::to_owned))
        .collect();
    let mut response = response;
    let said = response.body_mut().with_config().limit(REFUSAL_BYTES).read_to_string().unwrap_or_default();
    if said.to_ascii_lowercase().contains("failed") {
        return refused("login: the account was refused (user name or password)".to_owned());
    }
    if cookies.is_empty() { refused("login: no session came of it".to_owned()) } else { Ok(cookies.join("; ")) }
}

/// User name and password. It has no way of being printed.
pub struct Credentials {
    pub identity: String,
    pub password: String,
}

impl Credentials {
    pub fn of(typed: &SpaceTrackArguments, notices: &Notices) -> anyhow::Result<Self> {
        if let Some(path) = &typed.credentials {
            return of_file(path, notices);
        }
        let variable = |name: &Option<String>, flag: &str| {
            let name =
                name.as_deref().ok_or_else(|| anyhow!("no credentials; say --credentials FILE, or {flag} NAME"))?;
            std::env::var(name)
                .ok()
                .filter(|value| !value.is_empty())
                .ok_or_else(|| anyhow!("the environment variable {name} is not set; {flag} names it"))
        };
        Ok(Self {
            identity: variable(&typed.identity_env, "--identity-env")?,
            password: variable(&typed.password_env, "--password-env")?,
        })
    }
}

fn of_file(path: &Path, notices: &Notices) -> anyhow::Result<Credentials> {
    let shown = path.display();
    let text = std::fs::read_to_string(path).map_err(|error| anyhow!("credentials {shown}: {error}"))?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode =
            std::fs::metadata(path).map_err(|error| anyhow!("credentials {shown}: {error}"))?.permissions().mode();
        if mode & 0o077 != 0 {
            notices.warn(&[format!("credentials {shown} can be read by others (chmod 600 {shown})")]);
        }
    }
    #[cfg(not(unix))]
    let _ = notices;
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    match (lines.next(), lines.next(), lines.next()) {
        (Some(identity), Some(password), None) => {
            Ok(Credentials { identity: identity.to_owned(), password: password.to_owned() })
        }
        _ => Err(anyhow!("credentials {shown}: allowed are two lines, user name and password")),
    }
}
