//! Removes unfinished files when a signal ends the program.

/// On SIGHUP, SIGINT, SIGQUIT and SIGTERM, removes unfinished files and then ends the program by the same signal. A
/// signal that the parent process set to be ignored (`nohup`) stays ignored.
#[cfg(unix)]
pub fn remove_files_at_end() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
    let ignored = ignored_signals();
    let handled = [SIGHUP, SIGINT, SIGQUIT, SIGTERM].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    // If the handler cannot be installed, the next run removes the files.
    let Ok(mut signals) = signal_hook::iterator::Signals::new(handled) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            streakcast::output::remove_unfinished();
            let _ = signal_hook::low_level::emulate_default_handler(signal);
            // Reached only if the signal could not be sent.
            std::process::exit(128 + signal);
        }
    });
}

/// Returns the set of ignored signals: bit 0 is signal 1. On systems other than Linux, where it cannot be read, SIGHUP
/// and SIGQUIT count as ignored: then they have their usual effect, and the next run removes the files.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    use signal_hook::consts::{SIGHUP, SIGQUIT};
    let status = streakcast::input::read_to_string("/proc/self/status".as_ref()).unwrap_or_default();
    let set = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    set.and_then(|set| u64::from_str_radix(set.trim(), 16).ok()).unwrap_or(1 << (SIGHUP - 1) | 1 << (SIGQUIT - 1))
}

#[cfg(not(unix))]
pub fn remove_files_at_end() {}
