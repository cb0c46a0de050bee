//! A recorded session entered once more into bridge and controller: do they command the same, to the last bit?

use std::collections::VecDeque;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail, ensure};
use cable_robot::sim::ControllerModel;
use cable_robot_fieldbus::bridge::Bridge;
use cable_robot_fieldbus::{Config, Files, FrameQueue, Nanoseconds};
use cable_robot_files::{Lines, read_text};

use super::controller::{BridgeController, Identity};
use super::entry::{Input, OnBus};
use super::log::{self, Direction};
use super::{Outcome, Purpose, print};

/// Enters the session in this folder and prints what came of it. Nothing that the folder says is run: the controller is this program's own, or the `fmu` that the user
/// names, which must be the one that was recorded.
pub fn run(folder: &Path, fmu: Option<&Path>) -> Result<Outcome> {
    for name in [log::FIELDBUS, log::RIG, log::FRAMES, log::INPUTS, log::CYCLES] {
        let path = folder.join(name);
        let found = fs::metadata(&path).with_context(|| format!("cannot read {}", path.display()))?;
        ensure!(found.is_file(), "{} is no regular file", path.display());
    }
    let config = Files::read_with_rig(&folder.join(log::FIELDBUS), &folder.join(log::RIG))?.config;
    let inputs = Inputs::read(folder, &config)?;
    let mut controller = BridgeController::open(&config, fmu)?;
    check_identity(inputs.controller.as_deref(), controller.identity())?;
    let path = folder.join(log::CYCLES);
    let is_whole = ends_whole(&path)?;
    let mut cycles = csv::Reader::from_reader(lines(&path)?);
    if cycles.headers()?.iter().ne(log::columns(config.rig.cables.len())) {
        bail!("{}: its columns are not those that this program writes", path.display());
    }
    let mut replay = Replay::open(folder, config, inputs)?;
    let (mut count, mut ends_early) = (0, false);
    let mut rows = cycles.records().peekable();
    while let Some(row) = rows.next() {
        if rows.peek().is_none() && !is_whole {
            break;
        }
        let place = || format!("{}: line {}", path.display(), count + 2);
        let row = row.with_context(place)?;
        let recorded = Recorded::parse(&row, count).map_err(|reason| anyhow!(reason)).with_context(place)?;
        replay.clock.check(&recorded).map_err(|reason| anyhow!(reason)).with_context(place)?;
        match replay.cycle(&recorded, &mut controller)? {
            Step::Same => count += 1,
            Step::End(_) if replay.frames == 0 => {
                bail!("{} holds none of the frames that {} tells of", log::FRAMES, log::CYCLES)
            }
            Step::End(why) => {
                print(&format!("cycle {count} at {} s: {why}\n", log::seconds(recorded.time)))?;
                ends_early = true;
                break;
            }
            Step::Differs(what) => {
                print(&format!("cycle {count} at {} s differs: {what}\n", log::seconds(recorded.time)))?;
                return Ok(Outcome::Differs);
            }
        }
    }
    ensure!(count > 0, "{}: there is no cycle to compare", path.display());
    let frames = replay.frames;
    if !ends_early {
        replay.say_what_is_left(count)?;
    }
    print(&format!("{count} cycles with {frames} frames: the same commands, bit for bit\n"))?;
    Ok(Outcome::Done)
}

/// Whether the controller is the one that was recorded; recordings of earlier versions do not say.
fn check_identity(recorded: Option<&str>, controller: &Identity) -> Result<()> {
    let Some(recorded) = recorded.filter(|recorded| *recorded != controller.to_string()) else {
        return Ok(());
    };
    if recorded == Identity::Own.to_string() {
        bail!("the recording is of this program's own controller: leave out --controller");
    }
    bail!(
        "the recording is of another controller, an FMU with {recorded}: name its file with --controller FMU"
    )
}

/// A file of the recording that is read line by line.
fn lines(path: &Path) -> Result<Lines<File>> {
    Ok(Lines::new(cable_robot_files::open(path).with_context(|| format!("cannot read {}", path.display()))?))
}

/// Whether a file ends with a line: a program that found no room on the disk may have left half of one.
fn ends_whole(path: &Path) -> Result<bool> {
    let read = || -> io::Result<u8> {
        let (mut file, mut last) = (cable_robot_files::open(path)?, [0]);
        file.seek(SeekFrom::End(-1))?;
        file.read_exact(&mut last)?;
        Ok(last[0])
    };
    Ok(read().with_context(|| format!("cannot read {}", path.display()))? == b'\n')
}

/// A row of the cycles.
struct Recorded<'a> {
    number: u64,
    time: Nanoseconds,
    /// After the time it was due, and cycles before it that never came.
    lateness: Nanoseconds,
    missed: u64,
    /// Frames that had entered until then.
    received: u64,
    /// Frames that went out.
    sent: u64,
    computed: Vec<&'a str>,
}

impl<'a> Recorded<'a> {
    fn parse(row: &'a csv::StringRecord, number: u64) -> Result<Self, String> {
        let count =
            |text: &str| text.parse::<u64>().map_err(|_| format!("{text:?}: expected a whole number"));
        if !row[4].is_empty() {
            log::parse_microseconds(&row[4])?;
        }
        Ok(Self {
            number,
            time: log::parse_seconds(&row[0])?,
            lateness: log::parse_microseconds(&row[3])?,
            missed: count(&row[5])?,
            received: count(&row[1])?,
            sent: count(&row[2])?,
            computed: row.iter().skip(log::OWN_COLUMNS.len()).collect(),
        })
    }
}

/// Up to this long before its end a program that was killed has not handed its cycles over: twice as long as the journal waits.
const JOURNAL: Nanoseconds = 2_000_000_000;
const NO_FRAME: &str = "frames.log ends within this cycle";

/// What a recording says of times, against itself: the bridge computes with some of them only.
struct Clock {
    period: Nanoseconds,
    /// When the last cycle was due, and when it began.
    due: Nanoseconds,
    last: Nanoseconds,
    /// Of the last frame that was received from each bus.
    received: Vec<Nanoseconds>,
    /// Of the last frame that was sent.
    sent: Nanoseconds,
}

/// Times are recorded in whole microseconds.
const ROUNDING: Nanoseconds = 1_000;

impl Clock {
    fn new(config: &Config) -> Self {
        Self { period: config.period, due: 0, last: 0, received: vec![0; config.buses.len()], sent: 0 }
    }

    /// A cycle begins after the one before and what that one sent, and was due whole periods after it, as many as were left out.
    fn check(&mut self, recorded: &Recorded) -> Result<(), String> {
        let Recorded { time, lateness, missed, .. } = *recorded;
        let due = time.saturating_sub(lateness);
        let (since, least) =
            (due.saturating_sub(self.due), (missed.saturating_add(1)).saturating_mul(self.period));
        let off = (since + ROUNDING) % self.period;
        if time < self.last.max(self.sent) || off > 2 * ROUNDING || since + ROUNDING < least {
            return Err(format!(
                "the time {} with its lateness and missed cycles does not follow on the cycle at {} s",
                log::seconds(time),
                log::seconds(self.last)
            ));
        }
        (self.due, self.last, self.sent) = (due, time, time);
        Ok(())
    }

    /// A frame comes after those before it on its bus, and before the cycle that takes it in.
    fn receive(&mut self, OnBus { bus, time, .. }: &OnBus, cycle: Nanoseconds) -> Result<(), String> {
        let before = std::mem::replace(&mut self.received[*bus], *time);
        let is_in_order = before <= *time && *time <= cycle;
        if is_in_order {
            Ok(())
        } else {
            Err("it was received before the frame before it, or after its cycle".to_owned())
        }
    }

    /// A frame goes out after its cycle has begun and after those before it.
    fn send(&mut self, time: Nanoseconds) -> Result<(), String> {
        let before = std::mem::replace(&mut self.sent, time);
        if before <= time {
            Ok(())
        } else {
            Err("it was sent before its cycle or the frame before it".to_owned())
        }
    }
}

/// What entered beside frames.
struct Inputs {
    /// Which controller it was.
    controller: Option<String>,
    purpose: Purpose,
    inputs: VecDeque<Entered>,
    /// The cycle before which entries are missing.
    gap: Option<u64>,
}

/// An input, the cycle before which it entered, and why it was not taken: empty if it was.
struct Entered {
    cycle: u64,
    input: Input,
    refused: String,
}

impl Inputs {
    fn read(folder: &Path, config: &Config) -> Result<Self> {
        let path = folder.join(log::INPUTS);
        let text = read_text(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let mut rows = csv::Reader::from_reader(whole.as_bytes());
        let mut read =
            Self { controller: None, purpose: Purpose::Run(None), inputs: VecDeque::new(), gap: None };
        let mut last = 0;
        for (k, row) in rows.deserialize().enumerate() {
            let place = || format!("{}: line {}", path.display(), k + 2);
            let (cycle, text, refused): (u64, String, String) = row.with_context(place)?;
            ensure!(cycle >= last, "{}: cycle {cycle} comes after cycle {last}", place());
            last = cycle;
            match text.as_str() {
                log::GAP => _ = read.gap.get_or_insert(cycle),
                text => {
                    match (text.strip_prefix(log::CONTROLLER), log::parse_purpose(text, config.drives.len()))
                    {
                        (Some(identity), _) => read.controller = Some(identity.to_owned()),
                        (None, Some(purpose)) => read.purpose = purpose,
                        (None, None) => {
                            let input = log::parse_input(config, text).map_err(|reason| anyhow!(reason));
                            read.inputs.push_back(Entered {
                                cycle,
                                input: input.with_context(place)?,
                                refused,
                            });
                        }
                    }
                }
            }
        }
        Ok(read)
    }
}

enum Step {
    Same,
    /// The recording ends within the cycle.
    End(&'static str),
    Differs(String),
}

/// What is entered, and into what.
struct Replay {
    config: Config,
    bridge: Bridge,
    is_dry: bool,
    inputs: VecDeque<Entered>,
    gap: Option<u64>,
    clock: Clock,
    lines: BufReader<Lines<File>>,
    line: u64,
    received: u64,
    frames: u64,
    out: FrameQueue,
}

impl Replay {
    fn open(folder: &Path, config: Config, Inputs { purpose, inputs, gap, .. }: Inputs) -> Result<Self> {
        let path = folder.join(log::FRAMES);
        Ok(Self {
            bridge: purpose.bridge(&config),
            clock: Clock::new(&config),
            config,
            is_dry: purpose == Purpose::DryRun,
            inputs,
            gap,
            lines: BufReader::new(lines(&path)?),
            line: 0,
            received: 0,
            frames: 0,
            out: FrameQueue::new(),
        })
    }

    /// Looks at what comes after the last cycle: a program that was killed has handed over frames and inputs of up to a second of which no cycle tells.
    fn say_what_is_left(&mut self, cycles: u64) -> Result<()> {
        let latest = cycles + JOURNAL / self.config.period;
        if let Some(late) = self.inputs.iter().find(|entered| entered.cycle > latest) {
            bail!("{}: there is no cycle {}, the recording has {cycles}", log::INPUTS, late.cycle);
        }
        let (inputs, before) =
            (self.inputs.iter().filter(|entered| entered.cycle >= cycles).count(), self.frames);
        while self.next(None)?.is_some() {}
        let frames = self.frames - before;
        if inputs + frames as usize > 0 {
            print(&format!(
                "after the last cycle there are {frames} frames and {inputs} inputs, of which no cycle tells: they are not compared\n"
            ))?;
        }
        Ok(())
    }

    fn cycle(&mut self, recorded: &Recorded, controller: &mut dyn ControllerModel) -> Result<Step> {
        if self.gap.is_some_and(|gap| gap <= recorded.number) {
            return Ok(Step::End("entries are missing in the recording, the queue was full"));
        }
        while self.received < recorded.received {
            let Some(on_bus) = self.next(Some(Direction::Received))? else {
                return Ok(Step::End(NO_FRAME));
            };
            self.clock.receive(&on_bus, recorded.time).map_err(|reason| self.wrong(&reason))?;
            self.bridge.on_frame(on_bus.bus, &on_bus.frame, on_bus.time);
            self.received += 1;
        }
        while let Some(entered) = self.inputs.pop_front_if(|entered| entered.cycle <= recorded.number) {
            match entered.input {
                Input::Operator(command) => {
                    let refused = log::refusal_text(self.bridge.operator(command, recorded.time).err());
                    if refused != entered.refused {
                        let was = format!("was refused with {:?} and is with {refused:?}", entered.refused);
                        return Ok(Step::Differs(format!("{command} {was}")));
                    }
                }
                Input::Transport { bus, error, .. } => self.bridge.on_transport_error(bus, error),
            }
        }
        let report = self.bridge.cycle(recorded.time, controller, &mut self.out);
        let names = log::columns(report.length.len());
        let computed = log::computed(&report);
        let names = names.iter().skip(log::OWN_COLUMNS.len());
        for ((name, now), then) in names.zip(&computed).zip(&recorded.computed) {
            if now != then {
                return Ok(Step::Differs(format!("{name} was {then:?} and is {now:?}")));
            }
        }
        self.compare_sent(recorded)
    }

    /// What was put on the bus, and what a link refused, in the order of the bridge.
    fn compare_sent(&mut self, recorded: &Recorded) -> Result<Step> {
        let mut refused: VecDeque<_> = self
            .inputs
            .iter()
            .take_while(|entered| entered.cycle == recorded.number + 1)
            .filter_map(|entered| match entered.input {
                Input::Transport { bus, frame: Some(frame), .. } => Some((bus, frame)),
                _ => None,
            })
            .collect();
        let mut sent = VecDeque::new();
        for _ in 0..recorded.sent {
            let Some(OnBus { bus, frame, time }) = self.next(Some(Direction::Sent))? else {
                return Ok(Step::End(NO_FRAME));
            };
            self.clock.send(time).map_err(|reason| self.wrong(&reason))?;
            sent.push_back((bus, frame));
        }
        let commanded = if self.is_dry { &[] } else { self.out.frames() };
        for frame in commanded {
            let place = if sent.front() == Some(frame) { &mut sent } else { &mut refused };
            if place.pop_front() != Some(*frame) {
                return Ok(Step::Differs(format!("{} would be sent, and was not", frame.1)));
            }
        }
        Ok(match sent.front() {
            None => Step::Same,
            Some((_, frame)) => Step::Differs(format!("{frame} was sent, and would not be")),
        })
    }

    /// The next frame, which went this way, or any; `None` at the end of the file, which may be in a line.
    fn next(&mut self, direction: Option<Direction>) -> Result<Option<OnBus>> {
        let mut line = String::new();
        self.lines.read_line(&mut line).context(log::FRAMES)?;
        if !line.ends_with('\n') {
            // Half a line of text was cut; what is no text was never written.
            let is_text = line.chars().all(|character| character.is_ascii_graphic() || character == ' ');
            return if is_text {
                Ok(None)
            } else {
                Err(self.wrong("there is something behind the last frame"))
            };
        }
        self.line += 1;
        self.frames += 1;
        let (on_bus, found) =
            log::parse_frame_line(&self.config, &line).map_err(|reason| self.wrong(&reason))?;
        match direction.filter(|direction| *direction != found) {
            None => Ok(Some(on_bus)),
            Some(direction) => {
                Err(self.wrong(&format!("{found:?}: expected a frame that was {direction:?}")))
            }
        }
    }

    fn wrong(&self, reason: &str) -> anyhow::Error {
        anyhow!("{}: line {}: {reason}", log::FRAMES, self.line)
    }
}
