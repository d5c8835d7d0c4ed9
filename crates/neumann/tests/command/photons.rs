//! `neumann render --photons`: photons as points, with a legend.

use std::fs;

use neumann_picture::image_file::read_image;

use super::Folder;

/// How many pixels of a PNG have a colour.
fn n_coloured(folder: &Folder, name: &str) -> usize {
    let image = read_image(&folder.join(name)).unwrap();
    let is_coloured =
        |c: &neumann_core::radiometry::Rgb| c.max_channel() > 1.5 * c.r.min(c.g).min(c.b) + 0.01;
    image.pixels.iter().filter(|c| is_coloured(c)).count()
}

#[test]
fn photons_are_drawn_beside_their_legend() {
    let folder = Folder::new();
    let options = "render cornell --size 64x48 --integrator";
    for (id, by) in [("pm", "bounce"), ("ppm", "power")] {
        let name = format!("{id}.png");
        let line = format!("{options} {id} --photons {name} --photons-by {by} --json");
        let report = folder.succeed(&line);
        let report: serde_json::Value = serde_json::from_str(&report).unwrap();
        assert_eq!(report["iterations"], 1, "all that photons need");
        assert_eq!(report["outputs"], serde_json::json!([name]));
        let image = read_image(&folder.join(&name)).unwrap();
        assert!(
            image.width > 64 + 200 && image.height > 48,
            "a legend stands beside it"
        );
        assert!(n_coloured(&folder, &name) > 64 * 48 / 10, "{id}");
    }
    // The picture that is rendered beside them has nothing of them.
    folder.succeed(&format!(
        "{options} pm --iterations 2 -o with.exr --photons a.png"
    ));
    folder.succeed(&format!("{options} pm --iterations 2 -o without.exr"));
    let (with, without) = (folder.film("with.exr"), folder.film("without.exr"));
    assert_eq!(with.film.layers(), without.film.layers());
    // The photons of the iteration that was the last one, also when nothing is left to do.
    let line = format!("{options} ppm --iterations 2 -o c.exr --resume --photons");
    folder.succeed(&format!("{line} first.png"));
    folder.succeed(&format!("{line} again.png"));
    let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
    assert_eq!(bytes("first.png"), bytes("again.png"));
    folder.succeed(&format!("{options} ppm --photons other.png"));
    assert_ne!(bytes("first.png"), bytes("other.png"));
}

#[test]
fn methods_without_photons_and_other_files_are_refused() {
    let folder = Folder::new();
    for (line, expected) in [
        (
            "render cornell --photons a.png",
            "--photons: 'pt-mis' has no photons; use --integrator pm or ppm",
        ),
        ("render cornell --integrator pm --photons a.exr", ".png"),
        ("render cornell --integrator pm --photons a.jpg", "a.jpg"),
        (
            "render cornell --integrator pm --photons no/a.png",
            "does not exist",
        ),
        (
            "render cornell --integrator pm -o a.png --photons ./a.png",
            "twice",
        ),
        (
            "render cornell --integrator pm -o a.png --photons-by power",
            "--photons",
        ),
        (
            "render cornell --integrator pm --photons a.png --photons-by radius",
            "bounce",
        ),
        (
            "render cornell --integrator pm -o a.png --set show=power",
            "show",
        ),
    ] {
        let stderr = folder.fail(line, 2);
        assert!(stderr.contains(expected), "neumann {line}: {stderr}");
        assert!(folder.names().is_empty(), "neumann {line}");
    }
}
