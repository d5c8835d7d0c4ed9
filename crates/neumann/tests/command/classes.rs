//! Layers of light path expressions, and of lights.

use neumann_core::radiometry::Rgb;
use neumann_picture::exr_file::read_layers;

use super::Folder;

const SCENE: &str = "lamps --size 24x18 --iterations 3 --integrator bdpt";

fn assert_same(found: &[Rgb], expected: &[Rgb], what: &str) {
    for (found, expected) in found.iter().zip(expected) {
        let apart = (*found - *expected).map(f32::abs).max_channel();
        let bound = 1e-5 * expected.max_channel();
        assert!(apart <= bound, "{what}: {found:?} for {expected:?}");
    }
}

/// Spaces mean nothing in an expression.
const EXPRESSIONS: &str = "--expression rough=L[^S]*E --expression L.*S.*E";

#[test]
fn layers_are_written_by_name_and_add_up() {
    let folder = Folder::new();
    folder.succeed(&format!(
        "render {SCENE} -o l.exr {EXPRESSIONS} --lights each --mix others=0"
    ));
    let image = read_layers(&folder.join("l.exr")).unwrap();
    let sum = |names: &[String]| {
        let mut sum = vec![Rgb::BLACK; image.pixels.len()];
        for layer in names.iter().map(|name| &image.layers[name]) {
            sum.iter_mut()
                .zip(layer)
                .for_each(|(sum, value)| *sum += *value);
        }
        sum
    };
    let expressions = ["rough", "L.*S.*E"].map(|name| format!("expression.{name}"));
    assert_same(&sum(&expressions), &image.pixels, "expressions");
    let bulbs = ["torchiere bulb", "sconce bulb", "table lamp bulb"];
    let lights = bulbs.map(|name| format!("light.{name}"));
    assert_same(&sum(&lights), &image.pixels, "lights");
    let terms = lights.map(|light| format!("{light}.T2"));
    assert_same(&sum(&terms), &image.layers["T2"], "T2");
    assert_same(
        &image.layers["mix"],
        &image.pixels,
        "no light is in no group",
    );
}

/// Half of all light is a stop less of exposure.
#[test]
fn light_is_mixed_in_what_is_shown() {
    let folder = Folder::new();
    let options = "render caustic --size 24x18 --iterations 2";
    folder.succeed(&format!(
        "{options} -o a.png -o a.exr --lights key=lamp --mix key=0.5"
    ));
    folder.succeed(&format!("{options} -o b.png --exposure -1"));
    let [a, b] = ["a.png", "b.png"].map(|name| std::fs::read(folder.join(name)).unwrap());
    assert!(a == b, "the same picture");
    let image = read_layers(&folder.join("a.exr")).unwrap();
    let half: Vec<Rgb> = image.pixels.iter().map(|value| *value * 0.5).collect();
    assert_same(&image.layers["mix"], &half, "mix");
}

#[test]
fn a_series_has_them_as_pictures() {
    let folder = Folder::new();
    folder.succeed(&format!(
        "series caustic -o out --size 24x18 --iterations 2 --lights each --expression caustics {}",
        "--expression a=L.E --expression L.E"
    ));
    for name in [
        "expression-caustics",
        "expression-a",
        "expression-L-E",
        "light-lamp",
    ] {
        for extension in ["png", "exr"] {
            let path = folder.join("out").join(format!("{name}.{extension}"));
            assert!(path.is_file(), "{}", path.display());
        }
    }
}

#[test]
fn what_cannot_be_kept_is_refused() {
    let folder = Folder::new();
    let many = "--expression L.E ".repeat(33);
    for (options, said) in [
        (
            "--expression LXE",
            "--expression \"LXE\", character 2: 'X' is no bounce",
        ),
        (
            "--expression L.E --expression L.E",
            "two layers are called 'L.E'",
        ),
        (many.as_str(), "33 light path expressions are more layers"),
        (
            "--lights sun=lamp",
            "no light of the scene is called 'lamp'; its lights are",
        ),
        ("--lights lamp", "'lamp' is no light group"),
        (
            "--lights each --mix lamp=1",
            "'lamp' is no group of lights; there are",
        ),
        ("--lights each --mix light=-1", "use LIGHT=FACTOR"),
    ] {
        let stderr = folder.fail(&format!("render cornell -o c.exr {options}"), 2);
        assert!(stderr.contains(said), "{stderr}");
    }
    folder.succeed("render cornell -o c.exr --size 8x8 --iterations 1");
    let line = "render cornell -o c.exr --size 8x8 --iterations 2 --resume --expression L.E";
    assert!(folder.fail(line, 2).contains("cannot be gone on with"));
    folder.succeed("render cornell -o e.exr --size 8x8 --iterations 1 --expression L.E");
    let line = "render cornell -o e.exr --size 8x8 --iterations 2 --resume";
    assert!(folder.fail(line, 2).contains("would be lost"));
    assert!(folder.succeed("list expressions").contains("caustics"));
    assert!(
        folder
            .succeed("info cornell")
            .contains("light names   light\n")
    );
}
