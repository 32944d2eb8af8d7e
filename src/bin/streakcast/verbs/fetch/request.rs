//! Requests to a source, and credentials. A failed request is not repeated.

use std::io::ErrorKind;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::anyhow;
use ureq::http;
use ureq::{Agent, Body, Timeout};

use super::arguments::SpaceTrackArguments;
use super::sources::{Login, Source};
use super::verify::first_words;
use crate::files::readable_by_others;
use crate::notices::Notices;

/// Limit on the body of an error response, bytes.
const ERROR_BODY_BYTES: u64 = 2_000;
/// Longest time to connect.
const MAX_CONNECT: Duration = Duration::from_secs(30);

/// Options of a request.
pub struct RequestOptions {
    pub timeout: Duration,
    pub max_bytes: u64,
    /// True if addresses without TLS are accepted, for tests.
    pub plain: bool,
}

/// HTTP validators of the cached file.
#[derive(Default)]
pub struct Validators {
    pub etag: Option<String>,
    pub last_modified: Option<String>,
}

/// Response of a source.
pub enum Response {
    Data {
        bytes: Vec<u8>,
        validators: Validators,
    },
    NotModified,
    /// Any other response: an error status, a truncated body, or a closed connection.
    Refused {
        /// Description of the response.
        message: String,
        /// Value of the header Retry-After.
        retry_after: Option<String>,
    },
    /// The server was not reached (unknown host, no connection, no TLS), and no request was sent.
    Unreached(String),
}

impl Response {
    fn refused(message: String) -> Self {
        Self::Refused { message, retry_after: None }
    }
}

/// Sends one request, with login and logout if the source needs them. A redirect is reported and not followed,
/// because it means that the source has moved.
pub fn send(
    source: &Source,
    options: &RequestOptions,
    validators: &Validators,
    credentials: Option<&Credentials>,
) -> Response {
    // A timeout of zero would be rejected.
    let timeout = options.timeout.max(Duration::from_millis(1));
    let deadline = Instant::now() + timeout;
    // Shorter than the total timeout, so that a failed connection differs from a missing response.
    let connect = timeout.mul_f64(0.75).min(MAX_CONNECT);
    let agent: Agent = Agent::config_builder()
        .timeout_global(Some(timeout))
        .timeout_resolve(Some(connect))
        .timeout_connect(Some(connect))
        .max_redirects(0)
        .max_redirects_will_error(false)
        .http_status_as_error(false)
        .https_only(!options.plain)
        .user_agent(concat!("streakcast/", env!("CARGO_PKG_VERSION")))
        .build()
        .into();
    let cookie = match (&source.login, credentials) {
        (Some(login), Some(credentials)) => match log_in(&agent, login, credentials) {
            Ok(cookie) => Some(cookie),
            Err(response) => return response,
        },
        _ => None,
    };
    let response = get(&agent, &source.url, options, deadline, validators, cookie.as_deref());
    if let (Some(login), Some(cookie)) = (&source.login, &cookie) {
        // Errors of the logout are ignored.
        let logout = agent.get(&login.logout_url).config().timeout_global(Some(left(deadline))).build();
        let _ = logout.header("Cookie", cookie).call();
    }
    response
}

/// Returns the time until the deadline of all requests together; not zero, which would be rejected.
fn left(deadline: Instant) -> Duration {
    deadline.saturating_duration_since(Instant::now()).max(Duration::from_millis(1))
}

fn get(
    agent: &Agent,
    url: &str,
    options: &RequestOptions,
    deadline: Instant,
    validators: &Validators,
    cookie: Option<&str>,
) -> Response {
    let mut request = agent.get(url).config().timeout_global(Some(left(deadline))).build();
    for (name, value) in [
        ("If-None-Match", validators.etag.as_deref()),
        ("If-Modified-Since", validators.last_modified.as_deref()),
        ("Cookie", cookie),
    ] {
        if let Some(value) = value {
            request = request.header(name, value);
        }
    }
    let response = match request.call() {
        Ok(response) => response,
        Err(error) => return connection_error("no response", &error),
    };
    match response.status().as_u16() {
        200 => data(response, options.max_bytes),
        304 if validators.etag.is_some() || validators.last_modified.is_some() => Response::NotModified,
        _ => {
            let retry_after = header(&response, "retry-after");
            Response::Refused { message: error_message(response), retry_after }
        }
    }
}

/// Classifies a connection error. A server that was reached may have received the request, even if it closed the
/// connection or did not respond.
fn connection_error(what: &str, error: &ureq::Error) -> Response {
    let is_unreached = match error {
        ureq::Error::HostNotFound
        | ureq::Error::ConnectionFailed
        | ureq::Error::ConnectProxyFailed(_)
        | ureq::Error::InvalidProxyUrl
        | ureq::Error::Tls(_)
        | ureq::Error::Rustls(_)
        | ureq::Error::TlsRequired
        | ureq::Error::Timeout(Timeout::Resolve | Timeout::Connect) => true,
        // Unknown host names and invalid certificates are also `Io` errors. The kinds below occur only after the
        // connection is established.
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
        Response::Unreached(format!("not reached: {error}"))
    } else {
        Response::refused(format!("{what}: {error}"))
    }
}

fn data(mut response: http::Response<Body>, max_bytes: u64) -> Response {
    let validators = Validators { etag: header(&response, "etag"), last_modified: header(&response, "last-modified") };
    // One byte more than the limit is read, to detect a longer body. A body shorter than its Content-Length is an
    // error.
    match response.body_mut().with_config().limit(max_bytes.saturating_add(1)).read_to_vec() {
        Ok(bytes) if bytes.len() as u64 > max_bytes => {
            Response::refused(format!("200, with more than the limit of {max_bytes} bytes"))
        }
        Ok(bytes) => Response::Data { bytes, validators },
        Err(ureq::Error::BodyExceedsLimit(_)) => {
            Response::refused(format!("200, with more than the limit of {max_bytes} bytes"))
        }
        Err(error) => Response::refused(format!("200, with a truncated body: {error}")),
    }
}

/// Returns status, redirect address, and the start of the body of an error response.
fn error_message(mut response: http::Response<Body>) -> String {
    let status = response.status();
    let mut message =
        format!("{} {}", status.as_u16(), status.canonical_reason().unwrap_or_default()).trim_end().to_owned();
    if let Some(target) = header(&response, "location") {
        message += &format!(" to {target} (not followed)");
    }
    if let Ok(bytes) = response.body_mut().with_config().limit(ERROR_BODY_BYTES).read_to_vec()
        && !bytes.is_empty()
    {
        message += &format!("; {}", first_words(&bytes));
    }
    message
}

fn header(response: &http::Response<Body>, name: &str) -> Option<String> {
    // Values that are not ASCII are omitted, because they cannot be sent back.
    response.headers().get(name)?.to_str().ok().map(str::to_owned)
}

/// Logs in to Space-Track and returns the session cookie. For a wrong password the status is also 200.
fn log_in(agent: &Agent, login: &Login, credentials: &Credentials) -> Result<String, Response> {
    let refused = |message: String| Err(Response::refused(message));
    let form = [("identity", credentials.identity.as_str()), ("password", credentials.password.as_str())];
    let response = agent
        .post(&login.login_url)
        .send_form(form)
        .map_err(|error| connection_error("no response to the login", &error))?;
    if response.status().as_u16() != 200 {
        let retry_after = header(&response, "retry-after");
        return Err(Response::Refused { message: format!("login: {}", error_message(response)), retry_after });
    }
    let cookies: Vec<String> = response
        .headers()
        .get_all("set-cookie")
        .iter()
        .filter_map(|cookie| cookie.to_str().ok()?.split(';').next().map(str::to_owned))
        .collect();
    let mut response = response;
    let body = response.body_mut().with_config().limit(ERROR_BODY_BYTES).read_to_string().unwrap_or_default();
    if body.to_ascii_lowercase().contains("failed") {
        return refused("login: the account was refused (user name or password)".to_owned());
    }
    if cookies.is_empty() { refused("login: no session in the response".to_owned()) } else { Ok(cookies.join("; ")) }
}

/// User name and password. The type does not implement `Debug`, so that they cannot be printed by accident.
pub struct Credentials {
    pub identity: String,
    pub password: String,
}

impl Credentials {
    pub fn from_arguments(typed: &SpaceTrackArguments, notices: &Notices) -> anyhow::Result<Self> {
        if let Some(path) = &typed.credentials {
            return of_file(path, notices);
        }
        let variable = |name: &Option<String>, flag: &str| {
            let name = name
                .as_deref()
                .ok_or_else(|| anyhow!("missing credentials; specify --credentials FILE, or {flag} NAME"))?;
            std::env::var(name).ok().filter(|value| !value.is_empty()).ok_or_else(|| {
                anyhow!(
                    "the environment variable {name} of {flag} is not set; allowed: the name of a variable with a value"
                )
            })
        };
        Ok(Self {
            identity: variable(&typed.identity_env, "--identity-env")?,
            password: variable(&typed.password_env, "--password-env")?,
        })
    }
}

fn of_file(path: &Path, notices: &Notices) -> anyhow::Result<Credentials> {
    let shown = path.display();
    let text = streakcast::input::read_to_string(path).map_err(|error| anyhow!("credentials {shown}: {error}"))?;
    notices.warn(&readable_by_others("credentials file", path));
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    match (lines.next(), lines.next(), lines.next()) {
        (Some(identity), Some(password), None) => {
            Ok(Credentials { identity: identity.to_owned(), password: password.to_owned() })
        }
        _ => Err(anyhow!("invalid credentials {shown}; allowed: two lines, user name and password")),
    }
}
