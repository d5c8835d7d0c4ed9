//! How soon the window answers: from the moment an input is sent, on another thread, until the
//! frame that shows its effect has been presented. Prints one line of JSON: `cargo run --release -p
//! neumann-viewer --example latency [STEPS] [SCENE] [idle]`.

use std::io::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Event as Input, Key, Modifiers, RawInput};
use glam::Vec2;
use neumann_core::render::{Job, StopRule};
use neumann_viewer::app::App;
use neumann_viewer::camera_control::CameraControl;
use neumann_viewer::onlooker::{Nudge, Onlooker};
use neumann_viewer::render_link::RenderLink;
use neumann_viewer::{ViewError, ViewOptions};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let n_steps = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(60);
    let options = ViewOptions {
        scene: arguments.next().unwrap_or_default(),
        stop: match arguments.next().as_deref() {
            // Nothing is rendered meanwhile: the interface by itself.
            Some("idle") => StopRule::Iterations(1),
            _ => StopRule::Never,
        },
        ..ViewOptions::default()
    };
    let plan = Plan {
        n_steps,
        quiet: Duration::from_secs(10),
    };
    let text = match measure(options, plan) {
        Ok(report) => report.to_json(),
        Err(error) => error.to_string(),
    };
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// How much is measured.
#[derive(Clone, Copy, Debug)]
struct Plan {
    /// Changes of the view, and steps of the camera.
    n_steps: u32,
    /// Time without input, with and without a window, to compare rendering speeds.
    quiet: Duration,
}

/// What was measured; times in milliseconds.
#[derive(Clone, Debug, Default, PartialEq)]
struct Report {
    /// Key sent to changed view presented: median and 95th percentile.
    view: [f64; 2],
    /// Camera moved to a frame of the new picture presented.
    camera: [f64; 2],
    /// Camera moved to a frame of the new picture computed, without a window.
    coarse: [f64; 2],
    /// From the start of the program to the first frame with light in it.
    first_light: f64,
    /// The part of it in which the graphics adapter was set up.
    adapter: f64,
    /// The interface's own share of a frame: layout, combining layers, upload.
    share: [f64; 2],
    /// Combining layers alone.
    compose: [f64; 2],
    /// Iterations per second with the window open and no input.
    with_window: f64,
    /// The same without a window.
    without_window: f64,
    /// Pixels of the film.
    size: (usize, usize),
}

impl Report {
    /// As JSON.
    fn to_json(&self) -> String {
        let pair = |[median, p95]: [f64; 2]| format!("{{\"median\":{median:.1},\"p95\":{p95:.1}}}");
        format!(
            "{{\"film\":[{},{}],\"key_to_view_ms\":{},\"camera_to_coarse_frame_ms\":{},\
             \"camera_to_coarse_frame_computed_ms\":{},\"start_to_first_light_ms\":{:.1},\
             \"of_it_adapter_ms\":{:.1},\"interface_share_ms\":{},\"compose_ms\":{},\
             \"iterations_per_second_with_window\":{:.3},\
             \"iterations_per_second_without\":{:.3},\"rendering_lost_percent\":{:.1}}}",
            self.size.0,
            self.size.1,
            pair(self.view),
            pair(self.camera),
            pair(self.coarse),
            self.first_light,
            self.adapter,
            pair(self.share),
            pair(self.compose),
            self.with_window,
            self.without_window,
            100.0 * (1.0 - self.with_window / self.without_window.max(1e-9)),
        )
    }
}

/// Opens a window, measures and closes it; then renders the same without a window.
fn measure(options: ViewOptions, plan: Plan) -> Result<Report, ViewError> {
    let began = Instant::now();
    let threads = options.threads;
    let mut measured = Latencies::new(plan);
    neumann_viewer::run_watched(options, &mut measured)?;
    let mut report = measured.report(began);
    if let Some(job) = measured.job {
        let mut link = RenderLink::live(threads, || {}).map_err(ViewError::Other)?;
        link.start(job.scene, job.settings, job.stop);
        std::thread::sleep(Duration::from_secs(2));
        report.without_window = rate(plan.quiet, || {
            link.read(|p| (p.divisor, p.stats.n_iterations))
        });
        report.coarse = percentiles(&coarse_frames(&mut link, plan.n_steps));
    }
    Ok(report)
}

/// Times from a step of the camera to a first frame of what it sees, with rendering under way.
fn coarse_frames(link: &mut RenderLink, n_steps: u32) -> Vec<Duration> {
    let Some(mut job) = link.started().cloned() else {
        return Vec::new();
    };
    let mut control = CameraControl::new(job.settings.camera.clone(), job.scene.subject());
    (0..n_steps)
        .map(|i| {
            std::thread::sleep(Duration::from_millis(280 + u64::from(i * 37 % 101)));
            control.orbit(Vec2::new(if i % 2 == 0 { 0.05 } else { -0.05 }, 0.0));
            job.settings.camera = control.camera().clone();
            let start = Instant::now();
            link.start(Arc::clone(&job.scene), job.settings.clone(), job.stop);
            while link.read(|p| p.generation) != link.generation() {
                std::thread::sleep(Duration::from_micros(200));
            }
            start.elapsed()
        })
        .collect()
}

/// Whole iterations per second, between two of their ends.
fn rate(time: Duration, progress: impl Fn() -> (usize, u32)) -> f64 {
    let mut first = None;
    let mut last = None;
    let start = Instant::now();
    let mut before = progress();
    while start.elapsed() < time {
        std::thread::sleep(Duration::from_millis(1));
        let now = progress();
        if now != before {
            before = now;
            first = first.or(Some((Instant::now(), now.1)));
            last = Some((Instant::now(), now.1));
        }
    }
    match (first, last) {
        (Some((t0, n0)), Some((t1, n1))) if n1 > n0 => f64::from(n1 - n0) / (t1 - t0).as_secs_f64(),
        _ => 0.0,
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Awaited {
    View(Instant),
    Camera(Instant),
}

/// The measurement under way.
struct Latencies {
    plan: Plan,
    first_light: Option<Instant>,
    adapter: Duration,
    n_sent: u32,
    awaited: Option<Awaited>,
    view: Vec<Duration>,
    camera: Vec<Duration>,
    shares: Vec<Duration>,
    compose: Vec<Duration>,
    quiet: Option<(Instant, u32)>,
    with_window: f64,
    size: (usize, usize),
    job: Option<Job>,
}

impl Latencies {
    fn new(plan: Plan) -> Self {
        Self {
            plan,
            first_light: None,
            adapter: Duration::ZERO,
            n_sent: 0,
            awaited: None,
            view: Vec::new(),
            camera: Vec::new(),
            shares: Vec::new(),
            compose: Vec::new(),
            quiet: None,
            with_window: 0.0,
            size: (0, 0),
            job: None,
        }
    }

    /// The measurement's results.
    fn report(&self, began: Instant) -> Report {
        Report {
            view: percentiles(&self.view),
            camera: percentiles(&self.camera),
            coarse: [0.0; 2],
            first_light: self
                .first_light
                .map_or(f64::NAN, |at| milliseconds(at - began)),
            adapter: milliseconds(self.adapter),
            share: percentiles(&self.shares),
            compose: percentiles(&self.compose),
            with_window: self.with_window,
            without_window: 0.0,
            size: self.size,
        }
    }
}

impl Onlooker for Latencies {
    /// Sends the steps, at uneven intervals so that they fall anywhere within a frame.
    fn opened(&mut self, adapter: Duration, nudge: Nudge) {
        let plan = self.plan;
        self.adapter = adapter;
        // Without the thread nothing is measured, and the window stays open.
        let _ = std::thread::Builder::new()
            .name("neumann-measure".to_owned())
            .spawn(move || {
                std::thread::sleep(Duration::from_secs(4));
                for i in 0..2 * plan.n_steps + 3 {
                    let is_quiet = i == 2 * plan.n_steps + 1;
                    let pause = if is_quiet {
                        plan.quiet
                    } else {
                        Duration::from_millis(280 + u64::from(i * 37 % 101))
                    };
                    if !nudge.give() {
                        return;
                    }
                    std::thread::sleep(pause);
                }
            });
    }

    /// Takes the next step; false when all have been taken.
    fn nudged(&mut self, sent: Instant, app: &mut App, input: &mut RawInput) -> bool {
        let (i, n) = (self.n_sent, self.plan.n_steps);
        self.n_sent += 1;
        if i < n {
            let keys = [
                Key::Num1,
                Key::Num2,
                Key::L,
                Key::Num4,
                Key::Num0,
                Key::Num3,
            ];
            let modifiers = if i % 4 == 3 {
                Modifiers::SHIFT
            } else {
                Modifiers::NONE
            };
            for pressed in [true, false] {
                input.events.push(Input::Key {
                    key: keys[i as usize % keys.len()],
                    physical_key: None,
                    pressed,
                    repeat: false,
                    modifiers,
                });
            }
            self.awaited = Some(Awaited::View(sent));
        } else if i < 2 * n {
            if let Some(control) = &mut app.session.setup.camera {
                let turn = if i % 2 == 0 { 0.05 } else { -0.05 };
                control.orbit(Vec2::new(turn, 0.0));
                app.session.setup.is_changed = true;
            }
            self.awaited = Some(Awaited::Camera(sent));
        } else if i == 2 * n {
            // One pause to climb the ladder, then the quiet time begins.
            self.awaited = None;
        } else if i == 2 * n + 1 {
            self.quiet = Some((Instant::now(), app.session.picture.stats.n_iterations));
        } else {
            if let Some((start, before)) = self.quiet {
                let n = app
                    .session
                    .picture
                    .stats
                    .n_iterations
                    .saturating_sub(before);
                self.with_window = f64::from(n) / start.elapsed().as_secs_f64();
            }
            self.job = app.session.link.started().cloned();
            self.size = app.session.picture.size;
            return false;
        }
        true
    }

    /// A frame has been presented.
    fn presented(&mut self, app: &App, share: Duration) {
        let is_current = app.session.is_current();
        let picture = &app.session.picture;
        if self.first_light.is_none() && picture.is_there() {
            self.first_light = Some(Instant::now());
        }
        if self.n_sent > 0 {
            self.shares.push(share);
            self.compose
                .push(Duration::from_micros(u64::from(picture.compose_micros)));
        }
        match self.awaited {
            Some(Awaited::View(sent)) => self.view.push(sent.elapsed()),
            Some(Awaited::Camera(sent)) if is_current => self.camera.push(sent.elapsed()),
            _ => return,
        }
        self.awaited = None;
    }
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Median and 95th percentile, milliseconds.
fn percentiles(times: &[Duration]) -> [f64; 2] {
    let mut times: Vec<f64> = times.iter().copied().map(milliseconds).collect();
    times.sort_by(f64::total_cmp);
    [0.5, 0.95].map(|p| {
        let index = (times.len() as f64 * p) as usize;
        times
            .get(index.min(times.len().saturating_sub(1)))
            .copied()
            .unwrap_or(f64::NAN)
    })
}
