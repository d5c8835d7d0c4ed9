//! How a picture was made, as the header of its file says it.
//!
//! Each entry is an attribute `neumann.…` of the header, all of them texts but
//! for the counts, so that any viewer of OpenEXR files shows them.

use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::LayerAttributes;
use neumann_core::integrator::parameter_name;
use neumann_core::radiometry::Rgb;
use neumann_core::render::RenderSettings;
use neumann_core::scene::description::{
    CameraDescription, Crop, EnvironmentDescription, Projection,
};
use neumann_core::scene::{Appearance, Backs, Scene};

use super::IterationRanges;
use crate::state::State;

/// How a picture was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// Id of the integrator.
    pub integrator: String,
    /// Its parameters, name and value, in the order of its registry row.
    pub parameters: Vec<(String, String)>,
    /// The iterations that the picture is the mean of.
    pub iterations: IterationRanges,
    /// Time spent rendering, seconds; of all machines, where several took part.
    pub seconds: f64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Name of the scene.
    pub scene: String,
    /// Hash of the scene's content.
    pub content_hash: u64,
    /// Version of the program.
    pub program_version: String,
    /// Terms with `k` up to and including this one were computed.
    pub max_bounces: u32,
    /// The camera, by [`camera_text`].
    pub camera: String,
    /// The environment, by [`environment_text`].
    pub environment: String,
    /// Materials and lights, by [`appearance_text`]: they may have been edited since they were
    /// loaded.
    pub appearance: String,
    /// What the camera makes of backs; solid where the header says nothing.
    pub backs: Backs,
    /// Contributions refused because they were not finite or negative.
    pub n_refused: u64,
    /// All that had been chosen in the window, if it was saved there; says nothing about the film
    /// that the other entries do not.
    pub state: Option<Box<State>>,
}

impl Metadata {
    /// What is known before the first iteration.
    #[must_use]
    pub fn of(scene: &Scene, settings: &RenderSettings) -> Self {
        let value_text = |p: &neumann_core::integrator::Parameter| {
            let value = settings.values.value(p.name);
            p.format(value.unwrap_or_else(|| p.default_value()))
        };
        Self {
            integrator: settings.method.id.to_owned(),
            parameters: settings
                .method
                .parameters
                .iter()
                .map(|p| (p.name.to_owned(), value_text(p)))
                .collect(),
            seed: settings.seed,
            scene: scene.name().to_owned(),
            content_hash: scene.content_hash(),
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            max_bounces: settings.max_bounces,
            camera: camera_text(&settings.camera),
            environment: environment_text(scene.appearance().environment.as_deref()),
            appearance: appearance_text(scene.appearance()),
            backs: scene.appearance().backs,
            ..Self::default()
        }
    }

    /// The parameters as one text, `a=1 b=on`.
    #[must_use]
    pub fn parameters_text(&self) -> String {
        let texts: Vec<_> = self
            .parameters
            .iter()
            .map(|(name, value)| format!("{name}={value}"))
            .collect();
        texts.join(" ")
    }

    /// One line for people.
    #[must_use]
    pub fn summary(&self) -> String {
        let n = self.iterations.count();
        let iterations = if n == 1 { "iteration" } else { "iterations" };
        format!(
            "{} · {n} {iterations} · seed {}",
            self.integrator, self.seed
        )
    }

    pub(super) fn put(&self, attributes: &mut LayerAttributes) {
        let count = |n: u32| AttributeValue::I32(i32::try_from(n).unwrap_or(i32::MAX));
        let entries = [
            ("integrator", text(&self.integrator)),
            ("parameters", text(&self.parameters_text())),
            ("iterations", count(self.iterations.count())),
            ("firstIteration", count(self.iterations.first())),
            ("iterationRanges", text(&self.iterations.to_string())),
            ("seconds", AttributeValue::F64(self.seconds)),
            ("seed", text(&self.seed.to_string())),
            ("scene", text(&self.scene)),
            ("contentHash", text(&format!("{:016x}", self.content_hash))),
            ("version", text(&self.program_version)),
            ("maxBounces", count(self.max_bounces)),
            ("camera", text(&self.camera)),
            ("environment", text(&self.environment)),
            ("appearance", text(&self.appearance)),
            ("backs", text(self.backs.name())),
            ("refused", text(&self.n_refused.to_string())),
        ];
        for (name, value) in entries {
            let name = text_of(&format!("{PREFIX}{name}"));
            attributes.other.insert(name, value);
        }
        if let Some(state) = &self.state {
            let name = text_of(&format!("{PREFIX}state"));
            attributes.other.insert(name, text(&state.to_line()));
        }
        attributes.software_name = Some(text_of(&format!("neumann {}", self.program_version)));
    }

    /// Reads what [`Self::put`] wrote; the name of what is missing or odd otherwise.
    pub(super) fn take(attributes: &LayerAttributes) -> Result<Self, &'static str> {
        let value = |name: &'static str| {
            let name_text = text_of(&format!("{PREFIX}{name}"));
            attributes.other.get(&name_text).ok_or(name)
        };
        let string = |name| match value(name)? {
            AttributeValue::Text(t) => Ok(String::from_utf8_lossy(t.as_slice()).into_owned()),
            _ => Err(name),
        };
        let count = |name| match value(name)? {
            AttributeValue::I32(n) => u32::try_from(*n).map_err(|_| name),
            _ => Err(name),
        };
        let number = |name| string(name)?.parse::<u64>().map_err(|_| name);
        let seconds = match value("seconds")? {
            AttributeValue::F64(s) if s.is_finite() && *s >= 0.0 => *s,
            _ => return Err("seconds"),
        };
        let parameters = string("parameters")?
            .split_whitespace()
            .map(|pair| {
                let (name, value) = pair.split_once('=').ok_or("parameters")?;
                Ok((parameter_name(name), value.to_owned()))
            })
            .collect::<Result<_, &'static str>>()?;
        let iterations: IterationRanges = string("iterationRanges")?
            .parse()
            .map_err(|_| "iterationRanges")?;
        // Three entries say the same, the counts as far as they can.
        let is_count = |name: &'static str, n: u32| -> Result<bool, &'static str> {
            Ok(count(name)? == n.min(i32::MAX as u32))
        };
        if !is_count("iterations", iterations.count())? {
            return Err("iterations");
        }
        if !is_count("firstIteration", iterations.first())? {
            return Err("firstIteration");
        }
        Ok(Self {
            integrator: string("integrator")?,
            parameters,
            iterations,
            seconds,
            seed: number("seed")?,
            scene: string("scene")?,
            content_hash: u64::from_str_radix(&string("contentHash")?, 16)
                .map_err(|_| "contentHash")?,
            program_version: string("version")?,
            max_bounces: count("maxBounces")?,
            camera: string("camera")?,
            environment: string("environment")?,
            appearance: string("appearance")?,
            backs: match value("backs") {
                Ok(_) => Backs::named(&string("backs")?).ok_or("backs")?,
                Err(_) => Backs::Solid,
            },
            n_refused: number("refused")?,
            // One of a later version may not be understood; the film is as good without it.
            state: string("state")
                .ok()
                .and_then(|text| State::parse(&text).ok())
                .map(|(state, _)| Box::new(state)),
        })
    }
}

/// What the names of our attributes begin with.
pub(super) const PREFIX: &str = "neumann.";

/// A text attribute; UTF-8, as other programs take it to be.
pub(super) fn text(s: &str) -> AttributeValue {
    AttributeValue::Text(text_of(s))
}

pub(super) fn text_of(s: &str) -> Text {
    Text::from_slice_unchecked(s.as_bytes())
}

/// A camera as a text that is the same if and only if the rays are.
#[must_use]
pub fn camera_text(camera: &CameraDescription) -> String {
    let columns = camera.world_from_camera.to_cols_array();
    let matrix: Vec<_> = columns.iter().map(f32::to_string).collect();
    let projection = match camera.projection {
        Projection::Perspective { yfov } => format!("perspective {yfov}"),
        Projection::Orthographic { ymag } => format!("orthographic {ymag}"),
    };
    let lens = camera.lens.map_or_else(
        || "pinhole".to_owned(),
        |lens| format!("lens {} {}", lens.aperture, lens.focus_distance),
    );
    let crop = camera.crop.map(|Crop { of, at, size }| {
        let [of, at, size] = [of, at, size].map(|[x, y]| format!("{x} {y}"));
        format!("; region {at} {size} of {of}")
    });
    let crop = crop.unwrap_or_default();
    format!("{projection}; {lens}; {}{crop}", matrix.join(" "))
}

/// An environment as a text that differs where its light does.
#[must_use]
pub fn environment_text(environment: Option<&EnvironmentDescription>) -> String {
    let Some(e) = environment else {
        return "none".to_owned();
    };
    let texels = e.texels.iter().flat_map(Rgb::to_array);
    let sun = e.sun.into_iter().flat_map(|sun| {
        let (direction, radiance) = (sun.direction.to_array(), sun.radiance.to_array());
        direction
            .into_iter()
            .chain([sun.angular_radius])
            .chain(radiance)
    });
    let hash = fnv1a(texels.chain(sun).map(f32::to_bits));
    format!(
        "{} {}x{} {hash:016x}; intensity {}; rotation {}",
        e.name, e.width, e.height, e.intensity, e.rotation
    )
}

/// Materials, punctual lights and levels of lights as a text that differs where they do.
#[must_use]
pub fn appearance_text(appearance: &Appearance) -> String {
    let mut text = format!(
        "{:?} {:?} {:?} {:?} {:?}",
        appearance.materials,
        appearance.lights,
        appearance.material_levels,
        appearance.light_levels,
        appearance.environment_level
    );
    // Files that are older than this colour have none.
    if appearance.environment_tint != Rgb::WHITE {
        text += &format!(" {:?}", appearance.environment_tint);
    }
    format!("{:016x}", fnv1a(text.bytes().map(u32::from)))
}

/// FNV-1a, a word at a time.
pub(super) fn fnv1a(words: impl Iterator<Item = u32>) -> u64 {
    words.fold(0xcbf2_9ce4_8422_2325, |hash, word| {
        (hash ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
