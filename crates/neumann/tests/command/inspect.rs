//! `neumann inspect`: why a pixel is as bright as it is.

use neumann_picture::image_file::read_image;
use serde_json::Value;

use super::Folder;

fn inspected(folder: &Folder, line: &str) -> Value {
    serde_json::from_str(&folder.succeed(&format!("inspect {line} --json"))).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Bounces and techniques add up to the pixel, and the pixel is that of the rendered file.
#[test]
fn values_are_those_of_the_picture() {
    let folder = Folder::new();
    for integrator in ["pt-mis", "bdpt", "vcm"] {
        let options =
            format!("cornell-glass --size 16x16 --integrator {integrator} --iterations 4");
        let found = inspected(&folder, &format!("{options} --pixel 7,11"));
        folder.succeed(&format!("render {options} -o {integrator}.exr"));
        let image = read_image(&folder.join(&format!("{integrator}.exr")));
        let pixel = image.unwrap().pixels[11 * 16 + 7].to_array();
        for (c, expected) in pixel.into_iter().enumerate() {
            let of = |value: &Value| number(&value["value"][c]);
            let sum = |name: &str| found[name].as_array().unwrap().iter().map(of).sum::<f64>();
            let expected = f64::from(expected);
            for value in [sum("bounces"), sum("techniques"), of(&found["total"])] {
                let apart = (value - expected).abs();
                assert!(
                    apart <= 1e-4 * expected,
                    "{integrator}: {value} for {expected}"
                );
            }
        }
        let paths = found["paths"].as_array().unwrap();
        assert!(!paths.is_empty() && paths.len() <= 10, "{integrator}");
    }
}

#[test]
fn a_sentence_says_where_light_comes_from() {
    let folder = Folder::new();
    let sentence = |line: &str| {
        let text = folder.succeed(&format!("inspect {line} --size 64x64 --iterations 8"));
        text.lines().next().unwrap().to_owned()
    };
    let lamp = sentence("cornell --pixel 32,8");
    assert!(
        lamp.contains("of this pixel comes straight from "),
        "{lamp}"
    );
    let floor = sentence("cornell --pixel 20,60");
    assert!(
        floor.contains("of this pixel arrives after one bounce"),
        "{floor}"
    );
    assert!(floor.contains("; one path of "), "{floor}");
    // No term of the series but the first: nothing comes from a wall.
    let dark = sentence("cornell --pixel 4,32 --max-bounces 0");
    assert_eq!(dark, "No light has come here in 8 iterations.");
}

/// Kinds of paths that exclude each other have shares that add up to all.
#[test]
fn expressions_pick_ways_and_paths() {
    let folder = Folder::new();
    let options = "cornell-glass --size 64x64 --pixel 20,58 --integrator bdpt --iterations 8";
    let share = |only: &str| {
        // The command line of the test is cut at spaces.
        let found = inspected(&folder, &format!("{options} --only {only}"));
        for path in found["paths"].as_array().unwrap() {
            let path = path["path"].as_str().unwrap();
            assert_eq!(only.contains("S+"), path.contains('S'), "{only}: {path}");
        }
        number(&found["share"])
    };
    let (with, without) = (share("L.*S+.*E"), share("L[DG]*E"));
    assert!(with > 0.0 && without > 0.0, "{with} {without}");
    assert!((with + without - 1.0).abs() < 1e-5, "{with} {without}");
}

#[test]
fn what_cannot_be_read_is_refused_with_a_caret() {
    let folder = Folder::new();
    let stderr = folder.fail("inspect cornell --size 16x16 --pixel 3,3 --only LXE", 2);
    assert!(stderr.contains("LXE\n ^\n"), "{stderr}");
    assert!(stderr.contains("character 2: 'X' is no bounce"), "{stderr}");
    let stderr = folder.fail("inspect cornell --size 16x16 --pixel 16,3", 2);
    assert!(stderr.contains("16 columns and 16 rows"), "{stderr}");
    let stderr = folder.fail("inspect cornell --pixel 3,3 --technique 2", 2);
    assert!(stderr.contains("use S,T"), "{stderr}");
}

#[test]
fn fireflies_are_found_with_the_paths_that_made_them() {
    let folder = Folder::new();
    let line = "pool --size 48x36 --iterations 8 --fireflies 3";
    let found = inspected(&folder, line);
    let found = found["fireflies"].as_array().unwrap();
    assert_eq!(found.len(), 3);
    for firefly in found {
        assert!(number(&firefly["luminance"]) > 3.0 * number(&firefly["around"]));
        assert!(number(&firefly["path"]["share"]) > 0.05);
        assert!(
            firefly["path"]["rarity"]
                .as_str()
                .unwrap()
                .contains("weight")
        );
    }
    let text = folder.succeed(&format!("inspect {line}"));
    assert_eq!(text.matches("pixel ").count(), 3, "{text}");
    let none = folder.succeed("inspect furnace --size 16x16 --iterations 4 --fireflies 3");
    assert_eq!(none.trim(), "No pixel stands out.");
    let stderr = folder.fail("inspect pool --fireflies 3 --pixel 1,1", 2);
    assert!(stderr.contains("cannot be used with"), "{stderr}");
}
