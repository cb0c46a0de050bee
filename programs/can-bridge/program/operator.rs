//! What the operator wants: keys on a terminal, and lines from a pipe.

use std::io::IsTerminal;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use super::survey::Survey;
use super::terminal::{say, show_typed};
use anyhow::{Context, Result};
use cable_robot::robot::{Coordinates, Pose};
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
/// Of a goal that is typed: more is a key that is stuck.
const LONGEST_GOAL: usize = 60;
const KEYS: &str = "keys: h the platform stands at home   e enable   g a goal: x y z, Enter   any other key: let go   l let the platform down   r down and reset   q down and off";
const SURVEY_KEYS: &str = "keys: z every cable is slack   1-9 the motor of a cable pulls a little   y only that cable came in   w try the watchdogs   h the platform stands at home, until the cables are taut   p the platform is where it was asked for   m lift a little and weigh, until another key   any other key: let go   r reset   q off, and the verdict";

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
                let pressed = match survey.and_then(|survey| survey_key(key[0], survey)) {
                    Some(SurveyKey::Say(text)) => Err(text),
                    Some(SurveyKey::Once(command)) => Ok([command, None]),
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
fn survey_key(key: u8, survey: &Survey) -> Option<SurveyKey> {
    Some(match key {
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

/// What the keys pressed so far mean.
#[derive(Default)]
struct Keyboard {
    held: Option<OperatorCommand>,
    /// A goal that is being typed, which lets go of nothing.
    goal: Option<String>,
}

impl Keyboard {
    /// This is held from now on, or goes on to be; after another one that is, it lets go of that.
    fn hold(&mut self, command: OperatorCommand) -> OperatorCommand {
        self.held = Some(command).filter(|_| self.held.is_none_or(|held| held == command));
        self.held.unwrap_or(OperatorCommand::Release)
    }

    /// The commands that a key gives; while a goal is typed each key gives again what is held, which would run out otherwise.
    ///
    /// # Errors
    /// What would be right in place of a goal that is none.
    fn press(&mut self, key: u8) -> Result<[Option<OperatorCommand>; 2], String> {
        if let Some(typed) = self.goal.take() {
            match key {
                b'\n' | b'\r' if typed.is_empty() => return Ok([self.held, None]),
                b'\n' | b'\r' => return command(&format!("goal {typed}")).map(|goal| [goal, self.held]),
                _ => self.goal = after(typed, key),
            }
            self.held = self.held.filter(|_| self.goal.is_some());
        } else if key == b'g' {
            self.goal = Some(String::new());
        } else {
            self.held = held_after(self.held, key);
        }
        if self.goal.is_some() {
            return Ok([self.held, None]);
        }
        let also = match key {
            b'l' => Some(OperatorCommand::Lower),
            b'r' => Some(OperatorCommand::Reset),
            b'q' => Some(OperatorCommand::Shutdown),
            _ => None,
        };
        Ok([Some(self.held.unwrap_or(OperatorCommand::Release)), also])
    }

    /// What the operator sees of a goal that is being typed.
    fn typed(&self) -> Option<String> {
        self.goal.as_ref().map(|typed| format!("goal x y z (m), Enter: {typed}_"))
    }
}

/// What is typed of a goal after a key; nothing if the key has no place in it. Of spaces one behind a number has: whoever hits that bar lets go.
fn after(mut typed: String, key: u8) -> Option<String> {
    match key {
        b'\x08' | b'\x7F' => _ = typed.pop()?,
        _ if typed.len() >= LONGEST_GOAL => return None,
        b'0'..=b'9' | b'.' | b'-' => typed.push(key.into()),
        b' ' if typed.ends_with(|last: char| last.is_ascii_digit()) => typed.push(' '),
        _ => return None,
    }
    Some(typed)
}

/// What is held after a key, which may come again and again while it is pressed. From home one goes on to enable; every other key lets go.
fn held_after(held: Option<OperatorCommand>, key: u8) -> Option<OperatorCommand> {
    match (key, held) {
        (b'h', None | Some(OperatorCommand::Home)) => Some(OperatorCommand::Home),
        (b'e', _) => Some(OperatorCommand::Enable),
        _ => None,
    }
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
        _ => command(line),
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
        "weigh" => OperatorCommand::Weigh,
        "zero" => OperatorCommand::Zero,
        "watchdog" => OperatorCommand::TryWatchdog,
        "placed" => return pose("placed", words.collect()).map(|pose| Some(OperatorCommand::Placed(pose))),
        _ => {
            return Err(format!(
                "{line:?}: expected home, enable, release, lower, goal x y z [roll pitch yaw], reset or shutdown"
            ));
        }
    };
    match words.next() {
        None => Ok(Some(command)),
        Some(more) => Err(format!("{line:?}: {more:?} is too much")),
    }
}

fn cable(words: Vec<&str>) -> Result<OperatorCommand, String> {
    let number = words.first().and_then(|word| word.parse().ok()).filter(|number: &usize| *number > 0);
    match (number, words.len()) {
        (Some(number), 1) => Ok(OperatorCommand::Pull(number - 1)),
        _ => Err(format!("pull {}: expected the number of a cable, from 1", words.join(" "))),
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
    fn home_and_enable_are_held_until_another_key() {
        let (home, enable) = (Some(OperatorCommand::Home), Some(OperatorCommand::Enable));
        assert_eq!((held_after(None, b'h'), held_after(None, b'e')), (home, enable));
        assert_eq!(held_after(home, b'e'), enable);
        for (held, key) in [(enable, b'h'), (home, b'x'), (None, b'x'), (enable, b' ')] {
            assert_eq!(held_after(held, key), None, "{held:?} {key}");
        }
    }

    /// Every second repetition of a key that is pressed let go.
    #[test]
    fn a_key_that_repeats_while_it_is_pressed_does_not_let_go() {
        let mut keyboard = Keyboard::default();
        for (key, command) in [(b'h', OperatorCommand::Home), (b'e', OperatorCommand::Enable)] {
            (0..9).for_each(|_| assert_eq!(keyboard.press(key), Ok([Some(command), None])));
        }
    }

    /// What the last of the keys gives.
    fn typed(keyboard: &mut Keyboard, keys: &str) -> Result<[Option<OperatorCommand>; 2], String> {
        let mut last = Ok([None; 2]);
        keys.bytes().for_each(|key| last = keyboard.press(key));
        last
    }

    #[test]
    fn a_goal_is_typed_while_enable_is_held() {
        let mut keyboard = Keyboard::default();
        let enable = Some(OperatorCommand::Enable);
        _ = keyboard.press(b'e');
        let goal = Some(OperatorCommand::Goal(Pose::at(0.15, -0.1, 1.0)));
        // Enable ran out while somebody typed.
        assert_eq!(typed(&mut keyboard, "g0.15 -0.2"), Ok([enable, None]));
        assert_eq!(keyboard.typed().unwrap(), "goal x y z (m), Enter: 0.15 -0.2_");
        assert_eq!(typed(&mut keyboard, "\x7F1 1\n"), Ok([goal, enable]));
        assert!(typed(&mut keyboard, "g0.1 2\n").unwrap_err().contains("a pose is x y z"));
        assert_eq!(typed(&mut keyboard, "g\n"), Ok([enable, None]));
        assert_eq!((keyboard.held, keyboard.typed()), (enable, None));
    }

    #[test]
    fn a_key_without_a_place_in_a_goal_lets_go() {
        let release = Ok([Some(OperatorCommand::Release), None]);
        let too_long = format!("g{}", "1".repeat(LONGEST_GOAL + 1));
        for keys in ["gx", "g ", "g1  ", "g1e", "g\x1B", "g\x7F", &too_long] {
            let mut keyboard = Keyboard { held: Some(OperatorCommand::Enable), goal: None };
            let given = typed(&mut keyboard, keys);
            assert_eq!((given, keyboard.held, keyboard.typed()), (release.clone(), None, None), "{keys:?}");
        }
    }

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
        assert!(command("enable now").unwrap_err().contains("\"now\" is too much"));
        for goal in ["goal", "goal 1 2", "goal 0 0 -1", "goal 0 0 nan", "goal 0 0 one", "goal 0 0 1 2"] {
            assert!(command(goal).unwrap_err().contains("a pose is x y z"), "{goal}");
        }
    }
}
