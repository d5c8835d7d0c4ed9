//! `neumann hemisphere`: the reflection equation at the point that a pixel shows.

use serde_json::Value;

use super::Folder;

fn found(folder: &Folder, line: &str) -> Value {
    serde_json::from_str(&folder.succeed(&format!("hemisphere {line} --json"))).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// All ways to the integral agree with the pixel less what the point emits, on a sheet and in
/// numbers.
#[test]
fn one_number_is_found_by_all_ways() {
    let folder = Folder::new();
    let options = "--size 64x48 --samples 24 --max-bounces 4 --threads 2";
    for (scene, pixel) in [
        ("cornell", "30,42"),
        ("cornell", "31,4"),
        ("furnace", "9,9"),
    ] {
        let line = format!("{scene} --pixel {pixel} {options} -o sheet.png");
        let found = found(&folder, &line);
        let reference = &found["reference"];
        let emitted: Vec<f64> = found["emitted"]
            .as_array()
            .unwrap()
            .iter()
            .map(number)
            .collect();
        let emitted = 0.2126 * emitted[0] + 0.7152 * emitted[1] + 0.0722 * emitted[2];
        let expected = number(&reference["luminance"]) - emitted;
        let mut ways: Vec<(&str, &Value)> = ["bsdf", "light", "mis"]
            .into_iter()
            .map(|id| (id, &found["estimators"][id]))
            .collect();
        ways.push(("pictures", &found["pictures"]));
        for (name, way) in ways {
            let value = number(&way["luminance"]);
            // Intervals of both, twice as wide as 95 of 100 need.
            let bound = 2.0 * number(&way["interval"]).hypot(number(&reference["interval"]))
                + 1e-3 * (expected.abs() + emitted);
            assert!(
                (value - expected).abs() <= bound,
                "{scene} {pixel} {name}: {value} for {expected} ± {bound}"
            );
        }
        let course = found["estimators"]["mis"]["course"].as_array().unwrap();
        let last = course.last().unwrap();
        assert_eq!(last["n"], found["estimators"]["mis"]["paths"]);
        assert_eq!(found["samples"], 24);
        let sheet = std::fs::metadata(folder.join("sheet.png")).unwrap();
        assert!(sheet.len() > 20_000, "{}", sheet.len());
    }
}

/// The lamp of cornell emits, and its text says so; a mirror is a point among the directions.
#[test]
fn emission_and_mirrors_are_told_apart_from_pictures() {
    let folder = Folder::new();
    let options = "--size 64x48 --samples 4 --max-bounces 3";
    let text = folder.succeed(&format!("hemisphere cornell --pixel 30,42 {options}"));
    assert!(text.contains("L_o = L_e + ∫ L_i f cos θ dω"), "{text}");
    for name in [
        "BSDF sampling",
        "light sampling",
        "MIS",
        "pictures",
        "pt-mis",
    ] {
        assert!(text.contains(name), "{name}: {text}");
    }
    assert!(!text.contains("mirror-like"), "{text}");
    let text = folder.succeed(&format!("hemisphere cornell-glass --pixel 24,34 {options}"));
    assert!(text.contains("mirror-like direction"), "{text}");
}

#[test]
fn what_cannot_be_looked_at_is_refused() {
    let folder = Folder::new();
    let refused = |line: &str, words: &str| {
        let stderr = folder.fail(&format!("hemisphere {line}"), 2);
        assert!(stderr.contains(words), "{line}: {stderr}");
    };
    refused(
        "cornell --size 16x16 --pixel 16,3",
        "16 columns and 16 rows",
    );
    refused("sky --size 64x48 --pixel 0,0", "leaves the scene");
    refused("cornell --pixel 3,3 -o a.exr", "a.exr: the sheet is a .png");
    refused(
        "cornell --pixel 256,400 --integrator lt",
        "--integrator lt: one ray is rendered",
    );
    assert!(!folder.join("a.exr").exists());
}
