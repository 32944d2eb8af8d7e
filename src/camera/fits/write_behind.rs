//! Bytes that are made while others are written.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::sync::mpsc;
use std::thread;

use super::positioned::write_all_at;

/// Bytes that are made and written at once: whole pixels of every type, whole words of sums, and few enough to stay in a processor's cache.
const CHUNK: usize = 1 << 18;

/// Chunks that may wait to be written.
const WAITING: usize = 4;

/// Bytes after which the disk is asked to take what was written.
const FLUSH: usize = 1 << 22;

/// Writes `length` bytes to a file from `to` on, chunk after chunk as `make` makes them, in order. One thread writes, and only one: a file system lets no two
/// into a file. With `is_flushed` what is written is brought to the disk while the next chunks are made; that all of it is there the caller has to see to.
///
/// # Errors
/// What `make` says, and what the system says of writing.
pub(super) fn write_behind(
    file: &File,
    to: u64,
    length: usize,
    is_flushed: bool,
    mut make: impl FnMut(Range<usize>, &mut [u8]) -> io::Result<()>,
) -> io::Result<()> {
    thread::scope(|scope| {
        let (to_writer, made) = mpsc::sync_channel::<(usize, Vec<u8>)>(WAITING);
        let (to_maker, used) = mpsc::channel();
        let (to_flusher, written) = mpsc::channel();
        let writer = scope.spawn(move || {
            let mut since_flush = 0;
            for (from, chunk) in made {
                write_all_at(file, &chunk, to + from as u64)?;
                since_flush += chunk.len();
                if since_flush >= FLUSH {
                    since_flush = 0;
                    // Nobody listens where nothing is flushed, or where the disk failed, which is told in the end.
                    let _ = to_flusher.send(());
                }
                // The maker may have made its last.
                let _ = to_maker.send(chunk);
            }
            Ok(())
        });
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
        let finished = (0..length).step_by(CHUNK).try_for_each(|from| {
            let mut chunk = used.try_recv().unwrap_or_default();
            chunk.resize(CHUNK.min(length - from), 0);
            make(from..from + chunk.len(), &mut chunk)?;
            // Nobody takes it where the writer has failed, which says why itself.
            to_writer.send((from, chunk)).map_err(|_| io::Error::from(io::ErrorKind::BrokenPipe))
        });
        drop(to_writer);
        joined(writer).and(finished).and(flusher.map_or(Ok(()), joined))
    })
}

fn joined(thread: thread::ScopedJoinHandle<'_, io::Result<()>>) -> io::Result<()> {
    thread.join().unwrap_or_else(|_| Err(io::Error::other("a thread that writes stopped")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Seek, SeekFrom};

    #[test]
    fn verif_every_byte_is_where_it_belongs() {
        for (length, is_flushed) in [(0, false), (1, true), (CHUNK, false), (20 * CHUNK + 17, true), (9 * CHUNK, false)]
        {
            let mut file = tempfile::tempfile().unwrap();
            let byte = |at: usize| (at % 251) as u8;
            write_behind(&file, 7, length, is_flushed, |range, bytes| {
                assert_eq!(range.len(), bytes.len());
                bytes.iter_mut().zip(range).for_each(|(place, at)| *place = byte(at));
                Ok(())
            })
            .unwrap();
            let mut found = Vec::new();
            file.seek(SeekFrom::Start(0)).unwrap();
            file.read_to_end(&mut found).unwrap();
            let expected: Vec<u8> = [0; 7].into_iter().chain((0..length).map(byte)).collect();
            assert!(length == 0 && found.is_empty() || found == expected, "{length}");
        }
    }

    #[test]
    fn errors_of_either_side_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let file = File::create(&path).unwrap();
        let error = write_behind(&file, 0, 30 * CHUNK, true, |range, _| {
            if range.start < 20 * CHUNK { Ok(()) } else { Err(io::Error::other("no more")) }
        });
        assert_eq!(error.unwrap_err().to_string(), "no more");
        let closed = File::open(&path).unwrap();
        assert!(write_behind(&closed, 0, 30 * CHUNK, true, |_, _| Ok(())).is_err());
    }
}
