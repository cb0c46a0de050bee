//! `cable-robot completions`: what a shell completes after `cable-robot`.

use std::io::{Write, stdout};

use anyhow::Result;
use cable_robot::sim::BUNDLED;
use clap::{Args, Command, CommandFactory, ValueHint};

use crate::command::{Arguments, Outcome};
use crate::shell::Shell;

pub const EXAMPLE: &str = "\
Example: cable-robot completions bash
For bash, put the output into ~/.local/share/bash-completion/completions/cable-robot; for zsh, into a file _cable-robot in a
folder of $fpath; for fish, into ~/.config/fish/completions/cable-robot.fish.";

#[derive(Args)]
pub struct Completions {
    /// Shell to write them for
    shell: Shell,
}

impl Completions {
    pub fn run(&self) -> Result<Outcome> {
        let script = match self.shell {
            // clap_complete spells a name with a hyphen in two ways (clap-rs/clap issue 6421), so that no option is found.
            Shell::Bash => {
                self.shell.script(with_scenarios()).replace("cable__subcmd__robot", "cable__robot")
            }
            // In zsh names would stand in place of files.
            Shell::Zsh => self.shell.script(Arguments::command()),
            Shell::Fish => self.shell.script(with_scenarios()) + &fish_values(&with_scenarios()),
        };
        stdout().write_all(script.as_bytes())?;
        Ok(Outcome::Done)
    }
}

/// The command, `simulate` with the names of the bundled scenarios. It takes files as well, which shells offer where no name fits.
fn with_scenarios() -> Command {
    let names = BUNDLED.map(|(name, _)| name);
    Arguments::command().mut_subcommand("simulate", |simulate| {
        simulate.mut_arg("scenario", |scenario| scenario.value_parser(names))
    })
}

/// What clap_complete leaves out for fish: the values of arguments that are no options, with files where these are meant too.
fn fish_values(command: &Command) -> String {
    let mut lines = String::new();
    for task in command.get_subcommands() {
        let name = task.get_name();
        for argument in task.get_positionals() {
            let values: Vec<_> =
                argument.get_possible_values().iter().map(|v| v.get_name().to_owned()).collect();
            if !values.is_empty() {
                let files = if argument.get_value_hint() == ValueHint::FilePath { "" } else { " -f" };
                lines += &format!(
                    "complete -c cable-robot -n \"__fish_cable_robot_using_subcommand {name}\"{files} -a \"{}\"\n",
                    values.join(" ")
                );
            }
        }
    }
    lines
}
