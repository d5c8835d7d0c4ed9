//! Signals that a parent had the program ignore stay ignored; the others end it well.

#![cfg(target_os = "linux")]

use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::Folder;

/// Starts a render that lasts, by way of a shell that ignores the signals.
fn start(folder: &Folder, ignored: &str) -> Child {
    let program = env!("CARGO_BIN_EXE_neumann");
    let line = format!(
        "trap '' {ignored}; exec {program} render cornell --size 16x16 --time 1000 -o a.exr"
    );
    let trapless = line.trim_start_matches("trap '' ; ").to_owned();
    let child = Command::new("sh")
        .args(["-c", &trapless])
        .current_dir(folder.join("."))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // It listens once its thread for signals is there.
    let start = Instant::now();
    while !has_thread(&child, "neumann-signals") {
        assert!(start.elapsed() < Duration::from_secs(60), "it never began");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

fn has_thread(child: &Child, name: &str) -> bool {
    let Ok(tasks) = std::fs::read_dir(format!("/proc/{}/task", child.id())) else {
        return false;
    };
    tasks.flatten().any(|task| {
        let comm = std::fs::read_to_string(task.path().join("comm"));
        comm.is_ok_and(|comm| comm.trim() == name)
    })
}

fn signal(child: &Child, name: &str) {
    let pid = child.id().to_string();
    let status = Command::new("kill").args([name, &pid]).status().unwrap();
    assert!(status.success());
}

fn has_ended(child: &mut Child) -> bool {
    std::thread::sleep(Duration::from_millis(700));
    child.try_wait().unwrap().is_some()
}

/// Ends it, and finds its picture written.
fn end(mut child: Child, folder: &Folder, by: &str) {
    signal(&child, by);
    let mut stderr = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut stderr)
        .unwrap();
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(1), "{stderr}");
    assert!(folder.film("a.exr").film.n_iterations() > 0);
}

#[test]
fn what_nohup_ignores_stays_ignored() {
    let folder = Folder::new();
    let mut child = start(&folder, "HUP");
    signal(&child, "-HUP");
    assert!(!has_ended(&mut child), "nohup did not help");
    end(child, &folder, "-INT");
}

#[test]
fn what_a_script_in_the_background_ignores_stays_ignored() {
    let folder = Folder::new();
    let mut child = start(&folder, "INT");
    signal(&child, "-INT");
    assert!(!has_ended(&mut child), "Ctrl-C was not ignored");
    end(child, &folder, "-TERM");
}

#[test]
fn a_terminal_that_goes_away_ends_the_render_with_its_picture() {
    let folder = Folder::new();
    let child = start(&folder, "");
    end(child, &folder, "-HUP");
}
