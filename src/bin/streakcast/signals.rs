//! End of the program at a signal: unfinished files are removed first.

/// Removes unfinished files when the program is interrupted or terminated, and then ends as without this handler.
#[cfg(unix)]
pub fn remove_files_at_end() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    // Without a handler the next run removes the files.
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            streakcast::output::remove_unfinished();
            let _ = signal_hook::low_level::emulate_default_handler(signal);
            // Only if the signal could not be sent.
            std::process::exit(128 + signal);
        }
    });
}

#[cfg(not(unix))]
pub fn remove_files_at_end() {}
