//! What a shell completes after a program's name, and its page for `man`.

use std::io::{self, Write, stdout};

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Command, Parser, ValueEnum, value_parser};
use clap_complete::shells;
use clap_mangen::Man;

const COMPLETIONS: &str = "completions";
const MAN: &str = "man";

/// A shell that completions are written for.
#[derive(Clone, Copy, ValueEnum)]
pub enum Shell {
    /// The Bourne-again shell
    Bash,
    /// The Z shell
    Zsh,
    /// The friendly interactive shell
    Fish,
}

impl Shell {
    /// The script for a program.
    pub fn script(self, mut command: Command) -> String {
        let (name, mut script) = (command.get_name().to_owned(), vec![]);
        match self {
            Self::Bash => clap_complete::generate(shells::Bash, &mut command, name, &mut script),
            Self::Zsh => clap_complete::generate(shells::Zsh, &mut command, name, &mut script),
            Self::Fish => clap_complete::generate(shells::Fish, &mut command, name, &mut script),
        }
        String::from_utf8_lossy(&script).into_owned()
    }
}

/// The command line of a program without subcommands, which has `--completions SHELL` and `--man` besides: these print and end the program, and so does a wrong command line.
pub fn parse<A: Parser>() -> A {
    let command = A::command()
        .arg(
            Arg::new(COMPLETIONS)
                .long(COMPLETIONS)
                .value_name("SHELL")
                .value_parser(value_parser!(Shell))
                .exclusive(true)
                .help("Prints completions for a shell"),
        )
        .arg(
            Arg::new(MAN)
                .long(MAN)
                .action(ArgAction::SetTrue)
                .exclusive(true)
                .help("Prints the page for man"),
        );
    let matches = command.clone().get_matches();
    match show(&command, &matches) {
        Ok(false) => A::from_arg_matches(&matches).unwrap_or_else(|error| error.exit()),
        Ok(true) => std::process::exit(0),
        Err(error) => command.clone().error(ErrorKind::Io, error).exit(),
    }
}

/// Prints what `matches` ask for; false where they ask for neither.
fn show(command: &Command, matches: &ArgMatches) -> io::Result<bool> {
    if let Some(shell) = matches.get_one::<Shell>(COMPLETIONS) {
        return stdout().write_all(shell.script(command.clone()).as_bytes()).map(|()| true);
    }
    if matches.get_flag(MAN) {
        return Man::new(command.clone()).render(&mut stdout()).map(|()| true);
    }
    Ok(false)
}
