//! `cable-robot completions`: what a shell completes after `cable-robot`.

use std::io::{Write, stdout};

use anyhow::Result;
use clap::{Args, CommandFactory, ValueEnum};
use clap_complete::{Generator, shells};

use crate::{Arguments, Outcome};

pub const EXAMPLE: &str = "\
Example: cable-robot completions bash
For bash, put the output into ~/.local/share/bash-completion/completions/cable-robot; for zsh, into a file _cable-robot in a
folder of $fpath; for fish, into ~/.config/fish/completions/cable-robot.fish.";

#[derive(Args)]
pub struct Completions {
    /// Shell to write them for
    shell: Shell,
}

#[derive(Clone, Copy, ValueEnum)]
enum Shell {
    Bash,
    Zsh,
    Fish,
}

impl Completions {
    pub fn run(&self) -> Result<Outcome> {
        let script = match self.shell {
            // clap_complete spells a name with a hyphen in two ways (clap-rs/clap issue 6421), so that no option is found.
            Shell::Bash => script(shells::Bash).replace("cable__subcmd__robot", "cable__robot"),
            Shell::Zsh => script(shells::Zsh),
            Shell::Fish => script(shells::Fish),
        };
        stdout().write_all(script.as_bytes())?;
        Ok(Outcome::Done)
    }
}

fn script(shell: impl Generator) -> String {
    let mut script = vec![];
    clap_complete::generate(shell, &mut Arguments::command(), "cable-robot", &mut script);
    String::from_utf8_lossy(&script).into_owned()
}
