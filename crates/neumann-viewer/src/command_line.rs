//! The command that renders what the window shows, without a window.

use std::fmt::Display;

use glam::Vec3;
use neumann_core::render::StopRule;
use neumann_core::scene::description::{CameraDescription, Crop, Projection};
use neumann_core::scene::{Appearance, Backs, SkyChoice};

use crate::display::ViewSettings;
use crate::session::Session;
use crate::setup::{OpenScene, Setup};

/// A command line, for a shell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CommandLine {
    /// Its text.
    pub text: String,
    /// What of the window it has no words for.
    pub leaves_out: Vec<&'static str>,
}

/// The command for what is rendered now; `None` while there is no scene.
///
/// Numbers have all their digits; angles are as exact as degrees in single precision. It ends
/// where the window does, or else after as many iterations as are there.
#[must_use]
pub fn of(session: &Session, settings: &ViewSettings) -> Option<CommandLine> {
    let setup = &session.setup;
    let open = setup.open.as_ref()?;
    let render = setup.settings()?;
    let mut words = Words(vec!["neumann".to_owned(), "render".to_owned()]);
    words.word(&open.source);
    words.option("--integrator", render.method.id);
    for parameter in render.method.parameters {
        let value = render.values.value(parameter.name);
        if let Some(value) = value.filter(|value| *value != parameter.default_value()) {
            let text = format!("{}={}", parameter.name, parameter.format(value));
            words.option("--set", text);
        }
    }
    let region = render.camera.crop;
    let [width, height] = region.map_or([render.width, render.height], |region| region.of);
    words.option("--size", format!("{width}x{height}"));
    if let Some(Crop { at, size, .. }) = region {
        let region = [at[0], at[1], size[0], size[1]].map(|n| n.to_string());
        words.option("--region", region.join(","));
    }
    words.option("--max-bounces", render.max_bounces);
    words.option("--layers", render.n_layers);
    words.option("--seed", render.seed);
    camera(&mut words, setup, open);
    environment(&mut words, setup, open);
    match setup.stop {
        StopRule::Seconds(seconds) => words.option("--time", seconds),
        StopRule::Iterations(n) => words.option("--iterations", n),
        StopRule::Never => {
            words.option("--iterations", session.picture.stats.n_iterations.max(1));
        }
    }
    words.option("--exposure", settings.exposure_ev);
    words.option("--tone", settings.tone.name());
    let name = format!("{}-{}", open.short_name(), render.method.id);
    for extension in ["exr", "png"] {
        words.option("-o", format!("{name}.{extension}"));
    }
    let mut leaves_out = Vec::new();
    if is_edited(open) {
        leaves_out.push("edits of materials and lights");
    }
    if open.scene.appearance().environment_tint != open.original.environment_tint {
        leaves_out.push("the colour of the environment");
    }
    if is_other_width(setup, open) {
        leaves_out.push("the width of an orthographic view");
    }
    Some(CommandLine {
        text: words.0.join(" "),
        leaves_out,
    })
}

/// True if an orthographic camera shows more or less than in the file.
fn is_other_width(setup: &Setup, open: &OpenScene) -> bool {
    let now = setup
        .camera
        .as_ref()
        .map(|control| control.camera().projection);
    let of_file = open.scene.cameras().get(open.camera);
    matches!(now, Some(Projection::Orthographic { .. }))
        && now != of_file.map(|camera| camera.projection)
}

/// The camera of the file, and how it has been moved.
fn camera(words: &mut Words, setup: &Setup, open: &OpenScene) {
    let Some(control) = &setup.camera else { return };
    let camera = control.camera();
    words.option("--camera", open.camera);
    let of_file = open.scene.cameras().get(open.camera);
    let is_as_in_file = |same: fn(&CameraDescription) -> _| {
        of_file.is_some_and(|of_file| same(of_file) == same(camera))
    };
    if !is_as_in_file(|c| c.world_from_camera.to_cols_array().map(f32::to_bits)) {
        let places = [
            ("--eye", control.eye()),
            ("--target", control.target()),
            ("--up", control.up()),
        ];
        for (name, place) in places {
            words.option(name, triple(place));
        }
    }
    if let Projection::Perspective { yfov } = camera.projection
        && of_file.is_none_or(|of_file| of_file.projection != camera.projection)
    {
        words.option("--fov", degrees(yfov));
    }
    if of_file.is_none_or(|of_file| of_file.lens != camera.lens) {
        let lens = control.lens();
        words.option("--aperture", lens.aperture);
        if lens.aperture > 0.0 {
            words.option("--focus", lens.focus_distance);
        }
    }
}

/// The sky, its level and its turn, and what the camera makes of backs.
fn environment(words: &mut Words, setup: &Setup, open: &OpenScene) {
    let appearance = open.scene.appearance();
    let level = appearance.environment_level;
    match &setup.sky {
        _ if !level.is_on => words.option("--env", "none"),
        Some(SkyChoice::None) => words.option("--env", "none"),
        Some(SkyChoice::Builtin(sky)) => words.option("--env", sky.name()),
        Some(SkyChoice::File(path)) => words.option("--env", path.display()),
        None => {}
    }
    if level.is_on && level.brightness.to_bits() != 1f32.to_bits() {
        words.option("--env-intensity", level.brightness);
    }
    let turn = |appearance: &Appearance| appearance.environment.as_ref().map(|map| map.rotation);
    // What the command makes of the sky without being told.
    let usual = match &setup.sky {
        None => turn(&open.original).unwrap_or(0.0),
        Some(_) => 0.0,
    };
    let turned = turn(appearance).filter(|rotation| level.is_on && *rotation != usual);
    if let Some(rotation) = turned {
        words.option("--env-rotation", degrees(rotation));
    }
    if appearance.backs != Backs::default() {
        words.option("--backs", appearance.backs.name());
    }
}

/// True if materials or lights are other than in the file.
fn is_edited(open: &OpenScene) -> bool {
    let (now, was) = (open.scene.appearance(), &open.original);
    now.materials != was.materials
        || now.material_levels != was.material_levels
        || now.light_levels != was.light_levels
        || now.lights != was.lights
}

/// Degrees that are that many radians when they are read again, or as near as can be.
fn degrees(radians: f32) -> f32 {
    let near = radians.to_degrees();
    let around = [near.next_down(), near, near.next_up()];
    let exact = around.into_iter().find(|d| d.to_radians() == radians);
    exact.unwrap_or(near)
}

fn triple(v: Vec3) -> String {
    format!("{},{},{}", v.x, v.y, v.z)
}

/// The words of a command line.
struct Words(Vec<String>);

impl Words {
    /// An option with its value; a value that begins with a hyphen stays with its option.
    fn option(&mut self, name: &str, value: impl Display) {
        let value = quoted(&value.to_string());
        if value.starts_with('-') && name.starts_with("--") {
            self.0.push(format!("{name}={value}"));
        } else {
            self.0.push(name.to_owned());
            self.0.push(value);
        }
    }

    fn word(&mut self, word: &str) {
        self.0.push(quoted(word));
    }
}

/// A word as a shell takes it, in quotes where it has characters with a meaning of their own.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./:,=+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::{Words, degrees, quoted};

    #[test]
    fn shells_take_words_as_they_are() {
        assert_eq!(quoted("a/b-1.gltf"), "a/b-1.gltf");
        assert_eq!(quoted("my room.glb"), "'my room.glb'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        let mut words = Words(Vec::new());
        words.option("--eye", "-1,2,3");
        words.option("--seed", 4);
        assert_eq!(words.0, ["--eye=-1,2,3", "--seed", "4"]);
    }

    #[test]
    fn angles_are_as_near_as_can_be() {
        let angles: Vec<f32> = (1..2000).map(|i| i as f32 * 1e-3).collect();
        let again = |radians: f32| degrees(radians).to_radians();
        for &radians in &angles {
            let apart = (again(radians) - radians).abs() / radians;
            assert!(apart <= f32::EPSILON, "{radians}: {apart}");
        }
        let n_same = angles.iter().filter(|r| again(**r) == **r).count();
        assert!(n_same > angles.len() / 2, "{n_same}");
    }
}
