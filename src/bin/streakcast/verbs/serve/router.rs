//! Paths with their parameters and handlers, and middleware for all requests.

use std::net::IpAddr;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Instant;

use axum::extract::{Request, State};
use axum::http::header::{ALLOW, AUTHORIZATION, CONNECTION, CONTENT_TYPE, WWW_AUTHENTICATE};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Uri};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Extension, Router};
use streakcast::Watch;

use super::filter::Token;
use super::filter::{RequestFilter, has_body};
use super::handlers::{dome, exposure, exposures, forecast, health, night, satchecker};
use super::openapi::{JSON, Route};
use super::problem::Problem;
use super::query::Query;
use super::state::{RequestState, ServerState};
use super::workers::WorkerPool;
use super::{openapi, page};

/// Content security policy: the page can load from and connect only to this server, and cannot be embedded in a frame.
const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; \
     connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Headers of all responses.
pub const HEADERS: [(&str, &str); 6] = [
    ("content-security-policy", CONTENT_SECURITY_POLICY),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cache-control", "no-store"),
];

/// All paths of the API.
pub static ROUTES: &[Route] = &[
    Route {
        path: "/api/v1/night",
        alias: None,
        summary: "One night: exposures of the schedule, their verdicts, the Sun, the field, the site.",
        parameters: night::PARAMETERS,
        needs_token: true,
        handler: night::handle,
        schema: night::schema,
    },
    Route {
        path: "/api/v1/exposure",
        alias: None,
        summary: "Any exposure: its verdict, its crossings, the next clear start; as `flag` and `passes` of the command line.",
        parameters: exposure::PARAMETERS,
        needs_token: true,
        handler: exposure::handle,
        schema: exposure::schema,
    },
    Route {
        path: "/api/v1/exposures",
        alias: None,
        summary: "Many exposures in one request: their verdicts; as `flag` of the command line.",
        parameters: exposures::PARAMETERS,
        needs_token: true,
        handler: exposures::handle,
        schema: exposures::schema,
    },
    Route {
        path: "/api/v1/dome",
        alias: None,
        summary: "The sky over the site: sunlit satellites, a model's magnitudes at one height, the edge of the Earth's shadow, the Sun.",
        parameters: dome::PARAMETERS,
        needs_token: true,
        handler: dome::handle,
        schema: dome::schema,
    },
    Route {
        path: "/api/v1/forecast",
        alias: None,
        summary: "The visible passes of a night, the most probably visible first, and their calendar; as `forecast` of the command line.",
        parameters: forecast::PARAMETERS,
        needs_token: true,
        handler: forecast::handle,
        schema: forecast::schema,
    },
    Route {
        path: "/fov/satellite-passes/",
        alias: Some("/fov/satellite-passes"),
        summary: "Satellites in a circular field during a time interval, in the format of SatChecker, with magnitudes.",
        parameters: satchecker::PASSES,
        needs_token: true,
        handler: satchecker::passes,
        schema: satchecker::passes_schema,
    },
    Route {
        path: "/fov/satellites-above-horizon/",
        alias: Some("/fov/satellites-above-horizon"),
        summary: "Satellites above the horizon at one time, in the format of SatChecker, with magnitudes.",
        parameters: satchecker::ABOVE,
        needs_token: true,
        handler: satchecker::above,
        schema: satchecker::above_schema,
    },
    Route {
        path: "/health",
        alias: None,
        summary: "Status of the server, its version, and the sizes of its inputs.",
        parameters: &[],
        needs_token: false,
        handler: health::handle,
        schema: health::schema,
    },
    Route {
        path: "/openapi.json",
        alias: None,
        summary: "This document.",
        parameters: &[],
        needs_token: false,
        handler: |_, _| Ok(format!("{}\n", openapi::document(ROUTES))),
        schema: openapi::schema,
    },
];

/// State shared by the handlers.
pub struct App {
    /// Replaced when the element files change; a request uses the state of its start.
    pub state: Arc<RwLock<Arc<ServerState>>>,
    pub filter: RequestFilter,
    pub token: Option<Token>,
    pub workers: WorkerPool,
}

/// Address of the client, stored as an extension of each request.
#[derive(Clone, Copy)]
pub struct ClientAddress(pub IpAddr);

/// Returns the router with all paths and the middleware.
pub fn router(app: App) -> Router {
    let app = Arc::new(app);
    let mut router = Router::new();
    for (path, content_type, content) in page::FILES {
        router = router.route(path, get(([(CONTENT_TYPE, *content_type)], *content)));
    }
    for route in ROUTES {
        for path in [route.path].into_iter().chain(route.alias) {
            let handler = move |app, uri, headers| respond(route, app, uri, headers);
            router = router.route(path, get(handler));
        }
    }
    router
        .fallback(not_found)
        .method_not_allowed_fallback(method_not_allowed)
        .layer(middleware::from_fn_with_state(Arc::clone(&app), filter))
        .layer(middleware::from_fn(complete))
        .with_state(app)
}

async fn respond(route: &'static Route, State(app): State<Arc<App>>, uri: Uri, headers: HeaderMap) -> Response {
    let computed = async {
        if route.needs_token {
            check_token(app.token.as_ref(), &headers)?;
        }
        let query = Query::read(uri.query().unwrap_or_default(), route.parameters)?;
        let target = uri.path_and_query().map_or(route.path, |target| target.as_str());
        let state = Arc::clone(&app.state.read().unwrap_or_else(PoisonError::into_inner));
        let shared = Arc::clone(&state);
        let work = move |watch: &Watch| (route.handler)(&RequestState::new(Arc::clone(&shared), watch), &query);
        app.workers.response(&state.cache, target, work).await
    };
    match computed.await {
        Ok(body) => ([(CONTENT_TYPE, JSON)], body).into_response(),
        Err(problem) => problem.response(uri.path()),
    }
}

fn check_token(token: Option<&Token>, headers: &HeaderMap) -> Result<(), Problem> {
    let authorization = headers.get(AUTHORIZATION).map(HeaderValue::as_bytes);
    if token.is_none_or(|token| token.is_carried_by(authorization)) {
        return Ok(());
    }
    let detail = "the token is missing or wrong; allowed: the header 'Authorization: Bearer TOKEN'";
    Err(Problem::new(401, detail).with(WWW_AUTHENTICATE, "Bearer"))
}

async fn not_found(uri: Uri) -> Response {
    Problem::new(404, "unknown path; /openapi.json lists the paths").response(uri.path())
}

async fn method_not_allowed(uri: Uri) -> Response {
    Problem::new(405, "invalid method; allowed: GET and HEAD").with(ALLOW, "GET, HEAD").response(uri.path())
}

/// Rejects requests that the filter does not accept.
async fn filter(
    State(app): State<Arc<App>>,
    Extension(ClientAddress(address)): Extension<ClientAddress>,
    request: Request,
    next: Next,
) -> Response {
    match app.filter.check(&request, address, Instant::now()) {
        Ok(()) => next.run(request).await,
        Err(problem) => problem.response(request.uri().path()),
    }
}

/// Adds the common headers and the computing time to a response.
async fn complete(request: Request, next: Next) -> Response {
    let began = Instant::now();
    let closes = has_body(request.headers());
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    headers.extend(HEADERS.map(|(name, value)| (HeaderName::from_static(name), HeaderValue::from_static(value))));
    let took_ms = began.elapsed().as_secs_f64() * 1e3;
    headers.extend(HeaderValue::try_from(format!("answer;dur={took_ms:.2}")).map(|took| (SERVER_TIMING, took)));
    if closes {
        // The body of the request is not read. The connection is closed, because the body would be read as the next
        // request.
        headers.insert(CONNECTION, HeaderValue::from_static("close"));
    }
    response
}

const SERVER_TIMING: HeaderName = HeaderName::from_static("server-timing");
