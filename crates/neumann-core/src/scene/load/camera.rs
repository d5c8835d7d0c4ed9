//! Cameras, and their lens in `extras.neumann.lens`.

use std::f32::consts::PI;

use glam::Mat4;

use super::error::{Fault, quoted};
use super::json::{Document, Item};
use super::notes::Notes;
use crate::scene::description::{CAMERA_LENGTHS, CameraDescription, Lens, Projection, short};

/// The camera that a node carries, if any; one that cannot see is left out.
pub(super) fn read(
    document: &Document,
    node: &Item<'_>,
    world_from_node: Mat4,
    notes: &mut Notes,
) -> Result<Option<CameraDescription>, Fault> {
    let Some(index) = document.reference(node, "camera", "cameras")? else {
        return Ok(None);
    };
    let camera = document.item("cameras", index)?;
    let name = node
        .name()
        .or(camera.name())
        .map_or_else(|| format!("camera {index}"), str::to_owned);
    let mut left_out = |why: String| {
        notes.warn(format!("camera {}: {why}; it is left out", quoted(&name)));
        Ok(None)
    };
    if !world_from_node.is_finite() {
        return left_out("its transform is not finite".to_owned());
    }
    let kind = camera.text("type")?.unwrap_or("");
    let Some(lengths) = camera.child(kind)? else {
        return left_out(format!("{} says nothing of its projection", camera.at()));
    };
    let (projection, aspect_ratio) = match kind {
        "perspective" => {
            let yfov = lengths.number("yfov")?.unwrap_or(0.0);
            if !(yfov > 0.0 && yfov < PI) {
                return left_out(format!(
                    "{} is {yfov}, not between 0 and π",
                    lengths.path("yfov")
                ));
            }
            let aspect_ratio = lengths.number("aspectRatio")?;
            (Projection::Perspective { yfov }, aspect_ratio)
        }
        "orthographic" => {
            let xmag = lengths.number("xmag")?.unwrap_or(0.0).abs();
            let ymag = lengths.number("ymag")?.unwrap_or(0.0).abs();
            if !CAMERA_LENGTHS.contains(&ymag) {
                return left_out(format!(
                    "{} is {}, not between 1e-12 and 1e12",
                    lengths.path("ymag"),
                    short(ymag)
                ));
            }
            (Projection::Orthographic { ymag }, Some(xmag / ymag))
        }
        _ => return left_out(format!("its type is {}", quoted(kind))),
    };
    Ok(Some(CameraDescription {
        world_from_camera: world_from_node,
        aspect_ratio: aspect_ratio.filter(|&ratio| is_length(ratio)),
        projection,
        lens: lens(&camera, &name, notes)?,
        name,
        crop: None,
    }))
}

/// `{"aperture": metres, "focusDistance": metres}`; both are needed.
fn lens(camera: &Item<'_>, name: &str, notes: &mut Notes) -> Result<Option<Lens>, Fault> {
    let neumann = camera
        .child_if_object("extras")
        .and_then(|extras| extras.child_if_object("neumann"));
    let Some(lens) = neumann.and_then(|neumann| neumann.child_if_object("lens")) else {
        return Ok(None);
    };
    let at = lens.at();
    let aperture = lens.number("aperture")?.unwrap_or(0.0);
    let focus_distance = lens.number("focusDistance")?.unwrap_or(0.0);
    if aperture == 0.0 {
        return Ok(None); // A pinhole.
    }
    if !(is_length(aperture) && is_length(focus_distance)) {
        notes.warn(format!(
            "camera {}: {} needs an aperture and a focusDistance above 0; it stays a pinhole",
            quoted(name),
            at
        ));
        return Ok(None);
    }
    let lens = Lens {
        aperture,
        focus_distance,
    };
    if let Some(fault) = lens.fault() {
        notes.warn(format!(
            "camera {}: {at}: {fault}; it stays a pinhole",
            quoted(name)
        ));
        return Ok(None);
    }
    Ok(Some(lens))
}

fn is_length(length: f32) -> bool {
    length.is_finite() && length > 0.0
}
