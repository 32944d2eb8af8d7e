//! Connections: taken one by one, each with its limits of time and size, and a stop that lets finish what is open.

use std::convert::Infallible;
use std::future::{Future, poll_fn};
use std::net::{IpAddr, TcpListener};
use std::pin::{Pin, pin};
use std::sync::Arc;
use std::task::Poll;
use std::time::{Duration, Instant};

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::{CONNECTION, HeaderValue};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpStream;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};
use tokio::time::{sleep, timeout};

use super::desk::Desk;
use super::door::{Door, Wanted, has_body};
use super::farewell::{self, Wire};
use super::house::House;
use super::reply::Problem;
use super::token::Token;

/// Connections that are open at once; the next ones wait to be taken.
const MOST_CONNECTIONS: usize = 512;
/// A head must come within this, and so must the next request on an open connection.
pub const HEAD_TIMEOUT: Duration = Duration::from_secs(10);
/// Bytes of a head, and its lines.
pub const LONGEST_HEAD: usize = 16 << 10;
pub const MOST_HEADERS: usize = 64;
/// A connection that is older closes after the answer that is under way, and is cut some time later.
const OLDEST: Duration = Duration::from_secs(600);
/// What is open at a stop may take this long to finish.
const FINISH: Duration = Duration::from_secs(10);
/// After a fault of accepting (no more file descriptors), seconds.
const TRY_AGAIN: Duration = Duration::from_millis(100);

pub struct Settings {
    /// Requests a second and address.
    pub rate: u32,
    pub token: Option<Token>,
    pub is_loopback: bool,
    /// Answers computed at a time.
    pub workers: usize,
}

struct Service {
    door: Door,
    desk: Desk,
}

/// Serves until a signal asks it to stop.
pub fn serve(listener: TcpListener, house: House, settings: Settings) -> anyhow::Result<()> {
    let Settings { rate, token, is_loopback, workers } = settings;
    let service = Arc::new(Service { door: Door::new(rate, token, is_loopback), desk: Desk::new(house, workers) });
    listener.set_nonblocking(true)?;
    // The network needs one thread; answers are computed on others.
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().max_blocking_threads(workers + 1).build()?;
    runtime.block_on(accept(listener, service))?;
    // What has not finished by now is left.
    runtime.shutdown_background();
    Ok(())
}

async fn accept(listener: TcpListener, service: Arc<Service>) -> anyhow::Result<()> {
    let listener = tokio::net::TcpListener::from_std(listener)?;
    let (stop, stopped) = watch::channel(false);
    let places = Arc::new(Semaphore::new(MOST_CONNECTIONS));
    let mut signal = pin!(asked_to_stop()?);
    loop {
        let taken = async {
            let place = Arc::clone(&places).acquire_owned().await;
            (place, listener.accept().await)
        };
        match first(pin!(taken), signal.as_mut()).await {
            First::Left((Ok(place), Ok((stream, from)))) => {
                let connection = connection(stream, from.ip(), Arc::clone(&service), stopped.clone(), place);
                tokio::spawn(connection);
            }
            First::Left(_) => sleep(TRY_AGAIN).await,
            First::Right(()) => break,
        }
    }
    drop(listener);
    let _ = stop.send(true);
    // Every connection holds a place until it is done. A second signal waits for none.
    let finished = timeout(FINISH, places.acquire_many(MOST_CONNECTIONS as u32));
    first(pin!(finished), pin!(asked_to_stop()?)).await;
    Ok(())
}

/// One connection to its end; whatever goes wrong on it is its client's to notice.
async fn connection(
    stream: TcpStream,
    from: IpAddr,
    service: Arc<Service>,
    stopped: watch::Receiver<bool>,
    _place: OwnedSemaphorePermit,
) {
    let _ = stream.set_nodelay(true);
    let answer = service_fn(|request: Request<Incoming>| {
        let service = Arc::clone(&service);
        async move { Ok::<_, Infallible>(service.answer(request, from).await) }
    });
    let mut connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .max_buf_size(LONGEST_HEAD)
        .max_headers(MOST_HEADERS)
        .serve_connection(TokioIo::new(Wire(stream)), answer);
    let old = timeout(OLDEST, told_to_stop(stopped.clone()));
    let ended = match first(Pin::new(&mut connection), pin!(old)).await {
        First::Left(ended) => ended,
        First::Right(_) => {
            Pin::new(&mut connection).graceful_shutdown();
            match timeout(FINISH, &mut connection).await {
                Ok(ended) => ended,
                Err(_) => return,
            }
        }
    };
    let left = connection.into_parts();
    let word = ended.err().and_then(|error| farewell::last_word(&error, &left.read_buf));
    let Wire(mut stream) = left.io.into_inner();
    if farewell::say(&mut stream, word).await.is_ok() {
        // A stop waits for nobody who has been told all.
        first(pin!(farewell::hear_out(stream)), pin!(told_to_stop(stopped))).await;
    }
}

async fn told_to_stop(mut stopped: watch::Receiver<bool>) {
    let _ = stopped.wait_for(|stopped| *stopped).await;
}

impl Service {
    async fn answer(&self, request: Request<Incoming>, from: IpAddr) -> Response<Full<Bytes>> {
        let began = Instant::now();
        let uri = request.uri();
        let answer = match self.door.admit(&request, from, began) {
            Ok(Wanted::File(reply)) => Ok(reply),
            Ok(Wanted::Answer { route, question }) => {
                let target = uri.path_and_query().map_or(route.path, |target| target.as_str());
                self.desk.ask(route, question, target).await
            }
            Err(problem) => Err(problem),
        };
        let reply = answer.unwrap_or_else(|problem: Problem| problem.reply(uri.path()));
        let mut response = reply.response(request.method() == Method::HEAD, began);
        if has_body(request.headers()) {
            // It is not read, and nothing that stands in it may be taken for a request.
            response.headers_mut().insert(CONNECTION, HeaderValue::from_static("close"));
        }
        response
    }
}

/// Which of two came first.
enum First<A, B> {
    Left(A),
    Right(B),
}

async fn first<A: Future, B: Future>(mut left: Pin<&mut A>, mut right: Pin<&mut B>) -> First<A::Output, B::Output> {
    poll_fn(|context| {
        // A stop comes before the next connection.
        if let Poll::Ready(done) = right.as_mut().poll(context) {
            return Poll::Ready(First::Right(done));
        }
        left.as_mut().poll(context).map(First::Left)
    })
    .await
}

/// The first of the signals that ask a program to stop.
fn asked_to_stop() -> anyhow::Result<impl Future<Output = ()>> {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
        Ok(async move {
            first(pin!(interrupt.recv()), pin!(terminate.recv())).await;
        })
    }
    #[cfg(not(unix))]
    Ok(async {
        let _ = tokio::signal::ctrl_c().await;
    })
}
