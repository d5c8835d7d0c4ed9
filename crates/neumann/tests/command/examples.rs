//! Every command that a person may copy works: those of all `--help` texts, of README and of docs.
//!
//! Commands of one text run one after the other in one folder, as somebody who follows the text
//! would run them. Sizes and times are made small on the way, and files that a command reads are
//! put there. What opens the window draws it to a file instead, where there is a graphics adapter.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use neumann_core::integrator::{METHODS, NOTATION};

use super::Folder;
use super::tev::fake::FakeTev;

/// Where the workspace is.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Puts a file there that a command reads.
fn provide(folder: &Folder, name: &str) {
    let path = folder.join(name);
    if path.exists() {
        return;
    }
    let scenes = root().join("assets/scenes");
    match Path::new(name).extension().and_then(|e| e.to_str()) {
        Some("gltf" | "glb") => drop(fs::copy(scenes.join("cornell.glb"), path).unwrap()),
        Some("hdr") => drop(fs::copy(scenes.join("sky.hdr"), path).unwrap()),
        Some("exr" | "png") => {
            folder.succeed(&format!(
                "render cornell --size 16x16 --iterations 1 -o {name}"
            ));
        }
        Some("json") => fs::write(path, r#"{"scene": "cornell"}"#).unwrap(),
        _ => panic!("{name}: this test does not know how to make such a file"),
    }
}

fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_owned).collect()
}

/// A text of `neumann … --help`.
fn help(subcommand: &str) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_neumann"))
        .args(subcommand.split_whitespace())
        .arg("--help")
        .output()
        .unwrap();
    assert!(output.status.success(), "{subcommand}");
    String::from_utf8(output.stdout).unwrap()
}

/// The subcommands, as `neumann --help` lists them.
fn subcommands() -> Vec<String> {
    let text = help("");
    let (_, list) = text.split_once("Commands:\n").unwrap();
    list.lines()
        .take_while(|line| !line.trim().is_empty())
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect()
}

/// The commands of a help text: its examples, and those that it quotes.
fn commands_of_help(text: &str) -> Vec<String> {
    let mut commands: Vec<_> = quoted(text, '\'');
    let (_, examples) = text.split_once("Examples:\n").unwrap();
    for line in examples.lines().take_while(|line| !line.trim().is_empty()) {
        let line = line.trim();
        assert!(
            line.starts_with("neumann"),
            "an example has one line: {line}"
        );
        commands.push(line.to_owned());
    }
    commands
}

/// The commands of a document: lines of its blocks for the shell, and those that stand in a text.
fn commands_of_document(text: &str) -> Vec<String> {
    let mut commands = Vec::new();
    let mut fence: Option<&str> = None;
    let mut prose = String::new();
    let mut begun = String::new();
    for line in text.lines() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            fence = match fence {
                None => Some(language),
                Some(_) => None,
            };
            continue;
        }
        match fence {
            None => prose += &format!("{line}\n"),
            Some("sh") => {
                let line = line.split(" #").next().unwrap().trim();
                if let Some(part) = line.strip_suffix('\\') {
                    begun += part;
                } else if !line.is_empty() && !line.starts_with('#') {
                    commands.push(format!("{begun}{line}"));
                    begun.clear();
                }
            }
            Some(_) => {}
        }
    }
    commands.extend(quoted(&prose, '`'));
    commands
}

/// What stands between two marks and begins as a command of ours.
fn quoted(text: &str, mark: char) -> Vec<String> {
    let begins = ["neumann ", "scripts/", "cargo "];
    text.split(mark)
        .skip(1)
        .step_by(2)
        .filter(|part| begins.iter().any(|begin| part.starts_with(begin)))
        .map(|part| words(part).join(" "))
        .collect()
}

/// Runs all commands of a text, or finds that they are there.
fn try_all(origin: &str, commands: &[String]) {
    let folder = Folder::new();
    for line in commands {
        let mut line = words(line.split(" >").next().unwrap());
        let program = line.remove(0);
        match program.as_str() {
            "neumann" => try_one(&folder, origin, line),
            "cargo" => match line.iter().position(|word| word == "-p") {
                Some(at) => check_package(origin, &line[at + 1]),
                None if line
                    .iter()
                    .any(|word| word == "--workspace" || word == "--all") => {}
                None if line[0] == "run" => {
                    let own = line.iter().skip_while(|word| *word != "--").skip(1);
                    try_one(&folder, origin, own.cloned().collect());
                }
                None => panic!("{origin}: cargo {line:?}: which package?"),
            },
            "apt" => {}
            script if script.starts_with("scripts/") => {
                assert!(root().join(script).is_file(), "{origin}: no {script}");
            }
            // Schedulers have a test of their own, scripts/test-farm.
            "sbatch" | "squeue" | "scancel" | "hq" | "pip" => {}
            _ => panic!("{origin}: this test does not know the command {program}"),
        }
    }
}

fn check_package(origin: &str, package: &str) {
    let is_there = |folder: &str| {
        let manifest = fs::read_to_string(root().join(folder).join("Cargo.toml"));
        manifest.is_ok_and(|text| text.contains(&format!("name = \"{package}\"")))
    };
    let folder = format!("crates/{package}");
    assert!(
        is_there(&folder) || is_there("tests"),
        "{origin}: no package {package}"
    );
}

/// Runs one command, made small, which must succeed.
fn try_one(folder: &Folder, origin: &str, mut line: Vec<String>) {
    let said = format!("{origin}: neumann {}", line.join(" "));
    for word in &mut line {
        match word.as_str() {
            "SCENE" => "cornell".clone_into(word),
            "ID" => "pt-mis".clone_into(word),
            // Standard input has a test of its own.
            "-" => "state.json".clone_into(word),
            _ => {}
        }
    }
    let subcommand = line.first().cloned().unwrap_or_default();
    let all = subcommands();
    if line.len() == 1 && all.contains(&subcommand) {
        // The subcommand is named, not a command given.
        help(&subcommand);
        return;
    }
    let mut opens_window = subcommand == "view";
    if line.is_empty() || (!all.contains(&subcommand) && !subcommand.starts_with('-')) {
        // `neumann` and `neumann SCENE` open the window.
        let scene = line.pop().unwrap_or_else(|| "cornell".to_owned());
        line = vec!["view".to_owned(), scene];
        opens_window = true;
    }
    if matches!(subcommand.as_str(), "render" | "series") || opens_window {
        make_small(&mut line, opens_window);
    }
    let is_output = |i: usize| i > 0 && ["-o", "--output", "--screenshot"].contains(&&*line[i - 1]);
    for (i, word) in line.iter().enumerate() {
        let is_file = [".exr", ".png", ".hdr", ".gltf", ".glb", ".json"]
            .iter()
            .any(|ending| word.ends_with(ending));
        if is_file && !is_output(i) {
            provide(folder, word);
        }
    }
    if opens_window && cfg!(not(feature = "window")) {
        return;
    }
    let tev = provide_tev(&mut line);
    let output = folder.run(&line.join(" "));
    drop(tev);
    let stderr = String::from_utf8_lossy(&output.stderr);
    let has_no_adapter = opens_window && stderr.contains("no graphics adapter");
    if has_no_adapter && std::env::var_os("CI").is_none() {
        eprintln!("left out, for want of a graphics adapter: {said}");
        return;
    }
    assert!(output.status.success(), "{said}, run as {line:?}: {stderr}");
}

/// Lets somebody listen for a command that sends pictures to tev.
fn provide_tev(line: &mut Vec<String>) -> Option<FakeTev> {
    let address = line.iter().position(|word| word == "--tev")? + 1;
    if line.get(address).is_some_and(|word| word.contains(':')) {
        line.remove(address);
    }
    let tev = FakeTev::listen();
    line.insert(address, tev.address().to_owned());
    Some(tev)
}

/// Counts become a 64th, so that ranges of iterations that go together still do; pictures and times
/// become small.
fn make_small(line: &mut Vec<String>, opens_window: bool) {
    let mut has = Vec::new();
    for i in 1..line.len() {
        let option = line[i - 1].clone();
        let value = &mut line[i];
        let fewer = |text: &str| text.parse::<u32>().unwrap().div_ceil(64).to_string();
        match option.as_str() {
            "--iterations" | "--first-iteration" | "--after" => *value = fewer(value),
            "--size" => "16x16".clone_into(value),
            "--region" => "4,4,8,6".clone_into(value),
            "--window-size" => "640x360".clone_into(value),
            "--time" => "0.1".clone_into(value),
            "--until-error" => "0.5".clone_into(value),
            _ => {}
        }
        has.push(option);
    }
    let has = |option: &str| has.iter().any(|word| word == option);
    let mut more = Vec::new();
    if !has("--size") {
        more.push("--size 16x16");
    }
    if opens_window {
        if !has("--screenshot") {
            more.push("--screenshot window.png");
        }
        if !has("--after") {
            more.push("--after 1");
        }
        if !has("--window-size") {
            more.push("--window-size 640x360");
        }
    } else if !["--iterations", "--time", "--until-error"]
        .into_iter()
        .any(has)
    {
        more.push("--iterations 1");
    }
    line.extend(words(&more.join(" ")));
}

#[test]
fn every_command_of_the_help_works() {
    try_all("neumann --help", &commands_of_help(&help("")));
    let mut n_commands = 0;
    for name in subcommands() {
        let commands = commands_of_help(&help(&name));
        n_commands += commands.len();
        try_all(&format!("neumann {name} --help"), &commands);
    }
    assert!(n_commands > 20, "{n_commands}");
}

/// What is written for people: the pages of the root, and all of docs.
fn documents() -> Vec<PathBuf> {
    let pages = [
        "README.md",
        "ARCHITECTURE.md",
        "CONTRIBUTING.md",
        "CHANGELOG.md",
    ];
    let mut documents: Vec<_> = pages.map(|page| root().join(page)).into();
    for folder in ["docs", "docs/decisions"] {
        let entries = fs::read_dir(root().join(folder)).unwrap();
        let paths = entries.map(|entry| entry.unwrap().path());
        documents.extend(paths.filter(|path| path.extension().is_some_and(|e| e == "md")));
    }
    documents.sort();
    documents
}

#[test]
fn every_command_of_readme_and_docs_works() {
    let mut n_commands = 0;
    for path in documents() {
        let commands = commands_of_document(&fs::read_to_string(&path).unwrap());
        n_commands += commands.len();
        try_all(&path.file_name().unwrap().to_string_lossy(), &commands);
    }
    assert!(n_commands > 15, "{n_commands}");
}

/// docs/methods.md says what the program says; `UPDATE_SNAPSHOTS=true` writes it.
#[test]
fn methods_are_explained_in_docs_as_in_the_program() {
    let mut page = String::from(
        "# Methods\n\nHow each method estimates light. `neumann explain` prints the same, and the \
         window shows it on\nthe page Method. What a method cannot see, and how it is biased, is \
         in the [README](../README.md#methods).\n\n",
    );
    page += NOTATION;
    page += "\n";
    for m in METHODS {
        page += &format!(
            "\n## `{}`: {}\n```text\n{}\n\n{}```\n",
            m.id, m.name, m.formula, m.pseudo_code
        );
    }
    let path = root().join("docs/methods.md");
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        fs::write(&path, &page).unwrap();
    }
    assert!(
        fs::read_to_string(path).unwrap() == page,
        "docs/methods.md is old: run this test with UPDATE_SNAPSHOTS=true"
    );
    let folder = Folder::new();
    let said = folder.succeed("explain vcm");
    let vcm = METHODS.iter().find(|m| m.id == "vcm").unwrap();
    for line in vcm.pseudo_code.lines().chain([vcm.formula, NOTATION]) {
        assert!(said.contains(line), "{line} not in {said}");
    }
}
