//! `neumann bias`: how much of the error is noise, and how much the bias of a radius?

use serde_json::Value;

use super::Folder;

#[test]
fn the_error_is_split_in_words_on_a_map_and_as_json() {
    let folder = Folder::new();
    let common = "--size 24x24 --iterations 2 --renders 4";
    let line = format!("bias cornell ppm:radius=0.1,paths=16 {common}");
    let text = folder.succeed(&format!("{line} -o a.png"));
    for words in [
        "ppm:radius=0.1,paths=16 · 4 renders of 2 iterations at each of two radii · radius 0.4",
        "ppm:radius=0.1,paths=16 after 2 iterations, L: relative error ",
        "With half the radius noise ",
        "half radius: noise",
        "up to 1.6 times as large",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let map = |name: &str| std::fs::read(folder.join(name)).unwrap();
    folder.succeed(&format!("{line} -o b.png --view T2"));
    assert_ne!(map("a.png"), map("b.png"), "another part");
    let said = folder.succeed(&format!("{line} --json"));
    let said: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(
        (&said["renders"], &said["iterations"]),
        (&4.into(), &2.into())
    );
    let terms = said["terms"].as_array().unwrap();
    let names: Vec<_> = terms
        .iter()
        .map(|term| term["term"].as_str().unwrap())
        .collect();
    assert_eq!(names[..3], ["T0", "T1", "T2"]);
    assert_eq!(names.last(), Some(&"L"));
    for term in terms {
        let number = |name: &str, part: &str| term[name][part].as_f64().unwrap();
        for at in ["at_radius", "at_half"] {
            let both = number(at, "noise").hypot(number(at, "bias"));
            assert!((number(at, "error") - both).abs() < 1e-9, "{term}");
        }
        let quarter = 0.25 * number("at_radius", "bias");
        assert!((number("at_half", "bias") - quarter).abs() < 1e-6, "{term}");
    }
    let whole = terms.last().unwrap();
    assert_eq!(whole["bias_is_seen"], true, "{whole}");
    assert_eq!(terms[0]["at_radius"]["bias"], 0.0, "L_e has no radius");
}

#[test]
fn what_has_no_radius_is_refused() {
    let folder = Folder::new();
    for (line, words) in [
        (
            "bias cornell pt-mis",
            "pt-mis has no radius, and so no bias of one; pm, ppm, vcm have",
        ),
        ("bias cornell pm:nearest=50", "'nearest'"),
        ("bias cornell ppm --set radius=0.1", "--set:"),
        ("bias cornell ppm -o a.exr", "the map is a .png"),
        (
            "bias cornell ppm --view upto:2",
            "--view: upto:2 is not measured",
        ),
        ("bias cornell ppm --renders 1", "--renders"),
        ("bias cornell ppm:radius-unit=metres,radius=1e-6", "radius"),
    ] {
        let stderr = folder.fail(line, 2);
        assert!(stderr.contains(words), "{line}: {stderr}");
    }
}
