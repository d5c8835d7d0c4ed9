//! The real window under a virtual display: it opens, draws, answers keys, and closes.
//!
//! Needs Xvfb, xdotool, setxkbmap, `import` (of `ImageMagick`) and a graphics driver. Where one of
//! them is missing the test says so and passes, unless `CI` is set.

#![cfg(feature = "window")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stderr, reason = "a test says that it is left out")]

use std::io::Read;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use neumann_picture::image_file::read_image;
use neumann_picture::state::State;

/// A child process that does not outlive the test.
struct Guard(Child);

impl Drop for Guard {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A display of its own, found by Xvfb.
struct Display {
    server: Guard,
    name: String,
    folder: PathBuf,
}

impl Display {
    fn open() -> Option<Self> {
        let mut server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                "1280x720x24",
                // Else it starts anew when the first tool leaves, and drops the window on its way.
                "-noreset",
                "-nolisten",
                "tcp",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut number = Vec::new();
        let mut stdout = server.stdout.take()?;
        let mut byte = [0];
        while stdout.read(&mut byte).ok()? == 1 && byte[0] != b'\n' {
            number.push(byte[0]);
        }
        let number = String::from_utf8(number).ok()?.trim().to_owned();
        let name = format!(":{number}");
        let folder = format!("neumann-window-test-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(folder);
        std::fs::create_dir_all(&folder).ok()?;
        Some(Self {
            server: Guard(server),
            name,
            folder,
        })
    }

    fn tool(&self, program: &str, arguments: &[&str]) -> Option<String> {
        let output = Command::new(program)
            .args(arguments)
            .env("DISPLAY", &self.name)
            .output()
            .ok()?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    }

    /// The pixels on the screen.
    fn pixels(&self, name: &str) -> Vec<[f32; 3]> {
        let path = self.folder.join(name);
        let text = path.to_str().unwrap();
        self.tool("import", &["-window", "root", text]).unwrap();
        let image = read_image(&path).unwrap();
        image.pixels.iter().map(|p| p.to_array()).collect()
    }

    /// Asks again and again, up to a minute: a loaded machine may be slow.
    fn wait_for<T>(&self, what: &str, mut question: impl FnMut(&Self) -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(answer) = question(self) {
                return answer;
            }
            assert!(
                start.elapsed() < Duration::from_secs(60),
                "no {what} within a minute"
            );
            std::thread::sleep(Duration::from_millis(250));
        }
    }
}

/// Mean absolute difference of two screens.
fn difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    let sum: f32 = a
        .iter()
        .zip(b)
        .map(|(p, q)| (0..3).map(|c| (p[c] - q[c]).abs()).sum::<f32>())
        .sum();
    sum / a.len() as f32
}

/// Red pixels above the filmstrip.
fn n_red(pixels: &[[f32; 3]]) -> usize {
    let picture = &pixels[..500 * 1280];
    let is_red = |p: &&[f32; 3]| p[0] > 3.0 * p[1] && p[0] > 0.05;
    picture.iter().filter(is_red).count()
}

/// The window with a scene in it, on a display of its own.
struct Opened {
    display: Display,
    program: Guard,
    window: String,
}

/// `None` if a tool is missing here.
fn open(scene: &str) -> Option<Opened> {
    let has = |tool: &str| {
        Command::new(tool)
            .arg("-version")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .is_ok()
    };
    let is_ci = std::env::var_os("CI").is_some();
    if !["Xvfb", "xdotool", "import", "setxkbmap"]
        .into_iter()
        .all(has)
    {
        assert!(!is_ci, "Xvfb, xdotool, import and setxkbmap must be there");
        eprintln!("left out: needs Xvfb, xdotool, setxkbmap and ImageMagick");
        return None;
    }
    let display = Display::open().unwrap();
    let mut program = Guard(
        Command::new(env!("CARGO_BIN_EXE_neumann"))
            .args(["view", scene])
            .current_dir(&display.folder)
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .env("HOME", &display.folder)
            .env("XDG_CONFIG_HOME", &display.folder)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let window = display.wait_for("window", |d| {
        if let Some(status) = program.0.try_wait().unwrap() {
            let mut text = String::new();
            if let Some(mut stderr) = program.0.stderr.take() {
                let _ = stderr.read_to_string(&mut text);
            }
            panic!("the program ended by itself: {status}: {text}");
        }
        let found = d.tool("xdotool", &["search", "--onlyvisible", "--name", "neumann"])?;
        found.lines().next().map(str::to_owned)
    });
    display.tool("xdotool", &["windowfocus", &window]);
    Some(Opened {
        display,
        program,
        window,
    })
}

impl Opened {
    fn press(&self, keys: &str) {
        self.display.tool("xdotool", &["key", keys]);
    }

    /// Waits for the end; yields the exit code and what stands on stderr.
    fn ended(&mut self) -> (Option<i32>, String) {
        let program = &mut self.program.0;
        let status = self
            .display
            .wait_for("end", |_| program.try_wait().unwrap());
        let mut text = String::new();
        let mut stderr = program.stderr.take().unwrap();
        stderr.read_to_string(&mut text).unwrap();
        // Of the graphics driver, where nobody has logged in.
        let lines = text
            .lines()
            .filter(|line| !line.contains("XDG_RUNTIME_DIR"));
        (status.code(), lines.collect::<Vec<_>>().join("\n"))
    }

    /// Closes it by its key; it ends well.
    fn close(mut self) {
        self.press("ctrl+q");
        let status = self
            .display
            .wait_for("end", |_| self.program.0.try_wait().unwrap());
        assert!(status.success(), "{status}");
        let _ = std::fs::remove_dir_all(&self.display.folder);
    }
}

#[test]
fn the_window_opens_draws_answers_keys_and_closes() {
    let Some(opened) = open("cornell") else {
        return;
    };
    let display = &opened.display;

    // It draws: the middle of the red wall is red.
    let total = display.wait_for("picture", |d| {
        let pixels = d.pixels("total.png");
        (n_red(&pixels) > 5000).then_some(pixels)
    });

    // A key changes the view: emission alone has no red wall.
    opened.press("0");
    let emitted = display.wait_for("emission alone", |d| {
        let pixels = d.pixels("emitted.png");
        (n_red(&pixels) < 500).then_some(pixels)
    });
    assert!(difference(&total, &emitted) > 0.02);
    opened.close();
}

/// Codes of keys as an X server counts them: where they are, whatever they print.
const DIGIT_1: &str = "10";
const DIGIT_4: &str = "13";
const DIGIT_6: &str = "15";
const DIGIT_7: &str = "16";

/// The same places show the same parts of the series on every keyboard; saved states tell which.
#[test]
fn digits_are_places_on_every_keyboard() {
    let Some(opened) = open("furnace") else {
        return;
    };
    let display = &opened.display;
    let state = |after: &str| {
        opened.press("ctrl+shift+s");
        display.wait_for(&format!("state after {after}"), |d| {
            let files = std::fs::read_dir(&d.folder).unwrap();
            let mut files = files.map(|file| file.unwrap().path());
            let path = files.find(|path| path.extension().is_some_and(|e| e == "json"))?;
            let state = State::read(&path).ok()?.0;
            std::fs::remove_file(path).unwrap();
            Some(state)
        })
    };
    for layout in ["us", "de", "fr", "cz"] {
        display.tool("setxkbmap", &["-display", &display.name, layout]);
        for (keys, part) in [
            (vec![DIGIT_4], "T4"),
            (vec!["shift", DIGIT_1], "upto:1"),
            (vec![DIGIT_6], "T6"),
            (vec!["shift", DIGIT_7], "upto:7"),
            (vec![DIGIT_1], "T1"),
        ] {
            opened.press(&keys.join("+"));
            let state = state(&format!("{keys:?} on {layout}"));
            assert_eq!(state.part, part, "{keys:?} on {layout}");
            assert_eq!(state.magnified, None, "{keys:?} on {layout}");
        }
    }
    opened.close();
}

const GONE: &str =
    "error: the window is gone: its display has ended, or another program has closed it";

/// However the window is taken away, the program says so once, and keeps what it was to keep.
#[test]
fn a_window_that_is_taken_away_ends_the_program_with_one_sentence() {
    for how in ["windowkill", "windowclose", "server"] {
        let Some(mut opened) = open("furnace") else {
            return;
        };
        let folder = opened.display.folder.clone();
        // There is a state as soon as there is a scene.
        let kept = opened.display.wait_for("state", |_| {
            opened.press("ctrl+shift+s");
            let files = std::fs::read_dir(&folder).unwrap();
            let mut files = files.map(|file| file.unwrap().path());
            files.find(|path| path.extension().is_some_and(|e| e == "json"))
        });
        opened.press("ctrl+plus");
        let scale = folder.join("neumann").join("text-scale.txt");
        opened
            .display
            .wait_for("size of texts", |_| scale.exists().then_some(()));
        match how {
            "server" => opened.display.server.0.kill().unwrap(),
            _ => {
                let window = opened.window.clone();
                opened.display.tool("xdotool", &[how, &window]);
            }
        }
        let (code, text) = opened.ended();
        assert_eq!((code, text.as_str()), (Some(1), GONE), "{how}");
        State::read(&kept).unwrap();
        assert_eq!(std::fs::read_to_string(scale).unwrap(), "1.1\n", "{how}");
        std::fs::remove_dir_all(folder).unwrap();
    }
}
