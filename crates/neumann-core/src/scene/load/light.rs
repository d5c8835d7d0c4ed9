//! Punctual lights (`KHR_lights_punctual`).
//!
//! Numbers are taken as they stand: a unit of intensity in the file is a unit
//! of radiant intensity here. `range` is a hint for rasterisers and ignored.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::Mat4;

use super::error::{Fault, quoted};
use super::factor::{Factors, LARGEST};
use super::json::{Document, Item};
use super::notes::Notes;
use crate::radiometry::Rgb;
use crate::scene::description::{LightDescription, LightKind};

const EXTENSION: &str = "KHR_lights_punctual";

/// Far above the sun, which has about 3e25 W/sr; the power of many such lights is still finite.
const LARGEST_INTENSITY: f32 = 1e30;
/// As far above the sun's 1361 W/m²; its power over the largest scene is still finite.
const LARGEST_IRRADIANCE: f32 = 1e18;

/// The light that a node carries, if any.
pub(super) fn read(
    document: &Document,
    node: &Item<'_>,
    world_from_node: Mat4,
    notes: &mut Notes,
) -> Result<Option<LightDescription>, Fault> {
    let Some(carried) = node.extension(EXTENSION)? else {
        return Ok(None);
    };
    let Some(index) = carried.index("light")? else {
        return Ok(None);
    };
    let light = match document.root().extension(EXTENSION)? {
        Some(lights) => lights.list_item("lights", index)?,
        None => None,
    };
    let Some(light) = light else {
        return Err(Fault::broken(
            carried.path("light"),
            format!("refers to lights[{index}], which is not there"),
        ));
    };
    let name = node
        .name()
        .or(light.name())
        .map_or_else(|| format!("light {index}"), str::to_owned);
    let mut factors = Factors::of("light", &name, notes);
    let kind = match light.text("type")? {
        Some("point") => LightKind::Point {
            intensity: strength(&light, &mut factors, LARGEST_INTENSITY)?,
        },
        Some("directional") => LightKind::Directional {
            irradiance: strength(&light, &mut factors, LARGEST_IRRADIANCE)?,
        },
        Some("spot") => spot(&light, &mut factors)?,
        other => {
            notes.warn(format!(
                "light {}: its type is {}, which is unknown; it is left out",
                quoted(&name),
                quoted(other.unwrap_or(""))
            ));
            return Ok(None);
        }
    };
    if light.has("range") {
        notes.warn(format!(
            "light {}: its range is ignored, light reaches everywhere",
            quoted(&name)
        ));
    }
    Ok(Some(LightDescription {
        name,
        world_from_light: world_from_node,
        kind,
    }))
}

/// Colour times intensity, neither above `largest`.
fn strength(light: &Item<'_>, factors: &mut Factors<'_>, largest: f32) -> Result<Rgb, Fault> {
    let color = factors.color(light, "color", Rgb::WHITE, &(0.0..=LARGEST))?;
    let intensity = factors.number(light, "intensity", 1.0, 0.0..=largest)?;
    let strength = color * intensity;
    if strength.to_array().iter().any(|x| *x > largest) {
        factors.notes.warn(format!(
            "{}: its color times its intensity is beyond {largest:e}, which is used",
            factors.owner
        ));
    }
    Ok(strength.map(|x| x.min(largest)))
}

fn spot(light: &Item<'_>, factors: &mut Factors<'_>) -> Result<LightKind, Fault> {
    let intensity = strength(light, factors, LARGEST_INTENSITY)?;
    let (mut inner_cone, mut outer_cone) = (0.0, FRAC_PI_4);
    if let Some(spot) = light.child("spot")? {
        inner_cone = factors.number(&spot, "innerConeAngle", inner_cone, 0.0..=FRAC_PI_2)?;
        outer_cone = factors.number(&spot, "outerConeAngle", outer_cone, 0.0..=FRAC_PI_2)?;
    }
    if outer_cone == 0.0 {
        factors.notes.warn(format!(
            "{}: its outer cone has no width, so that it gives no light",
            factors.owner
        ));
    }
    if inner_cone > outer_cone {
        factors.notes.warn(format!(
            "{}: its inner cone is wider than the outer one, which is used for both",
            factors.owner
        ));
        inner_cone = outer_cone;
    }
    Ok(LightKind::Spot {
        intensity,
        inner_cone,
        outer_cone,
    })
}
