//! What goes wrong at the simulated rig, as one writes it: `at 2.0 lose 5%`, `lifted 0.4 cell 4 stuck`.

use cable_robot::robot::Pose;
use thiserror::Error;

use super::{CellFault, Link, LinkFaults, SimulatedRig};
use crate::Nanoseconds;
use crate::canopen::{NmtCommand, NmtState, Object};
use crate::frame::Frame;

/// The grammar, for people.
pub const GRAMMAR: &str = "\
lose 5%                        of the frames, each way
lose 0x203                     no frame with this identifier arrives
double 20%                     of the frames arrive twice
delay 15                       ms that every frame takes, each way
cut                            nothing passes
hang-up                        for good; rig-sim closes its end of the link
mend                           the link is well again
drive N emcy 0x2310            goes into Fault, with this emergency message
drive N fault                  goes into Fault, without a message
drive N reboot                 starts again by itself
drive N boots-late 4000         boots so many ms later
drive N boots-twice            says twice that it has
drive N hides-mode             shows its mode in Operation enabled only
drive N stopped                somebody sends it NMT stop
drive N silent                 sends no process data
drive N no-heartbeat           sends no heartbeat
drive N dead                   says and hears nothing
drive N frozen                 its encoder's value stays what it is
drive N jumps 20000            its encoder's value is off by so many counts
drive N counts-backwards       its encoder counts against its torque
drive N mode 8                 leaves its mode of operation for this one, and pulls nothing
drive N ignores-torque         goes on with the torque that it has, and says so (status bit 12)
drive N limited                an internal limit holds back half of its torque, and it says so (status bit 11)
drive N local                  obeys somebody else, and says so (status bit 9)
drive N blocked                its hardware enable is taken away: falls to Switched on
drive N ignores-watchdog       pulls on when nobody commands it any more
drive N leaves-operational     goes to Pre-operational when nobody commands it any more, as CiA 301 has it (0x1029)
drive N stops-itself           goes to Stopped then, and answers no question
drive N boots-anew             boots anew then
drive N slow-stage 100         its power stage takes so many ms to switch on, and as many to enable
drive N refuses-mode           never shows mode 10
drive N refuses 0x6072 0x06090031  to have an object (0x6072, 0x1400:5) written, with this abort code
cell N silent                  sends no process data
cell N dead                    says and hears nothing
cable N slack 12               mm of it, from now on; a slack cable's winch turns freely
place 0.1 0.2 0.8 0 0 0.1      a person puts the platform, if it stands, on blocks at this pose (m, rad)
cell N stuck                   its reading stays what it is
cell N says 100                N; also nan, inf
drive N well, cell N well      as before; what has failed stays failed
N: cable, from 1. In front of each: `at 2.0`, s after the start; `lifted 0.4`, s after the cables lifted the platform off its stand.";

/// Something that goes wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mishap {
    /// Share of the frames lost.
    Lose(f64),
    /// No frame with this identifier arrives.
    LoseId(u16),
    /// Share of the frames doubled.
    Double(f64),
    /// Frames take so long, each way.
    Delay(Nanoseconds),
    /// Nothing passes.
    Cut,
    /// The same for good, and the other end is told.
    HangUp,
    /// The link is well again.
    Mend,
    /// At the drive of a cable (from 0).
    Drive(usize, DriveMishap),
    /// At the load cell of a cable (from 0).
    Cell(usize, CellMishap),
    /// A cable (from 0) has so much slack, m.
    Slack(usize, f64),
    /// The platform is put on blocks at this pose.
    Place(Pose),
}

/// What goes wrong at a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the grammar says it")]
pub enum DriveMishap {
    Emergency(u16),
    Fault,
    Reboot,
    BootsLate(Nanoseconds),
    BootsTwice,
    HidesMode,
    Stopped,
    Silent,
    NoHeartbeat,
    Dead,
    Frozen,
    Jumps(i32),
    CountsBackwards,
    Mode(i8),
    IgnoresTorque,
    Limited,
    Local,
    Blocked,
    IgnoresWatchdog,
    LeavesOperational,
    StopsItself,
    BootsAnew,
    SlowStage(Nanoseconds),
    RefusesMode,
    Refuses(Object, u32),
    Well,
}

/// What goes wrong at a load cell.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the grammar says it")]
pub enum CellMishap {
    Silent,
    Dead,
    Stuck,
    Says(f64),
    Well,
}

/// When.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moment {
    /// As soon as it is read.
    Now,
    /// So long after the start.
    At(Nanoseconds),
    /// So long after the cables lifted the platform.
    Lifted(Nanoseconds),
}

/// A line that is none of the grammar.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0:?} is not understood; known are\n{GRAMMAR}")]
pub struct NotUnderstood(String);

impl Mishap {
    /// Reads the words of a mishap at a rig of so many cables.
    ///
    /// # Errors
    /// [`NotUnderstood`].
    pub fn parse(text: &str, cables: usize) -> Result<Self, NotUnderstood> {
        let words: Vec<_> = text.split_whitespace().collect();
        mishap(&words, cables).ok_or_else(|| NotUnderstood(text.to_owned()))
    }
}

fn mishap(words: &[&str], cables: usize) -> Option<Mishap> {
    let cable = |number: &str| cable(number, cables);
    Some(match *words {
        ["lose", id] if id.starts_with("0x") => Mishap::LoseId(hexadecimal(id)?.try_into().ok()?),
        ["lose", share] => Mishap::Lose(percent(share)?),
        ["delay", time] => Mishap::Delay((milli(time)? * 1e9) as Nanoseconds),
        ["double", share] => Mishap::Double(percent(share)?),
        ["cut"] => Mishap::Cut,
        ["hang-up"] => Mishap::HangUp,
        ["mend"] => Mishap::Mend,
        ["drive", number, ref what @ ..] => Mishap::Drive(cable(number)?, drive_mishap(what)?),
        ["cell", number, ref what @ ..] => Mishap::Cell(cable(number)?, cell_mishap(what)?),
        ["place", ref numbers @ ..] => Mishap::Place(pose(numbers)?),
        ["cable", number, "slack", length] => Mishap::Slack(cable(number)?, milli(length)?),
        _ => return None,
    })
}

fn drive_mishap(words: &[&str]) -> Option<DriveMishap> {
    Some(match *words {
        ["emcy", code] => DriveMishap::Emergency(hexadecimal(code)?.try_into().ok()?),
        ["fault"] => DriveMishap::Fault,
        ["reboot"] => DriveMishap::Reboot,
        ["boots-late", time] => DriveMishap::BootsLate((milli(time)? * 1e9) as Nanoseconds),
        ["boots-twice"] => DriveMishap::BootsTwice,
        ["hides-mode"] => DriveMishap::HidesMode,
        ["stopped"] => DriveMishap::Stopped,
        ["silent"] => DriveMishap::Silent,
        ["no-heartbeat"] => DriveMishap::NoHeartbeat,
        ["dead"] => DriveMishap::Dead,
        ["frozen"] => DriveMishap::Frozen,
        ["jumps", counts] => DriveMishap::Jumps(counts.parse().ok()?),
        ["counts-backwards"] => DriveMishap::CountsBackwards,
        ["mode", mode] => DriveMishap::Mode(mode.parse().ok()?),
        ["ignores-torque"] => DriveMishap::IgnoresTorque,
        ["limited"] => DriveMishap::Limited,
        ["local"] => DriveMishap::Local,
        ["blocked"] => DriveMishap::Blocked,
        ["ignores-watchdog"] => DriveMishap::IgnoresWatchdog,
        ["leaves-operational"] => DriveMishap::LeavesOperational,
        ["stops-itself"] => DriveMishap::StopsItself,
        ["boots-anew"] => DriveMishap::BootsAnew,
        ["slow-stage", time] => DriveMishap::SlowStage((milli(time)? * 1e9) as Nanoseconds),
        ["refuses-mode"] => DriveMishap::RefusesMode,
        ["refuses", index, code] => DriveMishap::Refuses(object(index)?, hexadecimal(code)?),
        ["well"] => DriveMishap::Well,
        _ => return None,
    })
}

fn cell_mishap(words: &[&str]) -> Option<CellMishap> {
    Some(match *words {
        ["silent"] => CellMishap::Silent,
        ["dead"] => CellMishap::Dead,
        ["stuck"] => CellMishap::Stuck,
        ["says", tension] => CellMishap::Says(tension.parse().ok()?),
        ["well"] => CellMishap::Well,
        _ => return None,
    })
}

/// x y z roll pitch yaw.
fn pose(words: &[&str]) -> Option<Pose> {
    let numbers: Vec<f64> =
        words.iter().filter_map(|word| word.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
    let coordinates: [f64; 6] = numbers.try_into().ok()?;
    (words.len() == 6).then(|| Pose(coordinates.into()))
}

/// A number of thousandths.
fn milli(text: &str) -> Option<f64> {
    let number: f64 = text.parse().ok()?;
    (0.0..=1e6).contains(&number).then_some(1e-3 * number)
}

fn percent(text: &str) -> Option<f64> {
    let percent: f64 = text.strip_suffix('%')?.parse().ok()?;
    (0.0..=100.0).contains(&percent).then_some(percent / 100.0)
}

fn cable(text: &str, cables: usize) -> Option<usize> {
    let number: usize = text.parse().ok()?;
    (1..=cables).contains(&number).then(|| number - 1)
}

/// With its subindex, or 0.
fn object(text: &str) -> Option<Object> {
    let (index, subindex) = text.split_once(':').unwrap_or((text, "0"));
    Some(Object::new(hexadecimal(index)?.try_into().ok()?, subindex.parse().ok()?))
}

fn hexadecimal(text: &str) -> Option<u32> {
    u32::from_str_radix(text.strip_prefix("0x")?, 16).ok()
}

/// What goes wrong when, in a script or from somebody's hand.
#[derive(Clone, Debug)]
pub struct Script {
    cables: usize,
    lines: Vec<(Moment, Mishap, String)>,
}

impl Script {
    /// Nothing goes wrong at a rig of so many cables.
    pub fn new(cables: usize) -> Self {
        Self { cables, lines: vec![] }
    }

    /// Reads one line and keeps it; empty ones and `# comments` say nothing.
    ///
    /// # Errors
    /// [`NotUnderstood`].
    pub fn add(&mut self, line: &str) -> Result<(), NotUnderstood> {
        let text = line.split('#').next().unwrap_or_default();
        let words: Vec<_> = text.split_whitespace().collect();
        let refused = || NotUnderstood(line.to_owned());
        let (moment, what) = match *words {
            [] => return Ok(()),
            ["at", time, ref what @ ..] => (Moment::At(seconds(time).ok_or_else(refused)?), what),
            ["lifted", time, ref what @ ..] => (Moment::Lifted(seconds(time).ok_or_else(refused)?), what),
            _ => (Moment::Now, &words[..]),
        };
        self.lines.push((moment, mishap(what, self.cables).ok_or_else(refused)?, what.join(" ")));
        Ok(())
    }

    /// Takes out what is due at `now`, the cables having lifted the platform at `lifted`, each with its words. In the order of the script.
    pub fn due(&mut self, now: Nanoseconds, lifted: Option<Nanoseconds>) -> Vec<(Mishap, String)> {
        let is_due = |&mut (moment, ..): &mut (Moment, Mishap, String)| match moment {
            Moment::Now => true,
            Moment::At(time) => now >= time,
            Moment::Lifted(time) => lifted.is_some_and(|lifted| now >= lifted + time),
        };
        self.lines.extract_if(.., is_due).map(|(_, mishap, words)| (mishap, words)).collect()
    }
}

fn seconds(text: &str) -> Option<Nanoseconds> {
    let time: f64 = text.parse().ok()?;
    (0.0..1e6).contains(&time).then_some((time * 1e9) as Nanoseconds)
}

impl SimulatedRig {
    /// Lets something go wrong at `now`; what nodes say of it goes to `out`.
    pub fn suffer(
        &mut self,
        mishap: Mishap,
        link: &mut Link,
        now: Nanoseconds,
        out: &mut Vec<(usize, Frame)>,
    ) {
        match mishap {
            Mishap::Lose(loss) => link.faults.loss = loss,
            Mishap::LoseId(id) => link.faults.lost_id = Some(id),
            Mishap::Delay(delay) => link.faults.delay = delay,
            Mishap::Double(duplicates) => link.faults.duplicates = duplicates,
            Mishap::Cut | Mishap::HangUp => link.faults.is_cut = true,
            Mishap::Mend => link.faults = LinkFaults::default(),
            Mishap::Drive(cable, what) => self.suffer_at_drive(cable, what, now, out),
            Mishap::Cell(cable, what) => self.suffer_at_cell(cable, what),
            Mishap::Slack(cable, slack) => self.slacken(cable, slack),
            Mishap::Place(pose) => self.place(pose),
        }
    }

    fn suffer_at_drive(
        &mut self,
        cable: usize,
        what: DriveMishap,
        now: Nanoseconds,
        out: &mut Vec<(usize, Frame)>,
    ) {
        let (drive, bus) = (&mut self.drives[cable], self.config.drives[cable].bus);
        match what {
            DriveMishap::Emergency(code) => {
                let mut sent = vec![];
                drive.fail(code, &mut sent);
                out.extend(sent.into_iter().map(|frame| (bus, frame)));
            }
            DriveMishap::Fault => drive.fail(0, &mut vec![]),
            DriveMishap::Reboot => drive.reboot(now),
            DriveMishap::BootsLate(time) => drive.node.faults.slow = time,
            DriveMishap::BootsTwice => drive.node.faults.boots_twice = true,
            DriveMishap::HidesMode => drive.faults.hides_mode = true,
            DriveMishap::Stopped => {
                let stop = NmtCommand::Stop.frame(Some(drive.node.address()));
                drive.on_frame(&stop, now, &mut vec![]);
            }
            DriveMishap::Silent => drive.faults.is_silent = true,
            DriveMishap::NoHeartbeat => drive.node.faults.no_heartbeat = true,
            DriveMishap::Dead => drive.node.faults.is_dead = true,
            DriveMishap::Frozen => drive.faults.is_encoder_frozen = true,
            DriveMishap::Jumps(counts) => drive.faults.encoder_error = counts,
            DriveMishap::CountsBackwards => drive.faults.counts_backwards = true,
            DriveMishap::Mode(mode) => drive.leave_mode(mode),
            DriveMishap::IgnoresTorque => drive.faults.ignores_torque = true,
            DriveMishap::Limited => drive.faults.is_limited = true,
            DriveMishap::Local => drive.faults.is_local = true,
            DriveMishap::Blocked => drive.faults.is_blocked = true,
            DriveMishap::IgnoresWatchdog => drive.faults.ignores_watchdog = true,
            DriveMishap::LeavesOperational => {
                drive.node.faults.without_master = Some(NmtState::PreOperational);
            }
            DriveMishap::StopsItself => drive.node.faults.without_master = Some(NmtState::Stopped),
            DriveMishap::BootsAnew => drive.faults.boots_without_master = true,
            DriveMishap::SlowStage(time) => drive.faults.slow_stage = time,
            DriveMishap::RefusesMode => drive.faults.refuses_mode = true,
            DriveMishap::Refuses(object, code) => drive.node.faults.refuses = Some((object, code)),
            DriveMishap::Well => (drive.faults, drive.node.faults) = Default::default(),
        }
    }

    fn suffer_at_cell(&mut self, cable: usize, what: CellMishap) {
        for cells in &mut self.cells {
            let Some((_, _, fault)) = cells.cells.iter_mut().find(|(other, ..)| *other == cable) else {
                continue;
            };
            match what {
                CellMishap::Silent => cells.is_silent = true,
                CellMishap::Dead => cells.node.faults.is_dead = true,
                CellMishap::Stuck => *fault = CellFault::Stuck,
                CellMishap::Says(tension) => *fault = CellFault::Says(tension),
                CellMishap::Well => {
                    *fault = CellFault::None;
                    (cells.is_silent, cells.node.faults) = Default::default();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_grammar_is_understood() {
        for line in GRAMMAR.lines().filter(|line| !line.starts_with("N:")) {
            let text = line.split("  ").next().unwrap().replace('N', "2");
            for text in text.split(", ") {
                assert!(Mishap::parse(text, 6).is_ok(), "{text}");
            }
        }
        let parse = |text: &str| Mishap::parse(text, 6).unwrap();
        assert_eq!(parse("lose 5%"), Mishap::Lose(0.05));
        assert_eq!(parse("drive 2 emcy 0x8611"), Mishap::Drive(1, DriveMishap::Emergency(0x8611)));
        let refused = DriveMishap::Refuses(Object::new(0x6072, 0), 0x0609_0031);
        assert_eq!(parse("drive 6 refuses 0x6072 0x06090031"), Mishap::Drive(5, refused));
        assert_eq!(parse("cell 4 says -1e3"), Mishap::Cell(3, CellMishap::Says(-1e3)));
    }

    #[test]
    fn anything_else_is_refused_with_the_grammar() {
        for text in [
            "lose 5",
            "lose 101%",
            "lose 0x10000",
            "delay -1",
            "cable 7 slack 5",
            "drive 2 mode 300",
            "drive 0 dead",
            "cell 7 stuck",
            "drive 2 emcy 8611",
            "drive 2",
            "hang",
        ] {
            let error = Mishap::parse(text, 6).unwrap_err().to_string();
            assert!(error.contains(text) && error.contains("cell N stuck"), "{error}");
        }
        for line in ["at dead", "at -1 cut", "at 1.0", "lifted cut"] {
            assert!(Script::new(6).add(line).is_err(), "{line}");
        }
    }

    #[test]
    fn a_script_is_done_when_it_is_due_and_once() {
        let mut script = Script::new(6);
        for line in ["# a comment", "at 2.0 lose 5%", "lifted 0.4 cut", "", "mend # at once"] {
            script.add(line).unwrap();
        }
        assert_eq!(script.due(0, None), [(Mishap::Mend, "mend".to_owned())]);
        assert_eq!(script.due(1_999_999_999, None), []);
        let lifted = Some(1_700_000_000);
        assert_eq!(script.due(2_000_000_000, lifted), [(Mishap::Lose(0.05), "lose 5%".to_owned())]);
        assert_eq!(script.due(2_100_000_000, lifted), [(Mishap::Cut, "cut".to_owned())]);
        assert_eq!(script.due(9_000_000_000, Some(1_700_000_000)), []);
    }
}
