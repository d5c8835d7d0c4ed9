//! A method at a radius, and at a smaller one.

use std::sync::Arc;

use neumann_core::endpoint::Camera;
use neumann_core::film::Film;
use neumann_core::integrator::{METHODS, Method, Radius, Value};
use neumann_core::pass::{CancelToken, Cancelled};
use neumann_core::render::{RenderSettings, WorkerPool};
use neumann_core::scene::Scene;

use super::RATIO;
use crate::agreement::{Length, batch};

/// Settings that differ in the radius alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Radii {
    /// With the radius that was asked for, and with the smaller one.
    pub settings: [RenderSettings; 2],
    /// The first radius and the last one of a render, metres.
    pub radius: [f64; 2],
    /// Mean square of the smaller radius over that of the larger one.
    pub q: f64,
}

/// Renders at both radii with one seed.
///
/// # Errors
/// [`Cancelled`] if the token was.
pub fn pair(
    scene: &Arc<Scene>,
    radii: &Radii,
    (n_iterations, seed): (u32, u64),
    pool: &WorkerPool,
    cancel: &CancelToken,
) -> Result<[Film; 2], Cancelled> {
    let render = |settings: &RenderSettings| {
        let settings = RenderSettings {
            seed,
            ..settings.clone()
        };
        let length = Length::Iterations(n_iterations);
        batch(scene, settings, length, pool, cancel).map(|(film, _)| film)
    };
    let [wide, narrow] = &radii.settings;
    Ok([render(wide)?, render(narrow)?])
}

/// True if a method counts photons within a radius.
#[must_use]
pub fn has_radius(method: &Method) -> bool {
    let mut parameters = method.parameters.iter();
    parameters.any(|parameter| parameter.name == Radius::INITIAL.name)
}

impl Radii {
    /// Of a render of so many iterations.
    ///
    /// # Errors
    /// Says why the method has no bias of a radius to be measured.
    pub fn of(scene: &Scene, settings: &RenderSettings, n_iterations: u32) -> Result<Self, String> {
        let method = settings.method;
        if !has_radius(method) {
            let with = METHODS.iter().filter(|method| has_radius(method));
            let with: Vec<&str> = with.map(|method| method.id).collect();
            return Err(format!(
                "{} has no radius, and so no bias of one; {} have",
                method.id,
                with.join(", ")
            ));
        }
        if settings.values.value("nearest").is_some() && settings.values.integer("nearest") > 0 {
            return Err(format!(
                "{}: with 'nearest' photons the radius is another one at each place; set it to 0",
                method.id
            ));
        }
        let camera = Camera::new(&settings.camera, settings.width, settings.height);
        let asked = Radius::of(&settings.values);
        let first = asked.at(scene, &camera, 0);
        // In metres, so that nothing holds the smaller one at the width of a pixel.
        let with = |radius: f64| {
            let mut settings = settings.clone();
            let text = radius.to_string();
            let metres = Radius::UNIT.parse("metres").unwrap_or(Value::Choice(1));
            let radius = Radius::INITIAL.parse(&text).map_err(|e| e.to_string())?;
            settings.values.put(Radius::UNIT.name, metres);
            settings.values.put(Radius::INITIAL.name, radius);
            Ok::<_, String>(settings)
        };
        let settings = [with(f64::from(first))?, with(RATIO * f64::from(first))?];
        let radii = |settings: &RenderSettings| {
            let radius = Radius::of(&settings.values);
            let at = |i| f64::from(radius.at(scene, &camera, i));
            (0..n_iterations).map(at).collect::<Vec<f64>>()
        };
        let [wide, narrow] = settings.each_ref().map(radii);
        let squares = |radii: &[f64]| radii.iter().map(|r| r * r).sum::<f64>();
        Ok(Self {
            radius: [0, wide.len().saturating_sub(1)].map(|i| wide.get(i).copied().unwrap_or(0.0)),
            q: squares(&narrow) / squares(&wide),
            settings,
        })
    }
}
