//! The camera looks through backs where it is asked to, and somebody is told that it may.

use serde_json::Value;

use super::{Folder, stderr_of};

/// The Cornell box from outside, towards its back wall.
const OUTSIDE: &str = "cornell --eye 0,2.7,-14 --target 0,2.7,0 --size 16x16 --iterations 2";

#[test]
fn a_room_is_seen_from_outside_through_its_walls() {
    let folder = Folder::new();
    let told = stderr_of(&folder, &format!("render {OUTSIDE} -o a.exr"));
    let sentence = "backs of single-sided surfaces hide ";
    assert!(told.contains(sentence) && told.contains("--backs see-through"));
    let told = stderr_of(
        &folder,
        &format!("render {OUTSIDE} --backs see-through -o b.exr"),
    );
    assert!(!told.contains(sentence), "{told}");
    let light = |name: &str| {
        let film = folder.film(name).film;
        film.total().iter().map(|c| c.luminance()).sum::<f32>()
    };
    let (solid, through) = (light("a.exr"), light("b.exr"));
    assert!(through > 2.0 * solid, "{solid} and {through}");
    // Another picture is neither resumed nor merged.
    let more = "--iterations 4 --resume -o a.exr --backs see-through";
    let line = format!("render {OUTSIDE} {more}").replace("--iterations 2 ", "");
    let told = folder.fail(&line, 2);
    let expected = "backs (see-through asked for, solid in the file)";
    assert!(told.contains(expected), "{told}");
    folder.succeed(&format!(
        "render {OUTSIDE} --backs see-through --first-iteration 2 -o c.exr"
    ));
    let told = folder.fail("merge a.exr c.exr -o d.exr", 2);
    assert!(told.contains("backs"), "{told}");
    folder.succeed("merge b.exr c.exr -o d.exr");
    assert_eq!(folder.film("d.exr").film.n_iterations(), 4);
}

#[test]
fn a_series_looks_through_backs_too_and_other_words_are_refused() {
    let folder = Folder::new();
    let line = format!("series {OUTSIDE} -o series --backs see-through --json");
    let report: Value = serde_json::from_str(&folder.succeed(&line)).unwrap();
    assert_eq!(report["refused"], 0);
    let film = folder.film("series/L.exr").film;
    assert!(film.layers()[1].iter().any(|c| c.luminance() > 0.05));
    let told = folder.fail("render cornell -o a.exr --backs glass", 2);
    assert!(
        told.contains("--backs") && told.contains("see-through"),
        "{told}"
    );
}
