//! A recorded session entered once more into bridge and controller: do they command the same, to the last bit?

use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail, ensure};
use cable_robot::sim::ControllerModel;
use cable_robot_fieldbus::bridge::Bridge;
use cable_robot_fieldbus::{Config, Files, FrameQueue, Nanoseconds};

use super::controller::FmuController;
use super::entry::{Input, OnBus};
use super::log::{self, Direction};
use super::{Outcome, print};

/// Enters the session in this folder and prints what came of it.
pub fn run(folder: &Path) -> Result<Outcome> {
    let config = Files::read_with_rig(&folder.join(log::FIELDBUS), &folder.join(log::RIG))?.config;
    let mut controller = FmuController::open(&config)?;
    let path = folder.join(log::CYCLES);
    let mut cycles =
        csv::Reader::from_path(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let header = cycles.headers()?.clone();
    if header.iter().ne(log::columns(config.rig.cables.len())) {
        bail!("{}: its columns are not those that this program writes", path.display());
    }
    let mut replay = Replay::open(folder, config)?;
    let mut count = 0;
    for row in cycles.records() {
        // A program that was killed leaves half a row, and frames that no row tells of.
        let Ok(row) = row else { break };
        let place = || format!("{}: line {}", path.display(), count + 2);
        let recorded = Recorded::parse(&row, count).map_err(|reason| anyhow!(reason)).with_context(place)?;
        match replay.cycle(&recorded, &mut controller)? {
            Step::Same => count += 1,
            Step::End(_) if replay.frames == 0 => {
                bail!("{} holds none of the frames that {} tells of", log::FRAMES, log::CYCLES)
            }
            Step::End(why) => {
                print(&format!("cycle {count} at {} s: {why}\n", log::seconds(recorded.time)))?;
                break;
            }
            Step::Differs(what) => {
                print(&format!("cycle {count} at {} s differs: {what}\n", log::seconds(recorded.time)))?;
                return Ok(Outcome::Differs);
            }
        }
    }
    ensure!(count > 0, "{}: there is no cycle to compare", path.display());
    print(&format!("{count} cycles with {} frames: the same commands, bit for bit\n", replay.frames))?;
    Ok(Outcome::Done)
}

/// A row of the cycles.
struct Recorded<'a> {
    number: u64,
    time: Nanoseconds,
    /// Frames that had entered until then.
    received: u64,
    /// Frames that went out.
    sent: u64,
    computed: Vec<&'a str>,
}

impl<'a> Recorded<'a> {
    fn parse(row: &'a csv::StringRecord, number: u64) -> Result<Self, String> {
        let count =
            |text: &str| text.parse::<u64>().map_err(|_| format!("{text:?}: expected a number of frames"));
        Ok(Self {
            number,
            time: log::parse_seconds(&row[0])?,
            received: count(&row[1])?,
            sent: count(&row[2])?,
            computed: row.iter().skip(log::OWN_COLUMNS.len()).collect(),
        })
    }
}

const NO_FRAME: &str = "frames.log ends within this cycle";

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
    inputs: VecDeque<(u64, Input)>,
    /// The cycle before which entries are missing.
    gap: Option<u64>,
    lines: BufReader<File>,
    line: u64,
    received: u64,
    frames: u64,
    out: FrameQueue,
}

impl Replay {
    fn open(folder: &Path, config: Config) -> Result<Self> {
        let path = folder.join(log::INPUTS);
        let mut rows =
            csv::Reader::from_path(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let (mut inputs, mut is_dry, mut gap) = (VecDeque::new(), false, None);
        for (k, row) in rows.deserialize().enumerate() {
            let Ok((cycle, text)): Result<(u64, String), _> = row else { break };
            match text.as_str() {
                log::DRY_RUN => is_dry = true,
                log::GAP => _ = gap.get_or_insert(cycle),
                text => {
                    let input = log::parse_input(&config, text).map_err(|reason| anyhow!(reason));
                    inputs.push_back((
                        cycle,
                        input.with_context(|| format!("{}: line {}", path.display(), k + 2))?,
                    ));
                }
            }
        }
        let path = folder.join(log::FRAMES);
        let file = File::open(&path).with_context(|| format!("cannot read {}", path.display()))?;
        Ok(Self {
            bridge: if is_dry { Bridge::shadow(config.clone()) } else { Bridge::new(config.clone()) },
            config,
            is_dry,
            inputs,
            gap,
            lines: BufReader::new(file),
            line: 0,
            received: 0,
            frames: 0,
            out: FrameQueue::new(),
        })
    }

    fn cycle(&mut self, recorded: &Recorded, controller: &mut dyn ControllerModel) -> Result<Step> {
        if self.gap.is_some_and(|gap| gap <= recorded.number) {
            return Ok(Step::End("entries are missing in the recording, the queue was full"));
        }
        while self.received < recorded.received {
            let Some(OnBus { bus, time, frame }) = self.next(Direction::Received)? else {
                return Ok(Step::End(NO_FRAME));
            };
            self.bridge.on_frame(bus, &frame, time);
            self.received += 1;
        }
        while self.inputs.front().is_some_and(|(cycle, _)| *cycle <= recorded.number) {
            match self.inputs.pop_front() {
                // That it is refused is part of the replay.
                Some((_, Input::Operator(command))) => _ = self.bridge.operator(command, recorded.time),
                Some((_, Input::Transport { bus, error, .. })) => self.bridge.on_transport_error(bus, error),
                None => {}
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
            .take_while(|(cycle, _)| *cycle == recorded.number + 1)
            .filter_map(|(_, input)| match input {
                Input::Transport { bus, frame: Some(frame), .. } => Some((*bus, *frame)),
                _ => None,
            })
            .collect();
        let mut sent = VecDeque::new();
        for _ in 0..recorded.sent {
            let Some(OnBus { bus, frame, .. }) = self.next(Direction::Sent)? else {
                return Ok(Step::End(NO_FRAME));
            };
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

    /// The next frame, which went this way; `None` at the end of the file, which may be in a line.
    fn next(&mut self, direction: Direction) -> Result<Option<OnBus>> {
        let mut line = String::new();
        self.lines.read_line(&mut line)?;
        if !line.ends_with('\n') {
            return Ok(None);
        }
        self.line += 1;
        self.frames += 1;
        let wrong = |reason: String| anyhow!("{}: line {}: {reason}", log::FRAMES, self.line);
        match log::parse_frame_line(&self.config, &line).map_err(wrong)? {
            (on_bus, found) if found == direction => Ok(Some(on_bus)),
            (_, found) => Err(wrong(format!("{found:?}: expected a frame that was {direction:?}"))),
        }
    }
}
