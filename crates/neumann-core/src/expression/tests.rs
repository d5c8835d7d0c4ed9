use super::parse::expression;
use super::{Expression, PRESETS};
use crate::transport::{Bounce, Lobe};

/// Material 7 is 'red wall'; 1 and 2 are both 'lamp'.
fn named(name: &str) -> Vec<u32> {
    match name {
        "red wall" => vec![7],
        "lamp" => vec![1, 2],
        _ => Vec::new(),
    }
}

fn read(text: &str) -> Expression {
    expression(text, &named).unwrap_or_else(|error| panic!("{error}"))
}

/// Bounces from the eye on: `D`, `t` for glass that is passed, `S` for a mirror, `G`, and `w` for
/// the red wall.
fn bounces(text: &str) -> Vec<Bounce> {
    text.chars()
        .map(|letter| Bounce {
            lobe: match letter {
                'D' | 'w' => Lobe::Diffuse,
                'G' => Lobe::Glossy,
                _ => Lobe::Specular,
            },
            is_transmission: letter == 't',
            material: Some(if letter == 'w' { 7 } else { 0 }),
        })
        .collect()
}

#[test]
fn expressions_stand_for_the_paths_that_they_say() {
    for (text, fits, fits_not) in [
        ("L E", vec![""], vec!["D"]),
        ("L D E", vec!["D", "w"], vec!["", "DD", "G"]),
        // From the light to the eye, so the last bounce is the first that the eye sees.
        ("LS+DE", vec!["DS", "DSS", "Dt"], vec!["D", "SD", "DSD"]),
        ("E D S+ L", vec!["DS", "DSS"], vec!["D", "SD"]),
        (
            "L . * S D S E",
            vec!["SDS", "SDSG", "SDSDD"],
            vec!["SDD", "DS"],
        ),
        ("L T{2} D E", vec!["Dtt"], vec!["Dt", "Dttt", "DSS"]),
        ("L S{1,2} D E", vec!["DS", "DSt"], vec!["D", "DSSS"]),
        ("L D{2,} E", vec!["DD", "DDDD"], vec!["D"]),
        ("L (S D | D S)? E", vec!["", "DS", "SD"], vec!["D", "S"]),
        ("L [^S]+ E", vec!["D", "GD"], vec!["", "DS"]),
        ("L [D G] E", vec!["D", "G"], vec!["S"]),
        ("L Sr D E | L St D E", vec!["DS", "Dt"], vec!["D"]),
        ("L 'red wall' . E", vec!["Dw", "tw"], vec!["wD", "ww D"]),
        ("L S'red wall' E", vec![], vec!["w", "S"]),
        ("L (D*)* E", vec!["", "DDD"], vec!["S"]),
        (
            "L ((S|D) G?){0,2} E",
            vec!["", "D", "GDS"],
            vec!["DDD", "G"],
        ),
    ] {
        let expression = read(text);
        for of in fits {
            assert!(expression.matches(&bounces(of), None), "{text}: {of}");
        }
        for of in fits_not {
            assert!(!expression.matches(&bounces(of), None), "{text}: {of}");
        }
    }
}

#[test]
fn lights_are_told_apart() {
    let of = |text: &str, emitter| read(text).matches(&bounces("D"), emitter);
    assert!(of("L'lamp' D E", Some(2)) && !of("L'lamp' D E", Some(3)));
    assert!(!of("L'lamp' D E", None) && of("E D L'environment'", None));
    assert!(!of("L'environment' D E", Some(1)) && of("L D E", Some(1)));
}

/// Every path has one of these kinds, and only one.
#[test]
fn presets_can_be_read() {
    for (name, text) in PRESETS {
        assert_eq!(read(text).text(), text, "{name}");
    }
}

#[test]
fn errors_say_what_is_wrong_and_where() {
    for (text, what, at) in [
        ("", "begins with L or E", 0),
        ("D E", "begins with L or E", 0),
        ("L D", "ends without E", 3),
        ("L D L", "E ends the expression", 4),
        ("L X E", "'X' is no bounce", 2),
        ("L * E", "'*' says how often, but not what", 2),
        ("L (D E", "')' is missing", 5),
        ("L [D E", "']' is missing", 5),
        ("L [] E", "holds nothing", 4),
        ("L D{3,2} E", "less than the first", 3),
        ("L D{99} E", "from 0 to 64", 4),
        ("L D{2 E", "'}' is missing", 6),
        ("L 'blue' E", "no material of the scene is called 'blue'", 2),
        ("L 'blue E", "does not end", 2),
        ("L D E E", "has ended before this", 6),
        ("L ((.{64}){64}){64} E", "too large", 21),
    ] {
        let error = expression(text, &named).unwrap_err();
        let said = error.to_string();
        assert!(said.contains(what), "{text}: {said}");
        assert!(said.contains(&format!("character {}:", at + 1)), "{said}");
        let marked = error.marked();
        let caret = marked.lines().last().unwrap_or_default();
        assert_eq!(caret.len(), at + 1, "{marked}");
    }
    let deep = format!("L {}D{} E", "(".repeat(99), ")".repeat(99));
    assert!(expression(&deep, &named).is_err());
    // Nothing, so often that it would take forever to write it down.
    let nothing = format!("L {}{} E", "(".repeat(30), "){64}".repeat(30));
    assert!(expression(&nothing, &named).is_err());
    let long = format!("L {} E", "D".repeat(999));
    assert!(expression(&long, &named).is_err());
}
