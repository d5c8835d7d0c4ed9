//! Measures how soon the window answers: from the moment an input is sent, on another
//! thread, until the frame that shows its effect has been presented.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Event as Input, Key, Modifiers, RawInput};
use glam::Vec2;
use winit::event_loop::EventLoopProxy;

use crate::app::App;
use crate::camera_control::CameraControl;
use crate::options::{ViewError, ViewOptions};
use crate::picture::Picture;
use crate::render_link::RenderLink;
use crate::window::{self, Event};

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Changes of the view, and steps of the camera.
    pub n_steps: u32,
    /// Time without input, with and without a window, to compare rendering speeds.
    pub quiet: Duration,
}

/// What was measured; times in milliseconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Key sent to changed view presented: median and 95th percentile.
    pub view: [f64; 2],
    /// Camera moved to a frame of the new picture presented.
    pub camera: [f64; 2],
    /// Camera moved to a frame of the new picture computed, without a window.
    pub coarse: [f64; 2],
    /// From the start of the program to the first frame with light in it.
    pub first_light: f64,
    /// The part of it in which the graphics adapter was set up.
    pub adapter: f64,
    /// The interface's own share of a frame: layout, combining layers, upload.
    pub share: [f64; 2],
    /// Combining layers alone.
    pub compose: [f64; 2],
    /// Iterations per second with the window open and no input.
    pub with_window: f64,
    /// The same without a window.
    pub without_window: f64,
    /// Pixels of the film.
    pub size: (usize, usize),
}

impl Report {
    /// As JSON.
    #[must_use]
    pub fn to_json(&self) -> String {
        let pair = |[median, p95]: [f64; 2]| format!("{{\"median\":{median:.1},\"p95\":{p95:.1}}}");
        format!(
            "{{\"film\":[{},{}],\"key_to_view_ms\":{},\"camera_to_coarse_frame_ms\":{},\
             \"camera_to_coarse_frame_computed_ms\":{},\"start_to_first_light_ms\":{:.1},\
             \"of_it_adapter_ms\":{:.1},\"interface_share_ms\":{},\"compose_ms\":{},\"iterations_per_second_with_window\":{:.3},\
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
///
/// # Errors
/// As [`crate::run`].
pub fn measure(options: ViewOptions, plan: Plan) -> Result<Report, ViewError> {
    let began = Instant::now();
    let threads = options.threads;
    let Some(measured) = window::run(options, Some(plan))? else {
        return Err(ViewError::Other("nothing was measured".to_owned()));
    };
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
    let mut control = CameraControl::new(job.settings.camera.clone(), job.scene.bounds());
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
pub(crate) struct Latencies {
    plan: Plan,
    first_light: Option<Instant>,
    pub(crate) adapter: Duration,
    n_sent: u32,
    awaited: Option<Awaited>,
    view: Vec<Duration>,
    camera: Vec<Duration>,
    shares: Vec<Duration>,
    compose: Vec<Duration>,
    quiet: Option<(Instant, u32)>,
    with_window: f64,
    size: (usize, usize),
    pub(crate) job: Option<neumann_core::render::Job>,
}

impl Latencies {
    pub(crate) fn new(plan: Plan) -> Self {
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

    /// Sends the steps, at uneven intervals so that they fall anywhere within a frame.
    pub(crate) fn begin(&self, proxy: EventLoopProxy<Event>) {
        let plan = self.plan;
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
                    if proxy.send_event(Event::Measure(Instant::now())).is_err() {
                        return;
                    }
                    std::thread::sleep(pause);
                }
            });
    }

    /// Takes the next step; false when all have been taken.
    pub(crate) fn step(&mut self, sent: Instant, app: &mut App, input: &mut RawInput) -> bool {
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
    pub(crate) fn frame_presented(&mut self, is_current: bool, share: Duration, picture: &Picture) {
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
