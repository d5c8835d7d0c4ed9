//! What keys and buttons do.

use egui::{Context, Theme};
use neumann_core::film::View as Part;
use neumann_core::integrator::METHODS;
use neumann_picture::tone::ToneCurve;

use super::App;
use crate::command_line;
use crate::compared::Reference;
use crate::display::{Against, image_area};
use crate::keys::Action;
use crate::notices::Offer;
use crate::panels::Page;
use crate::pick;
use crate::region::Drawing;
use crate::save;
use crate::scene_source::Wanted;
use crate::shell::WindowRequest;

impl App {
    /// Does what a key or a button asks for.
    pub fn perform(&mut self, ctx: &Context, action: Action) {
        if self.viewing.views.perform(action) {
            return;
        }
        let n_layers = self.session.setup.n_layers;
        match action {
            Action::Term(k) if k < n_layers => self.viewing.settings.part = Part::Term(k),
            Action::Term(_) => self.viewing.settings.part = Part::Tail,
            Action::Upto(k) if k < n_layers => self.viewing.settings.part = Part::Upto(k),
            Action::Upto(_) | Action::Total => self.viewing.settings.part = Part::Total,
            Action::Step(step) => {
                let (is_sum, place) = self.viewing.settings.place(n_layers);
                let place = place as i64 + i64::from(step);
                let place = place.clamp(0, n_layers as i64) as usize;
                self.viewing.settings.choose(is_sum, place, n_layers);
            }
            Action::Row(is_up) => {
                let (_, place) = self.viewing.settings.place(n_layers);
                self.viewing.settings.choose(!is_up, place, n_layers);
            }
            Action::Method(step) => {
                let n = METHODS.len() as i64;
                let index = (self.session.setup.method as i64 + i64::from(step)).rem_euclid(n);
                self.session.setup.choose_method(index as usize);
            }
            Action::Pause => {
                let is_paused = self.session.link.is_paused();
                self.session.link.pause(!is_paused);
            }
            Action::Restart => self.session.setup.is_changed = true,
            Action::Region => self.begin_or_end_region(),
            Action::FitFilm => self.session.fit(),
            Action::FrameAll | Action::ResetCamera => self.move_camera(action),
            Action::Undo | Action::Redo => self.undo_or_redo(ctx, action),
            Action::Pick => self.pick(ctx),
            Action::GoToView(index) => self.go_to_view(index),
            Action::KeepView(index) => self.keep_view(ctx, index),
            Action::Open => {
                self.shell.show_page(Page::Scene);
                self.shell.background.choose(Wanted::Scene);
            }
            Action::SavePng => save::png(&self.session, &self.viewing, &mut self.shell),
            Action::SaveExr => save::exr(&self.session, &self.viewing, &mut self.shell),
            Action::SaveState => save::state(&self.session, &self.viewing, &mut self.shell),
            Action::SaveSheet => {
                save::sheet(&self.session, &self.viewing.settings, &mut self.shell);
            }
            Action::SendToTev => self.shell.sending.toggle(ctx, &mut self.shell.notices),
            Action::Copy => save::copy(ctx, &self.session, &self.viewing, &mut self.shell),
            Action::CopyCommand => self.copy_command(ctx),
            Action::CopyState => {
                save::copy_state(ctx, &self.session, &self.viewing, &mut self.shell);
            }
            Action::Panels if self.shell.is_presenting => self.shell.is_presenting = false,
            Action::Panels => self.shell.is_bare = !self.shell.is_bare,
            Action::Panel(i) => self.shell.show_page(Page::ALL[i.min(Page::ALL.len() - 1)]),
            Action::Present => self.shell.is_presenting = !self.shell.is_presenting,
            Action::TextScale(tenths) => {
                self.shell.text_scale.step(tenths);
                let percent = 100.0 * self.shell.text_scale.factor();
                let text = format!("Text size {percent:.0} %");
                self.shell
                    .notices
                    .remark_instead(ctx, &["Text size "], text);
            }
            Action::Controls => match ctx.memory(|m| m.focused()) {
                Some(id) => ctx.memory_mut(|m| m.surrender_focus(id)),
                None => {
                    self.shell.show_page(self.shell.page);
                    self.shell.gives_panel_the_keyboard = true;
                }
            },
            Action::Theme => {
                let is_dark = ctx.theme() == Theme::Dark;
                ctx.set_theme(if is_dark { Theme::Light } else { Theme::Dark });
            }
            Action::View(id) => self.toggle_view(id),
            Action::Show(step) => {
                let row = self.viewing.views.further(step);
                self.show_view(row.id);
            }
            Action::Help => self.shell.is_help_open = !self.shell.is_help_open,
            Action::Fullscreen => self.shell.requests.push(WindowRequest::Fullscreen),
            Action::Escape => self.escape(ctx),
            Action::Quit => self.shell.requests.push(WindowRequest::Quit),
            _ => self.change_display(action),
        }
    }

    /// The next drag draws a region, unless there is one, which ends.
    fn begin_or_end_region(&mut self) {
        let setup = &mut self.session.setup;
        let settings = &mut self.viewing.settings;
        if settings.drawing.take().is_some() {
            // It was to be drawn, and is no longer.
        } else if setup.region.is_some() {
            setup.choose_region(None);
        } else if self.session.picture.is_there() {
            settings.drawing = Some(Drawing::default());
            self.viewing.views.close();
        } else {
            let text = "There is no picture yet to choose a region of";
            self.shell.notices.failure(text);
        }
    }

    /// True, with a notice, while only a region is rendered, which is not put aside.
    fn is_held_back(&mut self) -> bool {
        let is_region = self.session.region().is_some();
        if is_region {
            let text = "A region is rendered, and only a whole picture can be held; B ends it";
            self.shell.notices.failure(text);
        }
        is_region
    }

    /// Copies the command that renders what is shown; says what it leaves out.
    fn copy_command(&mut self, ctx: &Context) {
        let notices = &mut self.shell.notices;
        match command_line::of(&self.session, &self.viewing.settings) {
            Some(command) => {
                ctx.copy_text(command.text);
                let mut text = "Copied the command".to_owned();
                for what in command.leaves_out {
                    text.push_str(&format!("; it leaves out {what}, which a state has"));
                }
                notices.remark(ctx, text);
            }
            None => notices.failure("There is no scene yet to render by a command"),
        }
    }

    /// Undoes the last edit of what is rendered, or does again what was undone; says which.
    fn undo_or_redo(&mut self, ctx: &Context, action: Action) {
        let session = &mut self.session;
        let (done, word, verb) = match action {
            Action::Undo => (session.history.undo(&mut session.setup), "Undid", "undo"),
            _ => (session.history.redo(&mut session.setup), "Redid", "redo"),
        };
        let text = match done {
            Some(what) => format!("{word}: {what}"),
            None => format!("Nothing to {verb}"),
        };
        let notices = &mut self.shell.notices;
        // A sky may have come back, or gone again.
        let open = session.setup.open.as_ref();
        let has_sky = open.is_some_and(|o| o.scene.appearance().environment.is_some());
        notices.withdraw(|offer| match offer {
            Offer::PutSkyBack(_) => has_sky,
            Offer::RemoveSky => !has_sky,
            _ => false,
        });
        notices.remark_instead(ctx, &["Undid: ", "Redid: ", "Nothing to "], text);
    }

    /// Shows the material under the pointer, or that in the middle of the picture.
    fn pick(&mut self, ctx: &Context) {
        let Some(placement) = &self.viewing.placement else {
            return;
        };
        let pointer = ctx.input(|i| i.pointer.hover_pos());
        let fraction = pointer.and_then(|at| placement.fraction(at));
        let fraction = fraction.or_else(|| placement.fraction(placement.visible.center()));
        let setup = &self.session.setup;
        if let Some(picked) = fraction.and_then(|f| pick::at(setup, placement, f)) {
            self.shell.show_picked(picked);
        }
    }

    /// Shows a view, or goes back to the picture.
    fn toggle_view(&mut self, id: &str) {
        let viewing = &mut self.viewing;
        let setup = &self.session.setup;
        if let Err(refusal) = viewing.views.toggle(id, setup, &viewing.settings) {
            self.shell.notices.failure(refusal);
        }
    }

    /// Shows a view.
    pub(super) fn show_view(&mut self, id: &str) {
        let (viewing, setup) = (&mut self.viewing, &self.session.setup);
        if let Err(refusal) = viewing.views.show(id, setup, &viewing.settings) {
            self.shell.notices.failure(refusal);
        }
    }

    fn move_camera(&mut self, action: Action) {
        let (w, h) = self.session.setup.size;
        let Some(control) = &mut self.session.setup.camera else {
            return;
        };
        if action == Action::FrameAll {
            control.frame_all(w.max(1) as f32 / h.max(1) as f32);
        } else {
            control.reset();
        }
        self.session.setup.is_changed = true;
    }

    fn go_to_view(&mut self, index: usize) {
        if !self.session.setup.go_to_view(index) {
            let n = index + 1;
            let text = format!(
                "No view {n} of this scene is kept; Ctrl Shift {n} keeps where the camera is"
            );
            self.shell.notices.failure(text);
        }
    }

    fn keep_view(&mut self, ctx: &Context, index: usize) {
        let setup = &mut self.session.setup;
        if let Some(index) = setup.keep_view(index) {
            let name = &setup.views[index].name;
            let text = match index {
                0..=8 => format!("Kept as {name}; Ctrl {} comes back to it", index + 1),
                _ => format!("Kept as {name}"),
            };
            self.shell.notices.remark_instead(ctx, &["Kept as "], text);
        }
    }

    fn change_display(&mut self, action: Action) {
        let is_hold = matches!(action, Action::HoldA | Action::HoldB | Action::Wipe);
        if is_hold && self.is_held_back() {
            return;
        }
        let viewing = &mut self.viewing.settings;
        match action {
            Action::Exposure(thirds) => {
                viewing.is_auto = false;
                viewing.exposure_ev =
                    (viewing.exposure_ev + thirds as f32 / 3.0).clamp(-24.0, 24.0);
            }
            Action::AutoExposure => {
                viewing.is_auto = !viewing.is_auto;
                if viewing.is_auto {
                    viewing.exposure_ev = self.session.picture.auto_exposure(viewing.part);
                }
            }
            Action::Tone(step) => {
                let n = ToneCurve::ALL.len() as i64;
                let now = ToneCurve::ALL.iter().position(|t| *t == viewing.tone);
                let next = (now.unwrap_or(0) as i64 + i64::from(step)).rem_euclid(n);
                viewing.tone = ToneCurve::ALL[next as usize];
            }
            Action::Probe => viewing.is_probing = !viewing.is_probing,
            Action::FalseColour => viewing.is_false_colour = !viewing.is_false_colour,
            Action::Zoom(steps) => {
                if let Some(placement) = &self.viewing.placement {
                    let middle = viewing.center;
                    image_area::zoom(viewing, placement, (steps as f32).exp2(), middle);
                }
            }
            Action::ZoomFit => {
                viewing.zoom = None;
                viewing.center = [0.5, 0.5];
            }
            Action::HoldA => self.session.hold(0, viewing.part),
            Action::HoldB => self.session.hold(1, viewing.part),
            Action::Wipe => {
                if self.session.picture.held[0].is_none() {
                    self.session.hold(0, viewing.part);
                }
                viewing.is_wiping = !viewing.is_wiping;
                viewing.difference = None;
            }
            Action::Difference => {
                if viewing.difference.take().is_some() {
                    // It was shown, and is no longer.
                } else if self.session.picture.reference.is_some() {
                    viewing.difference = Some(Against::Reference);
                    viewing.is_wiping = false;
                } else {
                    self.shell.page = Page::Display;
                    let text = "No reference to compare with; load one on the Display page";
                    self.shell.notices.failure(text);
                }
            }
            _ => {}
        }
    }

    /// Takes what is held as A (0) or B (1) as the reference, in the part that it was held with.
    pub(super) fn refer_to_held(&mut self, which: usize) {
        let held = &self.session.picture.held;
        if let Some(held) = held.get(which).and_then(Option::as_ref) {
            let name = if which == 0 { "A" } else { "B" };
            self.take_reference(Reference::of_held(name, held));
        }
    }

    /// Closes the uppermost thing over the picture.
    fn escape(&mut self, ctx: &Context) {
        if self.viewing.settings.drawing.take().is_some() {
            // No region is drawn.
        } else if self.shell.had_focus {
            if let Some(id) = ctx.memory(|m| m.focused()) {
                ctx.memory_mut(|m| m.surrender_focus(id));
            }
        } else if egui::Popup::is_any_open(ctx) {
            // The toolkit closes it.
        } else if self.shell.is_help_open {
            self.shell.is_help_open = false;
        } else if self.shell.is_menu_open {
            self.shell.is_menu_open = false;
        } else if self.shell.notices.close_newest() || self.viewing.views.step_back() {
            // That was it.
        } else if self.session.setup.region.is_some() {
            self.session.setup.choose_region(None);
        } else if self.viewing.settings.is_wiping || self.viewing.settings.difference.is_some() {
            self.viewing.settings.is_wiping = false;
            self.viewing.settings.difference = None;
        } else if self.viewing.settings.zoom.is_some() {
            self.viewing.settings.zoom = None;
            self.viewing.settings.center = [0.5, 0.5];
        } else if self.shell.is_presenting {
            self.shell.is_presenting = false;
        } else {
            self.shell.is_bare = false;
        }
    }
}
