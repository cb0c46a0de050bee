//! Text from files, FMUs and buses, as it may reach a terminal.

use std::borrow::Cow;
use std::fmt::Write;

/// The text with every character that could command a terminal, or turn the order of what is read, written as JSON writes it: `\u001b`. Ends of
/// lines and tabulators stay.
pub fn plain(text: &str) -> Cow<'_, str> {
    if !text.chars().any(commands) {
        return text.into();
    }
    let mut shown = String::new();
    for character in text.chars() {
        if commands(character) {
            let _ = write!(shown, "\\u{:04x}", u32::from(character));
        } else {
            shown.push(character);
        }
    }
    shown.into()
}

fn commands(character: char) -> bool {
    let turns =
        matches!(character, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || character.is_control() && !matches!(character, '\n' | '\t')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escape_sequences_are_shown_and_not_sent() {
        let title = "\u{1b}]0;owned\u{7}\u{9b}2J\rover\u{202e}turned\u{7f}";
        assert_eq!(plain(title), r"\u001b]0;owned\u0007\u009b2J\u000dover\u202eturned\u007f");
        for as_it_is in ["", "two\n\tlines", "Müller 0.1 °C ≤ 2", r"a\b"] {
            assert_eq!(plain(as_it_is), as_it_is);
        }
        let json = format!("\"{}\"", plain("\u{9b}2J\u{7f}"));
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), "\u{9b}2J\u{7f}", "JSON stays JSON");
    }
}
