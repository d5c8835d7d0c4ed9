//! What is said of photons: while there are none, and of those in one pixel.

use neumann_core::photons::PhotonStack;
use neumann_core::radiometry::Rgb;
use neumann_picture::photons::{PhotonColours, PhotonLook, watts};

use crate::probe::Reading;
use crate::session::Session;

/// What a choice of colours says of photons, in a sentence.
pub(super) fn about(colours: PhotonColours) -> &'static str {
    match colours {
        PhotonColours::Bounce => "A colour for how often a photon was scattered before it landed.",
        PhotonColours::Power => "The power that the photons of a pixel carry, in watts.",
    }
}

/// Why no photons are shown.
pub(super) fn waiting(session: &Session, are_there: bool) -> &'static str {
    if are_there {
        "the picture is larger than the graphics device can draw"
    } else if session.link.is_paused() && session.picture.divisor > 1 {
        "paused: no photons are drawn until rendering goes on"
    } else {
        "drawing photons …"
    }
}

/// The photons of a pixel, as the probe tells of them: those that are shown in words, all of them
/// as bars.
pub(super) fn reading(
    stacks: &[PhotonStack],
    (x, y): (usize, usize),
    look: &PhotonLook,
) -> Reading {
    let mut bounces = vec![0.0; look.n_layers + 1];
    for stack in stacks {
        bounces[(stack.bounce as usize).min(look.n_layers)] += stack.n as f32;
    }
    let shown: Vec<_> = stacks.iter().filter(|s| look.shows(s.bounce)).collect();
    let n: u32 = shown.iter().map(|stack| stack.n).sum();
    let mut lines = vec![format!("x {x}  y {y}")];
    lines.push(match n {
        0 => "no photon".to_owned(),
        1 => format!("1 photon, bounce {}", shown[0].bounce),
        n => format!("{n} photons, bounce {}", counts(&shown)),
    });
    if n > 0 {
        let power = shown
            .iter()
            .fold(Rgb::BLACK, |sum, stack| sum + stack.power);
        lines.push(power.to_array().map(watts).join("  "));
    }
    Reading { lines, bounces }
}

/// Bounces with how often each occurs: `1, 2 ×3, 5`.
fn counts(stacks: &[&PhotonStack]) -> String {
    const MOST: usize = 3;
    let name = |stack: &&PhotonStack| match stack.n {
        1 => stack.bounce.to_string(),
        n => format!("{} ×{n}", stack.bounce),
    };
    let mut names: Vec<String> = stacks.iter().take(MOST).map(name).collect();
    if stacks.len() > MOST {
        names.push("…".to_owned());
    }
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use neumann_core::film::View;
    use neumann_core::photons::PhotonStack;
    use neumann_core::radiometry::Rgb;
    use neumann_picture::photons::PhotonLook;

    use super::reading;

    #[test]
    fn a_pixel_tells_what_is_shown_of_it() {
        let stack = |bounce, n| PhotonStack {
            bounce,
            n,
            power: Rgb::new(1e-3, 0.0, 2e-6) * n as f32,
        };
        let stacks = [stack(1, 2), stack(2, 1), stack(9, 4)];
        let look = |part| PhotonLook {
            part,
            n_layers: 3,
            ..PhotonLook::default()
        };
        let all = reading(&stacks, (5, 6), &look(View::Total));
        assert_eq!(
            all.lines,
            [
                "x 5  y 6",
                "7 photons, bounce 1 ×2, 2, 9 ×4",
                "7 mW  0  14 µW"
            ]
        );
        assert_eq!(all.bounces, [0.0, 2.0, 1.0, 4.0]);
        let one = reading(&stacks, (5, 6), &look(View::Term(2)));
        assert_eq!(one.lines[1..], ["1 photon, bounce 2", "1 mW  0  2 µW"]);
        assert_eq!(one.bounces, all.bounces);
        assert_eq!(
            reading(&[], (0, 0), &look(View::Total)).lines[1],
            "no photon"
        );
    }
}
