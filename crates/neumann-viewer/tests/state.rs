//! A state that is saved and opened again shows the same picture.

#[path = "state/looked_at.rs"]
mod looked_at;
mod support;

use std::path::PathBuf;
use std::time::Duration;

use egui::{Key, Modifiers, Theme};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::Vec2;
use neumann_core::film::View as Part;
use neumann_core::radiometry::Rgb;
use neumann_core::render::StopRule;
use neumann_core::scene::description::Crop;
use neumann_core::scene::{Backs, Level, Sky};
use neumann_picture::exr_file::read_exr;
use neumann_picture::exr_file::{appearance_text, camera_text, environment_text};
use neumann_picture::state::State;
use neumann_picture::tone::ToneCurve;
use neumann_viewer::app::App;
use neumann_viewer::setup::FilmSize;
use neumann_viewer::{command_line, state};

use support::{app, app_with_photons, app_with_quantities, app_with_techniques};

fn harness_of(app: App) -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size([1280.0, 720.0])
        .with_pixels_per_point(1.0)
        .with_theme(Theme::Dark)
        .build_ui_state(|ui, app: &mut App| app.ui(ui), app);
    harness.run_steps(4);
    harness
}

fn wait(harness: &mut Harness<'_, App>, is_done: impl Fn(&App) -> bool) {
    for _ in 0..1000 {
        harness.run_steps(2);
        if is_done(harness.state()) {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("nothing came from the background");
}

fn state_of(harness: &Harness<'_, App>) -> State {
    let app = harness.state();
    state::of(&app.session, &app.viewing).expect("a scene is open")
}

/// Changes a bit of everything.
fn change(app: &mut App) {
    let setup = &mut app.session.setup;
    let control = setup.camera.as_mut().expect("a camera");
    control.orbit(Vec2::new(0.1234, -0.0567));
    control.dolly(0.777);
    control.set_fov(0.7 + 1e-7);
    let mut lens = control.lens();
    lens.aperture = 0.1 / 3.0;
    control.set_lens(lens);
    setup.choose_sky(Some(Sky::Sun));
    setup.choose_backs(Backs::SeeThrough);
    let open = setup.open.as_ref().expect("a scene");
    let mut appearance = open.scene.appearance().clone();
    appearance.materials[0].base_color = Rgb::new(0.1, 0.2, 1.0 / 3.0);
    appearance.materials[0].roughness = 0.3;
    appearance.material_levels[0] = Level {
        is_on: true,
        brightness: 1.7,
    };
    appearance.materials[0].specular_color = Rgb::new(1.0, 0.7, 1.0 / 7.0);
    appearance.environment_level.brightness = 0.3;
    appearance.environment_tint = Rgb::new(1.0, 0.9, 1.0 / 3.0);
    let map = appearance.environment.as_mut().expect("a sky");
    std::sync::Arc::make_mut(map).rotation = 1.1;
    setup.dress(appearance);
    setup.max_bounces = 9;
    setup.n_layers = 7;
    setup.seed = 12;
    setup.stop = StopRule::Iterations(77);
    setup.film_size = FilmSize::Fixed(40, 30);
    let settings = &mut app.viewing.settings;
    settings.part = Part::Upto(3);
    settings.exposure_ev = 1.0 / 3.0;
    settings.tone = ToneCurve::ALL[3];
    settings.is_false_colour = true;
    settings.map_stops = 7.5;
    settings.zoom = Some(3.3);
    settings.center = [0.1, 0.9];
}

/// What was copied as text in the last frame.
fn copied(harness: &Harness<'_, App>) -> Option<String> {
    let commands = &harness.output().platform_output.commands;
    commands.iter().find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    })
}

#[test]
fn a_state_that_is_copied_and_pasted_is_the_same() {
    let mut first = harness_of(app_with_techniques());
    change(first.state_mut());
    first.run_steps(3);
    let wanted = state_of(&first);
    // In one frame, whose output is the last one.
    first.input_mut().events.push(egui::Event::Key {
        key: Key::C,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: Modifiers::COMMAND | Modifiers::SHIFT,
    });
    first.step();
    let text = copied(&first).expect("it is copied");
    assert_eq!(text.lines().count(), 1);
    let notices: Vec<_> = first.state().shell.notices.texts().collect();
    assert_eq!(
        notices,
        ["Copied the state; Ctrl V in another window opens it"]
    );

    let mut second = harness_of(app());
    second.event(egui::Event::Paste(text.clone()));
    second.run_steps(2);
    wait(&mut second, |app| !app.is_loading());
    second.run_steps(2);
    assert_eq!(state_of(&second), wanted);
    assert_eq!(second.state().shell.notices.texts().count(), 0);
    assert!(
        second.state().shell.recent.paths().is_empty(),
        "it is no file"
    );

    // What is wrong is told with its field, and the window stays as it is.
    for (from, to, told) in [
        (
            "\"max_bounces\":9",
            "\"max_bounces\":-9",
            "pasted text: max_bounces: ",
        ),
        ("{", "", "pasted text: "),
        (
            "\"scene\":\"furnace\"",
            "\"scene\":\"gone.glb\"",
            "pasted text: scene: there is no file",
        ),
    ] {
        second.event(egui::Event::Paste(text.replacen(from, to, 1)));
        second.run_steps(2);
        let newest = second
            .state()
            .shell
            .notices
            .texts()
            .last()
            .map(str::to_owned);
        let newest = newest.expect("it is told");
        assert!(newest.starts_with(told), "{newest}");
        assert!(!second.state().is_loading());
        second.key_press(Key::Escape);
        second.run_steps(2);
    }
    assert_eq!(state_of(&second), wanted);

    // What is pasted into a field is typed there.
    second.key_press(Key::F2);
    second.run_steps(2);
    second.get_by_label("Scene path").focus();
    second.run_steps(2);
    second.event(egui::Event::Paste("furnace".to_owned()));
    second.run_steps(2);
    assert_eq!(second.state().shell.fields.scene, "furnace");
    assert_eq!(second.state().shell.notices.texts().count(), 0);
}

#[test]
fn a_state_opened_again_shows_the_same_picture() {
    let mut first = harness_of(app_with_techniques());
    change(first.state_mut());
    first.run_steps(3);
    first.key_press(Key::V);
    first.run_steps(3);
    let saved = state_of(&first);
    assert_eq!(saved.view, "techniques");
    let (read, warnings) = State::parse(&saved.to_text()).expect("a state");
    assert_eq!((&read, warnings.len()), (&saved, 0));

    let mut second = harness_of(app());
    second.state_mut().open_state(Box::new(read));
    wait(&mut second, |app| !app.is_loading());
    second.run_steps(2);
    assert_eq!(state_of(&second), saved);
    assert_eq!(second.state().shell.notices.texts().count(), 0);

    let job = |harness: &Harness<'_, App>| {
        let job = harness.state().session.link.started();
        job.expect("it renders").clone()
    };
    let (a, b) = (job(&first), job(&second));
    let bits = |matrix: glam::Mat4| matrix.to_cols_array().map(f32::to_bits);
    assert_eq!(
        bits(a.settings.camera.world_from_camera),
        bits(b.settings.camera.world_from_camera)
    );
    assert_eq!(
        camera_text(&a.settings.camera),
        camera_text(&b.settings.camera)
    );
    let of_settings = |job: &neumann_core::render::Job| {
        let s = &job.settings;
        let size = (s.width, s.height);
        (
            s.method,
            s.values.clone(),
            size,
            s.max_bounces,
            s.n_layers,
            s.seed,
        )
    };
    assert_eq!(of_settings(&a), of_settings(&b));
    assert_eq!(a.stop, b.stop);
    let (now, was) = (a.scene.appearance(), b.scene.appearance());
    assert_eq!(a.scene.content_hash(), b.scene.content_hash());
    assert_eq!(appearance_text(now), appearance_text(was));
    let sky = |e: &neumann_core::scene::Appearance| environment_text(e.environment.as_deref());
    assert_eq!(sky(now), sky(was));
    assert_eq!(now.backs, was.backs);
    let looks = |harness: &Harness<'_, App>| harness.state().viewing.settings.clone();
    assert_eq!(looks(&first), looks(&second));
    // The way home is that of the file.
    second.key_press(Key::Home);
    second.run_steps(2);
    let home = harness_of(app());
    assert_eq!(
        camera_text(&job(&second).settings.camera),
        camera_text(&job(&home).settings.camera)
    );
}

/// A triangle under a lamp, of glass that has a colour inside.
const LAMP: &str = r#"{
    "asset": {"version": "2.0"},
    "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_transmission",
        "KHR_materials_volume"],
    "extensions": {"KHR_lights_punctual": {"lights": [
        {"name": "lamp", "type": "point", "intensity": 5, "color": [1, 0.5, 0.25]}]}},
    "materials": [{"name": "glass", "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 0.5,
            "attenuationColor": [0.5, 0.6, 0.7]}}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
    "nodes": [{"mesh": 0}, {"name": "lamp", "translation": [0, 1, 2],
        "extensions": {"KHR_lights_punctual": {"light": 0}}}],
    "scenes": [{"nodes": [0, 1]}], "scene": 0,
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [0, 0, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri":
        "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]
}"#;

#[test]
fn colours_of_lights_and_of_the_inside_come_back() {
    let folder = std::env::temp_dir().join(format!("neumann-lamp-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("lamp.gltf");
    std::fs::write(&path, LAMP).expect("a file");
    let mut first = harness_of(app());
    first.state_mut().open_scene(path.display().to_string());
    wait(&mut first, |app| !app.is_loading());
    let setup = &mut first.state_mut().session.setup;
    let open = setup.open.as_ref().expect("a scene");
    let mut appearance = open.scene.appearance().clone();
    let colour = Rgb::new(0.1, 3.0, 1.0 / 3.0);
    appearance.lights[0].kind.set_strength(colour);
    let volume = appearance.materials[0].volume.as_mut().expect("an inside");
    volume.attenuation_color = Rgb::new(0.9, 0.1, 1.0 / 7.0);
    setup.dress(appearance);
    first.run_steps(2);
    let saved = state_of(&first);
    let (read, warnings) = State::parse(&saved.to_text()).expect("a state");
    assert_eq!((&read, warnings.len()), (&saved, 0));

    let mut second = harness_of(app());
    second.state_mut().open_state(Box::new(read));
    wait(&mut second, |app| !app.is_loading());
    second.run_steps(2);
    assert_eq!(state_of(&second), saved);
    let of = |harness: &Harness<'_, App>| {
        let open = harness.state().session.setup.open.as_ref();
        open.expect("a scene").scene.appearance().clone()
    };
    let (now, was) = (of(&second), of(&first));
    assert_eq!(now.lights, was.lights);
    assert_eq!(now.lights[0].kind.strength(), colour);
    assert_eq!(now.materials, was.materials);
    // What a state brings is where undoing ends.
    assert_eq!(second.state().session.history.to_undo(), None);
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn a_state_has_the_region() {
    for film_size in [FilmSize::Fixed(40, 30), FilmSize::Window] {
        let mut first = harness_of(app());
        let setup = &mut first.state_mut().session.setup;
        setup.film_size = film_size;
        setup.is_changed = true;
        first.run_steps(2);
        let setup = &mut first.state_mut().session.setup;
        let region = Crop {
            of: setup.size.into(),
            at: [3, 4],
            size: [20, 10],
        };
        setup.choose_region(Some(region));
        first.run_steps(2);
        let saved = state_of(&first);
        assert_eq!(saved.region.map(Crop::from), Some(region));
        let (read, warnings) = State::parse(&saved.to_text()).expect("a state");
        assert_eq!((&read, warnings.len()), (&saved, 0));

        // A window of another size keeps the region and its film.
        let mut second = harness_of(app());
        second.set_size(egui::vec2(900.0, 600.0));
        second.run_steps(2);
        second.state_mut().open_state(Box::new(read));
        wait(&mut second, |app| !app.is_loading());
        second.run_steps(3);
        assert_eq!(state_of(&second), saved);
        let session = &second.state().session;
        let settings = &session.link.started().expect("it renders").settings;
        assert_eq!(settings.camera.crop, Some(region));
        assert_eq!((settings.width, settings.height), (20, 10));
        let around = session.picture.around.as_ref();
        assert!(
            around.is_none(),
            "nothing of the scene before stands around it"
        );
        let command = command_line::of(session, &second.state().viewing.settings);
        let command = command.expect("a scene is open").text;
        assert!(command.contains(" --region 3,4,20,10 "), "{command}");

        // A state without a region renders the whole picture.
        let whole = State {
            region: None,
            ..saved
        };
        second.state_mut().open_state(Box::new(whole.clone()));
        wait(&mut second, |app| !app.is_loading());
        second.run_steps(2);
        assert_eq!(state_of(&second), whole);
    }
}

#[test]
fn a_state_of_photons_shows_them_again() {
    let mut first = harness_of(app_with_photons());
    first.key_press(Key::P);
    first.run_steps(3);
    let saved = state_of(&first);
    assert_eq!(saved.view, "photons");
    let mut second = harness_of(app());
    second.state_mut().open_state(Box::new(saved.clone()));
    wait(&mut second, |app| !app.is_loading());
    second.run_steps(2);
    assert_eq!(state_of(&second), saved);
    assert_eq!(second.state().viewing.views.shown().id, "photons");
}

#[test]
fn a_state_of_what_pixels_hold_shows_it_again() {
    let mut first = harness_of(app_with_quantities());
    for _ in 0..3 {
        first.key_press(Key::N);
        first.run_steps(2);
    }
    let saved = state_of(&first);
    assert_eq!(saved.view, "depth");
    let mut second = harness_of(app_with_quantities());
    second.state_mut().open_state(Box::new(saved.clone()));
    wait(&mut second, |app| !app.is_loading());
    second.run_steps(2);
    assert_eq!(state_of(&second), saved);
    assert_eq!(second.state().viewing.views.shown().id, "depth");
}

#[test]
fn a_state_has_the_views_that_were_kept() {
    let mut first = harness_of(app());
    let keys = Modifiers::COMMAND | Modifiers::SHIFT;
    first.key_press_modifiers(keys, Key::Num1);
    first.run_steps(2);
    let saved = state_of(&first);
    assert_eq!(saved.views.len(), 1);
    let mut second = harness_of(app());
    second.key_press(Key::F);
    second.run_steps(2);
    second.key_press_modifiers(keys, Key::Num1);
    second.run_steps(2);
    second.state_mut().open_state(Box::new(saved.clone()));
    wait(&mut second, |app| !app.is_loading());
    second.run_steps(2);
    let views = &state_of(&second).views;
    assert_eq!(views.len(), 2, "what was kept before is not lost");
    assert_eq!(views[0], saved.views[0]);
}

#[test]
fn a_map_comes_back_with_its_level_and_turn() {
    let map = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/scenes/sky.hdr");
    let mut first = harness_of(app());
    let is_lit = |app: &App| {
        let open = app.session.setup.open.as_ref().expect("a scene");
        open.scene.appearance().environment.is_some()
    };
    assert!(!is_lit(first.state()));
    first
        .state_mut()
        .shell
        .background
        .open_environment(map.into());
    wait(&mut first, is_lit);
    first.run_steps(2);
    let to_undo = |harness: &Harness<'_, App>| {
        let history = &harness.state().session.history;
        history.to_undo().map(str::to_owned)
    };
    assert_eq!(
        to_undo(&first).as_deref(),
        Some("choice of the environment")
    );
    let setup = &mut first.state_mut().session.setup;
    let open = setup.open.as_ref().expect("a scene");
    let mut appearance = open.scene.appearance().clone();
    appearance.environment_level.is_on = false;
    let sky = appearance.environment.as_mut().expect("a sky");
    std::sync::Arc::make_mut(sky).rotation = -0.3;
    setup.dress(appearance);
    let saved = state_of(&first);

    let mut second = harness_of(app());
    second.state_mut().open_state(Box::new(saved.clone()));
    wait(&mut second, |app| !app.is_loading() && is_lit(app));
    second.run_steps(2);
    assert_eq!(state_of(&second), saved);
    assert_eq!(to_undo(&second), None, "a map of the state is no edit");
}

#[test]
fn a_key_saves_the_state_and_its_file_can_be_opened() {
    let folder = std::env::temp_dir().join(format!("neumann-state-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::env::set_current_dir(&folder).expect("a folder");
    let mut harness = harness_of(app());
    change(harness.state_mut());
    harness.run_steps(3);
    let saved = state_of(&harness);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    let notice = |app: &App| {
        let mut texts = app.shell.notices.texts();
        texts.find_map(|text| text.strip_prefix("Saved ").map(PathBuf::from))
    };
    wait(&mut harness, |app| notice(app).is_some());
    let path = notice(harness.state()).expect("it was saved");
    assert_eq!(State::read(&path).expect("a state").0, saved);

    // The header of all layers has it, too.
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::E);
    let picture = |app: &App| {
        let mut texts = app
            .shell
            .notices
            .texts()
            .filter_map(|t| t.strip_prefix("Saved "));
        texts.find(|text| text.ends_with(".exr")).map(PathBuf::from)
    };
    wait(&mut harness, |app| picture(app).is_some());
    let picture = picture(harness.state()).expect("it was saved");
    assert_eq!(State::read(&picture).expect("a state").0, saved);
    let checkpoint = read_exr(&picture).expect("a film");
    assert_eq!(checkpoint.film.n_layers(), 8);
    let features = checkpoint.features.expect("what the camera sees first");
    assert!(features.depth.iter().any(|depth| depth.is_finite()));

    let mut second = harness_of(app());
    let text = path.display().to_string();
    second.state_mut().open_path(text.clone());
    wait(&mut second, |app| !app.is_loading());
    assert_eq!(state_of(&second), saved);
    // What is wrong with a file is told, and what is shown stays.
    std::fs::write(&path, r#"{"scene": "furnace", "layers": 0}"#).expect("a file");
    second.state_mut().open_path(text);
    second.run_steps(2);
    let told = second.state().shell.notices.texts().last();
    let told = told.expect("a notice").to_owned();
    assert!(
        told.contains(".json: layers: 0 is out of range; use 1 to 64"),
        "{told}"
    );
    assert_eq!(state_of(&second), saved);
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn what_does_not_fit_the_scene_is_told_and_left_out() {
    let mut harness = harness_of(app());
    change(harness.state_mut());
    let mut state = state_of(&harness);
    state.edits.materials[0].name = "another".to_owned();
    state.edits.emitters[0].index = 99;
    state.view = "moon".to_owned();
    let mut second = harness_of(app());
    second.state_mut().open_state(Box::new(state));
    wait(&mut second, |app| !app.is_loading());
    let told: Vec<_> = second.state().shell.notices.texts().collect();
    for part in [
        "material 0 called 'another'",
        "material 99",
        "no view 'moon'",
    ] {
        assert!(told.iter().any(|text| text.contains(part)), "{told:?}");
    }
    assert_eq!(second.state().viewing.views.shown().id, "picture");
}
