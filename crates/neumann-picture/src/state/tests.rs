//! States go to a file and come back; what is wrong with a file is told.

use super::{
    CameraState, Exact, LensState, LevelEdit, LobesOf, LookedAt, MaterialEdit, ProjectionState,
    Racing, RegionState, State, Stop,
};
use crate::files::tests::TestFolder;

fn full() -> State {
    let mut state = State {
        scene: "cornell".to_owned(),
        camera: Some(CameraState {
            of_file: 0,
            world_from_camera: Exact::all([0.1; 16]),
            aspect_ratio: Some(Exact(1.5)),
            projection: ProjectionState::Perspective { yfov: Exact(0.7) },
            lens: Some(LensState {
                aperture: Exact(0.03),
                focus_distance: Exact(2.0),
            }),
            target: Some(Exact::all([1.0, 1.0 / 3.0, -1e-7])),
            up: Some(Exact::all([0.0, 1.0, 0.0])),
        }),
        size: Some([64, 48]),
        region: Some(RegionState {
            of: [64, 48],
            at: [10, 0],
            size: [54, 20],
        }),
        stop: Stop::Seconds(0.1),
        ..State::default()
    };
    state
        .parameters
        .insert("roulette-start".to_owned(), "5".to_owned());
    state.edits.materials.push(MaterialEdit {
        index: 2,
        name: "red".to_owned(),
        base_color: Exact::all([0.1, 0.2, 0.3]),
        roughness: Exact(0.4),
        metallic: Exact(0.0),
        specular: Exact(1.0),
        transmission: Exact(0.0),
        ior: Exact(1.5),
        emission: Exact::all([0.0; 3]),
        specular_color: Some(Exact::all([1.5, 1.0, 0.5])),
        attenuation_color: None,
    });
    state.edits.lights.push(LevelEdit {
        index: 0,
        name: "sun".to_owned(),
        is_on: false,
        brightness: Exact(2.0),
        strength: Some(Exact::all([3.0, 2.0, 1.0])),
    });
    state.looked_at = LookedAt {
        inspected: Some([3, 4]),
        hemisphere: Some([0, 47]),
        lobes: Some(LobesOf::Material(2)),
        race: vec![
            Racing::OfPage("bdpt".to_owned()),
            Racing::Own("pt-mis:roulette=off".to_owned()),
        ],
    };
    state
}

#[test]
fn what_cannot_be_looked_at_is_refused() {
    let refused = |looked_at: &str, words: &str| {
        let text = format!(r#"{{"scene": "cornell", "looked_at": {looked_at}}}"#);
        let (field, what) = State::parse(&text).unwrap_err();
        let error = format!("{field}: {what}");
        assert!(error.contains(words), "{error}");
    };
    refused(
        r#"{"inspected": [1, 65535]}"#,
        "looked_at.inspected[1]: 65535",
    );
    refused(
        r#"{"lobes": {"pixel": [70000, 1]}}"#,
        "looked_at.lobes.pixel[0]",
    );
    refused(r#"{"race": [{"own": "bdpt"}]}"#, "names 1; use 2 to 4");
    let race = |second: &str| format!(r#"{{"race": [{{"own": "bdpt"}}, {{{second}}}]}}"#);
    refused(
        &race(r#""own": "pt-mos""#),
        "looked_at.race[1]: no integrator",
    );
    refused(&race(r#""of_page": "pt-mis:roulette=off""#), "use 'own'");
}

#[test]
fn a_state_comes_back_from_its_file() {
    let folder = TestFolder::new();
    let path = folder.join("a.json");
    let mut state = full();
    state.parameters.clear();
    state.write(&path).unwrap();
    assert_eq!(State::read(&path).unwrap(), (state, Vec::new()));
}

#[test]
fn what_is_left_out_is_as_usual() {
    let (state, warnings) = State::parse(r#"{"scene": "cornell"}"#).unwrap();
    let usual = State {
        scene: "cornell".to_owned(),
        ..State::default()
    };
    assert_eq!((state, warnings.len()), (usual, 0));
}

/// As they were written before lights, environment and reflections had colours.
#[test]
fn edits_without_newer_colours_are_read() {
    let text = r#"{"scene": "cornell", "environment": {"sky": "sun", "brightness": 2},
        "edits": {
            "materials": [{"index": 1, "name": "red", "base_color": [0.1, 0.2, 0.3],
                "roughness": 0.5, "metallic": 0, "specular": 1, "transmission": 0, "ior": 1.5,
                "emission": [0, 0, 0]}],
            "emitters": [],
            "lights": [{"index": 0, "name": "sun", "is_on": true, "brightness": 3}]}}"#;
    let (state, warnings) = State::parse(text).unwrap();
    assert_eq!(warnings.len(), 0, "{warnings:?}");
    assert_eq!(state.environment.tint, Exact::all([1.0; 3]));
    assert_eq!(state.edits.lights[0].strength, None);
    assert_eq!(state.edits.materials[0].specular_color, None);
}

#[test]
fn what_nobody_knows_is_ignored_and_told() {
    let text = r#"{"scene": "cornell", "shine": 1, "exposure": {"stops": 1, "iso": 100},
        "parameters": {"no-such": "1"}}"#;
    let (state, warnings) = State::parse(text).unwrap();
    assert_eq!(state.exposure.stops, Exact(1.0));
    for field in ["shine", "exposure.iso", "parameters.no-such"] {
        let is_told = |w: &String| w.starts_with(&format!("{field}: "));
        assert!(warnings.iter().any(is_told), "{field}: {warnings:?}");
    }
}

#[test]
fn what_is_wrong_is_told_with_its_field() {
    for (text, field) in [
        (r#"{"scene": 1}"#, "scene"),
        (r#"{}"#, "scene"),
        (r#"{"scene": "cornell", "method": "best"}"#, "method"),
        (r#"{"scene": "cornell", "layers": 0}"#, "layers"),
        (r#"{"scene": "cornell", "layers": -1}"#, "layers"),
        (r#"{"scene": "cornell", "part": "T"}"#, "part"),
        (
            r#"{"scene": "cornell", "exposure": {"stops": 1e9}}"#,
            "exposure.stops",
        ),
        (r#"{"scene": "cornell", "size": [0, 5]}"#, "size[0]"),
        (r#"{"scene": "cornell", "stop": {"seconds": -1}}"#, "stop"),
        (
            r#"{"scene": "cornell", "edits": {"lights": [{"index": 0}]}}"#,
            "edits.lights[0]",
        ),
        (
            r#"{"scene": "cornell", "environment": {"tint": [1, 2, 0]}}"#,
            "environment.tint[1]",
        ),
        (r#"{"scene": "cornell", "size": [3"#, "size"),
        ("", ""),
        ("[]", ""),
        ("\u{0}", ""),
        (r#"{"scene": "cornell"} more"#, ""),
    ] {
        let (found, what) = State::parse(text).unwrap_err();
        assert!(found.starts_with(field), "{text}: {found}: {what}");
        assert!(
            what.contains("; ") || what.contains("use "),
            "{text}: {what}"
        );
    }
}

#[test]
fn a_region_that_is_no_part_of_the_film_is_told_with_its_field() {
    let read = |size: &str, region: &str| {
        State::parse(&format!(
            r#"{{"scene": "cornell", {size} "region": {{{region}}}}}"#
        ))
    };
    let film = r#""size": [64, 48],"#;
    for (size, region, field) in [
        (
            film,
            r#""of": [32, 48], "at": [0, 0], "size": [8, 8]"#,
            "region.of",
        ),
        (
            "",
            r#""of": [0, 48], "at": [0, 0], "size": [8, 8]"#,
            "region.of[0]",
        ),
        (
            "",
            r#""of": [64, 70000], "at": [0, 0], "size": [8, 8]"#,
            "region.of[1]",
        ),
        (
            film,
            r#""of": [64, 48], "at": [64, 0], "size": [8, 8]"#,
            "region.at[0]",
        ),
        (
            film,
            r#""of": [64, 48], "at": [0, -1], "size": [8, 8]"#,
            "region.at[1]",
        ),
        (
            film,
            r#""of": [64, 48], "at": [57, 0], "size": [8, 8]"#,
            "region.size[0]",
        ),
        (
            "",
            r#""of": [64, 48], "at": [0, 9], "size": [8, 0]"#,
            "region.size[1]",
        ),
        (
            "",
            r#""of": [64, 48], "at": [20, 9], "size": [-8, 4]"#,
            "region.size[0]",
        ),
        (
            "",
            r#""of": [64, 48], "at": [0, 18446744073709551615], "size": [1, 1]"#,
            "region.at[1]",
        ),
        ("", r#""of": [64, 48], "at": [0, 0]"#, "region"),
    ] {
        let (found, what) = read(size, region).unwrap_err();
        assert_eq!(found, field, "{region}: {what}");
        assert!(what.contains("; "), "{region}: {what}");
    }
    let (state, warnings) = read("", r#""of": [64, 48], "at": [56, 0], "size": [8, 48]"#).unwrap();
    assert_eq!(warnings, Vec::<String>::new());
    assert_eq!(state.region.map(|region| region.size), Some([8, 48]));
}

#[test]
fn every_prefix_of_a_state_is_refused_and_none_panics() {
    let text = full().to_text();
    let text = text.trim_end();
    for end in (0..text.len()).filter(|end| text.is_char_boundary(*end)) {
        assert!(State::parse(&text[..end]).is_err(), "{end}");
    }
}

#[test]
fn damaged_states_are_read_or_refused_and_none_panics() {
    let text = full().to_text();
    let pieces = [
        "-", "9", "e", "\"", "[", "{", "null", ",", "1e999", "\u{fffd}", "",
    ];
    let ends: Vec<usize> = (0..=text.len())
        .filter(|i| text.is_char_boundary(*i))
        .collect();
    let mut n_read = 0;
    for i in 0..20_000usize {
        let place = |k: usize| ends[i.wrapping_mul(k) % ends.len()];
        let (from, to) = (place(2_654_435_761), place(40_503));
        let (from, to) = (from.min(to), from.max(to).min(from.min(to) + i % 7));
        let to = (to..text.len())
            .find(|i| text.is_char_boundary(*i))
            .unwrap_or(text.len());
        let damaged = text[..from].to_owned() + pieces[i % pieces.len()] + &text[to..];
        n_read += usize::from(State::parse(&damaged).is_ok());
    }
    assert!(n_read > 100, "{n_read}");
}

#[test]
fn a_missing_scene_is_one_clear_error() {
    let folder = TestFolder::new();
    let path = folder.join("a.json");
    std::fs::write(&path, r#"{"scene": "rooms/none.glb"}"#).unwrap();
    let error = State::read(&path).unwrap_err();
    assert_eq!(error.field, "scene");
    let text = error.to_string();
    assert!(
        text.contains("a.json") && text.contains("rooms/none.glb"),
        "{text}"
    );
    // A path is taken from the folder of the state.
    std::fs::create_dir(folder.join("rooms")).unwrap();
    std::fs::write(folder.join("rooms/none.glb"), "").unwrap();
    let (state, _) = State::read(&path).unwrap();
    assert_eq!(
        state.scene,
        folder.join("rooms/none.glb").display().to_string()
    );
    assert!(State::read(&folder.join("b.json")).is_err());
}
