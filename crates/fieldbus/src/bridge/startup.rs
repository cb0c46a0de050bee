//! Setting up one node: its boot-up, then one object after the other, each read back.

mod script;

use super::fault::Fault;
use crate::Nanoseconds;
use crate::canopen::eds::Use;
use crate::canopen::{NmtCommand, NmtState, Node, Object, SdoRequest, SdoResponse, SdoResult};
use crate::config::{Config, Timeouts};
use crate::frame::Frame;
use script::{DEVICE_TYPE, Kind, Step};

/// Vendor, product, revision and serial number (0x1018), as far as a node says them.
pub type Identity = [Option<u32>; 4];

/// How often an unanswered question is asked.
const TRIES: u32 = 3;
/// Boot-up messages of a node while it is set up: some say it twice, after the reset and when their application is up. More are a fault.
const MOST_BOOTS: u32 = 3;

/// Where the node is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Reset, no boot-up message yet.
    Booting,
    Writing,
    Reading,
    /// Told to start, no heartbeat of Operational yet.
    Starting,
    Done,
}

/// One node on its way to Operational.
#[derive(Clone, Debug)]
pub(super) struct Startup {
    node: Node,
    script: Vec<Step>,
    phase: Phase,
    at: usize,
    /// When the question that is open was asked, and how often.
    asked: Option<Nanoseconds>,
    tries: u32,
    boots: u32,
    identity: Identity,
    /// When the phase began, or the first reading of what is awaited.
    since: Nanoseconds,
}

impl Startup {
    /// Of a drive.
    pub fn drive(config: &Config, cable: usize) -> Self {
        Self::new(config.drives[cable].node, script::of_drive(config, cable))
    }

    /// Of the node of a load cell, with all of its cells.
    pub fn load_cell(config: &Config, node: Node) -> Self {
        Self::new(node, script::of_load_cell(config, node))
    }

    /// What is asked of the node's objects. What it may go without is not.
    pub fn needs(&self) -> Vec<(Object, Use)> {
        script::needs(&self.script)
    }

    fn new(node: Node, script: Vec<Step>) -> Self {
        Self {
            node,
            script,
            phase: Phase::Booting,
            at: 0,
            asked: None,
            tries: 0,
            boots: 0,
            identity: Identity::default(),
            since: 0,
        }
    }

    /// From the beginning.
    pub fn restart(&mut self, now: Nanoseconds) {
        self.enter(Phase::Booting, now);
        (self.at, self.boots) = (0, 0);
    }

    /// Operational, as set up.
    pub fn is_done(&self) -> bool {
        self.phase == Phase::Done
    }

    /// Who it says it is, once it is set up.
    pub fn identity(&self) -> Identity {
        self.identity
    }

    fn enter(&mut self, phase: Phase, now: Nanoseconds) {
        (self.phase, self.asked, self.tries, self.since) = (phase, None, 0, now);
    }

    /// What to send now, if anything.
    pub fn next(&mut self, now: Nanoseconds, timeouts: &Timeouts) -> Result<Option<Frame>, Fault> {
        match self.phase {
            Phase::Done => Ok(None),
            Phase::Booting => self.command(NmtCommand::ResetCommunication, now, timeouts),
            Phase::Starting => self.command(NmtCommand::Start, now, timeouts),
            Phase::Writing | Phase::Reading => self.ask(now, timeouts),
        }
    }

    /// A command whose effect is seen in a heartbeat. At each third of the time allowed a start is given again. A reset is not, which would keep a node that boots
    /// slowly from ever ending: a question is asked, and who can answer does not boot.
    fn command(
        &mut self,
        command: NmtCommand,
        now: Nanoseconds,
        timeouts: &Timeouts,
    ) -> Result<Option<Frame>, Fault> {
        if now.saturating_sub(self.since) > timeouts.boot {
            let node = self.node;
            return Err(match command {
                NmtCommand::Start => Fault::NotOperational { node, state: NmtState::PreOperational },
                _ => Fault::NoBoot { node },
            });
        }
        let is_first = self.asked.is_none();
        if self.asked.is_some_and(|asked| now.saturating_sub(asked) <= timeouts.boot / 3) {
            return Ok(None);
        }
        self.asked = Some(now);
        Ok(Some(if is_first || command == NmtCommand::Start {
            command.frame(Some(self.node))
        } else {
            SdoRequest::Read(DEVICE_TYPE).frame(self.node)
        }))
    }

    fn ask(&mut self, now: Nanoseconds, timeouts: &Timeouts) -> Result<Option<Frame>, Fault> {
        let Step { object, value, .. } = self.script[self.at];
        if let Some(asked) = self.asked {
            if now.saturating_sub(asked) <= timeouts.service {
                return Ok(None);
            }
            if self.tries == TRIES {
                return Err(Fault::NoAnswer { node: self.node, object });
            }
        }
        self.asked = Some(now);
        self.tries += 1;
        let request = if self.phase == Phase::Writing {
            SdoRequest::Write(object, value)
        } else {
            SdoRequest::Read(object)
        };
        Ok(Some(request.frame(self.node)))
    }

    /// Takes in a heartbeat.
    pub fn on_heartbeat(&mut self, state: NmtState, now: Nanoseconds) -> Result<(), Fault> {
        match (self.phase, state) {
            // Before it was reset.
            (Phase::Booting, NmtState::BootUp) if self.asked.is_none() => Ok(()),
            (_, NmtState::BootUp) if self.boots < MOST_BOOTS => {
                (self.at, self.boots) = (0, self.boots + 1);
                self.begin_step(now);
                Ok(())
            }
            (Phase::Starting, NmtState::Operational) => {
                self.enter(Phase::Done, now);
                Ok(())
            }
            (Phase::Booting, _)
            | (_, NmtState::PreOperational | NmtState::Stopped | NmtState::Operational) => Ok(()),
            (_, NmtState::BootUp) => Err(Fault::Rebooted { node: self.node }),
        }
    }

    fn next_step(&mut self, now: Nanoseconds) {
        self.at += 1;
        self.begin_step(now);
    }

    fn begin_step(&mut self, now: Nanoseconds) {
        let phase = match self.script.get(self.at).map(|step| step.kind) {
            None => Phase::Starting,
            Some(Kind::Write | Kind::Offer) => Phase::Writing,
            Some(Kind::Check | Kind::Await | Kind::Note) => Phase::Reading,
        };
        self.enter(phase, now);
    }

    /// Takes in an answer. One to an older question is passed over.
    pub fn on_response(
        &mut self,
        response: &SdoResponse,
        now: Nanoseconds,
        timeouts: &Timeouts,
    ) -> Result<(), Fault> {
        if self.phase == Phase::Booting {
            // It was not reset, or its boot-up message was lost.
            self.asked = None;
            return Ok(());
        }
        let Some(step) = self.script.get(self.at).copied() else { return Ok(()) };
        if self.asked.is_none() || response.object != step.object {
            return Ok(());
        }
        match (self.phase, response.result) {
            (Phase::Writing, SdoResult::Aborted(_)) if step.kind == Kind::Offer => {
                self.next_step(now);
                Ok(())
            }
            (Phase::Reading, SdoResult::Aborted(_) | SdoResult::Segmented(_)) if step.kind == Kind::Note => {
                self.next_step(now);
                Ok(())
            }
            (Phase::Writing | Phase::Reading, SdoResult::Aborted(code)) => {
                Err(Fault::Refused { node: self.node, object: step.object, code })
            }
            (Phase::Reading, SdoResult::Segmented(bytes)) => {
                Err(Fault::TooLong { node: self.node, object: step.object, bytes })
            }
            (Phase::Writing, SdoResult::Written) => {
                self.enter(Phase::Reading, now);
                Ok(())
            }
            (Phase::Reading, SdoResult::Value(found)) => self.compare(&step, found.bits, now, timeouts),
            (Phase::Reading, SdoResult::Unsized(bytes)) => {
                self.compare(&step, step.value.width.read(bytes), now, timeouts)
            }
            _ => Ok(()),
        }
    }

    fn compare(
        &mut self,
        step: &Step,
        found: u32,
        now: Nanoseconds,
        timeouts: &Timeouts,
    ) -> Result<(), Fault> {
        if step.kind == Kind::Note {
            self.identity[usize::from(step.object.subindex) - 1] = Some(found);
            self.next_step(now);
            return Ok(());
        }
        let expected = step.value.bits;
        if (found ^ expected) & step.mask == 0 {
            self.next_step(now);
            return Ok(());
        }
        match step.kind {
            Kind::Await if now.saturating_sub(self.since) <= timeouts.drive => {
                (self.asked, self.tries) = (None, 0);
                Ok(())
            }
            // Some drives show their mode only once they are enabled; then it is asked for again.
            Kind::Await if found == 0 => {
                self.next_step(now);
                Ok(())
            }
            Kind::Await => Err(Fault::ModeRefused { node: self.node, found: found as i8 }),
            Kind::Write | Kind::Offer | Kind::Check | Kind::Note => {
                Err(Fault::Different { node: self.node, object: step.object, expected, found })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::script::IDENTITY;
    use super::*;
    use crate::canopen::Value;
    use crate::cia402::{MAX_TORQUE, MODE, MODE_DISPLAY};
    use crate::config::tests::{AKD, parse};

    const MS: u64 = 1_000_000;

    fn startup() -> (Startup, Timeouts) {
        let config = parse(AKD).unwrap();
        (Startup::drive(&config, 0), config.timeouts)
    }

    /// A node that stores what it is told, but for `answer`.
    fn run(answer: impl Fn(SdoRequest) -> Option<SdoResult>) -> Result<(Vec<SdoRequest>, u64), Fault> {
        let (mut startup, timeouts) = startup();
        let (mut asked, mut stored) = (vec![], vec![(Object::new(0x1000, 0), Value::u32(0x0002_0192))]);
        stored.push((Object::new(0x6076, 0), Value::u32(1000)));
        (1..=4).for_each(|part| stored.push((Object::new(IDENTITY, part), Value::u32(part.into()))));
        for k in 0..100_000 {
            let now = k * 4 * MS;
            let Some(frame) = startup.next(now, &timeouts)? else {
                if startup.is_done() {
                    return Ok((asked, now));
                }
                continue;
            };
            match NmtCommand::parse(&frame) {
                Some((NmtCommand::ResetCommunication, Some(1))) => {
                    startup.on_heartbeat(NmtState::BootUp, now)?
                }
                Some((NmtCommand::Start, Some(1))) => startup.on_heartbeat(NmtState::Operational, now)?,
                _ => {
                    let (_, request) = SdoRequest::parse(&frame).unwrap();
                    let request = request.unwrap();
                    asked.push(request);
                    let plain = match request {
                        SdoRequest::Write(object, value) => {
                            stored.retain(|(o, _)| *o != object);
                            stored.push((object, value));
                            if object == MODE {
                                stored.push((MODE_DISPLAY, value));
                            }
                            Some(SdoResult::Written)
                        }
                        SdoRequest::Read(object) => {
                            stored.iter().rev().find(|(o, _)| *o == object).map(|(_, v)| SdoResult::Value(*v))
                        }
                    };
                    if let Some(result) = answer(request).or(plain) {
                        startup.on_response(
                            &SdoResponse { object: request.object(), result },
                            now,
                            &timeouts,
                        )?;
                    }
                }
            }
        }
        unreachable!("a fault ends every wait")
    }

    #[test]
    fn a_drive_is_set_up_and_every_setting_is_read_back() {
        let (asked, _) = run(|_| None).unwrap();
        let writes: Vec<_> = asked.iter().filter(|r| matches!(r, SdoRequest::Write(..))).collect();
        assert_eq!(writes.len(), 2 + 7 + 1 + 8 + 1 + 1 + 1);
        for write in &writes {
            let place = asked.iter().position(|r| r == *write).unwrap();
            assert_eq!(asked[place + 1], SdoRequest::Read(write.object()));
        }
        assert_eq!(asked.last(), Some(&SdoRequest::Read(MODE_DISPLAY)));
        assert!(writes.contains(&&SdoRequest::Write(Object::new(0x1400, 1), Value::u32(0x201))));
        assert!(writes.contains(&&SdoRequest::Write(Object::new(0x1400, 5), Value::u16(100))));
    }

    #[test]
    fn a_drive_without_a_deadline_for_torque_frames_goes_without() {
        let deadline = Object::new(0x1400, 5);
        let refuses = |r: SdoRequest| (r.object() == deadline).then_some(SdoResult::Aborted(0x0609_0011));
        let (asked, _) = run(refuses).unwrap();
        assert!(
            !asked.contains(&SdoRequest::Read(deadline))
                && asked.last() == Some(&SdoRequest::Read(MODE_DISPLAY))
        );
    }

    #[test]
    fn refusals_differences_and_silence_end_it_with_their_object() {
        let refused =
            run(|r| (r.object() == MAX_TORQUE).then_some(SdoResult::Aborted(0x0609_0031))).unwrap_err();
        assert_eq!(refused, Fault::Refused { node: 1, object: MAX_TORQUE, code: 0x0609_0031 });
        let rated = Object::new(0x6076, 0);
        let different =
            run(|r| (r.object() == rated).then_some(SdoResult::Value(Value::u32(500)))).unwrap_err();
        assert_eq!(different, Fault::Different { node: 1, object: rated, expected: 1000, found: 500 });
        let written_only = run(|r| match r {
            SdoRequest::Read(object) if object == MODE => Some(SdoResult::Value(Value::u8(8))),
            _ => None,
        });
        assert!(matches!(written_only.unwrap_err(), Fault::Different { object: MODE, .. }));
    }

    /// It was said to be refused: "command specifier not valid or unknown".
    #[test]
    fn an_answer_in_segments_is_no_refusal_and_is_called_what_it_is() {
        let rated = Object::new(0x6076, 0);
        let long =
            run(|r| (r == SdoRequest::Read(rated)).then_some(SdoResult::Segmented(Some(9)))).unwrap_err();
        assert_eq!(long, Fault::TooLong { node: 1, object: rated, bytes: Some(9) });
        let said = "node 1 answers for object 0x6076:0 with 9 bytes in segments; of an object that is read here there are at most 4";
        assert_eq!(long.to_string(), said);
    }

    #[test]
    fn what_stands_behind_a_value_without_a_size_is_not_compared() {
        let rated = Object::new(0x605A, 0);
        let odd = SdoResult::Unsized([2, 0, 0xAA, 0xBB]);
        assert!(run(|r| (r == SdoRequest::Read(rated)).then_some(odd)).is_ok());
    }

    #[test]
    fn a_mode_that_is_not_shown_is_refused_after_its_time() {
        let refused =
            run(|r| (r == SdoRequest::Read(MODE_DISPLAY)).then_some(SdoResult::Value(Value::u8(8))));
        assert_eq!(refused.unwrap_err(), Fault::ModeRefused { node: 1, found: 8 });
    }

    #[test]
    fn an_answer_that_is_lost_twice_is_asked_for_again() {
        let count = std::cell::Cell::new(0);
        let (mut startup, timeouts) = startup();
        startup.next(0, &timeouts).unwrap();
        startup.on_heartbeat(NmtState::BootUp, 0).unwrap();
        let mut now = 0;
        let fault = loop {
            now += 4 * MS;
            match startup.next(now, &timeouts) {
                Ok(Some(_)) => count.set(count.get() + 1),
                Ok(None) => {}
                Err(fault) => break fault,
            }
        };
        assert_eq!((count.get(), fault), (3, Fault::NoAnswer { node: 1, object: Object::new(0x1000, 0) }));
        assert!((1500 * MS..1700 * MS).contains(&now), "{now}");
    }

    #[test]
    fn a_node_that_never_boots_or_boots_again_and_again_is_a_fault() {
        let (mut startup, timeouts) = startup();
        let fault = (0..).find_map(|k| startup.next(k * 100 * MS, &timeouts).err()).unwrap();
        assert_eq!(fault, Fault::NoBoot { node: 1 });
        startup.restart(0);
        startup.next(0, &timeouts).unwrap();
        for k in 0..MOST_BOOTS {
            assert_eq!(startup.on_heartbeat(NmtState::BootUp, k.into()), Ok(()));
            startup.next(1, &timeouts).unwrap();
        }
        assert_eq!(startup.on_heartbeat(NmtState::BootUp, 9), Err(Fault::Rebooted { node: 1 }));
    }

    #[test]
    fn a_node_is_reset_again_only_if_it_can_answer() {
        let (mut startup, timeouts) = startup();
        let sent = |startup: &mut Startup, now| NmtCommand::parse(&startup.next(now, &timeouts).unwrap()?);
        assert!(sent(&mut startup, 0).is_some());
        assert_eq!(sent(&mut startup, timeouts.boot / 2), None, "a question");
        assert_eq!(sent(&mut startup, timeouts.boot / 2 + 1), None);
        let result = SdoResult::Value(Value::u32(0));
        startup.on_response(&SdoResponse { object: DEVICE_TYPE, result }, 0, &timeouts).unwrap();
        assert!(sent(&mut startup, timeouts.boot / 2 + 2).is_some());
    }
}
