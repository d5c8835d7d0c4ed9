//! What keys and buttons do.

use egui::{Context, FocusDirection, Theme};
use neumann_core::film::View;
use neumann_core::integrator::METHODS;
use neumann_picture::tone::ToneCurve;

use crate::app::{App, WindowRequest};
use crate::display::image_area;
use crate::keys::Action;
use crate::panels::Page;
use crate::{save, stage, techniques};

impl App {
    /// Does what a key or a button asks for.
    pub fn perform(&mut self, ctx: &Context, action: Action) {
        let n_layers = self.setup.n_layers;
        match action {
            Action::Term(k) if k < n_layers => self.viewing.view = View::Term(k),
            Action::Term(_) => self.viewing.view = View::Tail,
            Action::Upto(k) if k < n_layers => self.viewing.view = View::Upto(k),
            Action::Upto(_) | Action::Total => self.viewing.view = View::Total,
            Action::Step(step) => {
                let (is_sum, place) = self.viewing.place(n_layers);
                let place = place as i64 + i64::from(step);
                let place = place.clamp(0, n_layers as i64) as usize;
                self.viewing.choose(is_sum, place, n_layers);
            }
            Action::Row(is_up) => {
                let (_, place) = self.viewing.place(n_layers);
                self.viewing.choose(!is_up, place, n_layers);
            }
            Action::Method(step) => {
                let n = METHODS.len() as i64;
                let index = (self.setup.method as i64 + i64::from(step)).rem_euclid(n);
                self.setup.choose_method(index as usize);
            }
            Action::Pause => {
                let is_paused = self.link.is_paused();
                self.link.pause(!is_paused);
            }
            Action::Restart => self.setup.is_changed = true,
            Action::FrameAll | Action::ResetCamera => self.move_camera(action),
            Action::Open => {
                self.is_bare = false;
                self.page = Page::Scene;
                self.background.choose(crate::scene_source::Wanted::Scene);
            }
            Action::SavePng => save::png(self),
            Action::SaveExr => save::exr(self),
            Action::SaveSheet => save::sheet(self),
            Action::Copy => save::copy(self, ctx),
            Action::Panels => self.is_bare = !self.is_bare,
            Action::Panel(i) => {
                self.is_bare = false;
                self.page = Page::ALL[i.min(Page::ALL.len() - 1)];
            }
            Action::Controls => ctx.memory_mut(|m| m.move_focus(FocusDirection::Next)),
            Action::Theme => {
                let is_dark = ctx.theme() == Theme::Dark;
                ctx.set_theme(if is_dark { Theme::Light } else { Theme::Dark });
            }
            Action::Techniques => techniques::toggle(self),
            Action::Help => self.is_help_open = !self.is_help_open,
            Action::Fullscreen => self.requests.push(WindowRequest::Fullscreen),
            Action::Escape => self.escape(ctx),
            Action::Quit => self.requests.push(WindowRequest::Quit),
            _ => self.change_display(action),
        }
    }

    fn move_camera(&mut self, action: Action) {
        let (w, h) = self.setup.size;
        let Some(control) = &mut self.setup.camera else {
            return;
        };
        if action == Action::FrameAll {
            control.frame_all(w.max(1) as f32 / h.max(1) as f32);
        } else {
            control.reset();
        }
        self.setup.is_changed = true;
    }

    fn change_display(&mut self, action: Action) {
        let viewing = &mut self.viewing;
        match action {
            Action::Exposure(thirds) => {
                viewing.is_auto = false;
                viewing.exposure_ev =
                    (viewing.exposure_ev + thirds as f32 / 3.0).clamp(-24.0, 24.0);
            }
            Action::AutoExposure => {
                viewing.is_auto = !viewing.is_auto;
                if viewing.is_auto {
                    viewing.exposure_ev = self.picture.auto_exposure(viewing.view);
                }
            }
            Action::Tone(step) => {
                let n = ToneCurve::ALL.len() as i64;
                let now = ToneCurve::ALL.iter().position(|t| *t == viewing.tone);
                let next = (now.unwrap_or(0) as i64 + i64::from(step)).rem_euclid(n);
                viewing.tone = ToneCurve::ALL[next as usize];
            }
            Action::FalseColour => viewing.is_false_colour = !viewing.is_false_colour,
            Action::Zoom(steps) => {
                if let Some(placement) = &self.placement {
                    let middle = viewing.center;
                    image_area::zoom(viewing, placement, (steps as f32).exp2(), middle);
                }
            }
            Action::ZoomFit => {
                viewing.zoom = None;
                viewing.center = [0.5, 0.5];
            }
            Action::HoldA => self.hold(0),
            Action::HoldB => self.hold(1),
            Action::Wipe => {
                if self.picture.held[0].is_none() {
                    self.hold(0);
                }
                self.viewing.is_wiping = !self.viewing.is_wiping;
                self.viewing.is_difference = false;
            }
            Action::Difference => {
                if self.picture.reference.is_some() {
                    viewing.is_difference = !viewing.is_difference;
                    viewing.is_wiping = false;
                } else {
                    self.page = Page::Display;
                    let text =
                        "No reference to hold the picture against; load one on the page Display";
                    self.notices.failure(text);
                }
            }
            _ => {}
        }
    }

    fn hold(&mut self, which: usize) {
        if !self.picture.is_there() {
            return;
        }
        let view = self.viewing.view;
        let label = stage::label_of(self);
        self.picture.hold(&self.link, which, view, label);
    }

    /// Closes the uppermost thing over the picture.
    fn escape(&mut self, ctx: &Context) {
        if self.had_focus {
            if let Some(id) = ctx.memory(|m| m.focused()) {
                ctx.memory_mut(|m| m.surrender_focus(id));
            }
        } else if self.is_help_open {
            self.is_help_open = false;
        } else if self.is_menu_open {
            self.is_menu_open = false;
        } else if self.notices.close_newest() {
        } else if self.techniques.is_open {
            self.techniques.step_back();
        } else if self.viewing.is_wiping || self.viewing.is_difference {
            self.viewing.is_wiping = false;
            self.viewing.is_difference = false;
        } else if self.viewing.zoom.is_some() {
            self.viewing.zoom = None;
            self.viewing.center = [0.5, 0.5];
        } else {
            self.is_bare = false;
        }
    }
}
