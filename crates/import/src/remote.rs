//! An instance in a process of its own, seen from here. Nothing that the FMU does there, and nothing that its process sends, does harm here.

use std::cell::RefCell;
use std::ffi::c_void;
use std::io::{self, BufRead, BufReader, ErrorKind, PipeReader, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::log::LogSink;
use super::slave::{Failure, Slave};
use super::wire::{HEAD, Message, Refusal, Reply, Request, Start, frame, length};
use super::worker::Show;
use super::{Lost, Status, Value, Variable, VariableType, Worker};

/// How often somebody who waits looks whether to go on.
const PATIENCE: Duration = Duration::from_millis(100);
/// A process that closed its socket is gone soon, a core dump written.
const LAST_WORDS: Duration = Duration::from_secs(2);
/// Bytes of what an FMU prints that are shown at once.
const LONGEST_PRINT: u64 = 1 << 16;

/// Owns the process.
pub(super) struct Remote {
    link: RefCell<Link>,
    lost: RefCell<Option<Lost>>,
    log: Arc<LogSink>,
}

impl Remote {
    /// Starts a process and has it load and instantiate.
    pub(super) fn start(worker: &Worker, start: &Start, log: Arc<LogSink>) -> Result<Self, Failure> {
        let link = Link::open(worker)
            .map_err(|reason| Lost::NotStarted(format!("{}: {reason}", worker.program.display())));
        let remote = Self { link: RefCell::new(link.map_err(Failure::Lost)?), lost: RefCell::default(), log };
        remote.ask(start).map_err(|refusal| refusal.failure)?;
        Ok(remote)
    }

    /// Sends a request and waits for the answer; once the process is lost, every request fails with the same.
    fn ask<T: serde::Serialize>(&self, request: &T) -> Result<Reply, Refusal> {
        if let Some(lost) = &*self.lost.borrow() {
            return Err(Failure::Lost(lost.clone()).into());
        }
        self.link.borrow_mut().exchange(request, &self.log).unwrap_or_else(|lost| {
            *self.lost.borrow_mut() = Some(lost.clone());
            Err(Failure::Lost(lost).into())
        })
    }

    /// As [`ask`](Self::ask), of no variable or of one alone.
    fn ask_one(&self, request: &Request) -> Result<Reply, Failure> {
        self.ask(request).map_err(|refusal| refusal.failure)
    }

    /// As [`ask`](Self::ask), where nothing but success is the answer.
    fn tell(&self, request: &Request) -> Result<(), Failure> {
        match self.ask_one(request)? {
            Reply::Done => Ok(()),
            _ => Err(self.garbled()),
        }
    }

    /// As [`ask`](Self::ask), where a state is the answer.
    fn ask_state(&self, request: &Request) -> Result<*mut c_void, Failure> {
        match self.ask_one(request)? {
            // Nobody here looks where it points.
            Reply::State(address) => Ok(std::ptr::without_provenance_mut(address as usize)),
            _ => Err(self.garbled()),
        }
    }

    /// A call after which nobody asks how it went: what goes wrong is logged.
    fn tell_at_the_end(&self, request: &Request, action: &str) -> Result<(), Failure> {
        let was_there = self.lost.borrow().is_none();
        let done = self.tell(request);
        if let (true, Err(Failure::Lost(lost))) = (was_there, &done) {
            self.log.receive(Status::Fatal, String::new(), format!("{action}: {lost}"));
        }
        done
    }

    /// It is not asked any more.
    fn garbled(&self) -> Failure {
        let lost = self.link.borrow_mut().end(Lost::Garbled);
        *self.lost.borrow_mut() = Some(lost.clone());
        Failure::Lost(lost)
    }
}

fn address(state: *mut c_void) -> u64 {
    state.addr() as u64
}

impl Slave for Remote {
    fn get(&self, kind: VariableType, reference: u32) -> Result<Value, Failure> {
        match self.ask_one(&Request::Get(vec![(kind, reference)]))? {
            Reply::Values(values) if values.len() == 1 => Ok(values[0]),
            _ => Err(self.garbled()),
        }
    }

    fn set(&self, kind: VariableType, reference: u32, value: Value) -> Result<(), Failure> {
        self.tell(&Request::Set(vec![(kind, reference, value)]))
    }

    fn get_all(&self, variables: &[Variable], values: &mut [Value]) -> Result<(), (usize, Failure)> {
        let pairs = variables.iter().map(|variable| (variable.kind, variable.reference)).collect();
        match self.ask(&Request::Get(pairs)) {
            Ok(Reply::Values(found)) if found.len() == values.len() => {
                values.copy_from_slice(&found);
                Ok(())
            }
            Ok(_) => Err((0, self.garbled())),
            Err(refusal) => Err(of_one(refusal, variables)),
        }
    }

    fn set_all(&self, variables: &[Variable], values: &[Value]) -> Result<(), (usize, Failure)> {
        let pairs = variables.iter().zip(values);
        let list = pairs.map(|(variable, value)| (variable.kind, variable.reference, *value)).collect();
        match self.ask(&Request::Set(list)) {
            Ok(Reply::Done) => Ok(()),
            Ok(_) => Err((0, self.garbled())),
            Err(refusal) => Err(of_one(refusal, variables)),
        }
    }

    fn set_logging(&self, on: bool) -> Result<(), Failure> {
        self.tell(&Request::SetLogging(on))
    }

    fn enter_initialization(&self, start: f64, stop: Option<f64>) -> Result<(), Failure> {
        self.tell(&Request::EnterInitialization(start, stop))
    }

    fn exit_initialization(&self) -> Result<(), Failure> {
        self.tell(&Request::ExitInitialization)
    }

    fn do_step(&self, time: f64, step: f64) -> Result<(), Failure> {
        self.tell(&Request::DoStep(time, step))
    }

    fn terminate(&self) -> Result<(), Failure> {
        self.tell_at_the_end(&Request::Terminate, "terminating")
    }

    fn get_state(&self) -> Result<*mut c_void, Failure> {
        self.ask_state(&Request::GetState)
    }

    fn set_state(&self, state: *mut c_void) -> Result<(), Failure> {
        self.tell(&Request::SetState(address(state)))
    }

    fn free_state(&self, state: *mut c_void) {
        let _ = self.tell_at_the_end(&Request::FreeState(address(state)), "freeing a state");
    }

    fn serialize(&self, state: *mut c_void) -> Result<Vec<u8>, Failure> {
        match self.ask_one(&Request::Serialize(address(state)))? {
            Reply::Bytes(bytes) => Ok(bytes),
            _ => Err(self.garbled()),
        }
    }

    fn deserialize(&self, bytes: &[u8]) -> Result<*mut c_void, Failure> {
        self.ask_state(&Request::Deserialize(bytes.to_vec()))
    }
}

/// The index was sent by the other process.
fn of_one(refusal: Refusal, variables: &[Variable]) -> (usize, Failure) {
    ((refusal.index as usize).min(variables.len().saturating_sub(1)), refusal.failure)
}

impl Drop for Remote {
    fn drop(&mut self) {
        let _ = self.tell_at_the_end(&Request::Free, "freeing");
        let _ = self.link.borrow_mut().ended();
    }
}

/// The process and the socket to it.
struct Link {
    child: Child,
    socket: UnixStream,
    worker: Worker,
    /// Ends when all is shown that the process printed.
    prints: Receiver<()>,
    /// What came and is not read yet.
    inbox: Vec<u8>,
    outbox: Vec<u8>,
}

impl Link {
    fn open(worker: &Worker) -> io::Result<Self> {
        let (socket, theirs) = UnixStream::pair()?;
        socket.set_read_timeout(Some(PATIENCE))?;
        socket.set_write_timeout(Some(PATIENCE))?;
        let (prints, printer) = io::pipe()?;
        // The command goes, and with it this process's end of the pipe.
        let child = Command::new(&worker.program)
            .args(&worker.arguments)
            .stdin(OwnedFd::from(theirs))
            .stdout(printer.try_clone()?)
            .stderr(printer)
            // Ctrl-C is for this process alone.
            .process_group(0)
            .spawn()?;
        let prints = show_prints(prints, Arc::clone(&worker.show));
        Ok(Self { child, socket, worker: worker.clone(), prints, inbox: vec![], outbox: vec![] })
    }

    fn exchange<T: serde::Serialize>(
        &mut self,
        request: &T,
        log: &LogSink,
    ) -> Result<Result<Reply, Refusal>, Lost> {
        let begun = Instant::now();
        if frame(request, &mut self.outbox).is_err() {
            return Err(self.end(Lost::Garbled));
        }
        self.send(begun)?;
        loop {
            match self.message(begun)? {
                Message::Log(status, category, text) => log.receive(status, category, text),
                Message::Answer(answer) => return Ok(answer),
            }
        }
    }

    fn send(&mut self, begun: Instant) -> Result<(), Lost> {
        let mut sent = 0;
        while sent < self.outbox.len() {
            match self.socket.write(&self.outbox[sent..]) {
                Ok(count) => sent += count,
                Err(error) => self.wait_on(begun, &error)?,
            }
        }
        Ok(())
    }

    /// The next message, waited for.
    fn message(&mut self, begun: Instant) -> Result<Message, Lost> {
        let mut chunk = [0; 1 << 14];
        loop {
            if let Some(end) = self.whole_frame()? {
                let message = postcard::from_bytes(&self.inbox[HEAD..end]);
                self.inbox.drain(..end);
                return message.map_err(|_| self.end(Lost::Garbled));
            }
            match self.socket.read(&mut chunk) {
                Ok(0) => return Err(self.ended()),
                Ok(count) => self.inbox.extend_from_slice(&chunk[..count]),
                Err(error) => self.wait_on(begun, &error)?,
            }
            self.go_on(begun)?;
        }
    }

    /// Where the first frame of the inbox ends, if it is all there.
    fn whole_frame(&mut self) -> Result<Option<usize>, Lost> {
        let Some(head) = self.inbox.first_chunk::<HEAD>() else { return Ok(None) };
        let Some(length) = length(*head) else { return Err(self.end(Lost::Garbled)) };
        Ok(Some(HEAD + length).filter(|end| *end <= self.inbox.len()))
    }

    /// Nothing could be sent or read just now: whether to go on.
    fn wait_on(&mut self, begun: Instant, error: &io::Error) -> Result<(), Lost> {
        if !matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted) {
            return Err(self.ended());
        }
        // A process that it has started may hold the socket open.
        if let Ok(Some(status)) = self.child.try_wait() {
            return Err(self.heard_out(Lost::Ended(status)));
        }
        self.go_on(begun)
    }

    /// Whether a call that has lasted so long may go on.
    fn go_on(&mut self, begun: Instant) -> Result<(), Lost> {
        let lasted = begun.elapsed();
        if lasted > self.worker.limit {
            return Err(self.end(Lost::Silent(self.worker.limit)));
        }
        if lasted > PATIENCE && (self.worker.stop)() { Err(self.end(Lost::Stopped)) } else { Ok(()) }
    }

    /// Kills the process.
    fn end(&mut self, lost: Lost) -> Lost {
        let _ = self.child.kill();
        let _ = self.child.wait();
        self.heard_out(lost)
    }

    /// Waits until all is shown that the process printed, unless another one that it has started can still print.
    fn heard_out(&self, lost: Lost) -> Lost {
        let _ = self.prints.recv_timeout(LAST_WORDS);
        lost
    }

    /// Waits for the end of a process that closed its socket, or has nothing more to do.
    fn ended(&mut self) -> Lost {
        let begun = Instant::now();
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) => return self.heard_out(Lost::Ended(status)),
                Ok(None) if begun.elapsed() < LAST_WORDS => thread::sleep(Duration::from_millis(1)),
                _ => return self.end(Lost::Garbled),
            }
        }
    }
}

/// Hands on what comes through the pipe, until it ends; what is returned ends then, too.
fn show_prints(prints: PipeReader, show: Show) -> Receiver<()> {
    let (end, ended) = channel();
    thread::spawn(move || {
        let (mut prints, mut line) = (BufReader::new(prints), vec![]);
        let mut next = |line: &mut Vec<u8>| prints.by_ref().take(LONGEST_PRINT).read_until(b'\n', line);
        while next(&mut line).is_ok_and(|count| count > 0) {
            show(&String::from_utf8_lossy(&line));
            line.clear();
        }
        drop(end);
    });
    ended
}
