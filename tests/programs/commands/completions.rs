//! What shells complete after the names of the programs, and their pages for `man`.

use std::fs;
use std::process::Command;

/// The completion script for a shell.
fn completions(shell: &str) -> String {
    let output =
        Command::new(env!("CARGO_BIN_EXE_cable-robot")).args(["completions", shell]).output().unwrap();
    assert!(output.status.success(), "{shell}");
    String::from_utf8(output.stdout).unwrap()
}

/// What bash completes after these words.
fn bash_completes(words: &str, current: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("completions.bash");
    fs::write(&script, completions("bash")).unwrap();
    // As bash does when the tabulator is pressed: the function it was told, the words, the one to complete.
    let ask = format!(
        "source {}; complete -p cable-robot > /dev/null || exit 1; COMP_WORDS=({words} '{current}'); \
         COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _cable__robot cable-robot '{current}' ''; echo ${{COMPREPLY[@]}}",
        script.display()
    );
    let output = Command::new("bash").args(["-c", &ask]).output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn bash_completes_commands_and_their_options() {
    assert_eq!(bash_completes("cable-robot", "sim").trim(), "simulate");
    for option in ["--fmu", "--output", "--list", "--planner"] {
        assert!(bash_completes("cable-robot simulate", "--").contains(option), "{option}");
    }
    assert!(!bash_completes("cable-robot plan", "--").contains("--fmu"));
}

#[test]
fn bash_completes_the_names_of_bundled_scenarios() {
    let offered = bash_completes("cable-robot simulate", "");
    assert!(offered.contains("paper") && offered.contains("unreachable"), "{offered}");
    assert_eq!(bash_completes("cable-robot simulate", "ex").trim(), "experiment");
    assert_eq!(bash_completes("cable-robot simulate", "./my").trim(), "", "left to bash: files");
}

/// What fish completes after these words, if it is there.
fn fish_completes(words: &str) -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("completions.fish");
    fs::write(&script, completions("fish")).unwrap();
    fs::write(folder.path().join("a_file.toml"), "").unwrap();
    let ask = format!("source {}; complete -C \"{words}\"", script.display());
    let asked = Command::new("fish").args(["--no-config", "-c", &ask]).current_dir(folder.path()).output();
    Some(String::from_utf8(asked.ok()?.stdout).unwrap())
}

#[test]
fn fish_completes_values_that_are_no_options() {
    let Some(figures) = fish_completes("cable-robot figure ") else {
        // A user may lack fish, continuous integration may not.
        assert!(std::env::var_os("CI").is_none(), "fish is not installed");
        return println!("skipped: fish is not installed");
    };
    assert_eq!(figures.split_whitespace().collect::<Vec<_>>(), ["2", "3", "5", "6", "7", "8", "9", "all"]);
    let scenarios = fish_completes("cable-robot simulate ").unwrap();
    assert!(scenarios.contains("detour") && scenarios.contains("a_file.toml"), "{scenarios}");
}

#[test]
fn zsh_and_fish_are_told_the_options() {
    for (shell, known) in [("zsh", "#compdef cable-robot"), ("fish", "complete -c cable-robot")] {
        let script = completions(shell);
        assert!(script.contains(known) && script.contains("fmu"), "{shell}");
    }
    let scenario =
        completions("zsh").lines().find(|line| line.starts_with("'::scenario")).unwrap().to_owned();
    assert!(scenario.contains("_files"), "{scenario}");
}

#[test]
fn the_other_programs_print_completions_and_their_page() {
    for (program, option) in
        [(env!("CARGO_BIN_EXE_can-bridge"), "replay"), (env!("CARGO_BIN_EXE_rig-sim"), "motor-lag")]
    {
        let run = |arguments: &[&str]| {
            let output = Command::new(program).args(arguments).output().unwrap();
            (output.status.code(), String::from_utf8(output.stdout).unwrap())
        };
        for shell in ["bash", "zsh", "fish"] {
            let (code, script) = run(&["--completions", shell]);
            assert!(code == Some(0) && script.contains(option), "{shell}: {script}");
        }
        let (code, page) = run(&["--man"]);
        assert!(
            code == Some(0) && page.contains(".TH ") && page.contains(&option.replace('-', "\\-")),
            "{page}"
        );
        // Without a file, which other runs need; not beside other options.
        assert_eq!(run(&["--man", "rig.toml"]).0, Some(2));
        assert_eq!(run(&["--completions", "dash"]).0, Some(2));
    }
}

#[test]
fn each_command_has_a_page_for_man() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("share/man1");
    let output = Command::new(env!("CARGO_BIN_EXE_cable-robot")).arg("man").arg(&pages).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for name in ["cable-robot", "cable-robot-plan", "cable-robot-certify", "cable-robot-study"] {
        let page = fs::read_to_string(pages.join(format!("{name}.1"))).unwrap();
        assert!(page.contains(".TH ") && page.contains(".SH SYNOPSIS"), "{page}");
    }
}
