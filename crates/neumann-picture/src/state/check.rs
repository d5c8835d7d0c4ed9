//! Whether the fields of a state can be what they say.

use std::f32::consts::PI;
use std::str::FromStr;

use neumann_core::film::View as Part;
use neumann_core::integrator::{METHODS, Method, ParameterValues, method};
use neumann_core::scene::Backs;

use super::{
    CameraState, Exact, LevelEdit, MaterialEdit, ProjectionState, RegionState, State, Stop,
};
use crate::false_colour::ColourMap;
use crate::tone::ToneCurve;

/// The field, and what is wrong with it.
pub(super) type Wrong = (String, String);

/// Most columns and rows of a film.
pub(super) const MAX_EDGE: usize = 65_535;

impl State {
    /// Refuses what cannot be; yields what is odd.
    pub(super) fn check(&self) -> Result<Vec<String>, Wrong> {
        if self.scene.is_empty() {
            return wrong(
                "scene",
                "names none; use a built-in scene or the path of a file",
            );
        }
        let Some(method) = method(&self.method) else {
            let ids: Vec<_> = METHODS.iter().map(|m| m.id).collect();
            let what = format!(
                "there is no method '{}'; use one of {}",
                self.method,
                ids.join(", ")
            );
            return wrong("method", what);
        };
        let (_, warnings) = self.values(method)?;
        read::<Part>("part", &self.part)?;
        read::<ToneCurve>("tone", &self.tone)?;
        read::<ColourMap>("false_colour.colours", &self.false_colour.colours)?;
        if Backs::named(&self.backs).is_none() {
            let what = format!("'{}' is not known; use solid or see-through", self.backs);
            return wrong("backs", what);
        }
        whole("max_bounces", self.max_bounces as usize, 0, 65_535)?;
        whole("layers", self.layers, 1, 64)?;
        for (i, edge) in self.size.into_iter().flatten().enumerate() {
            whole(&format!("size[{i}]"), edge, 1, MAX_EDGE)?;
        }
        if let Some(region) = &self.region {
            region.check(self.size)?;
        }
        match self.stop {
            Stop::Iterations(0) => return wrong("stop", "use one iteration or more"),
            Stop::Seconds(s) if !(s > 0.0 && s.is_finite()) => {
                return wrong("stop", "use a time above 0");
            }
            _ => {}
        }
        range("exposure.stops", self.exposure.stops, -100.0, 100.0)?;
        range("false_colour.stops", self.false_colour.stops, 0.1, 100.0)?;
        range(
            "environment.brightness",
            self.environment.brightness,
            0.0,
            f32::MAX,
        )?;
        shares("environment.tint", self.environment.tint)?;
        if let Some(magnified) = &self.magnified {
            range("magnified.zoom", magnified.zoom, 1e-3, 128.0)?;
        }
        self.camera.as_ref().map_or(Ok(()), CameraState::check)?;
        for (i, view) in self.views.iter().enumerate() {
            let checked = view.camera.check();
            checked.map_err(|(field, what)| (format!("views[{i}].{field}"), what))?;
        }
        let edits = &self.edits;
        for (i, edit) in edits.materials.iter().enumerate() {
            edit.check(&format!("edits.materials[{i}]"))?;
        }
        for (i, edit) in edits.emitters.iter().enumerate() {
            edit.check(&format!("edits.emitters[{i}]"))?;
        }
        for (i, edit) in edits.lights.iter().enumerate() {
            edit.check(&format!("edits.lights[{i}]"))?;
        }
        for (name, factor) in &self.layers_beside.mix {
            for channel in *factor {
                range(&format!("layers_beside.mix.{name}"), channel, 0.0, f32::MAX)?;
            }
        }
        self.looked_at.check()?;
        Ok(warnings)
    }

    /// The values of a method's parameters, and what is odd about them.
    ///
    /// # Errors
    /// The field, and what is wrong with it.
    pub fn values(&self, method: &Method) -> Result<(ParameterValues, Vec<String>), Wrong> {
        let mut values = ParameterValues::defaults(method.parameters);
        let mut warnings = Vec::new();
        for (name, text) in &self.parameters {
            let field = format!("parameters.{name}");
            if !method.parameters.iter().any(|p| p.name == name) {
                let id = method.id;
                warnings.push(format!(
                    "{field}: {id} has no such parameter; it is ignored"
                ));
            } else if let Err(error) = values.set(method.parameters, name, text) {
                return wrong(&field, error.to_string());
            }
        }
        Ok((values, warnings))
    }
}

impl CameraState {
    pub(super) fn check(&self) -> Result<(), Wrong> {
        match self.projection {
            ProjectionState::Perspective { yfov } => {
                if !(yfov.0 > 0.0 && yfov.0 < PI) {
                    let what = "use an angle in radians, above 0 and below 3.14";
                    return wrong("camera.projection.perspective.yfov", what);
                }
            }
            ProjectionState::Orthographic { ymag } => {
                positive("camera.projection.orthographic.ymag", ymag)?;
            }
        }
        if let Some(lens) = &self.lens {
            range("camera.lens.aperture", lens.aperture, 0.0, f32::MAX)?;
            positive("camera.lens.focus_distance", lens.focus_distance)?;
        }
        self.aspect_ratio
            .map_or(Ok(()), |ratio| positive("camera.aspect_ratio", ratio))
    }
}

impl RegionState {
    /// Refuses a region that is empty, or no part of a film of that size.
    fn check(&self, film: Option<[usize; 2]>) -> Result<(), Wrong> {
        for (i, edge) in self.of.into_iter().enumerate() {
            whole(&format!("region.of[{i}]"), edge, 1, MAX_EDGE)?;
        }
        if let Some(film) = film.filter(|film| *film != self.of) {
            let [of, film] = [self.of, film].map(|[width, height]| format!("{width}x{height}"));
            let what = format!("{of} is not the film's size; use that of 'size', {film}");
            return wrong("region.of", what);
        }
        for i in 0..2 {
            whole(&format!("region.at[{i}]"), self.at[i], 0, self.of[i] - 1)?;
            let most = self.of[i] - self.at[i];
            whole(&format!("region.size[{i}]"), self.size[i], 1, most)?;
        }
        Ok(())
    }
}

impl MaterialEdit {
    fn check(&self, way: &str) -> Result<(), Wrong> {
        shares(&format!("{way}.base_color"), self.base_color)?;
        for (name, value) in [
            ("roughness", self.roughness),
            ("metallic", self.metallic),
            ("specular", self.specular),
            ("transmission", self.transmission),
        ] {
            range(&format!("{way}.{name}"), value, 0.0, 1.0)?;
        }
        radiances(&format!("{way}.emission"), self.emission)?;
        if let Some(color) = self.specular_color {
            radiances(&format!("{way}.specular_color"), color)?;
        }
        if let Some(color) = self.attenuation_color {
            shares(&format!("{way}.attenuation_color"), color)?;
        }
        range(&format!("{way}.ior"), self.ior, 0.0, 1e6)
    }
}

impl LevelEdit {
    fn check(&self, way: &str) -> Result<(), Wrong> {
        if let Some(strength) = self.strength {
            radiances(&format!("{way}.strength"), strength)?;
        }
        range(&format!("{way}.brightness"), self.brightness, 0.0, f32::MAX)
    }
}

pub(super) fn wrong<T>(field: &str, what: impl Into<String>) -> Result<T, Wrong> {
    Err((field.to_owned(), what.into()))
}

fn read<T: FromStr<Err: ToString>>(field: &str, text: &str) -> Result<T, Wrong> {
    text.parse()
        .map_err(|error: T::Err| (field.to_owned(), error.to_string()))
}

pub(super) fn whole(field: &str, value: usize, min: usize, max: usize) -> Result<(), Wrong> {
    if (min..=max).contains(&value) {
        return Ok(());
    }
    wrong(
        field,
        format!("{value} is out of range; use {min} to {max}"),
    )
}

/// Channels from 0 to 1.
fn shares(field: &str, color: [Exact; 3]) -> Result<(), Wrong> {
    channels(field, color, 1.0)
}

/// Channels from 0 on.
fn radiances(field: &str, color: [Exact; 3]) -> Result<(), Wrong> {
    channels(field, color, f32::MAX)
}

fn channels(field: &str, color: [Exact; 3], max: f32) -> Result<(), Wrong> {
    let mut channels = color.into_iter().enumerate();
    channels.try_for_each(|(i, value)| range(&format!("{field}[{i}]"), value, 0.0, max))
}

fn range(field: &str, value: Exact, min: f32, max: f32) -> Result<(), Wrong> {
    if (min..=max).contains(&value.0) {
        return Ok(());
    }
    let remedy = if max == f32::MAX {
        format!("use {min} or more")
    } else {
        format!("use {min} to {max}")
    };
    wrong(field, format!("{} is out of range; {remedy}", value.0))
}

fn positive(field: &str, value: Exact) -> Result<(), Wrong> {
    if value.0 > 0.0 {
        return Ok(());
    }
    wrong(
        field,
        format!("{} is out of range; use a number above 0", value.0),
    )
}
