//! Bytes that are made and written chunk by chunk, several at once.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use super::positioned::write_all_at;
use super::room::Room;

/// Bytes that are made and written at once. A thread writes what it made itself, which is still in its cache. They begin at multiples of their length in the file,
/// the first excepted, so that no two share a page; what begins at a block of FITS is cut between whole pixels of every type and whole words of sums.
const CHUNK: usize = 1 << 20;

/// Bytes after which the disk is asked to take what was written.
const FLUSH: usize = 4 * CHUNK;

/// Writes `length` bytes to a file from `to` on as `make` makes them, and gathers in order what it says of each chunk. Chunks are begun in order, on two threads: a file
/// system lets one of them into a file at a time, and the other makes its next chunk meanwhile; more would only wait. With `is_flushed` what is written is brought to the disk while the next chunks are made; that all of it is there the caller has to see to.
///
/// # Errors
/// What `make` says, and what the system says of writing.
pub(super) fn write_in_chunks<T: Send>(
    file: &File,
    to: u64,
    length: usize,
    is_flushed: bool,
    make: impl Fn(Range<usize>, &mut [u8]) -> io::Result<T> + Sync,
) -> io::Result<Vec<T>> {
    let before = (to % CHUNK as u64) as usize;
    let (begun, has_failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let chunk = |from: usize, bytes: &mut [u8]| {
        let said = make(from..from + bytes.len(), bytes)?;
        write_all_at(file, bytes, to + from as u64)?;
        Ok::<_, io::Error>((from, said))
    };
    thread::scope(|scope| {
        let (to_flusher, written) = mpsc::channel();
        let flusher = is_flushed.then(|| {
            scope.spawn(move || {
                while written.recv().is_ok() {
                    // One flush for all that was written since the last.
                    while written.try_recv().is_ok() {}
                    file.sync_data()?;
                }
                Ok(())
            })
        });
        let work = |to_flusher: mpsc::Sender<()>| -> io::Result<Vec<(usize, T)>> {
            let (mut room, mut made, mut since_flush) = (Room::new(CHUNK.min(length)), Vec::new(), 0);
            while !has_failed.load(Ordering::Relaxed) {
                // Counted from the last multiple before `to`.
                let aligned = begun.fetch_add(CHUNK, Ordering::Relaxed);
                let from = aligned.saturating_sub(before);
                if from >= length {
                    break;
                }
                let bytes = room.first((aligned + CHUNK - before).min(length) - from);
                made.push(chunk(from, bytes).inspect_err(|_| has_failed.store(true, Ordering::Relaxed))?);
                since_flush += bytes.len();
                if since_flush >= FLUSH {
                    since_flush = 0;
                    // Nobody listens where nothing is flushed, or where the disk failed, which is told in the end.
                    let _ = to_flusher.send(());
                }
            }
            Ok(made)
        };
        let other = to_flusher.clone();
        let beside = (before + length > CHUNK).then(|| scope.spawn(move || work(other)));
        let own = work(to_flusher);
        let others = beside.map_or(Ok(Vec::new()), joined);
        let flushed = flusher.map_or(Ok(()), joined);
        let (mut made, others, ()) = (own?, others?, flushed?);
        made.extend(others);
        made.sort_by_key(|(from, _)| *from);
        Ok(made.into_iter().map(|(_, said)| said).collect())
    })
}

fn joined<T>(thread: thread::ScopedJoinHandle<'_, io::Result<T>>) -> io::Result<T> {
    thread.join().unwrap_or_else(|_| Err(io::Error::other("a thread that writes stopped")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Seek, SeekFrom};

    #[test]
    fn verif_every_byte_is_where_it_belongs() {
        for (length, is_flushed) in [(0, false), (1, true), (CHUNK, false), (9 * CHUNK + 17, true), (5 * CHUNK, false)]
        {
            for to in [0, 2880, 7 + CHUNK, 2 * CHUNK] {
                let mut file = tempfile::tempfile().unwrap();
                let byte = |at: usize| (at % 251) as u8;
                let said = write_in_chunks(&file, to as u64, length, is_flushed, |range, bytes| {
                    assert_eq!(range.len(), bytes.len());
                    assert!(range.start == 0 || (to + range.start).is_multiple_of(CHUNK));
                    bytes.iter_mut().zip(range.clone()).for_each(|(place, at)| *place = byte(at));
                    Ok(range)
                })
                .unwrap();
                // In order, and without a gap.
                let next = |end, range: &Range<usize>| if range.start == end { range.end } else { usize::MAX };
                assert_eq!(said.iter().fold(0, next), length);
                let mut found = Vec::new();
                file.seek(SeekFrom::Start(to as u64)).unwrap();
                file.read_to_end(&mut found).unwrap();
                assert!(found == (0..length).map(byte).collect::<Vec<u8>>(), "{length} from {to}");
            }
        }
    }

    #[test]
    fn errors_of_either_side_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let file = File::create(&path).unwrap();
        let error = write_in_chunks(&file, 0, 12 * CHUNK, true, |range, _| {
            if range.start < 8 * CHUNK { Ok(()) } else { Err(io::Error::other("no more")) }
        });
        assert_eq!(error.unwrap_err().to_string(), "no more");
        let closed = File::open(&path).unwrap();
        assert!(write_in_chunks(&closed, 0, 12 * CHUNK, true, |_, _| Ok(())).is_err());
    }
}
