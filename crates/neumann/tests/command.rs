//! The command as its users meet it: exit codes, files, JSON, resume, merge, threads.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![allow(clippy::print_stderr, reason = "a test says what it leaves out")]

#[path = "command/agree.rs"]
mod agree;
#[path = "command/backs.rs"]
mod backs;
#[path = "command/bias.rs"]
mod bias;
#[path = "command/classes.rs"]
mod classes;
#[path = "command/continued.rs"]
mod continued;
#[path = "command/examples.rs"]
mod examples;
#[path = "command/files_of_others.rs"]
mod files_of_others;
#[path = "command/hemisphere.rs"]
mod hemisphere;
#[path = "command/inspect.rs"]
mod inspect;
#[path = "command/lobe.rs"]
mod lobe;
#[path = "command/photons.rs"]
mod photons;
#[path = "command/race.rs"]
mod race;
#[path = "command/refusals.rs"]
mod refusals;
#[path = "command/replay.rs"]
mod replay;
#[path = "command/signals.rs"]
mod signals;
#[cfg(feature = "window")]
#[path = "command/states.rs"]
mod states;
#[path = "command/tev.rs"]
mod tev;

use std::path::PathBuf;
use std::process::{Command, Output};
use std::sync::atomic::{AtomicU32, Ordering};

use neumann_core::film::View;
use neumann_picture::exr_file::{Checkpoint, read_exr, read_layers};
use neumann_picture::image_file::read_image;
use serde_json::Value;

/// A folder of its own, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static COUNTER: AtomicU32 = AtomicU32::new(0);
        let n = COUNTER.fetch_add(1, Ordering::Relaxed);
        let path =
            std::env::temp_dir().join(format!("neumann-command-test-{}-{n}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn join(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Runs the command in this folder.
    fn run(&self, line: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_neumann"))
            .args(line.split_whitespace())
            .current_dir(&self.0)
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .env("HOME", &self.0)
            .env("XDG_CONFIG_HOME", &self.0)
            .output()
            .unwrap()
    }

    /// Runs the command, which must succeed; yields its stdout.
    fn succeed(&self, line: &str) -> String {
        let output = self.run(line);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "neumann {line}: {stderr}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs the command, which must end with the given code; yields its stderr.
    fn fail(&self, line: &str, code: i32) -> String {
        let output = self.run(line);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "neumann {line}: {stderr}");
        assert!(output.stdout.is_empty(), "errors go to stderr");
        stderr
    }

    fn film(&self, name: &str) -> Checkpoint {
        read_exr(&self.join(name)).unwrap()
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(&self.0)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn stderr_of(folder: &Folder, line: &str) -> String {
    let output = folder.run(line);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "neumann {line}: {stderr}");
    stderr
}

#[test]
fn help_explains_every_subcommand() {
    let folder = Folder::new();
    let text = folder.succeed("--help");
    for name in [
        "view",
        "render",
        "series",
        "compare",
        "list",
        "info",
        "merge",
        "completions",
    ] {
        assert!(text.contains(name), "{name}");
        let help = folder.succeed(&format!("{name} --help"));
        assert!(help.contains("Examples:"), "{name}");
    }
    assert!(folder.succeed("completions bash").contains("neumann"));
    assert!(folder.succeed("--version").starts_with("neumann "));
}

#[test]
fn wrong_usage_and_bad_input_end_with_2_and_one_line() {
    let folder = Folder::new();
    std::fs::write(folder.join("bad.gltf"), b"{ nonsense").unwrap();
    std::fs::write(folder.join("bad.exr"), b"v/1\x01 nonsense").unwrap();
    let cases = [
        ("render bad.gltf -o a.exr", "bad.gltf"),
        ("render missing.gltf -o a.exr", "missing.gltf"),
        ("render cornell -o no/such/a.exr", "no/such"),
        ("render cornell -o a.jpg", ".exr or .png"),
        ("render cornell -o a.exr -o a.exr", "twice"),
        ("render cornell -o a.exr --camera nobody", "nobody"),
        ("render cornell -o a.exr --set nothing=1", "nothing"),
        ("render cornell -o a.png --resume", "--resume"),
        ("render cornell -o a.exr --env missing.hdr", "missing.hdr"),
        ("render cornell -o a.exr --env-rotation 90", "--env"),
        (
            "render cornell -o a.exr --first-iteration 4294967295",
            "--first-iteration",
        ),
        ("info bad.gltf", "bad.gltf"),
        ("compare bad.exr bad.exr", "bad.exr"),
        ("merge bad.exr bad.exr -o a.exr", "bad.exr"),
        ("view missing.gltf", "missing.gltf"),
        ("missing.gltf", "missing.gltf"),
    ];
    for (line, expected) in cases {
        let stderr = folder.fail(line, 2);
        assert!(stderr.contains(expected), "neumann {line}: {stderr}");
        assert_eq!(
            stderr.trim_end().lines().count(),
            1,
            "neumann {line}: {stderr}"
        );
    }
    for line in [
        "render cornell",
        "render cornell -o a.exr --size huge",
        "list nothing",
        "--nonsense",
    ] {
        folder.fail(line, 2);
    }
    assert_eq!(
        folder.names(),
        ["bad.exr", "bad.gltf"],
        "nothing was written"
    );
}

#[test]
fn a_region_is_rendered_alone_and_told_apart() {
    let folder = Folder::new();
    let line = "render cornell -o r.exr --size 48x48 --region 8,20,24,10 --iterations 4";
    folder.succeed(line);
    let film = folder.film("r.exr");
    assert_eq!((film.film.width(), film.film.height()), (24, 10));
    // What the camera sees first is that of the whole picture.
    folder.succeed("render cornell -o w.exr --size 48x48 --iterations 1");
    let (part, whole) = (
        film.features.unwrap(),
        folder.film("w.exr").features.unwrap(),
    );
    for (x, y) in [(0, 0), (23, 9), (11, 4)] {
        let (a, b) = (part.depth[y * 24 + x], whole.depth[(y + 20) * 48 + x + 8]);
        assert!((a / b - 1.0).abs() < 1e-4, "{x} {y}: {a} {b}");
    }
    for (line, said) in [
        (
            "render cornell -o r.exr --size 48x48 --region 9,20,24,10 --iterations 8 --resume",
            "cannot be resumed",
        ),
        (
            "render cornell -o r.exr --size 48x48 --region 30,20,24,10",
            "reaches beyond the picture of 48x48",
        ),
        (
            "render cornell -o r.exr --region 1,2,3",
            "use COLUMN,ROW,WIDTH,HEIGHT",
        ),
    ] {
        let output = folder.run(line);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}: {stderr}");
        assert!(stderr.contains(said), "{line}: {stderr}");
    }
}

#[test]
fn a_render_writes_its_files_and_reports_what_it_did() {
    let folder = Folder::new();
    let line = "render furnace -o f.exr -o f.png --size 24x16 --iterations 16 --threads 2 --json";
    let report: Value = serde_json::from_str(&folder.succeed(line)).unwrap();
    let object = report.as_object().unwrap();
    let mut keys: Vec<_> = object.keys().map(String::as_str).collect();
    keys.sort_unstable();
    let mut expected = [
        "integrator",
        "iterations",
        "first_iteration",
        "seconds",
        "ms_per_iteration",
        "samples_per_second",
        "rays_per_second",
        "refused",
        "estimated_error",
        "term_errors",
        "peak_memory_bytes",
        "outputs",
    ];
    expected.sort_unstable();
    assert_eq!(keys, expected);
    assert_eq!(report["iterations"], 16);
    assert_eq!(report["refused"], 0);
    assert_eq!(report["outputs"].as_array().unwrap().len(), 2);
    let film = folder.film("f.exr");
    assert_eq!((film.film.width(), film.film.height()), (24, 16));
    assert_eq!(film.metadata.iterations.to_string(), "0-15");
    // Layer k of the furnace is 0.5^k.
    for (k, mean) in film.film.layer_means().iter().take(3).enumerate() {
        assert!(
            (mean[1] - 0.5f64.powi(k as i32)).abs() < 0.02,
            "{k}: {mean:?}"
        );
    }
    let features = film.features.unwrap();
    assert!((features.albedo[0].g - 0.5).abs() < 0.01);
    assert!(features.depth.iter().all(|z| z.is_finite()));
    let shown = read_image(&folder.join("f.png")).unwrap();
    assert_eq!((shown.width, shown.height), (24, 16));
    assert_eq!(
        folder.names(),
        ["f.exr", "f.png"],
        "no temporary files stay"
    );
}

#[test]
fn threads_do_not_change_a_bit() {
    let folder = Folder::new();
    for threads in [1, 2, 7] {
        folder.succeed(&format!(
            "render cornell-glass -o {threads}.exr --size 40x30 --iterations 4 --threads {threads}"
        ));
    }
    let one = folder.film("1.exr");
    for other in [folder.film("2.exr"), folder.film("7.exr")] {
        assert_eq!(one.film.layers(), other.film.layers());
        assert_eq!(one.film.total(), other.film.total());
        assert_eq!(one.film.variance_of_mean(7), other.film.variance_of_mean(7));
    }
}

/// In the furnace each bounce keeps half of the light, exactly.
#[test]
fn a_series_tells_how_its_terms_decay() {
    let folder = Folder::new();
    let line = "series furnace -o out --size 32x32 --iterations 64 --layers 8 --json";
    let report: Value = serde_json::from_str(&folder.succeed(line)).unwrap();
    let number = |name: &str| report["decay"][name].as_f64().unwrap();
    assert!(
        (number("ratio") - 0.5).abs() < 3.0 * number("error"),
        "{report}"
    );
    assert!(number("error") < 0.05);
    // Half of all light is emission, half of the rest is T L_e, and so on up to bounce 16.
    let beyond = 0.5f64.powi(17);
    let apart = (number("beyond") - beyond).abs();
    assert!(apart < 3.0 * number("beyond_error"), "{report}");
}

#[test]
fn a_series_has_every_term_and_a_sheet() {
    let folder = Folder::new();
    let report: Value = serde_json::from_str(
        &folder.succeed("series furnace -o out --size 16x16 --iterations 4 --layers 2 --json"),
    )
    .unwrap();
    let mut names: Vec<_> = std::fs::read_dir(folder.join("out"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected = [
        "L.exr",
        "L.png",
        "T0.exr",
        "T0.png",
        "T1.exr",
        "T1.png",
        "energy.csv",
        "energy.svg",
        "sheet.png",
        "tail.exr",
        "tail.png",
        "upto0.exr",
        "upto0.png",
        "upto1.exr",
        "upto1.png",
    ];
    assert_eq!(names, expected);
    assert_eq!(report["outputs"].as_array().unwrap().len(), expected.len());
    let shares = report["energy_shares"].as_array().unwrap();
    let sum: f64 = shares.iter().map(|s| s.as_f64().unwrap()).sum();
    assert!((sum - 1.0).abs() < 1e-9 && shares.len() == 3);
    let energy = std::fs::read_to_string(folder.join("out/energy.csv")).unwrap();
    let first = energy.lines().nth(1).unwrap().split(',').nth(1).unwrap();
    assert_eq!(first.parse::<f64>().unwrap(), shares[0].as_f64().unwrap());
    let term = read_image(&folder.join("out/T1.exr")).unwrap();
    assert_eq!(term.pixels, folder.film("out/L.exr").film.layers()[1]);
    folder.succeed("series furnace -o out --size 16x16 --iterations 6 --layers 2 --resume");
    assert_eq!(folder.film("out/L.exr").film.n_iterations(), 6);
}

#[test]
fn pictures_are_compared_layer_by_layer() {
    let folder = Folder::new();
    let base = "render furnace --size 16x16 --iterations 8";
    folder.succeed(&format!("{base} -o a.exr"));
    folder.succeed(&format!("{base} -o b.exr --seed 5"));
    let compare = |line: &str| -> Value {
        serde_json::from_str(&folder.succeed(&format!("compare {line} --json"))).unwrap()
    };
    let same = compare("a.exr a.exr");
    assert_eq!(
        (same["rmse"].as_f64(), same["flip"].as_f64()),
        (Some(0.0), Some(0.0))
    );
    let other = compare("a.exr b.exr -o d.png");
    assert!(other["rmse"].as_f64().unwrap() > 0.0);
    assert!((other["mean_ratio"][1].as_f64().unwrap() - 1.0).abs() < 0.05);
    assert_eq!(read_image(&folder.join("d.png")).unwrap().width, 16);
    let terms = compare("a.exr a.exr --layer T1");
    assert!((terms["mean"][0].as_f64().unwrap() - 0.5).abs() < 0.05);
    assert!(
        folder
            .fail("compare a.exr b.exr --layer T9", 2)
            .contains("T9")
    );
}

#[test]
fn lists_and_information_are_machine_readable() {
    let folder = Folder::new();
    let json = |line: &str| -> Value { serde_json::from_str(&folder.succeed(line)).unwrap() };
    let scenes = json("list scenes --json");
    assert!(
        scenes
            .as_array()
            .unwrap()
            .iter()
            .any(|s| s["name"] == "cornell")
    );
    let integrators = json("list integrators --json");
    let defaults: Vec<_> = integrators
        .as_array()
        .unwrap()
        .iter()
        .filter(|m| m["is_default"] == true)
        .collect();
    assert_eq!(defaults.len(), 1);
    assert_eq!(defaults[0]["id"], "pt-mis");
    assert!(
        json("list parameters --json")
            .as_array()
            .unwrap()
            .iter()
            .all(|p| p["default"] != Value::Null)
    );
    let info = json("info cornell --json");
    assert!(info["triangles"].as_u64().unwrap() >= 10);
    assert_eq!(info["cameras"].as_array().unwrap().len(), 1);
    for what in ["scenes", "integrators", "parameters"] {
        assert!(folder.succeed(&format!("list {what}")).lines().count() > 3);
    }
}

#[test]
fn goals_of_time_and_error_end_a_render() {
    let folder = Folder::new();
    let base = "render furnace --size 8x8 -o a.exr --json";
    let report: Value =
        serde_json::from_str(&folder.succeed(&format!("{base} --time 0.2"))).unwrap();
    assert!(report["iterations"].as_u64().unwrap() > 1);
    let line = format!("{base} --until-error 0.02 --integrator pt-nee");
    let report: Value = serde_json::from_str(&folder.succeed(&line)).unwrap();
    assert!(report["estimated_error"].as_f64().unwrap() <= 0.02);
}

#[test]
fn the_error_of_a_black_picture_is_unknown() {
    let folder = Folder::new();
    let line = "render cornell --eye 0,100,0 --target 0,200,1 --size 8x8 -o a.exr --json \
                --until-error 0.5 --iterations 20";
    let report: Value = serde_json::from_str(&folder.succeed(line)).unwrap();
    assert_eq!(report["iterations"], 20);
    assert!(report["estimated_error"].is_null());
}

#[cfg(unix)]
#[cfg(unix)]
#[test]
fn techniques_are_written_apart_and_photons_reported() {
    let folder = Folder::new();
    let line = "render cornell -o v.exr --integrator vcm --size 48x32 --iterations 2 \
        --max-bounces 4 --techniques pyramid --techniques-divisor 2 --json";
    let report: Value = serde_json::from_str(&folder.succeed(line)).unwrap();
    assert_eq!(report["photons"]["light_paths"], 48 * 32);
    assert!(report["photons"]["radius"].as_f64().unwrap() > 0.0);
    let sheet = read_image(&folder.join("pyramid/techniques.png")).unwrap();
    assert!(sheet.width > 600 && sheet.height > 600);
    let techniques = read_layers(&folder.join("pyramid/techniques.exr")).unwrap();
    assert_eq!((techniques.width, techniques.height), (24, 16));
    for name in ["s0t2", "s1t2", "s2t1", "s1t2.raw", "merge-s2t2", "rest"] {
        assert!(techniques.layers.contains_key(name), "{name}");
    }
    // Its R, G, B is L, averaged over two by two pixels.
    let film = folder.film("v.exr").film;
    for (i, found) in techniques.pixels.iter().enumerate() {
        let (x, y) = (i % 24 * 2, i / 24 * 2);
        let at = |dx: usize, dy: usize| film.radiance(View::Total, (y + dy) * 48 + x + dx).g;
        let mean = 0.25 * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1));
        assert!((found.g - mean).abs() <= 1e-5 * mean.max(1e-3), "{i}");
    }
    folder.fail("render cornell -o v.exr --techniques-divisor 2", 2);
}
