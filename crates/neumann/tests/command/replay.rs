//! `neumann replay`: the paths behind a pixel.

use serde_json::Value;

use super::Folder;

/// The value that JSON says adds up, and is that of the picture.
#[test]
fn replayed_contributions_are_the_pixel() {
    let folder = Folder::new();
    for integrator in ["naive", "pt-mis", "lt", "vcm"] {
        let options = format!("cornell-glass --size 16x16 --seed 3 --integrator {integrator}");
        let line = format!("replay {options} --pixel 7,11 --iteration 2 --json");
        let replayed: Value = serde_json::from_str(&folder.succeed(&line)).unwrap();
        let value = |v: &Value| [0, 1, 2].map(|c| v[c].as_f64().unwrap());
        let contributions = replayed["contributions"].as_array().unwrap();
        assert!(!contributions.is_empty(), "{integrator}");
        let mut sum = [0.0; 3];
        for contribution in contributions {
            let of = value(&contribution["value"]);
            sum.iter_mut().zip(of).for_each(|(sum, v)| *sum += v);
            let path = contribution["path"].as_str().unwrap();
            assert!(path.starts_with('E') && path.ends_with('L'), "{path}");
        }
        let total = value(&replayed["value"]);
        for (sum, total) in sum.iter().zip(total) {
            assert!((sum - total).abs() <= 1e-5 * total, "{integrator}");
        }
        let text = folder.succeed(&format!("replay {options} --pixel 7,11 --iteration 2"));
        let n_lines = text.lines().filter(|line| line.contains("  E ")).count();
        assert_eq!(n_lines, contributions.len(), "{integrator}: {text}");
    }
}

#[test]
fn a_pixel_beside_the_picture_is_refused() {
    let folder = Folder::new();
    let stderr = folder.fail("replay cornell --size 16x16 --pixel 16,3", 2);
    assert!(stderr.contains("16 columns and 16 rows"), "{stderr}");
    let stderr = folder.fail("replay cornell --size 16x16 --pixel 3", 2);
    assert!(stderr.contains("COLUMN,ROW"), "{stderr}");
}
