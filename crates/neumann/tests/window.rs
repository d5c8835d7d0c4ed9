//! The real window under a virtual display: it opens, draws, answers keys, and closes.
//!
//! Needs Xvfb, xdotool, `import` (of `ImageMagick`) and a graphics driver. Where one of them is
//! missing the test says so and passes, unless `CI` is set.

#![cfg(feature = "window")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stderr, reason = "a test says that it is left out")]

use std::io::Read;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use neumann_picture::image_file::read_image;

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
    _server: Guard,
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
        let name = format!(":{}", String::from_utf8(number).ok()?.trim());
        let folder =
            std::env::temp_dir().join(format!("neumann-window-test-{}", std::process::id()));
        std::fs::create_dir_all(&folder).ok()?;
        Some(Self {
            _server: Guard(server),
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

#[test]
fn the_window_opens_draws_answers_keys_and_closes() {
    let has = |tool: &str| {
        Command::new(tool)
            .arg("-version")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .is_ok()
    };
    let is_ci = std::env::var_os("CI").is_some();
    if !(has("Xvfb") && has("xdotool") && has("import")) {
        assert!(!is_ci, "Xvfb, xdotool and import must be there");
        eprintln!("left out: needs Xvfb, xdotool and ImageMagick");
        return;
    }
    let display = Display::open().unwrap();
    let mut program = Guard(
        Command::new(env!("CARGO_BIN_EXE_neumann"))
            .args(["view", "cornell"])
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .env("HOME", &display.folder)
            .env("XDG_CONFIG_HOME", &display.folder)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap(),
    );

    // It opens.
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

    // It draws: the middle of the red wall is red.
    let total = display.wait_for("picture", |d| {
        let pixels = d.pixels("total.png");
        (n_red(&pixels) > 5000).then_some(pixels)
    });

    // A key changes the view: emission alone has no red wall.
    display.tool("xdotool", &["key", "0"]);
    let emitted = display.wait_for("emission alone", |d| {
        let pixels = d.pixels("emitted.png");
        (n_red(&pixels) < 500).then_some(pixels)
    });
    assert!(difference(&total, &emitted) > 0.02);

    // And it closes.
    display.tool("xdotool", &["key", "ctrl+q"]);
    let status = display.wait_for("end", |_| program.0.try_wait().unwrap());
    assert!(status.success(), "{status}");
    let _ = std::fs::remove_dir_all(&display.folder);
}
