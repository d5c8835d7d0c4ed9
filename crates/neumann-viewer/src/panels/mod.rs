//! The panel beside the picture: one page each for method, scene, camera and display.

mod camera;
mod display;
mod history;
mod lights;
mod materials;
mod method;
mod scene;

pub(crate) use lights::remove_sky;

use egui::{Margin, Rect, ScrollArea, Ui, UiBuilder};

use crate::session::Session;
use crate::shell::Shell;
use crate::theme::{self, GRID, Palette};
use crate::viewing::Viewing;
use crate::widgets::tabs;

/// The pages of the panel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Page {
    /// Method, its parameters, depth, when to stop.
    #[default]
    Method,
    /// Scene, lights, materials, environment.
    Scene,
    /// Camera and lens.
    Camera,
    /// Exposure, tone, false colour, zoom, wipe, difference.
    Display,
}

impl Page {
    /// All pages, in the order of the tabs.
    pub const ALL: [Self; 4] = [Self::Method, Self::Scene, Self::Camera, Self::Display];

    /// The word on its tab.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Method => "Method",
            Self::Scene => "Scene",
            Self::Camera => "Camera",
            Self::Display => "Display",
        }
    }

    /// What stands on it, with its key.
    fn about(self) -> &'static str {
        match self {
            Self::Method => "The method, its parameters, and when rendering stops. (F1)",
            Self::Scene => "Other scenes, lights, environment and materials. (F2)",
            Self::Camera => "Camera, lens and size of the film. (F3)",
            Self::Display => "Exposure, tone curve, false colour and comparison. (F4)",
        }
    }
}

/// Draws the panel into `rect`.
pub fn show(
    ui: &mut Ui,
    rect: Rect,
    session: &mut Session,
    viewing: &mut Viewing,
    shell: &mut Shell,
) {
    let p = Palette::of(ui);
    theme::fill_panel(ui, rect);
    ui.painter()
        .vline(rect.left() + 0.5, rect.y_range(), (1.0, p.line));
    let inner = rect.shrink2(egui::vec2(2.0 * GRID, 0.0));
    ui.scope_builder(UiBuilder::new().max_rect(inner).id_salt("panel"), |ui| {
        ui.add_space(GRID / 2.0);
        let takes_keyboard = std::mem::take(&mut shell.gives_panel_the_keyboard);
        let titles = Page::ALL.map(Page::title);
        let chosen = Page::ALL.iter().position(|page| *page == shell.page);
        let about = |i: usize| Page::ALL[i].about().to_owned();
        if let Some(i) = tabs(ui, &titles, about, chosen.unwrap_or(0), takes_keyboard) {
            shell.page = Page::ALL[i];
        }
        ui.add_space(GRID / 2.0);
        // Text runs to the edge of the panel's own margin; what scrolls is cut a little further
        // out.
        let area = ui
            .available_rect_before_wrap()
            .expand2(egui::vec2(GRID, 0.0));
        ui.scope_builder(UiBuilder::new().max_rect(area), |ui| {
            ScrollArea::vertical()
                .id_salt(shell.page.title())
                .auto_shrink(false)
                .show(ui, |ui| {
                    let margin = Margin::symmetric(GRID as i8, 0);
                    egui::Frame::new().inner_margin(margin).show(ui, |ui| {
                        ui.set_width(ui.available_width());
                        let page = shell.page;
                        match page {
                            Page::Method => method::show(ui, session, &viewing.views, shell),
                            Page::Scene => scene::show(ui, session, shell),
                            Page::Camera => camera::show(ui, session, shell),
                            Page::Display => {
                                display::show(ui, session, viewing, shell);
                            }
                        }
                        shell.reveals_pick &= page != Page::Scene;
                        ui.add_space(2.0 * GRID);
                    });
                });
        });
    });
}
