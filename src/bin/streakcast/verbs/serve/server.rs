//! Connections, with limits on their number, on their age and on request heads, and a stop that completes open requests.

use std::future::Future;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::http::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpStream;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};
use tokio::time::{sleep, timeout};
use tower::ServiceExt;

use super::malformed::{self, HEAD_TIMEOUT, MAX_HEAD_BYTES, MAX_HEADERS, Wire};
use super::router::ClientAddress;

/// Most open connections; further ones wait in the queue of the operating system.
const MAX_CONNECTIONS: u32 = 512;
/// Age at which a connection closes, after the answer under way.
const MAX_AGE: Duration = Duration::from_secs(600);
/// Time in which open requests have to end after a stop.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(10);
/// Pause after an error of accept, such as too many open files.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Serves until SIGINT or SIGTERM arrives; `workers` is the number of blocking threads.
pub fn serve(listener: TcpListener, router: Router, workers: usize) -> anyhow::Result<()> {
    listener.set_nonblocking(true)?;
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().max_blocking_threads(workers + 1).build()?;
    runtime.block_on(accept(listener, router))?;
    // Does not wait for answers that are still being computed.
    runtime.shutdown_background();
    Ok(())
}

async fn accept(listener: TcpListener, router: Router) -> anyhow::Result<()> {
    let listener = tokio::net::TcpListener::from_std(listener)?;
    let permits = Arc::new(Semaphore::new(MAX_CONNECTIONS as usize));
    // Dropping the sender stops the connections.
    let (running, stop) = watch::channel(());
    let mut signal = Box::pin(stop_signal()?);
    loop {
        let next = async { (Arc::clone(&permits).acquire_owned().await, listener.accept().await) };
        tokio::select! {
            biased;
            () = &mut signal => break,
            accepted = next => match accepted {
                (Ok(permit), Ok((stream, from))) => {
                    tokio::spawn(serve_connection(stream, from, router.clone(), stop.clone(), permit));
                }
                _ => sleep(ACCEPT_PAUSE).await,
            },
        }
    }
    drop((listener, running));
    // A second signal ends the wait.
    tokio::select! {
        _ = timeout(SHUTDOWN_TIMEOUT, permits.acquire_many(MAX_CONNECTIONS)) => {}
        () = stop_signal()? => {}
    }
    Ok(())
}

/// Serves one connection to its end. Errors of a connection concern its client alone.
async fn serve_connection(
    stream: TcpStream,
    from: SocketAddr,
    router: Router,
    stop: watch::Receiver<()>,
    _permit: OwnedSemaphorePermit,
) {
    let _ = stream.set_nodelay(true);
    let service = service_fn(|mut request: Request<Incoming>| {
        request.extensions_mut().insert(ClientAddress(from.ip()));
        router.clone().oneshot(request)
    });
    let mut connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .max_buf_size(MAX_HEAD_BYTES)
        .max_headers(MAX_HEADERS)
        .serve_connection(TokioIo::new(Wire(stream)), service);
    let ended = tokio::select! {
        ended = &mut connection => ended,
        _ = timeout(MAX_AGE, stopped(stop.clone())) => {
            std::pin::Pin::new(&mut connection).graceful_shutdown();
            let Ok(ended) = timeout(SHUTDOWN_TIMEOUT, &mut connection).await else { return };
            ended
        }
    };
    let parts = connection.into_parts();
    let problem = ended.err().and_then(|error| malformed::problem_of(&error, &parts.read_buf));
    tokio::select! {
        () = malformed::close(parts.io.into_inner().0, problem) => {}
        () = stopped(stop) => {}
    }
}

async fn stopped(mut stop: watch::Receiver<()>) {
    while stop.changed().await.is_ok() {}
}

/// Returns the arrival of SIGINT or SIGTERM (Ctrl-C on other systems).
fn stop_signal() -> anyhow::Result<impl Future<Output = ()>> {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
        Ok(async move {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
        })
    }
    #[cfg(not(unix))]
    Ok(async {
        let _ = tokio::signal::ctrl_c().await;
    })
}
