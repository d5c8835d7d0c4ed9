//! Two pictures side by side or one less the other, if they can be compared at all: of one size,
//! and, where they are subtracted, of one scene and of the same part of the series.

pub mod measured;
pub mod origin;
pub mod reference;

use std::borrow::Cow;
use std::sync::Arc;

use neumann_core::film::View as Part;
use neumann_core::radiometry::Rgb;

pub use measured::{Measured, Measuring};
pub use origin::{Origin, SceneName};
pub use reference::Reference;

use crate::display::image_area::Placement;
use crate::display::{Against, Slot, ViewSettings};
use crate::session::Session;

/// What is compared on the screen.
#[derive(Clone, Debug, PartialEq)]
pub enum Compared {
    /// Nothing: one picture is shown.
    Nothing,
    /// Nothing, though it was asked for; the sentence says why.
    Refused(String),
    /// The first picture left of the wipe, the second right of it.
    Wipe([Side; 2]),
    /// The first picture less the second.
    Difference([Side; 2]),
}

/// One of two pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// What it is called.
    pub name: String,
    /// Where it stands.
    pub slot: Slot,
    /// The part of the series that it shows.
    pub part: Part,
    /// Its pixels at full resolution.
    pub size: (usize, usize),
    /// Where it comes from, if that is known.
    pub origin: Option<Origin>,
    /// Terms before the tail, if it has one.
    n_layers: Option<usize>,
}

impl Compared {
    /// What the settings ask for, of the pictures that there are.
    #[must_use]
    pub fn of(session: &Session, settings: &ViewSettings) -> Self {
        let live = |name: &str| Side::live(name, session, settings.part);
        let held = |which: usize| Side::held(which, session);
        let right = || held(1).unwrap_or_else(|| live("B (live)"));
        let is_wanted = settings.is_wiping || settings.difference.is_some();
        if is_wanted && session.region().is_some() {
            let why = "No comparison while a region is rendered; B ends it";
            return Self::Refused(why.to_owned());
        }
        match settings.difference {
            Some(Against::Reference) => Self::to_reference(live("picture"), session),
            Some(Against::Held) => held(0).map_or(Self::Nothing, |left| {
                let sides = [left, right()];
                match other_size(&sides).or_else(|| other_content(&sides)) {
                    Some(why) => Self::Refused(format!("No difference: {why}")),
                    None => Self::Difference(sides),
                }
            }),
            None if settings.is_wiping => held(0).map_or(Self::Nothing, |left| {
                let sides = [left, right()];
                match other_size(&sides) {
                    Some(why) => Self::Refused(format!("No wipe: {why}")),
                    None => Self::Wipe(sides),
                }
            }),
            None => Self::Nothing,
        }
    }

    fn to_reference(live: Side, session: &Session) -> Self {
        let n_layers = session.picture.n_layers;
        let Some(reference) = &session.picture.reference else {
            return Self::Nothing;
        };
        if live.part.layers(n_layers).is_none() {
            return Self::Nothing;
        }
        let part = live.part;
        let sides = [live, Side::reference(reference, part, n_layers)];
        let why = other_scene(&sides)
            .or_else(|| other_size(&sides))
            .or_else(|| reference.refusal(part, n_layers));
        match why {
            Some(why) => Self::Refused(format!("No difference: {why}")),
            None => Self::Difference(sides),
        }
    }

    /// The two pictures.
    #[must_use]
    pub fn sides(&self) -> Option<&[Side; 2]> {
        match self {
            Self::Wipe(sides) | Self::Difference(sides) => Some(sides),
            Self::Nothing | Self::Refused(_) => None,
        }
    }

    /// What is shown of the two; empty where nothing is compared.
    #[must_use]
    pub fn title(&self) -> String {
        match self {
            Self::Wipe([a, b]) => format!("{} | {}", a.name, b.name),
            Self::Difference([a, b]) => format!("{} − {}, in luminance", a.name, b.name),
            Self::Nothing | Self::Refused(_) => String::new(),
        }
    }

    /// What is said of the two, a line each, and whether two cameras saw them.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let Some(sides) = self.sides() else {
            return Vec::new();
        };
        let cameras = sides
            .each_ref()
            .map(|side| side.origin.as_ref().map(|o| &o.camera));
        let note = match cameras {
            [Some(a), Some(b)] if a != b => Some("seen by two different cameras".to_owned()),
            _ => None,
        };
        let words = |side: &Side| format!("{}:  {}", side.name, side.words());
        sides.iter().map(words).chain(note).collect()
    }
}

impl Side {
    /// The live picture.
    #[must_use]
    pub fn live(name: &str, session: &Session, part: Part) -> Self {
        Self {
            name: name.to_owned(),
            slot: Slot::Live,
            part,
            size: session.shown_size(),
            origin: session.origin(),
            n_layers: Some(session.picture.n_layers),
        }
    }

    /// What is held as A (0) or B (1).
    #[must_use]
    pub fn held(which: usize, session: &Session) -> Option<Self> {
        let held = session.picture.held.get(which)?.as_ref()?;
        let (name, slot) = if which == 0 {
            ("A", Slot::HeldA)
        } else {
            ("B", Slot::HeldB)
        };
        Some(Self {
            name: name.to_owned(),
            slot,
            part: held.view,
            size: held.size,
            origin: held.origin.clone(),
            n_layers: Some(held.n_layers),
        })
    }

    fn reference(reference: &Reference, part: Part, n_layers: usize) -> Self {
        Self {
            name: reference.name.clone(),
            slot: Slot::Reference,
            part,
            size: reference.size,
            origin: reference.origin.clone(),
            n_layers: Some(n_layers),
        }
    }

    /// Part, method, iterations and seconds, as far as they are known.
    #[must_use]
    pub fn words(&self) -> String {
        match &self.origin {
            Some(origin) => format!("{} · {}", self.part, origin.words()),
            None => self.part.to_string(),
        }
    }

    /// The same, shorter.
    #[must_use]
    pub fn label(&self) -> String {
        match &self.origin {
            Some(origin) => format!(
                "{} · {} · {}",
                self.part, origin.method, origin.n_iterations
            ),
            None => self.part.to_string(),
        }
    }

    /// Its pixels, with their number per row and of rows: fewer than its size while it climbs the
    /// ladder.
    #[must_use]
    pub fn pixels(&self, session: &Session) -> Pixels {
        let picture = &session.picture;
        let held = |which: usize| picture.held.get(which).and_then(Option::as_ref);
        let of_held = |which| held(which).map(|h| (h.size, Arc::clone(&h.pixels)));
        let there = match self.slot {
            Slot::HeldA => of_held(0),
            Slot::HeldB => of_held(1),
            Slot::Reference => picture.reference_pixels(self.part).map(|p| (self.size, p)),
            Slot::Live | Slot::Thumbnails => None,
        };
        let (size, pixels) = there.unwrap_or_else(|| {
            let pieced = picture.pixels(&session.link, self.part);
            (pieced.size, Arc::new(pieced.pixels))
        });
        Pixels { size, pixels }
    }

    /// Its radiance at a share of its width and height.
    #[must_use]
    pub fn radiance(&self, session: &Session, fraction: [f32; 2]) -> Rgb {
        if self.slot != Slot::Live || session.region().is_some() {
            return self.pixels(session).at(fraction);
        }
        let picture = &session.picture;
        let radiance = picture.read_film(&session.link, |film, _, _| {
            let (x, y) = Placement::pixel(fraction, (film.width(), film.height()));
            film.radiance(self.part, y * film.width() + x)
        });
        radiance.unwrap_or_else(|| picture.planes.lock().plane(Slot::Live).radiance(fraction))
    }
}

/// The pixels of one of two pictures.
#[derive(Clone, Debug)]
pub struct Pixels {
    /// Pixels per row, and rows.
    pub size: (usize, usize),
    /// Row 0 on top.
    pub pixels: Arc<Vec<Rgb>>,
}

impl Pixels {
    /// The radiance at a share of width and height.
    #[must_use]
    pub fn at(&self, fraction: [f32; 2]) -> Rgb {
        let (x, y) = Placement::pixel(fraction, self.size);
        let pixel = self.pixels.get(y * self.size.0 + x);
        pixel.copied().unwrap_or(Rgb::BLACK)
    }
}

fn other_size([a, b]: &[Side; 2]) -> Option<String> {
    (a.size != b.size).then(|| {
        format!(
            "{} has {}×{} pixels, {} has {}×{}",
            named(a),
            a.size.0,
            a.size.1,
            named(b),
            b.size.0,
            b.size.1
        )
    })
}

fn other_scene([a, b]: &[Side; 2]) -> Option<String> {
    let (x, y) = (&a.origin.as_ref()?.scene, &b.origin.as_ref()?.scene);
    if x == y {
        return None;
    }
    let (a, b) = (named(a), named(b));
    Some(if x.name == y.name {
        format!("{a} and {b} are of two versions of the scene '{}'", x.name)
    } else {
        format!("{a} is of the scene '{}', {b} of '{}'", x.name, y.name)
    })
}

/// Another scene, or another part of the series.
fn other_content(sides: &[Side; 2]) -> Option<String> {
    let [a, b] = sides;
    other_scene(sides).or_else(|| {
        let is_other_tail = a.part == Part::Tail && a.n_layers != b.n_layers;
        if a.part != b.part {
            Some(format!(
                "{} is {}, {} is {}",
                a.name, a.part, b.name, b.part
            ))
        } else if is_other_tail {
            Some("the two tails begin at different terms".to_owned())
        } else {
            None
        }
    })
}

fn named(side: &Side) -> Cow<'_, str> {
    match side.slot {
        Slot::Live if side.name == "picture" => Cow::Borrowed("the picture"),
        Slot::Reference => Cow::Owned(format!("the reference {}", side.name)),
        _ => Cow::Borrowed(&side.name),
    }
}
