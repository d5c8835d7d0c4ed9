//! `neumann lobe`: the BSDF of a material, direction by direction.

use serde_json::Value;

use super::Folder;

fn found(folder: &Folder, line: &str) -> Value {
    serde_json::from_str(&folder.succeed(&format!("lobe {line} --json"))).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn figures_sheet_and_curves_are_written() {
    let folder = Folder::new();
    let text = folder.succeed("lobe cornell --material red -o red.png --csv red.csv");
    let rows: Vec<&str> = text.lines().collect();
    assert_eq!(rows[0], "material red");
    for (row, angle) in rows[2..6].iter().zip(["0°", "30°", "60°", "80°"]) {
        assert!(row.starts_with(angle) && row.ends_with("1.0000"), "{row}");
    }
    assert!(rows[6].starts_with("reciprocity holds"), "{text}");
    let sheet = std::fs::metadata(folder.join("red.png")).unwrap();
    assert!(sheet.len() > 20_000, "{}", sheet.len());
    let csv = std::fs::read_to_string(folder.join("red.csv")).unwrap();
    let mut lines = csv.lines();
    let head = "curve,viewer_deg,direction_deg,red,green,blue,pdf_w";
    assert_eq!(lines.next(), Some(head));
    // A diffuse surface: the albedo over π everywhere above it.
    let albedo = number(&found(&folder, "cornell --material red")["albedo"][0]["albedo"][0]);
    let mut n = 0;
    for line in lines.filter(|line| line.starts_with("polar,60,")) {
        let cells: Vec<f64> = line
            .split(',')
            .skip(1)
            .map(|c| c.parse().unwrap())
            .collect();
        let expected = if cells[1].abs() < 90.0 {
            albedo / std::f64::consts::PI
        } else {
            0.0
        };
        assert!((cells[2] - expected).abs() < 1e-5, "{line}");
        n += 1;
    }
    assert!(n > 150, "{n}");
    assert!(csv.contains("\nalbedo,30,,"));
}

/// Seen through a pixel the same material is found as by its name, and the angle is told.
#[test]
fn a_pixel_shows_the_material_that_is_there() {
    let folder = Folder::new();
    let seen = found(&folder, "cornell --size 64x64 --pixel 4,30");
    let name = seen["material"].as_str().unwrap();
    assert!(["red", "green"].contains(&name), "{name}");
    let named = found(&folder, &format!("cornell --material {name}"));
    assert_eq!(seen["albedo"], named["albedo"]);
    assert!(number(&seen["seen_under"]) > 5.0 && named["seen_under"].is_null());
}

#[test]
fn mirror_like_lobes_have_directions_and_shares() {
    let folder = Folder::new();
    let glass = found(
        &folder,
        "cornell-glass --material glass --behind --angles 20,60",
    );
    assert_eq!(glass["from_behind"], true);
    let views = glass["views"].as_array().unwrap();
    assert_eq!(views.len(), 2);
    let lobes = |view: &Value| view["mirror_like"].as_array().unwrap().len();
    assert_eq!(
        (lobes(&views[0]), lobes(&views[1])),
        (2, 1),
        "total reflection"
    );
    assert!(glass["reciprocity"].is_null());
    let curves = "lobe cornell-glass --material glass --angles 20 --csv glass.csv";
    folder.succeed(curves);
    let csv = std::fs::read_to_string(folder.join("glass.csv")).unwrap();
    assert_eq!(
        csv.lines()
            .filter(|l| l.starts_with("specular,20,"))
            .count(),
        2
    );
}

/// What is plotted makes another sheet, of the same figures.
#[test]
fn plots_can_be_chosen() {
    let folder = Folder::new();
    let sheet = |options: &str| {
        let line = format!("lobe sky --material 3 -o lobe.png {options}");
        let text = folder.succeed(&line);
        (text, std::fs::read(folder.join("lobe.png")).unwrap())
    };
    let (text, plain) = sheet("");
    for options in ["--log", "--cosine"] {
        let (same, other) = sheet(options);
        assert_eq!(text, same);
        assert!(plain != other, "{options}");
    }
}

#[test]
fn what_cannot_be_looked_at_is_refused() {
    let folder = Folder::new();
    let refused = |line: &str, words: &str| {
        let stderr = folder.fail(&format!("lobe {line}"), 2);
        assert!(stderr.contains(words), "{line}: {stderr}");
    };
    refused("cornell", "--material with one of white, green, red, light");
    refused("cornell --material gren", "did you mean 'green'?");
    refused("cornell --material 9", "no such material; it has white");
    refused(
        "cornell --size 16x16 --pixel 16,3",
        "16 columns and 16 rows",
    );
    refused("sky --size 64x48 --pixel 0,0", "leaves the scene");
    refused(
        "cornell --material red -o a.exr",
        "a.exr: the sheet is a .png",
    );
    refused(
        "cornell --material red --angles 95",
        "use degrees from 0 to 89",
    );
    refused(
        "cornell --material red --angles 1,2,3,4,5",
        "at most 4 stand side by side",
    );
    refused("cornell --material red --log", "--output");
    refused("cornell --material red --csv no/where.csv", "no/where.csv");
    assert!(!folder.join("a.exr").exists());
}
