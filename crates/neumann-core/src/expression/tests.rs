use super::{Expression, ExpressionError, Names, PRESETS, parse};
use crate::radiometry::Rgb;
use crate::transport::{Bounce, Lobe, Scattered, Source};

/// Material 7 is 'red wall'; 1 and 2 are both 'lamp'.
fn named(name: &str) -> Vec<u32> {
    match name {
        "red wall" => vec![7],
        "lamp" => vec![1, 2],
        _ => Vec::new(),
    }
}

/// Light 5 is 'spot'.
fn lights(name: &str) -> Vec<u32> {
    if name == "spot" { vec![5] } else { Vec::new() }
}

fn expression(text: &str) -> Result<Expression, ExpressionError> {
    let names = Names {
        materials: &named,
        lights: &lights,
    };
    parse::expression(text, &names)
}

fn read(text: &str) -> Expression {
    expression(text).unwrap_or_else(|error| panic!("{error}"))
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
    let of = |text: &str, source| read(text).matches(&bounces("D"), Some(source));
    let material = Source::Material;
    assert!(of("L'lamp' D E", material(2)) && !of("L'lamp' D E", material(3)));
    assert!(!of("L'lamp' D E", Source::Environment));
    assert!(of("E D L'environment'", Source::Environment));
    assert!(!of("L'environment' D E", material(1)) && of("L D E", material(1)));
    assert!(of("L'spot' D E", Source::Punctual(5)) && !of("L'spot' D E", material(5)));
    // Each of those side by side has its own light.
    let two = "L'spot' D E | L'lamp' S E";
    assert!(of(two, Source::Punctual(5)) && !of(two, material(1)));
}

/// A bounce that two lobes have in common goes each lobe's way with its share, and is counted once
/// where both ways are taken.
#[test]
fn shares_of_lobes_add_up() {
    let coated = |glossy: f32| Scattered {
        bounce: Bounce {
            lobe: Lobe::Diffuse,
            is_transmission: false,
            material: Some(7),
        },
        glossy: Rgb::new(glossy, 0.5, 0.0),
    };
    let mirror = Scattered::by_one(Bounce {
        lobe: Lobe::Specular,
        is_transmission: false,
        material: None,
    });
    let row = [coated(0.25), mirror, coated(0.125)];
    let share = |text: &str| read(text).share(&row, None).r;
    assert_eq!(share("E D S D L"), 0.75 * 0.875);
    assert_eq!(share("E G S D L"), 0.25 * 0.875);
    assert_eq!(share("L D S G E"), 0.25 * 0.875);
    assert_eq!(share("L .* E"), 1.0);
    assert_eq!(share("L (D|G|.)* E"), 1.0, "however often it fits");
    assert_eq!(share("L [DG] S [DG] E | L G .* E"), 1.0);
    assert_eq!(share("L .* G .* E"), 1.0 - 0.75 * 0.875);
    let complete = [
        "L D* E",
        "L [DS]* G [DS]* E",
        "L [DS]* S [DS]* E",
        "L .* G .* G .* E",
    ];
    let sum: f32 = complete.map(share).iter().sum();
    assert_eq!(sum, 1.0, "{complete:?}");
}

#[test]
fn presets_can_be_read() {
    for (name, text) in PRESETS {
        assert_eq!(read(text).text(), text, "{name}");
        let named = read(name);
        assert_eq!((named.name(), named.text()), (name, text));
    }
    let own = read(" my haze = L G E ");
    assert_eq!((own.name(), own.text()), ("my haze", "L G E"));
    assert_eq!(own.to_string(), "my haze=L G E");
    assert_eq!(read("L G E").to_string(), "L G E");
}

#[test]
fn errors_say_what_is_wrong_and_where() {
    for (text, what, at) in [
        ("", "begins with L or E", 0),
        ("a.b=L E", "a name before '='", 0),
        ("a=L D", "ends without E", 5),
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
        // Which of the last 20 bounces were diffuse has to be known.
        ("L .{20} D .* E", "too large", 14),
        (
            "L'blue' E",
            "no material or light of the scene is called 'blue'",
            1,
        ),
    ] {
        let error = expression(text).unwrap_err();
        let said = error.to_string();
        assert!(said.contains(what), "{text}: {said}");
        assert!(said.contains(&format!("character {}:", at + 1)), "{said}");
        let marked = error.marked();
        let caret = marked.lines().last().unwrap_or_default();
        assert_eq!(caret.len(), at + 1, "{marked}");
    }
    let deep = format!("L {}D{} E", "(".repeat(99), ")".repeat(99));
    assert!(expression(&deep).is_err());
    // Nothing, so often that it would take forever to write it down.
    let nothing = format!("L {}{} E", "(".repeat(30), "){64}".repeat(30));
    assert!(expression(&nothing).is_err());
    let long = format!("L {} E", "D".repeat(999));
    assert!(expression(&long).is_err());
}
