//! Lines for somebody who may not read them: a thread writes, and what finds no room is dropped and counted.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

/// Lines that wait.
const ROOM: usize = 1024;
/// How long the end waits for a reader.
const PATIENCE: Duration = Duration::from_secs(1);

/// One end of it: pushing never waits.
pub struct Outlet<T> {
    queue: SyncSender<T>,
    waiting: Arc<AtomicUsize>,
    lost: Arc<AtomicU64>,
}

impl<T: Send + 'static> Outlet<T> {
    /// Calls `write` in a thread of its own; after its first failure no more.
    pub fn new(name: &str, mut write: impl FnMut(T) -> io::Result<()> + Send + 'static) -> Result<Self> {
        let (queue, lines) = sync_channel(ROOM);
        let (waiting, lost) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicU64::new(0)));
        let this = Self { queue, waiting: Arc::clone(&waiting), lost: Arc::clone(&lost) };
        let run = move || {
            let mut is_open = true;
            for line in lines {
                is_open = is_open && write(line).is_ok();
                lost.fetch_add(u64::from(!is_open), Ordering::Relaxed);
                waiting.fetch_sub(1, Ordering::Release);
            }
        };
        thread::Builder::new()
            .name(name.to_owned())
            .spawn(run)
            .with_context(|| format!("no thread for {name}"))?;
        Ok(this)
    }

    /// Hands a line over, if there is room.
    pub fn push(&self, line: T) {
        self.waiting.fetch_add(1, Ordering::Relaxed);
        if self.queue.try_send(line).is_err() {
            self.waiting.fetch_sub(1, Ordering::Relaxed);
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Waits until everything is written, or nobody has read for a while. How many lines were not.
    pub fn finish(&self) -> u64 {
        let end = Instant::now() + PATIENCE;
        while self.waiting.load(Ordering::Acquire) > 0 && Instant::now() < end {
            thread::sleep(Duration::from_millis(1));
        }
        self.lost.load(Ordering::Relaxed) + self.waiting.load(Ordering::Acquire) as u64
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn lines_come_out_in_their_order_and_those_without_a_reader_are_counted() {
        let (sender, receiver) = channel();
        let outlet = Outlet::new("test", move |k: u32| sender.send(k).map_err(io::Error::other)).unwrap();
        (0..10).for_each(|k| outlet.push(k));
        assert_eq!((outlet.finish(), receiver.iter().take(10).collect::<Vec<_>>()), (0, (0..10).collect()));
        drop(receiver);
        (0..10).for_each(|k| outlet.push(k));
        assert_eq!(outlet.finish(), 10);

        let stalled = Outlet::new("test", |_: u32| {
            loop {
                thread::park();
            }
        });
        let stalled = stalled.unwrap();
        (0..2000).for_each(|k| stalled.push(k));
        assert_eq!(stalled.finish(), 2000);
    }
}
