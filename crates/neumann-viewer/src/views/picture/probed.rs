//! What the pixel under the pointer holds, of whichever pictures are on the screen.

use neumann_core::radiometry::Rgb;

use crate::compared::{Compared, Side};
use crate::display::image_area::Placement;
use crate::display::{Slot, ViewSettings};
use crate::probe::Reading;
use crate::region;
use crate::session::Session;
use crate::widgets::significant;

/// Reads the pictures at a share of their width and height: the film, that side of a wipe which
/// lies there, or both sides of a difference.
#[must_use]
pub fn read(session: &Session, settings: &ViewSettings, fraction: [f32; 2]) -> Reading {
    match Compared::of(session, settings) {
        Compared::Nothing | Compared::Refused(_) => of_live(session, settings, fraction),
        Compared::Wipe([a, b]) => {
            let side = if fraction[0] < settings.wipe { a } else { b };
            of_side(session, settings, &side, fraction)
        }
        Compared::Difference(sides) => of_difference(session, settings, &sides, fraction),
    }
}

fn of_live(session: &Session, settings: &ViewSettings, fraction: [f32; 2]) -> Reading {
    let reading = session
        .picture
        .read_film(&session.link, |film, divisor, region| {
            let Some((_, region)) = region else {
                return Reading::of_film(film, settings.part, fraction, divisor);
            };
            let (x, y) = Placement::pixel(fraction, region.of.into());
            let place = format!("x {x}  y {y}");
            match region::within(region, fraction) {
                Some(share) => {
                    let mut reading = Reading::of_film(film, settings.part, share, divisor);
                    reading.lines[0] = place;
                    reading
                }
                None => Reading::outside_region(place),
            }
        });
    reading.unwrap_or_else(|| of_screen(session, fraction))
}

/// Reads what is on the screen, to its three digits, where its film is gone.
fn of_screen(session: &Session, fraction: [f32; 2]) -> Reading {
    let (x, y) = Placement::pixel(fraction, session.shown_size());
    let planes = session.picture.planes.lock();
    let radiance = planes.plane(Slot::Live).radiance(fraction).to_array();
    let [r, g, b] = radiance.map(|channel| significant(f64::from(channel), 3));
    Reading {
        lines: vec![
            format!("x {x}  y {y}"),
            format!("{r}  {g}  {b}"),
            "W m⁻² sr⁻¹".to_owned(),
        ],
        bounces: Vec::new(),
    }
}

fn of_side(session: &Session, settings: &ViewSettings, side: &Side, fraction: [f32; 2]) -> Reading {
    let mut reading = if side.slot == Slot::Live {
        of_live(session, settings, fraction)
    } else {
        let radiance = three(side.radiance(session, fraction));
        let unit = "W m⁻² sr⁻¹".to_owned();
        Reading {
            lines: vec![place(side, fraction), radiance, unit],
            bounces: Vec::new(),
        }
    };
    if let Some(first) = reading.lines.first_mut() {
        *first = format!("{}  {first}", side.name);
    }
    reading
}

fn of_difference(
    session: &Session,
    settings: &ViewSettings,
    sides: &[Side; 2],
    fraction: [f32; 2],
) -> Reading {
    let [a, b] = sides
        .each_ref()
        .map(|side| side.radiance(session, fraction));
    let line = |name: &str, value: Rgb| format!("{name}  {}", three(value));
    let bounces = if sides[0].slot == Slot::Live {
        of_live(session, settings, fraction).bounces
    } else {
        Vec::new()
    };
    Reading {
        lines: vec![
            place(&sides[0], fraction),
            line(&sides[0].name, a),
            line(&sides[1].name, b),
            line("difference", a - b),
            "W m⁻² sr⁻¹".to_owned(),
        ],
        bounces,
    }
}

fn place(side: &Side, fraction: [f32; 2]) -> String {
    let (x, y) = Placement::pixel(fraction, side.size);
    format!("x {x}  y {y}")
}

fn three(value: Rgb) -> String {
    let number = |v: f32| significant(f64::from(v), 4);
    let Rgb { r, g, b } = value;
    format!("{}  {}  {}", number(r), number(g), number(b))
}
