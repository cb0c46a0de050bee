//! What an operator may do next.

use cable_robot_fieldbus::State;

/// In a state, in the words of keys or of lines on standard input.
pub fn next(state: State, has_keys: bool) -> String {
    let word = |key: &'static str, line: &'static str| if has_keys { key } else { line };
    let (home, enable, release) = (word("h", "home"), word("e", "enable"), word("any other key", "release"));
    let lower = word("l", "lower");
    let (goal, reset, shutdown) = (word("g", "goal x y z"), word("r", "reset"), word("q", "shutdown"));
    let jog = word("its number and i or o", "jog N in|out");
    match state {
        State::Configuring => "nodes are reset and set up, nothing moves".to_owned(),
        State::Homing => format!(
            "put the platform at the home pose, stand clear of the cables, then {home}; {jog} hauls a cable in or pays it out; {shutdown} ends"
        ),
        State::TakingUpSlack => {
            format!("cables are made taut, each is pulled at in turn; {release} switches the motors off")
        }
        State::Ready => {
            format!("{enable} lifts the platform off its stand; {release} switches the motors off")
        }
        State::Enabled => format!("{goal} gives a goal once the platform is lifted; {release} lets go"),
        State::Stopping => "wait for the safe output".to_owned(),
        State::Safe => format!(
            "{enable} goes on from here; after safe.hold_time, or on {lower}, {reset} or {shutdown}, the platform is let down"
        ),
        State::Fault => format!(
            "{reset} sets everything up anew, {shutdown} ends; a platform that hangs is let down before that, if its pose is known"
        ),
        State::Lowering => "the platform is let down to its stand: stand clear".to_owned(),
        State::Trying => "a trial of the survey: stand clear of the cables".to_owned(),
        State::Jogging => format!("one cable moves: keep clear of it and its winch; {release} stops it"),
        State::Off => "the drives are switched off".to_owned(),
        State::Shadow => format!("nothing is sent; {goal} gives the controller a goal"),
    }
}
