//! The window on the desktop: winit's events in, frames out.
//!
//! Nothing is drawn without a reason: input, a new picture, or something that egui animates. New
//! pictures are drawn at most at the rate below, but the first one after a change at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use egui::{Context, ViewportId};
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalSize};
use winit::event::{KeyEvent, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::keyboard::{Key, PhysicalKey};
use winit::platform::modifier_supplement::KeyEventExtModifierSupplement;
use winit::window::{Fullscreen, Window, WindowId};

use crate::app::App;
use crate::bookmarks::Bookmarks;
use crate::keys::Places;
use crate::onlooker::{Nudge, Onlooker};
use crate::options::{ViewError, ViewOptions};
use crate::recent::Recent;
use crate::render_link::RenderLink;
use crate::shell::WindowRequest;
use crate::surface::Surface;
use crate::text_scale::TextScale;
use crate::views::race::{self, RaceView};
use crate::{gone, writing};

/// What reaches the window beside winit's own events.
#[derive(Debug)]
pub(crate) enum Event {
    /// The picture has changed.
    Published,
    /// Something has come from the background.
    Wake,
    /// Assistive technology.
    AccessKit(accesskit_winit::Event),
    /// From an onlooker, given at that time.
    Nudge(Instant),
}

impl From<accesskit_winit::Event> for Event {
    fn from(event: accesskit_winit::Event) -> Self {
        Self::AccessKit(event)
    }
}

/// Least time between frames that only show a newer picture, on a software adapter.
const SOFTWARE_PERIOD: Duration = Duration::from_millis(80);
/// The same on a graphics processor.
const HARDWARE_PERIOD: Duration = Duration::from_millis(16);

/// Longest time between frames that only show a newer picture.
const SLOWEST_PERIOD: Duration = Duration::from_millis(500);
/// Announcements this close together make one frame.
const COALESCING: Duration = Duration::from_millis(12);

/// How long a frame waits for a coarse picture of what has just been asked for.
const COARSE_PATIENCE: Duration = Duration::from_millis(33);

/// Opens the window and stays until it is closed, by its user or an onlooker.
///
/// # Errors
/// If there is no display, no graphics adapter, or no threads.
pub(crate) fn run(
    options: ViewOptions,
    onlooker: Option<&mut dyn Onlooker>,
) -> Result<(), ViewError> {
    let event_loop = EventLoop::<Event>::with_user_event()
        .build()
        .map_err(|e| ViewError::NoDisplay(one_line(&e.to_string())))?;
    gone::watch(&event_loop);
    let mut handler = Handler {
        proxy: event_loop.create_proxy(),
        options: Some(options),
        running: None,
        failure: None,
        onlooker,
    };
    let run = event_loop.run_app(&mut handler);
    writing::finish(gone::PATIENCE);
    // A loop that has begun fails only when its display does.
    run.map_err(|_| ViewError::Gone)?;
    match handler.failure {
        Some(failure) => Err(failure),
        None => Ok(()),
    }
}

fn one_line(text: &str) -> String {
    text.lines().collect::<Vec<_>>().join(" ")
}

struct Handler<'a> {
    proxy: EventLoopProxy<Event>,
    options: Option<ViewOptions>,
    running: Option<Running>,
    failure: Option<ViewError>,
    onlooker: Option<&'a mut dyn Onlooker>,
}

struct Running {
    window: Arc<Window>,
    surface: Surface,
    ctx: Context,
    egui: egui_winit::State,
    app: App,
    /// What stands in the title bar.
    title: String,
    is_announced: Arc<AtomicBool>,
    period: Duration,
    is_software: bool,
    drawn: Instant,
    /// How long the last frame took.
    cost: Duration,
    /// The interface's own part of it.
    share: Duration,
    next: Option<Instant>,
}

impl Handler<'_> {
    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), ViewError> {
        let Some(options) = self.options.take() else {
            return Ok(());
        };
        let other = |e: &dyn std::fmt::Display| ViewError::Other(e.to_string());
        let attributes = Window::default_attributes()
            .with_title("neumann")
            .with_visible(false)
            .with_inner_size(LogicalSize::new(1280.0, 720.0))
            .with_min_inner_size(LogicalSize::new(640.0, 420.0));
        let window = event_loop
            .create_window(attributes)
            .map_err(|e| ViewError::NoDisplay(one_line(&e.to_string())))?;
        let window = Arc::new(window);
        let ctx = Context::default();
        crate::theme::install(&ctx);
        crate::theme::set_cleared(&ctx);
        let is_announced = Arc::new(AtomicBool::new(false));
        let (proxy, flag) = (self.proxy.clone(), Arc::clone(&is_announced));
        let link = RenderLink::live(options.threads, move || {
            if !flag.swap(true, Ordering::AcqRel) {
                // The loop has gone when the window has.
                let _ = proxy.send_event(Event::Published);
            }
        })
        .map_err(|e| other(&e))?;
        let proxy = self.proxy.clone();
        let sizes = options.clone();
        let mut app = App::new(link, options, move || {
            let _ = proxy.send_event(Event::Wake);
        });
        app.shell.recent = Recent::load();
        if let Some(race) = app.viewing.views.get_mut::<RaceView>() {
            race.cache = race::cache_folder();
        }
        app.shell.bookmarks = Bookmarks::load();
        if let Some(complaint) = app.shell.bookmarks.complaint() {
            app.shell.notices.failure(complaint);
        }
        app.shell.text_scale = TextScale::load();
        app.shell.places = Places::of_display();
        app.open_first_scene();
        // The scene is read while the graphics device gets ready.
        let start = Instant::now();
        let surface = Surface::new(event_loop, Arc::clone(&window))?;
        app.largest_side = surface.max_texture_side();
        sizes.check_sizes(app.largest_side)?;
        let adapter = start.elapsed();
        let mut egui = egui_winit::State::new(
            ctx.clone(),
            ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(surface.max_texture_side()),
        );
        egui.init_accesskit(event_loop, &window, self.proxy.clone());
        window.set_visible(true);
        window.request_redraw();
        let is_software = surface.is_software;
        let period = if is_software {
            SOFTWARE_PERIOD
        } else {
            HARDWARE_PERIOD
        };
        if let Some(onlooker) = &mut self.onlooker {
            onlooker.opened(adapter, Nudge(self.proxy.clone()));
        }
        self.running = Some(Running {
            window,
            surface,
            ctx,
            egui,
            app,
            title: String::new(),
            is_announced,
            period,
            is_software,
            drawn: Instant::now(),
            cost: Duration::ZERO,
            share: Duration::ZERO,
            next: None,
        });
        Ok(())
    }
}

impl ApplicationHandler<Event> for Handler<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if let Err(failure) = self.open(event_loop) {
            self.failure = Some(failure);
            event_loop.exit();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(running) = &mut self.running else {
            return;
        };
        match &event {
            WindowEvent::CloseRequested => {
                close(running, event_loop);
                return;
            }
            WindowEvent::Destroyed => running.surface.is_gone = true,
            WindowEvent::RedrawRequested => {
                running.redraw(event_loop);
                if let Some(onlooker) = &mut self.onlooker {
                    onlooker.presented(&running.app, running.share);
                }
                return;
            }
            WindowEvent::Resized(PhysicalSize { width, height }) => {
                running.surface.resize(*width, *height);
            }
            WindowEvent::KeyboardInput { event, .. } => running.learn(event),
            _ => {}
        }
        if running
            .egui
            .on_window_event(&running.window, &event)
            .repaint
        {
            running.window.request_redraw();
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, event: Event) {
        let Some(running) = &mut self.running else {
            return;
        };
        match event {
            Event::Published => {
                if running.app.session.is_current() || running.app.session.catching_up().is_some() {
                    running.wake_at(running.due());
                } else {
                    running.window.request_redraw();
                }
            }
            Event::Wake => running.window.request_redraw(),
            Event::AccessKit(event) => {
                running.take_accesskit(event);
                running.window.request_redraw();
            }
            Event::Nudge(given) => {
                let Some(onlooker) = &mut self.onlooker else {
                    return;
                };
                let input = running.egui.egui_input_mut();
                if onlooker.nudged(given, &mut running.app, input) {
                    running.window.request_redraw();
                } else {
                    close(running, event_loop);
                }
            }
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(running)) = (cause, &mut self.running) {
            running.next = None;
            running.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if self.running.as_ref().is_some_and(|r| r.surface.is_gone) {
            self.failure = Some(ViewError::Gone);
            event_loop.exit();
            return;
        }
        let next = self.running.as_ref().and_then(|r| r.next);
        event_loop.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        self.running = None;
    }
}

/// Takes the window away first, so that closing is immediate whatever still has to end.
fn close(running: &Running, event_loop: &ActiveEventLoop) {
    running.window.set_visible(false);
    event_loop.exit();
}

impl Running {
    fn redraw(&mut self, event_loop: &ActiveEventLoop) {
        self.is_announced.store(false, Ordering::Release);
        self.next = None;
        let start = Instant::now();
        let n_starts = self.app.session.link.n_starts();
        let mut output = self.lay_out();
        let mut laid_out = start.elapsed();
        if self.app.session.link.n_starts() != n_starts && self.first_frame_comes() {
            // One frame that shows what was asked for is there sooner than one that does not and a
            // second one that does.
            let start = Instant::now();
            let newer = self.lay_out();
            output.append(newer);
            laid_out += start.elapsed();
        }
        self.egui
            .handle_platform_output(&self.window, std::mem::take(&mut output.platform_output));
        let delay = output
            .viewport_output
            .get(&ViewportId::ROOT)
            .map_or(Duration::MAX, |viewport| viewport.repaint_delay);
        // Egui asks for one more frame after any input; it must not stand in the way of the next.
        if let Some(at) = Instant::now().checked_add(delay.max(self.period)) {
            self.wake_at(at);
        }
        let presenting = Instant::now();
        let prepared = self.surface.present(&self.window, &self.ctx, output);
        self.drawn = Instant::now();
        self.cost = presenting.elapsed();
        self.share = laid_out + prepared.unwrap_or_default();
        let title = self.app.title();
        if title != self.title {
            self.window.set_title(&title);
            self.title = title;
        }
        for request in std::mem::take(&mut self.app.shell.requests) {
            match request {
                WindowRequest::Quit => close(self, event_loop),
                WindowRequest::Fullscreen => {
                    let is_full = self.window.fullscreen().is_some();
                    let wanted = (!is_full).then_some(Fullscreen::Borderless(None));
                    self.window.set_fullscreen(wanted);
                }
            }
        }
    }

    /// When the picture that was just announced is to be drawn.
    ///
    /// A film and its statistics are announced one after the other; a frame waits for both. On a
    /// software adapter a frame costs the renderer time: at full resolution, where each iteration
    /// changes little, frames take an eighth of it at most.
    fn due(&self) -> Instant {
        let is_climbing = self.app.session.picture.divisor > 1;
        let pause = if !self.is_software || is_climbing {
            self.period
        } else {
            (8 * self.cost).clamp(self.period, SLOWEST_PERIOD)
        };
        (self.drawn + pause).max(Instant::now() + COALESCING)
    }

    fn lay_out(&mut self) -> egui::FullOutput {
        let input = self.egui.take_egui_input(&self.window);
        self.ctx.run_ui(input, |ui| self.app.ui(ui))
    }

    /// Waits a moment for the first frame of what has just been started; true if it has come.
    fn first_frame_comes(&self) -> bool {
        let start = Instant::now();
        let link = &self.app.session.link;
        while !link.is_paused() && !link.is_held() && start.elapsed() < COARSE_PATIENCE {
            if link.read(|published| published.generation) == link.generation() {
                return true;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        false
    }

    fn wake_at(&mut self, at: Instant) {
        self.next = Some(self.next.map_or(at, |next| next.min(at)));
    }

    /// Takes over what a key prints, for the help page.
    fn learn(&mut self, event: &KeyEvent) {
        if let (PhysicalKey::Code(place), Key::Character(printed)) =
            (event.physical_key, event.key_without_modifiers())
        {
            self.app.shell.places.learn(place, &printed);
        }
    }

    fn take_accesskit(&mut self, event: accesskit_winit::Event) {
        use accesskit_winit::WindowEvent;
        match event.window_event {
            WindowEvent::InitialTreeRequested => self.ctx.enable_accesskit(),
            WindowEvent::ActionRequested(request) => {
                self.egui.on_accesskit_action_request(request);
            }
            WindowEvent::AccessibilityDeactivated => self.ctx.disable_accesskit(),
        }
    }
}
