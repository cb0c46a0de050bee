//! What keys mean: what is held, a goal that is typed, and the cable that is meant.

use cable_robot_fieldbus::OperatorCommand;
use cable_robot_fieldbus::bridge::JogDirection;

use super::operator::command;

/// Of a goal that is typed: more is a key that is stuck.
const LONGEST_GOAL: usize = 60;

/// What the keys pressed so far mean.
#[derive(Default)]
pub struct Keyboard {
    /// The last whose number was pressed, from 0.
    pub cable: Option<usize>,
    /// As if it were pressed still.
    pub held: Option<OperatorCommand>,
    /// A goal that is being typed, which lets go of nothing.
    goal: Option<String>,
}

impl Keyboard {
    /// A number outside of a goal says which cable is meant from now on.
    pub fn choose(&mut self, key: u8) {
        if let (b'1'..=b'9', None) = (key, &self.goal) {
            self.cable = Some(usize::from(key - b'1'));
        }
    }

    /// This is held from now on, or goes on to be; after another one that is, it lets go of that.
    pub fn hold(&mut self, command: OperatorCommand) -> OperatorCommand {
        self.held = Some(command).filter(|_| self.held.is_none_or(|held| held == command));
        self.held.unwrap_or(OperatorCommand::Release)
    }

    /// Nothing is held any more. What moved a cable is let go of; the motors that home switched on stay on.
    pub fn end_trial(&mut self) -> Option<OperatorCommand> {
        let held = self.held.take();
        let moves =
            |held: &OperatorCommand| matches!(held, OperatorCommand::Pull(_) | OperatorCommand::Jog(..));
        held.filter(moves).map(|_| OperatorCommand::Release)
    }

    /// The commands that a key gives; while a goal is typed each key gives again what is held, which would run out otherwise.
    ///
    /// # Errors
    /// What would be right in place of a goal that is none.
    pub fn press(&mut self, key: u8) -> Result<[Option<OperatorCommand>; 2], String> {
        if let Some(typed) = self.goal.take() {
            match key {
                b'\n' | b'\r' if typed.is_empty() => return Ok([self.held, None]),
                b'\n' | b'\r' => return command(&format!("goal {typed}")).map(|goal| [goal, self.held]),
                _ => self.goal = after(typed, key),
            }
            self.held = self.held.filter(|_| self.goal.is_some());
        } else if key == b'g' {
            self.goal = Some(String::new());
        } else if let (Some(direction), Some(cable)) = (jog_key(key), self.cable) {
            return Ok([Some(self.hold(OperatorCommand::Jog(cable, direction))), None]);
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
    pub fn typed(&self) -> Option<String> {
        self.goal.as_ref().map(|typed| format!("goal x y z (m), Enter: {typed}_"))
    }
}

fn jog_key(key: u8) -> Option<JogDirection> {
    match key {
        b'i' => Some(JogDirection::In),
        b'o' => Some(JogDirection::Out),
        _ => None,
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

#[cfg(test)]
mod tests {
    use cable_robot::robot::Pose;

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

    #[test]
    fn a_cable_is_chosen_by_its_number_and_moves_until_another_key() {
        let mut keyboard = Keyboard::default();
        let mut press = |key| {
            keyboard.choose(key);
            keyboard.press(key).unwrap()[0]
        };
        let (release, jog) =
            (Some(OperatorCommand::Release), |direction| Some(OperatorCommand::Jog(2, direction)));
        assert_eq!(
            [b'i', b'3', b'i', b'i'].map(&mut press),
            [release, release, jog(JogDirection::In), jog(JogDirection::In)]
        );
        // The other way it goes only after letting go.
        assert_eq!([b'o', b'o', b' '].map(&mut press), [release, jog(JogDirection::Out), release]);
        assert_eq!(
            [b'e', b'o', b'o'].map(&mut press),
            [Some(OperatorCommand::Enable), release, jog(JogDirection::Out)]
        );
        assert_eq!(
            typed(&mut keyboard, "xg5\x7F\x7Fo"),
            Ok([jog(JogDirection::Out), None]),
            "a goal's figures are no cable"
        );
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
            let mut keyboard = Keyboard { held: Some(OperatorCommand::Enable), ..Keyboard::default() };
            let given = typed(&mut keyboard, keys);
            assert_eq!((given, keyboard.held, keyboard.typed()), (release.clone(), None, None), "{keys:?}");
        }
    }
}
