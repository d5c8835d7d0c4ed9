//! Skies that come with the program, each a lat-long map by a formula.
//!
//! | name | what it is |
//! |---|---|
//! | `studio` | soft boxes over a grey ground: what lights a file that has no light of its own |
//! | `uniform` | radiance 1 from everywhere |
//! | `sun` | sun and clear sky over a grey ground |
//!
//! All are scaled alike: of all unoccluded surfaces of albedo 1, the one turned
//! towards the most light has radiance 1. So exposure 0 suits each of them.

mod daylight;
mod studio;

use std::f32::consts::{PI, TAU};
use std::path::PathBuf;

use glam::Vec3;

use super::description::{DefaultSky, EnvironmentDescription, SceneDescription};
use super::load::{LoadError, load_environment};
use crate::radiometry::Rgb;

/// A sky that comes with the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sky {
    /// Soft boxes over a grey ground.
    Studio,
    /// Radiance 1 from everywhere.
    Uniform,
    /// Sun and clear sky.
    Sun,
}

/// Size of the maps, texels.
const WIDTH: usize = 512;
const HEIGHT: usize = 256;

impl Sky {
    /// All of them, in the order of menus.
    pub const ALL: [Self; 3] = [Self::Studio, Self::Uniform, Self::Sun];

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Studio => "studio",
            Self::Uniform => "uniform",
            Self::Sun => "sun",
        }
    }

    /// What it is, in a few words.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self {
            Self::Studio => "soft boxes over a grey ground",
            Self::Uniform => "radiance 1 from everywhere",
            Self::Sun => "afternoon sun and clear sky",
        }
    }

    /// The sky of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|sky| sky.name() == name)
    }

    /// Its map.
    #[must_use]
    pub fn description(self) -> EnvironmentDescription {
        match self {
            Self::Studio => map(self, |direction| Rgb::splat(studio::radiance(direction))),
            Self::Uniform => EnvironmentDescription::uniform(Rgb::WHITE),
            Self::Sun => {
                let daylight = daylight::Daylight::new();
                EnvironmentDescription {
                    sun: Some(daylight.sun()),
                    ..map(self, |direction| daylight.radiance(direction))
                }
            }
        }
    }
}

/// A sky that somebody asks for in place of the scene's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SkyChoice {
    /// No sky at all, and none by default either.
    None,
    /// One that comes with the program.
    Builtin(Sky),
    /// A lat-long map.
    File(PathBuf),
}

impl SkyChoice {
    /// What a word stands for: `none`, the name of a [`Sky`], or else the path of a map. A map of
    /// such
    /// a name is reached by `./studio`.
    #[must_use]
    pub fn from_word(word: &str) -> Self {
        match Sky::named(word) {
            Some(sky) => Self::Builtin(sky),
            None if word == "none" => Self::None,
            None => Self::File(PathBuf::from(word)),
        }
    }

    /// The file that it is read from, if any.
    #[must_use]
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::File(path) => Some(path),
            Self::None | Self::Builtin(_) => None,
        }
    }

    /// Puts it in place of the scene's sky; what is odd about a map is told with the scene's
    /// warnings.
    ///
    /// # Errors
    /// When the map cannot be read.
    pub fn apply(&self, scene: &mut SceneDescription) -> Result<(), LoadError> {
        scene.environment = match self {
            Self::None => None,
            Self::Builtin(sky) => Some(sky.description()),
            Self::File(path) => {
                let file = load_environment(path)?;
                scene.report.warnings.extend(file.warnings);
                Some(file.environment)
            }
        };
        scene.default_sky = DefaultSky::Never;
        Ok(())
    }
}

/// A map of the radiance from the direction of each texel's centre.
fn map(sky: Sky, radiance: impl Fn(Vec3) -> Rgb) -> EnvironmentDescription {
    let texels = (0..HEIGHT)
        .flat_map(|y| {
            let (sin_theta, cos_theta) = (PI * (y as f32 + 0.5) / HEIGHT as f32).sin_cos();
            (0..WIDTH).map(move |x| {
                let phi = TAU * ((x as f32 + 0.5) / WIDTH as f32 - 0.5);
                Vec3::new(sin_theta * phi.sin(), cos_theta, -sin_theta * phi.cos())
            })
        })
        .map(radiance)
        .collect();
    EnvironmentDescription {
        name: sky.name().to_owned(),
        width: WIDTH,
        height: HEIGHT,
        texels,
        intensity: 1.0,
        rotation: 0.0,
        sun: None,
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{PI, TAU};
    use std::sync::Arc;

    use glam::Vec3;

    use super::{Sky, SkyChoice};
    use crate::endpoint::light::EnvironmentLight;

    /// Radiance of a white surface under a sky: `1/π ∫ L cos dω`, summed over a grid.
    fn of_white_surface(light: &EnvironmentLight, sky: Sky, normal: Vec3) -> f32 {
        let (rows, columns) = (128, 256);
        let mut sum = 0.0;
        for row in 0..rows {
            let theta = PI * (row as f32 + 0.5) / rows as f32;
            let texel = theta.sin() * (PI / rows as f32) * (TAU / columns as f32);
            for column in 0..columns {
                let phi = TAU * (column as f32 + 0.5) / columns as f32;
                let d = Vec3::new(
                    theta.sin() * phi.sin(),
                    theta.cos(),
                    -theta.sin() * phi.cos(),
                );
                // The sun is smaller than the cells and has a term of its own.
                let is_sun = light.is_in_sun(d);
                if !is_sun {
                    sum += light.radiance(d).luminance() * normal.dot(d).max(0.0) * texel;
                }
            }
        }
        if let Some(sun) = sky.description().sun {
            let solid_angle = 4.0 * PI * (0.5 * sun.angular_radius).sin().powi(2);
            sum += sun.radiance.luminance() * solid_angle * normal.dot(sun.direction).max(0.0);
        }
        sum / PI
    }

    #[test]
    fn the_brightest_white_surface_has_radiance_one() {
        for sky in Sky::ALL {
            let light = EnvironmentLight::new(&Arc::new(sky.description()), 1.0).unwrap();
            let mut brightest: f32 = 0.0;
            for row in 0..=12 {
                for column in 0..24 {
                    let (theta, phi) = (PI * row as f32 / 12.0, TAU * column as f32 / 24.0);
                    let normal = Vec3::new(
                        theta.sin() * phi.sin(),
                        theta.cos(),
                        theta.sin() * phi.cos(),
                    );
                    brightest = brightest.max(of_white_surface(&light, sky, normal));
                }
            }
            assert!((brightest - 1.0).abs() < 0.02, "{sky:?}: {brightest}");
        }
    }

    #[test]
    fn white_objects_stand_out_from_the_studio() {
        let light = EnvironmentLight::new(&Arc::new(Sky::Studio.description()), 1.0).unwrap();
        let mut range = [f32::INFINITY, 0.0f32];
        // What a camera sees that looks down on an object: the ground behind it.
        for column in 0..32 {
            let phi = TAU * column as f32 / 32.0;
            for depth in [0.05, 0.2, 0.5, 0.9] {
                let d = Vec3::new(phi.sin(), -depth, phi.cos()).normalize();
                let ground = light.radiance(d).luminance();
                range = [range[0].min(ground), range[1].max(ground)];
            }
        }
        assert!(range[0] > 0.1 && range[1] < 0.25, "{range:?}");
        let towards_camera = of_white_surface(&light, Sky::Studio, Vec3::Z);
        assert!(towards_camera > 2.5 * range[1], "{towards_camera}");
        let left = of_white_surface(&light, Sky::Studio, Vec3::NEG_X);
        let right = of_white_surface(&light, Sky::Studio, Vec3::X);
        assert!(left > 1.2 * right, "sides differ: {left} {right}");
    }

    #[test]
    fn names_are_found() {
        for sky in Sky::ALL {
            assert_eq!(Sky::named(sky.name()), Some(sky));
            assert_eq!(sky.description().name, sky.name());
        }
        assert_eq!(Sky::named("./sun"), None);
        assert_eq!(SkyChoice::from_word("sun"), SkyChoice::Builtin(Sky::Sun));
        assert_eq!(SkyChoice::from_word("none"), SkyChoice::None);
        let file = SkyChoice::File("./sun".into());
        assert_eq!(SkyChoice::from_word("./sun"), file);
    }
}
