//! The built-in scenes as small pictures, rendered in the background when they are first looked at.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

use egui::{
    Color32, ColorImage, Rect, Role, Sense, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo,
    pos2,
};
use neumann_core::film::Film;
use neumann_core::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::BUILTINS;
use neumann_picture::tone::{Display, ToneCurve, auto_exposure};

use crate::theme::{self, GRID, Palette};
use crate::widgets::focus_ring;

/// Small pictures of the built-in scenes.
pub struct Gallery {
    pictures: Vec<Option<TextureHandle>>,
    sender: Sender<(usize, ColorImage)>,
    receiver: Receiver<(usize, ColorImage)>,
    is_started: bool,
    is_still: bool,
    cancel: Arc<Mutex<CancelToken>>,
    wake: Arc<dyn Fn() + Send + Sync>,
}

/// Edge of a picture, pixels.
const EDGE: usize = 96;
const ITERATIONS: usize = 16;

impl Gallery {
    /// An empty gallery; `wake` asks for a frame.
    #[must_use]
    pub fn new(wake: Arc<dyn Fn() + Send + Sync>) -> Self {
        let (sender, receiver) = channel();
        Self {
            pictures: vec![None; BUILTINS.len()],
            sender,
            receiver,
            is_started: false,
            is_still: false,
            cancel: Arc::default(),
            wake,
        }
    }

    /// Leaves the pictures out, for snapshots that must not depend on time.
    pub fn keep_still(&mut self) {
        self.is_still = true;
    }

    fn refresh(&mut self, ui: &Ui) {
        if !self.is_started && !self.is_still {
            self.is_started = true;
            let (sender, wake) = (self.sender.clone(), Arc::clone(&self.wake));
            let cancel = Arc::clone(&self.cancel);
            // Without the thread there are only names; that will do.
            let _ = std::thread::Builder::new()
                .name("neumann-gallery".to_owned())
                .spawn(move || render_all(&sender, &*wake, &cancel));
        }
        for (i, image) in self.receiver.try_iter() {
            let name = format!("gallery {i}");
            let texture = ui.ctx().load_texture(name, image, TextureOptions::LINEAR);
            if let Some(picture) = self.pictures.get_mut(i) {
                *picture = Some(texture);
            }
        }
    }
}

impl Drop for Gallery {
    fn drop(&mut self) {
        self.cancel
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .cancel();
    }
}

/// Draws all built-in scenes, two to a row, the one called `open` as chosen; yields the one that
/// was clicked.
pub fn show(ui: &mut Ui, gallery: &mut Gallery, open: Option<&str>) -> Option<&'static str> {
    gallery.refresh(ui);
    let mut chosen = None;
    let width = (ui.available_width() - GRID) / 2.0;
    let height = width * 0.75 + 24.0;
    for (row, pair) in BUILTINS.chunks(2).enumerate() {
        let size = Vec2::new(ui.available_width(), height);
        let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
        for (column, builtin) in pair.iter().enumerate() {
            let i = 2 * row + column;
            let left = rect.left() + column as f32 * (width + GRID);
            let tile =
                Rect::from_min_size(pos2(left.round(), rect.top()), Vec2::new(width, height));
            let is_chosen = open == Some(builtin.name);
            let picture = gallery.pictures.get(i).and_then(Option::as_ref);
            if tile_of(ui, tile, (builtin.name, builtin.about), picture, is_chosen) {
                chosen = Some(builtin.name);
            }
        }
        ui.add_space(GRID / 2.0);
    }
    chosen
}

fn tile_of(
    ui: &Ui,
    tile: Rect,
    (name, about): (&str, &str),
    picture: Option<&TextureHandle>,
    is_chosen: bool,
) -> bool {
    let p = Palette::of(ui);
    let response = ui.interact(tile, ui.scope_id().with(("builtin", name)), Sense::click());
    let painter = ui.painter();
    painter.rect_filled(
        tile,
        4,
        if response.hovered() {
            p.hovered
        } else {
            p.raised
        },
    );
    let image = Rect::from_min_max(tile.min, pos2(tile.right(), tile.bottom() - 24.0)).shrink(3.0);
    painter.rect_filled(image, 2, p.ground);
    if let Some(texture) = picture {
        // The middle of the square picture fills the tile.
        let cut = 0.5 * (1.0 - image.height() / image.width());
        let uv = Rect::from_min_max(pos2(0.0, cut), pos2(1.0, 1.0 - cut));
        painter.image(texture.id(), image, uv, Color32::WHITE);
    }
    painter.text(
        pos2(tile.left() + 6.0, tile.bottom() - 12.0),
        egui::Align2::LEFT_CENTER,
        name,
        theme::small(),
        if is_chosen { p.strong } else { p.text },
    );
    if is_chosen {
        let stroke = egui::Stroke::new(1.5, p.amber);
        painter.rect_stroke(tile, 4, stroke, egui::StrokeKind::Inside);
    }
    focus_ring(ui, &response, tile, 4);
    response.widget_info(|| {
        WidgetInfo::selected(Role::Button, true, is_chosen, format!("open {name}"))
    });
    let is_clicked = response.clicked();
    response.on_hover_text(about);
    is_clicked
}

fn render_all(sender: &Sender<(usize, ColorImage)>, wake: &dyn Fn(), cancel: &Mutex<CancelToken>) {
    let Ok(pool) = WorkerPool::new(Some(1), crate::render_link::yield_to_renderer) else {
        return;
    };
    let token = cancel
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .clone();
    for (i, builtin) in BUILTINS.iter().enumerate() {
        let Ok(description) = builtin.load() else {
            continue;
        };
        let scene = Arc::new(pool.run(|| Scene::build(&description)));
        let Some(camera) = scene.cameras().first().cloned() else {
            continue;
        };
        let mut settings = RenderSettings::new(camera, EDGE, EDGE);
        settings.n_layers = 1;
        let mut renderer = Renderer::new(scene, settings, pool.clone(), 0);
        let mut film = Film::new(EDGE, EDGE, 1);
        for _ in 0..ITERATIONS {
            match renderer.iterate_after(&film, &token) {
                Ok(iteration) => iteration.add_to(&mut film),
                Err(_) => return,
            }
        }
        let total = film.total();
        let display = Display {
            exposure_ev: auto_exposure(&total),
            tone: ToneCurve::Neutral,
        };
        let pixels = total.iter().map(|p| {
            let [r, g, b] = display.srgb8(*p);
            Color32::from_rgb(r, g, b)
        });
        let image = ColorImage::new([EDGE, EDGE], pixels.collect());
        if sender.send((i, image)).is_err() {
            return;
        }
        wake();
    }
}
