//! A long text in pieces on all cores: cut where a record begins, read apart, put together in order.

use rayon::prelude::*;

use super::record::Parsed;

/// Shorter texts are read in one piece: a thread costs more than it saves.
const LEAST_CHUNK: usize = 200_000;

/// Reads `text` with `parse`, in pieces that begin where `next_record(text, from)` says: the offset at or after `from` at
/// which reading may begin afresh, or the length of the text. The answer is the one that a single piece gives.
pub(super) fn parse_in_chunks<'a>(
    text: &'a str,
    next_record: impl Fn(&'a str, usize) -> usize,
    parse: impl Fn(&'a str) -> Parsed + Sync,
) -> Parsed {
    // Two pieces a thread, for threads may be busy elsewhere.
    let pieces = (text.len() / LEAST_CHUNK).min(2 * rayon::current_num_threads());
    let mut cuts = vec![0];
    for piece in 1..pieces {
        let from = text.len() / pieces * piece;
        let last = cuts[cuts.len() - 1];
        let from = (from.max(last + 1)..=text.len()).find(|&at| text.is_char_boundary(at)).unwrap_or(text.len());
        cuts.push(next_record(text, from));
    }
    cuts.push(text.len());
    let parts: Vec<(usize, Parsed)> =
        cuts.par_windows(2).map(|cut| (cut[0], parse(text.get(cut[0]..cut[1]).unwrap_or_default()))).collect();
    let mut parts = parts.into_iter();
    let mut whole = parts.next().map(|(_, first)| first).unwrap_or_default();
    for (offset, part) in parts {
        whole.sets.extend(part.sets);
        whole.last_good_at = part.last_good_at.map(|at| at + offset).or(whole.last_good_at);
        whole.rejected.extend(part.rejected.into_iter().map(|(at, reason)| (at + offset, reason)));
        whole.bad_checksums_accepted += part.bad_checksums_accepted;
    }
    whole
}

/// Offset of the first line that begins at or after `from`.
pub(super) fn next_line(text: &str, from: usize) -> usize {
    if from == 0 {
        return 0;
    }
    let rest = text.as_bytes().get(from - 1..).unwrap_or_default();
    rest.iter().position(|&byte| byte == b'\n' || byte == b'\r').map_or(text.len(), |at| from + at)
}
