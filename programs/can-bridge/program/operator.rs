//! What the operator wants: keys on a terminal, and lines from a pipe.

use std::io::IsTerminal;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use super::keyboard::Keyboard;
use super::survey::Survey;
use super::terminal::{say, show_typed};
use anyhow::{Context, Result};
use cable_robot::robot::{Coordinates, Pose};
use cable_robot_fieldbus::bridge::JogDirection;
use cable_robot_fieldbus::{Config, OperatorCommand};
use rtrb::{Consumer, Producer, RingBuffer};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::stdio::stdin;
use rustix::termios::{
    InputModes, LocalModes, OptionalActions, SpecialCodeIndex, Termios, tcgetattr, tcsetattr,
};

/// What the terminal takes for "no key does that" (_POSIX_VDISABLE).
const NO_KEY: u8 = 0;
/// More commands than anybody gives in a cycle.
const QUEUE: usize = 256;
/// Of a line.
const LONGEST_LINE: usize = 256;
const KEYS: &str = "keys: h the platform stands at home   e enable   g a goal: x y z, Enter   1-9 and then i or o: that cable in or out, until another key   any other key: let go   l let the platform down   r down and reset   q down and off";
const SURVEY_KEYS: &str = "keys: z every cable is slack   1-9 the motor of a cable pulls a little   y only that cable came in   i that cable in, o out, until another key   w try the watchdogs   h the platform stands at home, until the cables are taut   p the platform is where it was asked for   m lift a little and weigh, until another key   any other key: let go   r reset   q off, and the verdict";

/// Reads stdin in a thread of its own; its end lets go. A terminal is put back when the second result is dropped.
pub fn listen(
    config: &Config,
    survey: Option<Arc<Survey>>,
) -> Result<(Consumer<OperatorCommand>, Option<Terminal>)> {
    let (producer, consumer) = RingBuffer::new(QUEUE);
    // Three times within the time allowed.
    let again = Duration::from_nanos(config.timeouts.enable / 3);
    let terminal = if std::io::stdin().is_terminal() { Some(Terminal::raw()?) } else { None };
    let has_keys = terminal.is_some();
    let read = move || {
        if has_keys { keys(producer, again, survey.as_deref()) } else { lines(producer, survey.as_deref()) }
    };
    thread::Builder::new().name("operator".to_owned()).spawn(read).context("no thread for the operator")?;
    Ok((consumer, terminal))
}

/// Keys come at once and unseen while this lives. Ctrl-C still is a signal; Ctrl-Z, Ctrl-\ and Ctrl-S are keys like any other and let go.
pub struct Terminal {
    before: Termios,
}

impl Terminal {
    fn raw() -> Result<Self> {
        let before = tcgetattr(stdin()).context("cannot read the terminal's settings")?;
        let mut raw = before.clone();
        raw.local_modes -= LocalModes::ICANON | LocalModes::ECHO;
        raw.input_modes -= InputModes::IXON;
        for stopping in [SpecialCodeIndex::VSUSP, SpecialCodeIndex::VQUIT] {
            raw.special_codes[stopping] = NO_KEY;
        }
        tcsetattr(stdin(), OptionalActions::Now, &raw).context("cannot set the terminal")?;
        Ok(Self { before })
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // Nobody is left to tell if it fails.
        let _ = tcsetattr(stdin(), OptionalActions::Now, &self.before);
    }
}

/// Waits for room: no command is ever dropped, least of all a release. Nobody takes them any more once the program ends.
fn give(queue: &mut Producer<OperatorCommand>, command: OperatorCommand) {
    while queue.push(command).is_err() && !queue.is_abandoned() {
        thread::sleep(Duration::from_millis(1));
    }
}

/// A terminal knows no key that is held: `h` and `e` count as held until another key.
fn keys(mut queue: Producer<OperatorCommand>, again: Duration, survey: Option<&Survey>) {
    say(if survey.is_some() { SURVEY_KEYS } else { KEYS });
    let mut keyboard = Keyboard::default();
    let mut tell = |command| give(&mut queue, command);
    loop {
        let mut key = [0];
        match read_within(&mut key, keyboard.held.map(|_| again)) {
            None => keyboard.held.into_iter().for_each(&mut tell),
            Some(0) => return tell(OperatorCommand::Lower),
            Some(_) => {
                keyboard.choose(key[0]);
                let pressed = match survey.and_then(|survey| survey_key(key[0], survey, keyboard.cable)) {
                    Some(SurveyKey::Say(text)) => {
                        say(format_args!("can-bridge: operator: {text}"));
                        Ok([keyboard.held.take().map(|_| OperatorCommand::Release), None])
                    }
                    Some(SurveyKey::Once(command)) => Ok([keyboard.end_trial(), command]),
                    Some(SurveyKey::Hold(command)) => Ok([Some(keyboard.hold(command)), None]),
                    None => keyboard.press(key[0]),
                };
                match pressed {
                    Ok(commands) => commands.into_iter().flatten().for_each(&mut tell),
                    Err(text) => say(format_args!("can-bridge: operator: {text}")),
                }
                show_typed(keyboard.typed());
            }
        }
    }
}

/// What a key means in a survey.
enum SurveyKey {
    Say(String),
    Once(Option<OperatorCommand>),
    /// Until another key.
    Hold(OperatorCommand),
}

/// Nothing for a key that means what it does without a survey. There are no goals: their figures would be motors.
fn survey_key(key: u8, survey: &Survey, cable: Option<usize>) -> Option<SurveyKey> {
    Some(match key {
        b'i' | b'o' if cable.is_some_and(|cable| !survey.knows(cable)) => {
            say("can-bridge: operator: nothing is jogged before you saw (y) what its pull does");
            SurveyKey::Once(Some(OperatorCommand::Release))
        }
        b'y' => SurveyKey::Say(survey.confirm()),
        b'z' => SurveyKey::Once(Some(OperatorCommand::Zero)),
        b'w' => SurveyKey::Once(Some(OperatorCommand::TryWatchdog)),
        b'p' => SurveyKey::Once(survey.asked().map(OperatorCommand::Placed)),
        b'g' => SurveyKey::Once(Some(OperatorCommand::Release)),
        b'm' => SurveyKey::Hold(OperatorCommand::Weigh),
        b'1'..=b'9' => SurveyKey::Hold(OperatorCommand::Pull(usize::from(key - b'1'))),
        _ => return None,
    })
}

/// A command a line, see [`command`].
fn lines(mut queue: Producer<OperatorCommand>, survey: Option<&Survey>) {
    let (mut line, mut bytes) = (Vec::with_capacity(LONGEST_LINE), [0; LONGEST_LINE]);
    loop {
        let read = read_within(&mut bytes, None).unwrap_or(0);
        for byte in &bytes[..read] {
            match byte {
                b'\n' => {
                    match command_of(&String::from_utf8_lossy(&line), survey) {
                        Ok(command) => command.into_iter().for_each(|command| give(&mut queue, command)),
                        // Whoever wanted to let go, and wrote it wrongly, has let go.
                        Err(reason) => {
                            say(format_args!("can-bridge: operator: {reason}: taken for release"));
                            give(&mut queue, OperatorCommand::Release);
                        }
                    }
                    line.clear();
                }
                // One more than may be: such a line is no command.
                _ if line.len() <= LONGEST_LINE => line.push(*byte),
                _ => {}
            }
        }
        if read == 0 {
            say(format_args!(
                "can-bridge: the operator's input has ended: a platform that hangs is let down; SIGTERM ends the program"
            ));
            return give(&mut queue, OperatorCommand::Lower);
        }
    }
}

/// What a line asks; `placed` alone is at the pose that the survey asks for.
fn command_of(line: &str, survey: Option<&Survey>) -> Result<Option<OperatorCommand>, String> {
    match survey {
        Some(survey) if line.trim_ascii() == "yes" => {
            say(format_args!("can-bridge: {}", survey.confirm()));
            Ok(None)
        }
        Some(survey) if line.trim_ascii() == "placed" => Ok(survey.asked().map(OperatorCommand::Placed)),
        _ => match (command(line)?, survey) {
            (Some(OperatorCommand::Jog(cable, _)), Some(survey)) if !survey.knows(cable) => {
                Err(format!("{line:?}: pull {} first, and yes if you saw its cable come in", cable + 1))
            }
            (command, _) => Ok(command),
        },
    }
}

/// Bytes read from stdin, 0 at its end; `None` if nothing came in time.
fn read_within(bytes: &mut [u8], time: Option<Duration>) -> Option<usize> {
    let limit =
        time.map(|time| Timespec { tv_sec: time.as_secs() as i64, tv_nsec: time.subsec_nanos().into() });
    loop {
        match poll(&mut [PollFd::new(&stdin(), PollFlags::IN)], limit.as_ref()) {
            Ok(0) => return None,
            Err(rustix::io::Errno::INTR) => {}
            Ok(_) | Err(_) => return Some(rustix::io::read(stdin(), &mut *bytes).unwrap_or(0)),
        }
    }
}

/// What a line asks; nothing if it is empty.
pub fn command(line: &str) -> Result<Option<OperatorCommand>, String> {
    if line.len() > LONGEST_LINE {
        return Err(format!("a line of more than {LONGEST_LINE} bytes"));
    }
    let mut words = line.split_ascii_whitespace();
    let Some(word) = words.next() else { return Ok(None) };
    let command = match word {
        "home" => OperatorCommand::Home,
        "enable" => OperatorCommand::Enable,
        "release" => OperatorCommand::Release,
        "lower" => OperatorCommand::Lower,
        "reset" => OperatorCommand::Reset,
        "shutdown" => OperatorCommand::Shutdown,
        "goal" => return pose("goal", words.collect()).map(|pose| Some(OperatorCommand::Goal(pose))),
        "pull" => return cable(words.collect()).map(Some),
        "jog" => return jog(words.collect()).map(Some),
        "weigh" => OperatorCommand::Weigh,
        "zero" => OperatorCommand::Zero,
        "watchdog" => OperatorCommand::TryWatchdog,
        "placed" => return pose("placed", words.collect()).map(|pose| Some(OperatorCommand::Placed(pose))),
        _ => {
            return Err(format!(
                "{line:?}: expected home, enable, release, lower, goal x y z [roll pitch yaw], jog N in|out, reset or shutdown"
            ));
        }
    };
    match words.next() {
        None => Ok(Some(command)),
        Some(more) => Err(format!("{line:?}: {more:?} is too much")),
    }
}

fn cable(words: Vec<&str>) -> Result<OperatorCommand, String> {
    match (number(&words), words.len()) {
        (Some(cable), 1) => Ok(OperatorCommand::Pull(cable)),
        _ => Err(format!("pull {}: expected the number of a cable, from 1", words.join(" "))),
    }
}

/// Of a cable, from 0.
fn number(words: &[&str]) -> Option<usize> {
    words.first()?.parse::<usize>().ok()?.checked_sub(1)
}

fn jog(words: Vec<&str>) -> Result<OperatorCommand, String> {
    let direction = match words.get(1) {
        Some(&"in") => Some(JogDirection::In),
        Some(&"out") => Some(JogDirection::Out),
        _ => None,
    };
    match (number(&words), direction, words.len()) {
        (Some(cable), Some(direction), 2) => Ok(OperatorCommand::Jog(cable, direction)),
        _ => Err(format!("jog {}: expected the number of a cable, from 1, and in or out", words.join(" "))),
    }
}

fn pose(word: &str, words: Vec<&str>) -> Result<Pose, String> {
    let allowed = "a pose is x y z (m) or x y z roll pitch yaw (m, rad), below the base: z > 0";
    let numbers: Vec<f64> =
        words.iter().filter_map(|word| word.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
    if numbers.len() != words.len() || !matches!(numbers.len(), 3 | 6) || numbers[2] <= 0.0 {
        return Err(format!("{word} {}: {allowed}", words.join(" ")));
    }
    let mut pose = Coordinates::zeros();
    pose.as_mut_slice()[..numbers.len()].copy_from_slice(&numbers);
    Ok(Pose(pose))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_come_back_as_they_were_written() {
        let pose = Pose(Coordinates::from([0.1 + 0.2, -1e-17, 1.0 / 3.0, 0.0, -0.0, 0.25]));
        for command_given in [
            OperatorCommand::Home,
            OperatorCommand::Enable,
            OperatorCommand::Release,
            OperatorCommand::Lower,
            OperatorCommand::Reset,
            OperatorCommand::Shutdown,
            OperatorCommand::Goal(pose),
            OperatorCommand::Placed(pose),
            OperatorCommand::Pull(2),
            OperatorCommand::Jog(11, JogDirection::In),
            OperatorCommand::Jog(0, JogDirection::Out),
            OperatorCommand::Zero,
            OperatorCommand::Weigh,
            OperatorCommand::TryWatchdog,
        ] {
            assert_eq!(command(&command_given.to_string()), Ok(Some(command_given)));
        }
        assert_eq!(command(" goal 0.1  0 1\r"), Ok(Some(OperatorCommand::Goal(Pose::at(0.1, 0.0, 1.0)))));
        assert_eq!(command(""), Ok(None));
    }

    /// The program takes them up slower than somebody gives them.
    #[test]
    fn a_release_behind_a_flood_of_lines_is_not_dropped() {
        let (mut producer, mut consumer) = RingBuffer::new(16);
        let flood = thread::spawn(move || {
            (0..100).for_each(|_| give(&mut producer, OperatorCommand::Enable));
            give(&mut producer, OperatorCommand::Release);
        });
        let mut taken = vec![];
        while taken.last() != Some(&OperatorCommand::Release) {
            assert!(taken.len() < 101, "the release is missing");
            thread::sleep(Duration::from_millis(1));
            taken.extend(std::iter::from_fn(|| consumer.pop().ok()));
        }
        flood.join().unwrap();
        assert_eq!(taken.len(), 101);
    }

    #[test]
    fn what_is_no_command_is_refused_with_what_would_be_right() {
        assert!(
            command(&format!("enable{}", " ".repeat(LONGEST_LINE)))
                .unwrap_err()
                .contains("a line of more than 256")
        );
        assert!(command("go").unwrap_err().contains("expected home, enable"));
        for jog in ["jog", "jog 3", "jog in", "jog 0 in", "jog 3 up", "jog 3 in out"] {
            assert!(
                command(jog).unwrap_err().contains("the number of a cable, from 1, and in or out"),
                "{jog}"
            );
        }
        assert!(command("enable now").unwrap_err().contains("\"now\" is too much"));
        for goal in ["goal", "goal 1 2", "goal 0 0 -1", "goal 0 0 nan", "goal 0 0 one", "goal 0 0 1 2"] {
            assert!(command(goal).unwrap_err().contains("a pose is x y z"), "{goal}");
        }
    }
}
