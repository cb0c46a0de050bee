//! What the process of an FMU does: it loads one library, makes one instance of it, and does what it is asked to do.

use std::ffi::c_void;
use std::fs::File;
use std::io::{self, BufReader, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::rc::Rc;
use std::sync::{Arc, Mutex, PoisonError};

use super::fmu::{Library, instantiate};
use super::log::LogSink;
use super::slave::{Failure, Slave};
use super::wire::{Message, Refusal, Reply, Request, Start, frame, receive};
use super::{Value, VariableType};

/// Serves the process that started this one with [`Fmu::open_apart`](super::Fmu::open_apart), until that has enough or is no more: all that the
/// `main` of a [`Worker`](super::Worker) has to do. The FMU reads an empty stdin; what it prints goes to the process that started this one.
///
/// # Errors
/// Stdin is no socket: nobody started this as a worker; or what comes is no request.
pub fn serve() -> io::Result<()> {
    let socket = take_over_stdin()?;
    let answers = Arc::new(Answers { socket: socket.try_clone()?.into() });
    let mut requests = BufReader::new(socket);
    let Some(start) = receive::<Start>(&mut requests)? else { return Ok(()) };
    let heard = Arc::clone(&answers);
    let log = LogSink::new(
        &start.name,
        Box::new(move |message| {
            // Whoever does not listen any more has killed this process, or will.
            let _ = heard.send(&Message::Log(message.status, message.category.clone(), message.text.clone()));
        }),
    );
    let slave = match begin(&start, Arc::new(log)) {
        Ok(slave) => slave,
        Err(failure) => return answers.send(&Message::Answer(Err(failure.into()))),
    };
    answers.send(&Message::Answer(Ok(Reply::Done)))?;
    while let Some(request) = receive(&mut requests)? {
        if matches!(request, Request::Free) {
            drop(slave);
            return answers.send(&Message::Answer(Ok(Reply::Done)));
        }
        answers.send(&Message::Answer(answer(&*slave, request)))?;
    }
    Ok(())
}

/// The socket that stdin is, out of the FMU's way.
fn take_over_stdin() -> io::Result<UnixStream> {
    #[cfg(target_os = "linux")]
    rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL))?;
    let socket: OwnedFd = io::stdin().as_fd().try_clone_to_owned()?;
    rustix::stdio::dup2_stdin(File::open("/dev/null")?)?;
    let socket = UnixStream::from(socket);
    socket.peer_addr().map_err(|_| io::Error::other("stdin is no socket: other programs start this one"))?;
    Ok(socket)
}

/// Messages may come from any thread of the FMU.
struct Answers {
    socket: Mutex<UnixStream>,
}

impl Answers {
    fn send(&self, message: &Message) -> io::Result<()> {
        let mut bytes = vec![];
        frame(message, &mut bytes)?;
        self.socket.lock().unwrap_or_else(PoisonError::into_inner).write_all(&bytes)
    }
}

fn begin(start: &Start, log: Arc<LogSink>) -> Result<Rc<dyn Slave>, Failure> {
    let library = Library::load(start.version, Path::new(&start.library)).map_err(Failure::Library)?;
    instantiate(&library, &start.name, &start.token, Path::new(&start.resources), log)
}

fn answer(slave: &dyn Slave, request: Request) -> Result<Reply, Refusal> {
    // An address comes from here, and goes to its own instance.
    let state = |address: u64| std::ptr::with_exposed_provenance_mut(address as usize);
    let address = |state: *mut c_void| Reply::State(state.expose_provenance() as u64);
    let done = |()| Reply::Done;
    let reply = match request {
        Request::Get(variables) => return get(slave, &variables),
        Request::Set(values) => return set(slave, &values),
        Request::SetLogging(on) => slave.set_logging(on).map(done),
        Request::EnterInitialization(begin, end) => slave.enter_initialization(begin, end).map(done),
        Request::ExitInitialization => slave.exit_initialization().map(done),
        Request::DoStep(time, step) => slave.do_step(time, step).map(done),
        Request::Terminate => slave.terminate().map(done),
        Request::GetState => slave.get_state().map(address),
        Request::SetState(at) => slave.set_state(state(at)).map(done),
        Request::FreeState(at) => {
            slave.free_state(state(at));
            Ok(Reply::Done)
        }
        Request::Serialize(at) => slave.serialize(state(at)).map(Reply::Bytes),
        Request::Deserialize(bytes) => slave.deserialize(&bytes).map(address),
        Request::Free => Ok(Reply::Done),
    };
    Ok(reply?)
}

fn get(slave: &dyn Slave, variables: &[(VariableType, u32)]) -> Result<Reply, Refusal> {
    let values = variables.iter().zip(0..).map(|((kind, reference), index)| {
        slave.get(*kind, *reference).map_err(|failure| Refusal { index, failure })
    });
    values.collect::<Result<_, _>>().map(Reply::Values)
}

fn set(slave: &dyn Slave, values: &[(VariableType, u32, Value)]) -> Result<Reply, Refusal> {
    for ((kind, reference, value), index) in values.iter().zip(0..) {
        slave.set(*kind, *reference, *value).map_err(|failure| Refusal { index, failure })?;
    }
    Ok(Reply::Done)
}
