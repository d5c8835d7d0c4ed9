//! Between the window and a [`State`]: what is written of it, and how it is taken up again.

use std::sync::Arc;

use glam::Vec3;
use neumann_core::radiometry::Rgb;
use neumann_core::render::StopRule;
use neumann_core::scene::description::{Crop, MaterialDescription};
use neumann_core::scene::{Appearance, Level, SkyChoice};
use neumann_picture::state::{
    CameraState, Edits, EnvironmentState, Exact, ExposureState, FalseColourState, LayersState,
    LevelEdit, LobesOf, LookedAt, Magnified, MaterialEdit, State, Stop,
};

use crate::display::ViewSettings;
use crate::display::layers::LayerSettings;
use crate::session::Session;
use crate::setup::{FilmSize, OpenScene, Setup};
use crate::viewing::Viewing;
use crate::views::Views;
use crate::views::entry::Entry;
use crate::views::hemisphere::HemisphereView;
use crate::views::inspect::InspectView;
use crate::views::lobe::{Choice, LobeView};
use crate::views::race::RaceView;

/// What is seen now; `None` while there is no scene.
#[must_use]
pub fn of(session: &Session, viewing: &Viewing) -> Option<State> {
    let setup = &session.setup;
    let open = setup.open.as_ref()?;
    let settings = &viewing.settings;
    let appearance = open.scene.appearance();
    let render = State::of_render(&open.source, &setup.settings()?);
    Some(State {
        camera: camera_of(setup),
        views: setup.views.clone(),
        size: match setup.film_size {
            FilmSize::Window => None,
            FilmSize::Locked => Some(setup.size.into()),
            FilmSize::Fixed(width, height) => Some([width, height]),
        },
        stop: match setup.stop {
            StopRule::Never => Stop::Never,
            StopRule::Iterations(n) => Stop::Iterations(n),
            StopRule::Seconds(seconds) => Stop::Seconds(seconds),
        },
        view: viewing.views.shown().id.to_owned(),
        part: settings.part.to_string(),
        exposure: ExposureState {
            stops: Exact(settings.exposure_ev),
            is_automatic: settings.is_auto,
        },
        tone: settings.tone.name().to_owned(),
        false_colour: FalseColourState {
            is_on: settings.is_false_colour,
            colours: settings.map.name().to_owned(),
            stops: Exact(settings.map_stops),
        },
        magnified: settings.zoom.map(|zoom| Magnified {
            zoom: Exact(zoom),
            center: Exact::all(settings.center),
        }),
        environment: EnvironmentState {
            is_on: appearance.environment_level.is_on,
            brightness: Exact(appearance.environment_level.brightness),
            tint: Exact::all(appearance.environment_tint.to_array()),
            ..EnvironmentState::of(setup.sky.as_ref(), appearance.environment.as_deref())
        },
        backs: appearance.backs.name().to_owned(),
        edits: edits(open),
        layers_beside: layers_of(&settings.layers),
        looked_at: looked_at(&viewing.views),
        ..render
    })
}

/// The camera as it stands; `None` while there is no scene.
pub(crate) fn camera_of(setup: &Setup) -> Option<CameraState> {
    let (open, control) = (setup.open.as_ref()?, setup.camera.as_ref()?);
    Some(CameraState {
        of_file: open.camera,
        target: Some(Exact::all(control.target().to_array())),
        up: Some(Exact::all(control.up().to_array())),
        ..CameraState::of(control.camera())
    })
}

/// The sky that a state asks for in place of the scene's.
#[must_use]
pub fn sky(state: &State) -> Option<SkyChoice> {
    let word = state.environment.sky.as_str();
    (word != EnvironmentState::OWN).then(|| SkyChoice::from_word(word))
}

/// Takes up a state, its scene being open. Yields what of it could not be, in a sentence each.
#[must_use]
pub fn take_up(state: &State, session: &mut Session, viewing: &mut Viewing) -> Vec<String> {
    let mut complaints = Vec::new();
    let setup = &mut session.setup;
    take_method(state, setup);
    setup.region = state.region.map(Crop::from);
    if let Some(region) = setup.region {
        // Its film is of that size, whether or not it follows the window.
        setup.size = region.of.into();
    }
    if let Some(camera) = &state.camera {
        take_camera(camera, setup);
    }
    // Those that were kept before stay, behind those of the state.
    let mut views = state.views.clone();
    views.extend(
        setup
            .views
            .drain(..)
            .filter(|view| !state.views.contains(view)),
    );
    setup.views = views;
    if let Some(open) = &setup.open {
        let mut appearance = open.scene.appearance().clone();
        take_edits(&state.edits, &mut appearance, &mut complaints);
        take_environment(&state.environment, &mut appearance);
        setup.dress(appearance);
    }
    setup.is_changed = true;
    take_looks(state, &mut viewing.settings);
    viewing.views.close();
    if let Err(refusal) = viewing.views.show(&state.view, setup, &viewing.settings) {
        complaints.push(refusal);
    }
    take_looked_at(&state.looked_at, &mut viewing.views);
    complaints
}

/// What views look at.
fn looked_at(views: &Views) -> LookedAt {
    let race = views.get::<RaceView>().map(|view| &view.entries);
    LookedAt {
        inspected: views.get::<InspectView>().and_then(|view| view.pixel),
        hemisphere: views.get::<HemisphereView>().and_then(|view| view.pixel),
        lobes: views.get::<LobeView>().and_then(|view| {
            view.choice.map(|choice| match choice {
                Choice::Pixel(pixel) => LobesOf::Pixel(pixel),
                Choice::Material(material) => LobesOf::Material(material),
            })
        }),
        race: race.into_iter().flatten().map(Entry::state).collect(),
    }
}

/// Lets views look at something, after one of them has been opened.
fn take_looked_at(state: &LookedAt, views: &mut Views) {
    if let Some(view) = views.get_mut::<InspectView>() {
        view.pixel = state.inspected;
    }
    if let Some(view) = views.get_mut::<HemisphereView>() {
        view.pixel = state.hemisphere;
    }
    if let Some(view) = views.get_mut::<LobeView>() {
        view.choice = state.lobes.map(|lobes| match lobes {
            LobesOf::Pixel(pixel) => Choice::Pixel(pixel),
            LobesOf::Material(material) => Choice::Material(material),
        });
    }
    if let Some(view) = views.get_mut::<RaceView>() {
        // A state that was read has been checked.
        view.enter(state.race.iter().filter_map(Entry::of_state).collect());
    }
}

/// Level, colour and turn of the environment; for a map that came later than the scene, too.
pub fn take_environment(state: &EnvironmentState, appearance: &mut Appearance) {
    appearance.environment_level = Level {
        is_on: state.is_on,
        brightness: state.brightness.0,
    };
    appearance.environment_tint = rgb(state.tint);
    if let (Some(rotation), Some(map)) = (state.rotation, &mut appearance.environment)
        && map.rotation.to_bits() != rotation.0.to_bits()
    {
        Arc::make_mut(map).rotation = rotation.0;
    }
}

/// Puts the camera as it stood.
pub(crate) fn take_camera(state: &CameraState, setup: &mut Setup) {
    setup.take_camera(state.of_file);
    let Some(control) = &mut setup.camera else {
        return;
    };
    let camera = state.description(control.camera().name.clone());
    let vector = |all| Vec3::from_array(Exact::values(all));
    control.put(camera, state.target.map(vector), state.up.map(vector));
}

fn take_method(state: &State, setup: &mut Setup) {
    if let Some(index) = neumann_core::integrator::METHODS
        .iter()
        .position(|method| method.id == state.method)
    {
        setup.method = index;
    }
    // A state that was read has been checked.
    if let Ok((values, _)) = state.values(setup.method()) {
        setup.values[setup.method] = values;
    }
    setup.max_bounces = state.max_bounces;
    setup.n_layers = state.layers.max(1);
    setup.seed = state.seed;
    setup.film_size = FilmSize::of(state.size.map(|[w, h]| (w, h)));
    setup.stop = match state.stop {
        Stop::Never => StopRule::Never,
        Stop::Iterations(n) => StopRule::Iterations(n),
        Stop::Seconds(seconds) => StopRule::Seconds(seconds),
    };
}

fn take_looks(state: &State, settings: &mut ViewSettings) {
    // A state that was read has been checked; of another one, what can be read counts.
    *settings = ViewSettings {
        part: state.part.parse().unwrap_or(settings.part),
        exposure_ev: state.exposure.stops.0,
        is_auto: state.exposure.is_automatic,
        tone: state.tone.parse().unwrap_or(settings.tone),
        is_false_colour: state.false_colour.is_on,
        map: state.false_colour.colours.parse().unwrap_or(settings.map),
        map_stops: state.false_colour.stops.0,
        layers: layers(&state.layers_beside),
        zoom: state.magnified.as_ref().map(|magnified| magnified.zoom.0),
        center: state
            .magnified
            .as_ref()
            .map_or([0.5, 0.5], |magnified| Exact::values(magnified.center)),
        is_probing: settings.is_probing,
        ..ViewSettings::default()
    };
}

fn edits(open: &OpenScene) -> Edits {
    let appearance = open.scene.appearance();
    let materials = appearance.materials.iter().zip(&open.original.materials);
    let materials = materials.enumerate().filter(|(_, (now, was))| now != was);
    let names = appearance.materials.iter().map(|m| m.name.as_str());
    let lights = appearance.lights.iter().map(|light| light.name.as_str());
    Edits {
        materials: materials.map(|(i, (now, _))| material(i, now)).collect(),
        emitters: levels(names, &appearance.material_levels, |_| None),
        lights: levels(lights, &appearance.light_levels, |i| {
            let strength = appearance.lights[i].kind.strength();
            let original = open.original.lights.get(i)?.kind.strength();
            (strength != original).then_some(strength)
        }),
    }
}

/// Lights that shine otherwise; `strength` is that of a light by itself, where it is another.
fn levels<'a>(
    names: impl Iterator<Item = &'a str>,
    levels: &[Level],
    strength: impl Fn(usize) -> Option<Rgb>,
) -> Vec<LevelEdit> {
    let all = names.zip(levels).enumerate();
    let edited = all.filter_map(|(index, (name, level))| {
        let strength = strength(index);
        (*level != Level::default() || strength.is_some()).then(|| LevelEdit {
            index,
            name: name.to_owned(),
            is_on: level.is_on,
            brightness: Exact(level.brightness),
            strength: strength.map(|strength| Exact::all(strength.to_array())),
        })
    });
    edited.collect()
}

fn material(index: usize, material: &MaterialDescription) -> MaterialEdit {
    MaterialEdit {
        index,
        name: material.name.clone(),
        base_color: Exact::all(material.base_color.to_array()),
        roughness: Exact(material.roughness),
        metallic: Exact(material.metallic),
        specular: Exact(material.specular),
        transmission: Exact(material.transmission),
        ior: Exact(material.ior),
        emission: Exact::all(material.emission.to_array()),
        specular_color: Some(Exact::all(material.specular_color.to_array())),
        attenuation_color: material
            .volume
            .map(|volume| Exact::all(volume.attenuation_color.to_array())),
    }
}

fn take_edits(edits: &Edits, appearance: &mut Appearance, complaints: &mut Vec<String>) {
    let mut left_out = |what: &str, index: usize, name: &str| {
        complaints.push(format!(
            "The scene has no {what} {index} called '{name}'; it was edited, and stays as in the \
             file"
        ));
    };
    for edit in &edits.materials {
        let found = appearance.materials.get_mut(edit.index);
        let Some(material) = found.filter(|material| material.name == edit.name) else {
            left_out("material", edit.index, &edit.name);
            continue;
        };
        material.base_color = rgb(edit.base_color);
        material.roughness = edit.roughness.0;
        material.metallic = edit.metallic.0;
        material.specular = edit.specular.0;
        material.transmission = edit.transmission.0;
        material.ior = edit.ior.0;
        material.emission = rgb(edit.emission);
        if let Some(color) = edit.specular_color {
            material.specular_color = rgb(color);
        }
        if let (Some(color), Some(volume)) = (edit.attenuation_color, &mut material.volume) {
            volume.attenuation_color = rgb(color);
        }
    }
    let level = |edit: &LevelEdit| Level {
        is_on: edit.is_on,
        brightness: edit.brightness.0,
    };
    for edit in &edits.emitters {
        let named = appearance.materials.get(edit.index);
        let is_it = named.is_some_and(|material| material.name == edit.name);
        match appearance.material_levels.get_mut(edit.index) {
            Some(there) if is_it => *there = level(edit),
            _ => left_out("material", edit.index, &edit.name),
        }
    }
    for edit in &edits.lights {
        let named = appearance.lights.get_mut(edit.index);
        let named = named.filter(|light| light.name == edit.name);
        match (named, appearance.light_levels.get_mut(edit.index)) {
            (Some(light), Some(there)) => {
                *there = level(edit);
                if let Some(strength) = edit.strength {
                    light.kind.set_strength(rgb(strength));
                }
            }
            _ => left_out("light", edit.index, &edit.name),
        }
    }
}

fn layers_of(settings: &LayerSettings) -> LayersState {
    let mix = settings.mix.iter();
    LayersState {
        expressions: settings.expressions.clone(),
        lights: settings.lights.clone(),
        mix: mix
            .map(|(name, factor)| (name.clone(), Exact::all(factor.to_array())))
            .collect(),
    }
}

fn layers(state: &LayersState) -> LayerSettings {
    let mix = state.mix.iter();
    LayerSettings {
        expressions: state.expressions.clone(),
        lights: state.lights.clone(),
        mix: mix
            .map(|(name, factor)| (name.clone(), rgb(*factor)))
            .collect(),
        ..LayerSettings::default()
    }
}

fn rgb(all: [Exact; 3]) -> Rgb {
    let [r, g, b] = Exact::values(all);
    Rgb::new(r, g, b)
}
