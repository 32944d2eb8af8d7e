//! Removes unfinished files when a signal ends the program.

/// On SIGINT and SIGTERM, removes unfinished files and then ends the program by the same signal.
#[cfg(unix)]
pub fn remove_files_at_end() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    // If the handler cannot be installed, the next run removes the files.
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            streakcast::output::remove_unfinished();
            let _ = signal_hook::low_level::emulate_default_handler(signal);
            // Reached only if the signal could not be sent.
            std::process::exit(128 + signal);
        }
    });
}

#[cfg(not(unix))]
pub fn remove_files_at_end() {}
