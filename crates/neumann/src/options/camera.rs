//! Which camera, and what about it is different.

use glam::Vec3;
use neumann_core::film::Features;
use neumann_core::scene::Scene;
use neumann_core::scene::description::{CAMERA_LENGTHS, CameraDescription, Lens, Projection};

use super::CameraArguments;
use crate::failure::{Outcome, bad_input};

/// The camera asked for.
pub(super) fn resolve(arguments: &CameraArguments, scene: &Scene) -> Outcome<CameraDescription> {
    let mut camera = choose(arguments.camera.as_deref(), scene.cameras())?;
    place(arguments, &mut camera)?;
    if let Some(degrees) = arguments.fov {
        camera.projection = Projection::Perspective {
            yfov: degrees.to_radians(),
        };
    }
    focus(arguments, scene, &mut camera)?;
    Ok(camera)
}

/// By name, else by number; the first one where none is named.
fn choose(wanted: Option<&str>, cameras: &[CameraDescription]) -> Outcome<CameraDescription> {
    let found = match wanted {
        None => cameras.first(),
        Some(name) => cameras
            .iter()
            .find(|camera| camera.name == name)
            .or_else(|| cameras.get(name.parse::<usize>().ok()?)),
    };
    found.cloned().ok_or_else(|| {
        let known: Vec<_> = cameras
            .iter()
            .enumerate()
            .map(|(i, camera)| format!("{i} {}", camera.name))
            .collect();
        bad_input(format!(
            "--camera {}: the scene has no such camera; it has {}",
            wanted.unwrap_or_default(),
            known.join(", ")
        ))
    })
}

fn place(arguments: &CameraArguments, camera: &mut CameraDescription) -> Outcome {
    if arguments.eye.is_none() && arguments.target.is_none() && arguments.up.is_none() {
        return Ok(());
    }
    let matrix = camera.world_from_camera;
    let eye = arguments.eye.unwrap_or(matrix.w_axis.truncate());
    let forward = -matrix.z_axis.truncate().normalize_or(Vec3::Z);
    let target = arguments.target.unwrap_or(eye + forward);
    let direction = (target - eye).normalize_or_zero();
    if direction == Vec3::ZERO {
        return Err(bad_input(
            "--target: is where the camera stands; choose another point",
        ));
    }
    let up = arguments.up.unwrap_or(Vec3::Y).normalize_or_zero();
    let is_parallel = direction.cross(up).length() < 1e-4;
    if is_parallel && arguments.up.is_some() {
        return Err(bad_input(
            "--up: is the direction of view, or zero; choose another one",
        ));
    }
    let up = if is_parallel { Vec3::NEG_Z } else { up };
    camera.world_from_camera = CameraDescription::looking_at(eye, target, up);
    Ok(())
}

fn focus(arguments: &CameraArguments, scene: &Scene, camera: &mut CameraDescription) -> Outcome {
    let present = camera.lens;
    let aperture = arguments.aperture.or(present.map(|lens| lens.aperture));
    let aperture = match aperture {
        Some(aperture) if aperture > 0.0 => aperture,
        None if arguments.focus.is_some() => {
            return Err(bad_input(
                "--focus: a pinhole has everything sharp; give --aperture as well",
            ));
        }
        _ => {
            camera.lens = None;
            return Ok(());
        }
    };
    let kept = present
        .filter(|_| arguments.eye.is_none() && arguments.target.is_none())
        .map(|lens| lens.focus_distance);
    let focus_distance = match arguments.focus.or(kept) {
        Some(distance) => distance,
        None => {
            camera.lens = None;
            let depth = Features::trace(scene, camera, 1, 1).depth[0];
            if !depth.is_finite() || depth <= 0.0 {
                return Err(bad_input(
                    "--aperture: nothing is in the middle of the picture to focus on; give --focus",
                ));
            }
            depth
        }
    };
    let lens = Lens {
        aperture,
        focus_distance,
    };
    if let Some(fault) = lens.fault() {
        let option = if arguments.focus.is_some() && CAMERA_LENGTHS.contains(&aperture) {
            "--focus"
        } else {
            "--aperture"
        };
        return Err(bad_input(format!("{option}: {fault}; choose another one")));
    }
    camera.lens = Some(lens);
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use neumann_core::scene::description::Projection;
    use neumann_core::scene::load::LoadOptions;
    use neumann_core::scene::{Scene, open};

    use super::{CameraArguments, resolve};

    fn cornell() -> Scene {
        Scene::build(&open("cornell", &LoadOptions::default()).unwrap())
    }

    #[test]
    fn the_first_camera_is_the_default_and_wrong_names_are_refused() {
        let scene = cornell();
        let default = resolve(&CameraArguments::default(), &scene).unwrap();
        let by = |name: &str| {
            let arguments = CameraArguments {
                camera: Some(name.to_owned()),
                ..CameraArguments::default()
            };
            resolve(&arguments, &scene)
        };
        assert_eq!(by("0").unwrap().name, default.name);
        assert_eq!(by(&default.name).unwrap().name, default.name);
        let error = by("99").unwrap_err().to_string();
        assert!(error.contains(&default.name), "{error}");
    }

    #[test]
    fn eye_and_target_place_the_camera() {
        let arguments = CameraArguments {
            eye: Some(Vec3::new(0.0, 2.0, 5.0)),
            target: Some(Vec3::new(0.0, 2.0, 0.0)),
            fov: Some(60.0),
            ..CameraArguments::default()
        };
        let camera = resolve(&arguments, &cornell()).unwrap();
        let matrix = camera.world_from_camera;
        assert_eq!(matrix.w_axis.truncate(), Vec3::new(0.0, 2.0, 5.0));
        assert_eq!(-matrix.z_axis.truncate(), Vec3::NEG_Z);
        assert_eq!(
            camera.projection,
            Projection::Perspective {
                yfov: 60f32.to_radians()
            }
        );
        let straight_down = CameraArguments {
            eye: Some(Vec3::Y),
            target: Some(Vec3::ZERO),
            ..CameraArguments::default()
        };
        assert!(resolve(&straight_down, &cornell()).is_ok());
        let nowhere = CameraArguments {
            eye: Some(Vec3::Y),
            target: Some(Vec3::Y),
            ..CameraArguments::default()
        };
        assert!(resolve(&nowhere, &cornell()).is_err());
    }

    #[test]
    fn a_lens_focuses_on_what_is_in_the_middle() {
        let scene = cornell();
        let with = |aperture, focus| {
            let arguments = CameraArguments {
                aperture,
                focus,
                ..CameraArguments::default()
            };
            resolve(&arguments, &scene)
        };
        let lens = with(Some(0.1), None).unwrap().lens.unwrap();
        assert!(lens.focus_distance > 0.1, "{lens:?}");
        let lens = with(Some(0.1), Some(3.0)).unwrap().lens.unwrap();
        assert_eq!((lens.aperture, lens.focus_distance), (0.1, 3.0));
        assert!(with(Some(0.0), None).unwrap().lens.is_none());
        assert!(with(None, Some(3.0)).is_err());
        // Rays through such a lens would not be finite.
        for (aperture, focus) in [(1.0, 1e-22), (1.0, 1e-5), (1e-20, 1.0), (1e20, 1e20)] {
            let error = with(Some(aperture), Some(focus)).unwrap_err().to_string();
            let expected = if !(1e-12..=1e12).contains(&aperture) {
                format!("--aperture: an aperture of {aperture:e} m is not between")
            } else {
                "--focus: a".to_owned()
            };
            assert!(error.starts_with(&expected), "{error}");
            assert!(
                !error.contains("0.00000") && !error.contains("00000"),
                "{error}"
            );
        }
    }
}
