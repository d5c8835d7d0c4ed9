//! The window's state, and one frame of it: shared by the window, screenshots and tests.
//!
//! A [`Session`] is what is rendered, [`Viewing`] how it is looked at, and the [`Shell`] what
//! stands around it. Panels and views take of these what they need.

mod actions;
mod opening;

use std::sync::Arc;
use std::time::Duration;

use egui::{Context, Rect, Ui, pos2};
use neumann_core::scene::OpeningProgress;
use neumann_picture::state::{EnvironmentState, State};

use crate::compared::Compared;
use crate::display::ViewSettings;
use crate::flight::Flight;
use crate::keys;
use crate::options::{Exposure, ViewOptions};
use crate::render_link::RenderLink;
use crate::session::Session;
use crate::setup::Setup;
use crate::shell::{Command, Shell};
use crate::status::{self, Status};
use crate::viewing::Viewing;
use crate::views::{self, Stage, VIEWS};
use crate::widgets::significant;
use crate::{filmstrip, help, panels, save, theme, top_bar};

/// All state of the window.
pub struct App {
    /// What is rendered, and the film of it.
    pub session: Session,
    /// How it is looked at.
    pub viewing: Viewing,
    /// What stands around it.
    pub shell: Shell,
    /// Most pixels of a film each way, which is what the graphics device can draw.
    pub(crate) largest_side: usize,
    options: ViewOptions,
    is_first_scene: bool,
    /// Exposure follows the picture because the scene is the user's own, not because anybody asked.
    exposes_by_itself: bool,
    loading: Option<Loading>,
    /// Level and turn of a map that is still being read.
    map_to_come: Option<EnvironmentState>,
    /// A map that the command asked for is still being read.
    awaits_map: bool,
    /// Size of texts in the last frame, and whether that was a presentation.
    look: (f32, bool),
    flight: Flight,
}

/// How often the bar of a scene that is being opened is drawn anew.
const PROGRESS_PERIOD: Duration = Duration::from_millis(50);

/// A scene on its way.
pub struct Loading {
    /// What it was asked for by.
    pub source: String,
    /// How far it is.
    pub progress: OpeningProgress,
    /// Number of the request.
    request: u64,
    /// What is to be taken up when it is there.
    state: Option<Box<State>>,
}

const TOP: f32 = 40.0;
const STATUS: f32 = 24.0;
const PANEL: f32 = 272.0;

impl App {
    /// A window on what `link` renders. `wake` asks for a frame, from any thread.
    #[must_use]
    pub fn new(
        link: RenderLink,
        options: ViewOptions,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let (setup, complaints) = Setup::new(&options);
        let mut shell = Shell::new(Arc::new(wake));
        for complaint in complaints {
            shell.notices.failure(complaint);
        }
        let settings = ViewSettings {
            part: options.part,
            exposure_ev: match options.exposure {
                Exposure::Stops(stops) => stops,
                _ => 0.0,
            },
            is_auto: options.exposure == Exposure::Auto,
            tone: options.tone,
            ..ViewSettings::default()
        };
        let is_debounced = options.screenshot.is_none();
        Self {
            session: Session::new(setup, link, is_debounced),
            viewing: Viewing {
                settings,
                ..Viewing::default()
            },
            shell,
            largest_side: 8192,
            options,
            is_first_scene: true,
            exposes_by_itself: false,
            loading: None,
            map_to_come: None,
            awaits_map: false,
            look: (1.0, false),
            flight: Flight::default(),
        }
    }

    /// True while a scene is being opened.
    #[must_use]
    pub fn is_loading(&self) -> bool {
        self.loading.is_some()
    }

    /// The scene that is being opened.
    #[must_use]
    pub fn loading(&self) -> Option<&Loading> {
        self.loading.as_ref()
    }

    /// What stands in the window's title bar: scene, method and program.
    #[must_use]
    pub fn title(&self) -> String {
        let setup = &self.session.setup;
        match &setup.open {
            Some(open) => format!("{} – {} – neumann", open.short_name(), setup.method().id),
            None => "neumann".to_owned(),
        }
    }

    /// Draws one frame and acts on its input.
    pub fn ui(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        if !theme::is_installed(&ctx) {
            theme::install(&ctx);
            ctx.request_repaint();
            return;
        }
        self.take_arrivals(&ctx);
        self.take_dropped_files(&ctx);
        self.take_pasted(&ctx);
        if self.is_loading() {
            ctx.request_repaint_after(PROGRESS_PERIOD);
        }
        if let Some(list) = &mut self.shell.file_list {
            let choice = list.take_keys(&ctx);
            self.take_choice(choice);
        }
        for action in keys::take_actions(&ctx) {
            self.perform(&ctx, action);
        }
        if self.flight.steer(&ctx, &mut self.session.setup) {
            let speed = significant(f64::from(self.flight.speed()), 2);
            let text = format!("Flying at {speed} scene radii a second");
            self.shell
                .notices
                .remark_instead(&ctx, &["Flying at "], text);
        }
        self.follow_exposure();
        self.session.refresh(&mut self.viewing.settings);
        self.send_to_tev(&ctx);
        self.follow_exposure();

        let is_presenting = self.shell.is_presenting;
        self.shell.text_scale.apply(&ctx, is_presenting);
        let stage = if is_presenting {
            self.presentation(ui)
        } else if self.shell.is_bare {
            ctx.content_rect()
        } else {
            self.surroundings(ui)
        };
        self.follow_exposure();
        let room = stage.size() * ctx.pixels_per_point();
        let look = (ctx.zoom_factor(), is_presenting);
        let looks_different = std::mem::replace(&mut self.look, look) != look;
        if looks_different && !self.session.setup.is_changed {
            self.session.keep_size_in(room);
        } else if let Some(rest) = self.session.follow_room(room) {
            ctx.request_repaint_after(rest);
        }
        let viewing = &mut self.viewing;
        viewing.views.attend(&mut self.session, &viewing.settings);
        let mut stage_of_view = Stage {
            rect: stage,
            session: &mut self.session,
            settings: &mut viewing.settings,
            placement: &mut viewing.placement,
            caption: Rect::NOTHING,
            picked: None,
            notices: &mut self.shell.notices,
            opening: self.loading.as_ref().map(|l| &l.progress),
        };
        viewing.views.draw(ui, &mut stage_of_view);
        if let Some(picked) = stage_of_view.picked {
            self.shell.show_picked(picked);
            ctx.request_repaint();
        }
        self.measure(&ctx);
        if let Some(offer) = self.shell.notices.show(&ctx, stage) {
            self.accept(offer);
        }
        if let Some(list) = &mut self.shell.file_list {
            let choice = list.show(&ctx);
            self.take_choice(choice);
        }
        if self.shell.is_help_open {
            help::show(ui, &mut self.shell.is_help_open, &self.shell.places);
        }
        self.remember_views(&ctx);
        self.shell.had_focus = ctx.memory(|m| m.focused().is_some());
        let session = &mut self.session;
        session.history.follow(&ctx, &session.setup);
        session.start_if_changed();
    }

    /// Has what is new sent to tev, while that is wanted.
    fn send_to_tev(&mut self, ctx: &Context) {
        let (sending, session) = (&mut self.shell.sending, &self.session);
        if let Some(errand) = sending.next_errand(session) {
            self.shell.background.send(errand);
        } else if let Some(rest) = sending.rest(session) {
            ctx.request_repaint_after(rest);
        }
    }

    /// Remembers the views of the scene for the next start, unless one is being named.
    fn remember_views(&mut self, ctx: &Context) {
        let setup = &self.session.setup;
        if let Some(open) = &setup.open
            && !ctx.text_edit_focused()
        {
            self.shell.bookmarks.keep(&open.source, &setup.views);
        }
    }

    /// Has it measured how far the two pictures on the screen are apart.
    fn measure(&mut self, ctx: &Context) {
        if self.viewing.views.shown().id != VIEWS[0].id {
            return;
        }
        let compared = Compared::of(&self.session, &self.viewing.settings);
        let settings = &self.viewing.settings;
        if let Some(measurement) = self.session.next_measurement(&compared, settings) {
            self.shell.background.measure(measurement);
        } else if compared.sides().is_some()
            && let Some(rest) = self.session.measuring.rest()
        {
            ctx.request_repaint_after(rest);
        }
    }

    fn follow_exposure(&mut self) {
        let viewing = &mut self.viewing;
        viewing.set_exposure.follow(&mut viewing.settings);
    }

    /// Draws bars, filmstrip and panel; yields what they leave for the picture.
    fn surroundings(&mut self, ui: &mut Ui) -> Rect {
        let window = ui.ctx().content_rect();
        let top = Rect::from_min_max(window.min, pos2(window.right(), window.top() + TOP));
        top_bar::show(ui, top, &mut self.session, &mut self.shell);
        self.obey(ui.ctx());
        let bottom = Rect::from_min_max(pos2(window.left(), window.bottom() - STATUS), window.max);
        let strip = self.strip(ui, bottom.top(), filmstrip::Form::of(window.size()));
        let panel_width = if window.width() < 800.0 { 240.0 } else { PANEL };
        let panel = Rect::from_min_max(
            pos2(window.right() - panel_width, top.bottom()),
            pos2(window.right(), strip.top()),
        );
        panels::show(
            ui,
            panel,
            &mut self.session,
            &mut self.viewing,
            &mut self.shell,
        );
        self.obey(ui.ctx());
        self.status_line(ui, bottom);
        Rect::from_min_max(
            pos2(window.left(), top.bottom()),
            pos2(panel.left(), strip.top()),
        )
    }

    /// Draws what a lecture room is to see: the method above, the filmstrip below; yields what they
    /// leave for the picture.
    fn presentation(&mut self, ui: &mut Ui) -> Rect {
        let window = ui.ctx().content_rect();
        let top = Rect::from_min_max(window.min, pos2(window.right(), window.top() + TOP));
        top_bar::present(ui, top, self.session.setup.method(), self.session.bias());
        let form = filmstrip::Form::presented(window.size());
        let strip = self.strip(ui, window.bottom(), form);
        Rect::from_min_max(
            pos2(window.left(), top.bottom()),
            pos2(window.right(), strip.top()),
        )
    }

    /// Draws the filmstrip above `bottom`; yields where it stands.
    fn strip(&mut self, ui: &mut Ui, bottom: f32, form: filmstrip::Form) -> Rect {
        let window = ui.ctx().content_rect();
        let strip = Rect::from_min_max(
            pos2(window.left(), bottom - form.height()),
            pos2(window.right(), bottom),
        );
        let n_draws = filmstrip::show(
            ui,
            strip,
            form,
            &self.session.picture,
            &mut self.viewing.settings,
            views::N_DRAWS,
        );
        debug_assert!(
            n_draws <= crate::display::MAX_DRAWS,
            "room for all draw calls"
        );
        strip
    }

    /// Does what bars and panels have asked for.
    fn obey(&mut self, ctx: &Context) {
        for command in self.shell.take_commands() {
            match command {
                Command::Do(action) => self.perform(ctx, action),
                Command::OpenScene(source) => self.open_path(source),
                Command::ReferToHeld(which) => self.refer_to_held(which),
                Command::SaveAs => {
                    save::png_as(&self.session, &self.viewing, &mut self.shell);
                }
            }
        }
    }

    fn status_line(&mut self, ui: &mut Ui, rect: Rect) {
        let session = &self.session;
        let status = Status {
            picture: &session.picture,
            stop: session.setup.stop,
            is_paused: session.link.is_paused() || session.link.is_held(),
            is_waiting: !session.is_current(),
            catching_up: session.catching_up(),
            is_after_region: session.is_after_region(),
            region: session.setup.region,
            can_fit: session.can_fit(),
            opening: self.loading.as_ref().map(|l| &l.progress),
            bias: session.bias(),
        };
        if status::show(ui, rect, &status) {
            self.session.setup.choose_region(None);
        }
    }
}
