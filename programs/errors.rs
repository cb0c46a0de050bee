//! How errors are said: on one line, with what was probably meant.

use anyhow::Error;
use strsim::jaro_winkler;

use super::plain::plain;

/// Longest line of an error, characters.
const LONGEST_LINE: usize = 500;
/// Names at least so similar (0 to 1) are worth a question.
const SIMILAR: f64 = 0.8;

/// What a program says of an error: itself, the error, its causes.
pub fn in_words(program: &str, error: &Error) -> String {
    let text = format!("{error:#}");
    let question = misspelt(&text).map_or(String::new(), |name| format!("; did you mean {name}?"));
    plain(&format!("{program}: {}{question}", with_short_lines(&text))).into_owned()
}

/// The known name that is most like `given`, if one is like it at all.
pub fn similar<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let given = given.to_lowercase();
    let likeness = |name: &&str| jaro_winkler(&given, &name.to_lowercase());
    known
        .into_iter()
        .filter(|name| likeness(name) >= SIMILAR)
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)))
}

/// Of "unknown field `a`, expected one of `b`, `c`", as files are refused: the one that was probably meant.
fn misspelt(text: &str) -> Option<&str> {
    let (_, rest) = text.split_once("unknown field `").or_else(|| text.split_once("unknown variant `"))?;
    let (given, rest) = rest.split_once("`, expected ")?;
    similar(given, rest.lines().next()?.split('`').skip(1).step_by(2))
}

/// Without the rest of lines that nobody reads: TOML's errors show the line of the file, which may be all of it.
fn with_short_lines(text: &str) -> String {
    let short = |line: &str| match line.char_indices().nth(LONGEST_LINE) {
        Some((end, _)) => format!("{}...", line[..end].trim_end()),
        None => line.to_owned(),
    };
    text.lines().map(short).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::anyhow;

    #[test]
    fn a_misspelt_field_gets_the_one_that_was_meant() {
        let said = |text: &str| in_words("cable-robot", &anyhow!("{text}"));
        let field = said("line 3: unknown field `wheight`, expected one of `mass`, `weight`, `inertia`");
        assert!(field.ends_with("did you mean weight?"), "{field}");
        let variant = said("unknown variant `exat`, expected `bounded` or `exact`");
        assert!(variant.ends_with("did you mean exact?"), "{variant}");
        for other in ["unknown field `zzz`, expected one of `mass`, `inertia`", "no such file"] {
            assert!(!said(other).contains("did you mean"), "{other}");
        }
    }

    #[test]
    fn lines_that_nobody_reads_are_cut() {
        let said = in_words("cable-robot", &anyhow!("a\n{}\nb", "x".repeat(10_000)));
        assert!(said.starts_with("cable-robot: a\n") && said.ends_with("...\nb") && said.len() < 600);
    }
}
