//! Layers beside the bounces: classes of paths that light path expressions name, and the light of
//! each source, which is mixed without rendering anew.
//!
//! While the view is open the renderer keeps the layers apart. [`LayersView`] makes pictures of
//! them; `column` lists them with their sliders. What is asked for stands in
//! [`ViewSettings::layers`].

mod asked;
mod column;
mod made;

use std::sync::Arc;

use egui::{Color32, Key, Pos2, Rect, Ui, pos2};
use neumann_core::film::{ClassFilm, View as Part};
use neumann_core::radiometry::Rgb;
use neumann_picture::png_file::Pixels8;

use self::asked::Asked;
use self::made::Made;
use super::{Needs, Row, Shown, Stage, View, picture, plate};
use crate::display::ViewSettings;
use crate::display::image_area::Placement;
use crate::display::layers::{LayerSettings, ShownLayer};
use crate::formula;
use crate::keys::{self, Action};
use crate::panels::Page;
use crate::probe::Reading;
use crate::region;
use crate::session::Session;
use crate::theme::Palette;
use crate::widgets::significant;

/// Its row.
pub static ROW: Row = Row {
    id: ID,
    page: Page::Method,
    title: "Layers",
    about: "Light path expressions as layers, and the light of each source, mixed live",
    key: Some(keys::line(
        keys::DISPLAY,
        "Shift V",
        "layers: expressions, lights",
        &[keys::on(keys::SHIFT, Key::V, Action::View(ID))],
    )),
    needs: Needs {
        classes: true,
        ..Needs::NOTHING
    },
    refusal: |_| None,
    build: || Box::new(LayersView::default()),
};

const ID: &str = "layers";

/// The layers, and their pictures.
#[derive(Default)]
pub struct LayersView {
    asked: Option<Asked>,
    film: Option<Arc<ClassFilm>>,
    made: Option<Made>,
    /// What is being typed.
    field: String,
    /// Why it is no expression.
    complaint: Option<String>,
    /// What a key has asked for: so many layers further.
    step: i32,
    /// The list scrolls to what is shown.
    reveals: bool,
}

impl LayersView {
    /// The layers as rendered so far, once there are some.
    #[must_use]
    pub fn film(&self) -> Option<&Arc<ClassFilm>> {
        self.film.as_ref()
    }

    /// The picture that is shown, row 0 on top.
    #[must_use]
    pub fn pixels(&self) -> Option<&Arc<Vec<Rgb>>> {
        self.made.as_ref().map(Made::pixels)
    }

    /// All that can be chosen, from top to bottom.
    fn places(&self, settings: &LayerSettings) -> Vec<ShownLayer> {
        let expressions = (0..settings.expressions.len()).map(ShownLayer::Expression);
        let n_lights = self.film.as_ref().map_or(0, |film| film.n_groups());
        let is_lit = |group: &usize| self.film.as_ref().is_some_and(|film| film.is_lit(*group));
        let lights = (0..n_lights).filter(is_lit).map(ShownLayer::Light);
        expressions.chain([ShownLayer::Mix]).chain(lights).collect()
    }

    fn take_step(&mut self, settings: &mut LayerSettings) {
        let step = std::mem::take(&mut self.step);
        let places = self.places(settings);
        if let Some(at) = places.iter().position(|place| *place == settings.shown) {
            let at = at as i32 + step;
            settings.shown = places[at.clamp(0, places.len() as i32 - 1) as usize];
            self.reveals = step != 0;
        }
    }

    /// What is shown, in words.
    fn caption(&self, settings: &ViewSettings) -> String {
        let part = || match settings.part {
            Part::Total => String::new(),
            part => format!(", {}", formula::spoken(part)),
        };
        let layers = &settings.layers;
        match layers.shown {
            ShownLayer::Mix if layers.mix.is_empty() => format!("All light{}", part()),
            ShownLayer::Mix => format!("All light, mixed{}", part()),
            ShownLayer::Expression(i) => layers.expressions.get(i).cloned().unwrap_or_default(),
            ShownLayer::Light(group) => {
                let film = self.film.as_ref();
                let name = film.and_then(|film| film.group_names().nth(group).map(str::to_owned));
                format!("Light of {}{}", name.unwrap_or_default(), part())
            }
        }
    }

    fn facts(&self, session: &Session, settings: &ViewSettings) -> String {
        let n = match &self.film {
            None => return "keeping layers apart …".to_owned(),
            Some(_) if is_plain(&settings.layers) => session.picture.stats.n_iterations,
            Some(film) => film.n_iterations(),
        };
        match n {
            1 => "1 iteration".to_owned(),
            n => format!("{n} iterations"),
        }
    }

    /// The picture, unless the film says the same with more iterations.
    fn shown(&self, settings: &ViewSettings) -> Option<&Made> {
        self.made.as_ref().filter(|_| !is_plain(&settings.layers))
    }

    fn draw_picture(&mut self, ui: &Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let p = Palette::of(ui);
        let (rect, size) = (stage.rect, stage.session.shown_size());
        let caption = self.caption(stage.settings);
        let facts = self.facts(stage.session, stage.settings);
        let name = format!("{caption}; {facts}");
        let (response, placement) = picture::take_pointer(ui, stage, size, &name);
        let corner = match self.shown(stage.settings) {
            Some(made) => {
                let place = region::rect(&placement, made.region());
                picture::fill_around(ui, rect, place.intersect(rect), p.ground);
                let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
                let painter = ui.painter().with_clip_rect(rect);
                painter.image(made.texture(), place, whole, Color32::WHITE);
                place.min
            }
            // All light as it is rendered.
            None if picture::draw_live(ui, stage, &placement) => placement.visible.min,
            None => return None,
        };
        let painter = ui.painter().with_clip_rect(rect);
        let facts = [facts, String::new()];
        stage.caption = plate::show(&painter, rect, corner, &caption, facts, &p);
        response.hover_pos()
    }
}

impl View for LayersView {
    fn close(&mut self) {
        self.asked = None;
        self.film = None;
        self.made = None;
    }

    fn attend(&mut self, session: &Session, settings: &ViewSettings) -> bool {
        let Some(job) = session.link.started() else {
            return true;
        };
        let layers = &settings.layers;
        if !self
            .asked
            .as_ref()
            .is_some_and(|asked| asked.is_of(layers, &job.scene))
        {
            self.asked = Some(Asked::new(layers, &job.scene));
        }
        let classes = self.asked.as_ref().map(|asked| &asked.classes);
        let published = session.link.read(|published| published.classes.clone());
        let is_asked = |film: &Arc<ClassFilm>| {
            classes.is_some_and(|classes| Arc::ptr_eq(classes, film.classes()))
        };
        let is_there = |film: &Arc<ClassFilm>| is_asked(film) && film.n_iterations() > 0;
        self.film = published.filter(is_there).filter(|_| session.is_current());
        true
    }

    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        if let Some(asked) = &self.asked {
            let classes = Some(&asked.classes);
            let kept = stage.session.link.kept_classes();
            if kept.map(Arc::as_ptr) != classes.map(Arc::as_ptr) {
                stage.session.link.keep_classes(classes.cloned());
            }
        }
        self.take_step(&mut stage.settings.layers);
        self.make(ui.ctx(), stage.session, stage.settings);
        let [left, right] = super::column::split(stage.rect, super::column::FIGURES);
        stage.rect = left;
        let hovered = self.draw_picture(ui, stage);
        super::column::show(ui, right, "layers", |ui| {
            ui.spacing_mut().item_spacing.y = 4.0;
            column::contents(ui, self, stage.session, &mut stage.settings.layers);
        });
        self.reveals = false;
        hovered
    }

    fn probe(&self, at: Pos2, stage: &Stage<'_>) -> Option<Reading> {
        let placement = stage.placement.as_ref()?;
        let fraction = placement.fraction(at)?;
        let Some(made) = self.shown(stage.settings) else {
            return Some(picture::read(stage.session, stage.settings, fraction));
        };
        let (x, y) = Placement::pixel(fraction, placement.size);
        let mut lines = vec![format!("x {x}  y {y}")];
        let Some(fraction) = region::share(made.region(), fraction) else {
            return Some(Reading::outside_region(lines.remove(0)));
        };
        let (x, y) = Placement::pixel(fraction, made.size());
        let value = made.pixels().get(y * made.size().0 + x)?.to_array();
        let number = |v: f32| significant(f64::from(v), 4);
        lines.push(value.map(number).join("  "));
        lines.push("W m⁻² sr⁻¹".to_owned());
        Some(Reading {
            lines,
            bounces: Vec::new(),
        })
    }

    fn image(&self, session: &Session, settings: &ViewSettings) -> Option<Shown> {
        let Some(made) = self.shown(settings) else {
            let is_there = session.picture.is_there();
            return is_there.then(|| picture::shown_image(session, settings));
        };
        let (pixels, (width, height)) = (Arc::clone(made.pixels()), made.size());
        let (name, settings) = (self.caption(settings), settings.clone());
        let words = name.split(|c: char| !c.is_alphanumeric());
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        Some(Shown {
            name: words.join("-"),
            pixels: Box::new(move || Pixels8 {
                width,
                height,
                pixels: pixels.iter().map(|value| settings.code(*value)).collect(),
            }),
        })
    }

    fn perform(&mut self, action: Action) -> bool {
        match action {
            Action::Row(is_up) => self.step += if is_up { -1 } else { 1 },
            _ => return false,
        }
        true
    }
}

/// True if all light is shown as it is rendered.
fn is_plain(layers: &LayerSettings) -> bool {
    layers.shown == ShownLayer::Mix && layers.mix.is_empty()
}

/// The pixels of a layer, if the film keeps it.
fn layer(film: &ClassFilm, asked: &Asked, layers: &LayerSettings, part: Part) -> Option<Vec<Rgb>> {
    match layers.shown {
        ShownLayer::Mix => film.mixed(part, &layers.factors(film)),
        ShownLayer::Expression(i) => {
            let number = asked.expressions.get(i)?.as_ref().ok()?;
            Some(film.expression(*number))
        }
        ShownLayer::Light(group) => {
            let factor = layers.factor(film.group_names().nth(group)?);
            let mut pixels = film.group(group, part)?;
            pixels.iter_mut().for_each(|value| *value *= factor);
            Some(pixels)
        }
    }
}
