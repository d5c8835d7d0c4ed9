//! The photons of a method as points: what its photon map holds where the camera looks.
//!
//! While the view is open the renderer draws the photons of the latest iteration. [`PhotonView`]
//! owns them and the texture that they are painted to; `legend` says what their colours mean.

mod legend;
mod words;

use std::sync::Arc;

use egui::{Align2, Color32, Context, Key, Pos2, Rect, TextureHandle, Ui, pos2};
use neumann_core::integrator::methods_with_photons;
use neumann_core::photons::PhotonPicture;
use neumann_core::scene::description::Crop;
use neumann_picture::photons::{PhotonColours, PhotonLook, PowerScale, facts};
use neumann_picture::sheet::photon_sheet;

use super::{Needs, Row, Shown, Stage, View};
use super::{picture, plate};
use crate::display::ViewSettings;
use crate::display::image_area::Placement;
use crate::keys::{self, Action};
use crate::panels::Page;
use crate::probe::Reading;
use crate::region;
use crate::session::Session;
use crate::theme::{self, Palette};

use legend::Legend;

/// Its row.
pub static ROW: Row = Row {
    id: ID,
    page: Page::Method,
    title: "Show photons",
    about: "The photons of the map as points, by how often they were scattered or by their power",
    key: Some(keys::line(
        keys::DISPLAY,
        "P",
        "photons as points",
        &[keys::on(keys::NONE, Key::P, Action::View(ID))],
    )),
    needs: Needs {
        photons: true,
        ..Needs::NOTHING
    },
    refusal: |setup| {
        let method = setup.method();
        let text = || {
            let name = method.name;
            format!(
                "{name} has no photons; the photons view needs {}",
                methods_with_photons()
            )
        };
        (!method.has_photons).then(text)
    },
    build: || Box::new(PhotonView::default()),
};

const ID: &str = "photons";

/// The photon view: what of it is looked at.
#[derive(Default)]
pub struct PhotonView {
    /// What the photons are coloured by.
    pub colours: PhotonColours,
    photons: Option<Taken>,
    /// Version of the picture when the renderer was last asked for photons.
    read: Option<u64>,
    painted: Option<Painted>,
}

/// Photons that were taken over from the renderer.
struct Taken {
    picture: Arc<PhotonPicture>,
    scale: PowerScale,
    facts: [String; 4],
    /// Where it lies in the whole picture, if it is of a region alone.
    region: Option<Crop>,
}

/// Photons on a texture, and their legend.
struct Painted {
    of: Arc<PhotonPicture>,
    look: PhotonLook,
    texture: TextureHandle,
    legend: Legend,
}

impl PhotonView {
    /// How photons are shown. An exposure that follows the picture suits radiance; photons have a
    /// scale of their own.
    fn look(&self, session: &Session, settings: &ViewSettings) -> PhotonLook {
        let mut display = settings.display();
        if settings.is_auto {
            display.exposure_ev = 0.0;
        }
        PhotonLook {
            colours: self.colours,
            part: settings.part,
            n_layers: session.picture.n_layers,
            display,
        }
    }

    /// Paints the photons, unless they are painted already.
    fn paint(&mut self, ctx: &Context, look: PhotonLook) {
        let Some(Taken { picture, scale, .. }) = &self.photons else {
            return;
        };
        let is_painted =
            |painted: &Painted| Arc::ptr_eq(&painted.of, picture) && painted.look == look;
        if self.painted.as_ref().is_some_and(is_painted) {
            return;
        }
        let largest = ctx.input(|input| input.max_texture_side);
        if picture.width().max(picture.height()) > largest {
            return;
        }
        let pixels = look.pixels(picture, *scale);
        let old = self.painted.take().map(|painted| painted.texture);
        let texture = plate::texture(ctx, ID, old, pixels);
        self.painted = Some(Painted {
            of: Arc::clone(picture),
            look,
            texture,
            legend: Legend::new(picture, *scale, &look),
        });
    }
}

impl View for PhotonView {
    fn close(&mut self) {
        *self = Self {
            colours: self.colours,
            ..Self::default()
        };
    }

    fn attend(&mut self, session: &Session, _settings: &ViewSettings) -> bool {
        if self.read == Some(session.picture.version) {
            return true;
        }
        self.read = Some(session.picture.version);
        // What was drawn last stays while a job has nothing new yet.
        let published = session.link.read(|published| published.photons.clone());
        let is_new = |picture: &Arc<PhotonPicture>| {
            let old = self.photons.as_ref();
            old.is_none_or(|old| !Arc::ptr_eq(&old.picture, picture))
        };
        if let Some(picture) = published.filter(is_new) {
            self.photons = Some(Taken {
                scale: PowerScale::of(&picture),
                facts: facts(&picture),
                region: session.picture.region,
                picture,
            });
        }
        true
    }

    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let p = Palette::of(ui);
        let look = self.look(stage.session, stage.settings);
        let caption = look.caption();
        let facts = self.photons.as_ref().map(|taken| taken.facts.clone());
        let name = match &facts {
            Some(facts) => format!("{caption}, {}", facts.join(" · ")),
            None => format!("{caption}, none yet"),
        };
        let size = stage.session.shown_size();
        let (response, placement) = picture::take_pointer(ui, stage, size, &name);
        self.paint(ui.ctx(), look);
        let rect = stage.rect;
        let painter = ui.painter().with_clip_rect(rect);
        let Some(painted) = &self.painted else {
            picture::fill_around(ui, rect, Rect::NOTHING, p.ground);
            let text = words::waiting(stage.session, self.photons.is_some());
            let at = rect.center();
            painter.text(at, Align2::CENTER_CENTER, text, theme::body(), p.weak);
            return None;
        };
        let region = self.photons.as_ref().and_then(|taken| taken.region);
        let place = region::rect(&placement, region.as_ref());
        picture::fill_around(ui, rect, place.intersect(rect), p.ground);
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        painter.image(painted.texture.id(), place, whole, Color32::WHITE);
        if let Some(facts) = &facts {
            // Where there is no room for all, how many there are is left to the status line.
            let lines = [facts.join(" · "), facts[2..].join(" · ")];
            stage.caption = plate::show(&painter, rect, place.min, &caption, lines, &p);
        }
        let area = plate::legend_area(rect, place.right());
        if let Some(colours) = painted.legend.show(ui, area, self.colours) {
            self.colours = colours;
            ui.ctx().request_repaint();
        }
        response.hover_pos()
    }

    fn probe(&self, at: Pos2, stage: &Stage<'_>) -> Option<Reading> {
        let Taken {
            picture, region, ..
        } = self.photons.as_ref()?;
        let fraction = stage.placement.as_ref()?.fraction(at)?;
        let size = (picture.width(), picture.height());
        let full = Placement::pixel(fraction, stage.placement.as_ref()?.size);
        let Some(share) = region::share(region.as_ref(), fraction) else {
            let (x, y) = full;
            return Some(Reading::outside_region(format!("x {x}  y {y}")));
        };
        let (x, y) = Placement::pixel(share, size);
        let look = self.look(stage.session, stage.settings);
        Some(words::reading(
            picture.of_pixel(y * size.0 + x),
            full,
            &look,
        ))
    }

    fn image(&self, session: &Session, settings: &ViewSettings) -> Option<Shown> {
        let taken = self.photons.as_ref()?;
        let (picture, scale) = (Arc::clone(&taken.picture), taken.scale);
        let look = self.look(session, settings);
        let open = session.setup.open.as_ref();
        let scene = open.map_or("scene", |open| open.short_name()).to_owned();
        let line = format!("{} · {}", look.caption(), session.setup.method().id);
        Some(Shown {
            name: format!("photons-{}", self.colours),
            pixels: Box::new(move || photon_sheet(&picture, scale, &look, [&scene, &line])),
        })
    }
}
