//! What a pixel holds beside radiance, in place of the picture: what the camera sees first, the
//! error, and the number of samples. One view for each [`Quantity`].

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Context, Pos2, TextureHandle, Ui};
use neumann_core::film::View as Part;
use neumann_core::film::{Features, SampleMap};
use neumann_core::scene::description::Crop;
use neumann_picture::quantity::{Quantity, QuantityLook, QuantityPlane};
use neumann_picture::sheet::{PictureSheet, picture_sheet};

use super::plate::{self, Painting};
use super::{Needs, Row, Shown, Stage, View, picture};
use crate::display::ViewSettings;
use crate::panels::Page;
use crate::probe::Reading;
use crate::session::Session;

/// The row of albedos.
pub static ALBEDO: Row = row(
    Quantity::Albedo,
    "Albedo",
    "Share of light that the first surface reflects or lets pass",
    || Box::new(QuantityView::of(Quantity::Albedo)),
);

/// The row of normals.
pub static NORMAL: Row = row(
    Quantity::Normal,
    "Normal",
    "Where the first surface faces, in world space",
    || Box::new(QuantityView::of(Quantity::Normal)),
);

/// The row of depths.
pub static DEPTH: Row = row(
    Quantity::Depth,
    "Depth",
    "How far the first surface is, along the view axis",
    || Box::new(QuantityView::of(Quantity::Depth)),
);

/// The row of errors.
pub static ERROR: Row = row(
    Quantity::Error,
    "Error",
    "Standard error of each pixel: how far the mean of its samples may be from the truth",
    || Box::new(QuantityView::of(Quantity::Error)),
);

/// The row of numbers of samples.
pub static SAMPLES: Row = row(
    Quantity::Samples,
    "Samples",
    "Camera paths of each pixel so far",
    || Box::new(QuantityView::of(Quantity::Samples)),
);

const fn row(
    quantity: Quantity,
    title: &'static str,
    about: &'static str,
    build: fn() -> Box<dyn View>,
) -> Row {
    Row {
        id: quantity.name(),
        page: Page::Display,
        title,
        about,
        // One key steps through all of them.
        key: None,
        needs: Needs {
            features: quantity.is_feature(),
            ..Needs::NOTHING
        },
        refusal: |_| None,
        build,
    }
}

/// The view of a quantity.
pub struct QuantityView {
    quantity: Quantity,
    /// Part of the series when it was opened; another one is looked at in the picture.
    opened_on: Part,
    taken: Option<Taken>,
    /// Version of the picture when errors were computed last, and when that was.
    computed: Option<(u64, Instant)>,
    painted: Option<Painted>,
}

/// A quantity of all pixels, and what it was made from.
struct Taken {
    plane: Arc<QuantityPlane>,
    fact: String,
    of: Source,
    /// Where it lies in the whole picture, if it is of a region alone.
    region: Option<Crop>,
}

enum Source {
    Features(Arc<Features>),
    Film,
    Samples(Arc<SampleMap>),
}

/// A quantity on a texture.
struct Painted {
    of: Arc<QuantityPlane>,
    look: QuantityLook,
    texture: TextureHandle,
}

/// Errors are computed no more often than this.
const PERIOD: Duration = Duration::from_millis(250);

impl QuantityView {
    fn of(quantity: Quantity) -> Self {
        Self {
            quantity,
            opened_on: Part::Total,
            taken: None,
            computed: None,
            painted: None,
        }
    }

    fn take(&mut self, plane: QuantityPlane, of: Source, region: Option<Crop>) {
        self.taken = Some(Taken {
            fact: plane.fact(),
            plane: Arc::new(plane),
            of,
            region,
        });
    }

    fn take_features(&mut self, session: &Session) {
        let published = session.link.read(|published| published.features.clone());
        let Some(features) = published else { return };
        let is_old = matches!(
            self.taken.as_ref().map(|taken| &taken.of),
            Some(Source::Features(old)) if Arc::ptr_eq(old, &features)
        );
        if !is_old && let Some(plane) = QuantityPlane::of_features(self.quantity, &features) {
            self.take(plane, Source::Features(features), session.picture.region);
        }
    }

    fn take_samples(&mut self, session: &Session) {
        let published = session.link.read(|published| published.samples.clone());
        let Some(samples) = published else { return };
        let is_old = matches!(
            self.taken.as_ref().map(|taken| &taken.of),
            Some(Source::Samples(old)) if Arc::ptr_eq(old, &samples)
        );
        if !is_old {
            self.take(
                QuantityPlane::of_samples(&samples),
                Source::Samples(samples),
                session.picture.region,
            );
        }
    }

    fn compute_errors(&mut self, session: &Session) {
        let version = session.picture.version;
        let is_due = self
            .computed
            .is_none_or(|(before, at)| before != version && at.elapsed() >= PERIOD);
        if !is_due {
            return;
        }
        self.computed = Some((version, Instant::now()));
        // What cannot be known of the whole picture cannot be known of its pixels.
        let is_known = session.picture.stats.estimated_error.is_some();
        let of_film = || {
            session
                .link
                .read(|published| QuantityPlane::of_errors(&published.film))
        };
        match is_known.then(of_film).flatten() {
            Some(plane) => self.take(plane, Source::Film, session.picture.region),
            None => self.taken = None,
        }
    }

    /// How long errors that are not of the latest picture must wait yet.
    fn rest(&self, session: &Session) -> Option<Duration> {
        let (version, at) = self.computed?;
        (version != session.picture.version).then(|| PERIOD.saturating_sub(at.elapsed()))
    }

    fn paint(&mut self, ctx: &Context, look: QuantityLook) {
        let Some(Taken { plane, .. }) = &self.taken else {
            self.painted = None;
            return;
        };
        let is_painted =
            |painted: &Painted| Arc::ptr_eq(&painted.of, plane) && painted.look == look;
        let largest = ctx.input(|input| input.max_texture_side);
        let is_drawable = plane.size.0.max(plane.size.1) <= largest;
        if !is_drawable || self.painted.as_ref().is_some_and(is_painted) {
            return;
        }
        let old = self.painted.take().map(|painted| painted.texture);
        self.painted = Some(Painted {
            texture: plate::texture(ctx, self.quantity.name(), old, plane.pixels(&look)),
            of: Arc::clone(plane),
            look,
        });
    }

    /// Why there is nothing to show.
    fn waiting(&self) -> &'static str {
        match self.quantity {
            _ if self.taken.is_some() => "the picture is larger than the graphics device can draw",
            Quantity::Error => "the error is not known yet, or by this method not at all",
            _ => "measuring …",
        }
    }
}

fn look(settings: &ViewSettings) -> QuantityLook {
    QuantityLook {
        map: settings.map,
        stops: settings.map_stops,
        exposure_ev: settings.exposure_ev,
    }
}

impl View for QuantityView {
    fn open(&mut self, settings: &ViewSettings) {
        self.opened_on = settings.part;
    }

    fn close(&mut self) {
        *self = Self::of(self.quantity);
    }

    fn attend(&mut self, session: &Session, settings: &ViewSettings) -> bool {
        if settings.part != self.opened_on {
            return false;
        }
        match self.quantity {
            Quantity::Error => self.compute_errors(session),
            Quantity::Samples => self.take_samples(session),
            _ => self.take_features(session),
        }
        true
    }

    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let caption = self.quantity.caption();
        let fact = self.taken.as_ref().map(|taken| taken.fact.clone());
        let name = format!("{caption}; {}", fact.as_deref().unwrap_or(self.waiting()));
        let size = stage.session.shown_size();
        let (response, placement) = picture::take_pointer(ui, stage, size, &name);
        if let Some(rest) = self.rest(stage.session) {
            ui.ctx().request_repaint_after(rest);
        }
        let look = look(stage.settings);
        self.paint(ui.ctx(), look);
        let (Some(painted), Some(fact), Some(taken)) = (&self.painted, fact, &self.taken) else {
            plate::wait(ui, stage.rect, self.waiting());
            return None;
        };
        let painting = Painting {
            texture: &painted.texture,
            region: taken.region.as_ref(),
            caption,
            facts: [fact, String::new()],
            scale: &painted.of.scale(&look),
        };
        plate::paint(ui, stage, &placement, painting);
        response.hover_pos()
    }

    fn probe(&self, at: Pos2, stage: &Stage<'_>) -> Option<Reading> {
        let Taken { plane, region, .. } = self.taken.as_ref()?;
        plate::under(at, stage, region.as_ref(), plane.size, |(x, y)| {
            plane.words(x, y)
        })
    }

    fn image(&self, session: &Session, settings: &ViewSettings) -> Option<Shown> {
        let Taken { plane, fact, .. } = self.taken.as_ref()?;
        let (plane, fact) = (Arc::clone(plane), fact.clone());
        let look = look(settings);
        let open = session.setup.open.as_ref();
        let scene = open.map_or("scene", |open| open.short_name()).to_owned();
        let caption = self.quantity.caption().to_owned();
        Some(Shown {
            name: self.quantity.name().to_owned(),
            pixels: Box::new(move || {
                picture_sheet(&PictureSheet {
                    heading: [scene, caption],
                    picture: plane.pixels(&look),
                    wipe: None,
                    strokes: Vec::new(),
                    scale: Some(plane.scale(&look)),
                    lines: vec![fact],
                })
            }),
        })
    }
}
