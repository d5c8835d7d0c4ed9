//! What comes into the window from outside, and what goes out.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::{Mat4, Vec3};
use neumann_core::radiometry::Rgb;
use neumann_core::scene::builtin::builtin;
use neumann_core::scene::description::{
    CameraDescription, InstanceDescription, MaterialDescription, MeshDescription, SceneDescription,
};
use neumann_core::scene::{Scene, Sky};
use neumann_viewer::app::App;
use neumann_viewer::command_line;
use neumann_viewer::file_list::FileList;
use neumann_viewer::panels::Page;
use neumann_viewer::scene_source::Wanted;
use neumann_viewer::setup::Setup;

use crate::{click, harness, press, wait};

#[test]
fn a_bad_path_says_so_and_keeps_the_scene() {
    let mut harness = harness([1280.0, 960.0]);
    press(&mut harness, Key::F2);
    assert_eq!(harness.state().shell.page, Page::Scene);
    harness.get_by_label("Scene path").focus();
    harness.run_steps(2);
    harness
        .get_by_label("Scene path")
        .type_text("no-such-scene.glb");
    harness.run_steps(2);
    click(&mut harness, "Open scene");
    wait(&mut harness, |app| !app.is_loading());
    let notice = harness
        .state()
        .shell
        .notices
        .texts()
        .next()
        .unwrap()
        .to_owned();
    assert!(notice.contains("no-such-scene.glb"), "{notice}");
    assert_eq!(
        harness.state().session.setup.open.as_ref().unwrap().source,
        "furnace"
    );
    press(&mut harness, Key::Escape);
    press(&mut harness, Key::Escape);
    assert_eq!(harness.state().shell.notices.texts().count(), 0);

    harness.state_mut().shell.fields.scene = "cornell".to_owned();
    harness.run_steps(2);
    click(&mut harness, "Open scene");
    wait(&mut harness, |app| !app.is_loading());
    assert_eq!(
        harness.state().session.setup.open.as_ref().unwrap().source,
        "cornell"
    );
    assert_eq!(harness.state().session.link.n_starts(), 2);
}

/// Saves the state by its key; yields its file.
#[cfg(unix)]
fn save_state(harness: &mut Harness<'_, App>) -> PathBuf {
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    let saved = |app: &App| {
        let mut texts = app.shell.notices.texts();
        texts.find_map(|text| text.strip_prefix("Saved ").map(PathBuf::from))
    };
    wait(harness, |app| saved(app).is_some());
    saved(harness.state()).expect("it was saved")
}

#[test]
#[cfg(unix)]
fn the_folder_of_a_saved_file_is_shown_or_its_path_copied() {
    use std::os::unix::fs::PermissionsExt;

    let folder = format!("neumann-folder-test-{}", std::process::id());
    let folder = std::env::temp_dir().join(folder);
    std::fs::create_dir_all(&folder).unwrap();
    let (opener, told) = (folder.join("opener"), folder.join("told"));
    let script = format!("#!/bin/sh\nprintf %s \"$1\" > '{}'\n", told.display());
    std::fs::write(&opener, script).unwrap();
    let permissions = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(&opener, permissions).unwrap();

    let mut harness = harness([1280.0, 720.0]);
    harness.state_mut().shell.background.opener = opener;
    let file = save_state(&mut harness);
    click(&mut harness, "Show folder");
    wait(&mut harness, |app| !app.shell.background.is_busy());
    let shown = std::fs::read_to_string(told).unwrap();
    assert_eq!(Some(Path::new(&shown)), file.parent());
    assert_eq!(harness.state().shell.notices.texts().count(), 0);

    for opener in ["no-such-program", "false"] {
        harness.state_mut().shell.background.opener = PathBuf::from(opener);
        let file = save_state(&mut harness);
        harness.get_by_label("Show folder").click();
        let mut copied = None;
        for _ in 0..1000 {
            harness.step();
            let commands = &harness.output().platform_output.commands;
            copied = commands.iter().find_map(|command| match command {
                egui::OutputCommand::CopyText(text) => Some(text.clone()),
                _ => None,
            });
            if copied.is_some() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        assert_eq!(copied, Some(file.display().to_string()), "{opener}");
        let notices: Vec<_> = harness.state().shell.notices.texts().collect();
        let expected = "Copied the path, as no program here shows folders";
        assert_eq!(notices, [expected], "{opener}");
        press(&mut harness, Key::Escape);
        std::fs::remove_file(file).unwrap();
    }
    std::fs::remove_dir_all(folder).unwrap();
}

/// The command has the camera to the bit, and what differs from the defaults.
#[test]
fn the_window_can_be_copied_as_a_command() {
    let mut harness = harness([1280.0, 720.0]);
    let copied = |harness: &Harness<'_, App>| {
        let state = harness.state();
        command_line::of(&state.session, &state.viewing.settings).unwrap()
    };
    let command = copied(&harness);
    assert_eq!(
        command.text,
        "neumann render furnace --integrator pt-mis --size 96x96 --max-bounces 16 --layers 8 \
         --seed 0 --camera 0 --iterations 64 --exposure=-2 --tone none -o furnace-pt-mis.exr \
         -o furnace-pt-mis.png"
    );
    assert!(command.leaves_out.is_empty());

    let setup = &mut harness.state_mut().session.setup;
    let control = setup.camera.as_mut().unwrap();
    control.orbit(glam::Vec2::new(0.3, -0.2));
    control.fly(Vec3::new(0.1, 0.2, 0.3));
    control.set_fov(0.8);
    let camera = control.camera().clone();
    click(&mut harness, "Russian roulette");
    let text = copied(&harness).text;
    assert!(text.contains(" --set roulette=off "), "{text}");
    let after = |option: &str| {
        let words = text.split([' ', '=']);
        let value = words.skip_while(|word| *word != option).nth(1);
        value.unwrap_or_else(|| panic!("{option} in {text}"))
    };
    let place = |option: &str| {
        let numbers = after(option)
            .split(',')
            .map(|number| number.parse().unwrap());
        Vec3::from_slice(&numbers.collect::<Vec<f32>>())
    };
    let matrix = CameraDescription::looking_at(place("--eye"), place("--target"), place("--up"));
    assert_eq!(matrix, camera.world_from_camera);
    let fov: f32 = after("--fov").parse().unwrap();
    assert_eq!(
        neumann_core::scene::description::Projection::Perspective {
            yfov: fov.to_radians()
        },
        camera.projection
    );

    // A sky keeps its turn where the command would give it another one, and edits are told.
    let setup = &mut harness.state_mut().session.setup;
    setup.choose_sky(Some(Sky::Sun));
    let turned = |setup: &mut Setup, rotation: f32| {
        let scene = &setup.open.as_ref().unwrap().scene;
        let mut appearance = scene.appearance().clone();
        let sky = appearance.environment.as_mut().unwrap();
        Arc::make_mut(sky).rotation = rotation;
        appearance.material_levels[0].brightness = 2.0;
        setup.dress(appearance);
    };
    turned(setup, 0.5f32.to_radians());
    let command = copied(&harness);
    assert!(
        command.text.contains(" --env sun --env-rotation 0.5 "),
        "{}",
        command.text
    );
    assert_eq!(command.leaves_out, ["edits of materials and lights"]);
    turned(&mut harness.state_mut().session.setup, 0.0);
    assert!(!copied(&harness).text.contains("rotation"));
    let level = |setup: &mut Setup| {
        let scene = &setup.open.as_ref().unwrap().scene;
        let mut appearance = scene.appearance().clone();
        appearance.material_levels[0].brightness = 1.0;
        setup.dress(appearance);
    };
    level(&mut harness.state_mut().session.setup);

    // It is copied by its key.
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::L);
    harness.run_steps(2);
    let notices: Vec<_> = harness.state().shell.notices.texts().collect();
    assert_eq!(notices, ["Copied the command"]);
}

/// A triangle without light, as a file of the user's own.
fn dark_triangle() -> Arc<Scene> {
    let mesh = MeshDescription {
        name: "triangle".to_owned(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
        ..MeshDescription::default()
    };
    Arc::new(Scene::build(&SceneDescription {
        meshes: vec![mesh],
        instances: vec![InstanceDescription {
            name: "triangle".to_owned(),
            mesh: 0,
            world_from_mesh: Mat4::IDENTITY,
        }],
        ..SceneDescription::default()
    }))
}

fn sky_of(harness: &Harness<'_, App>) -> Option<String> {
    let open = harness
        .state()
        .session
        .setup
        .open
        .as_ref()
        .expect("a scene is open");
    let environment = open.scene.appearance().environment.as_ref();
    environment.map(|e| e.name.clone())
}

#[test]
fn the_default_sky_goes_at_a_click_and_others_can_be_chosen() {
    let mut harness = harness([1280.0, 2400.0]);
    let app = harness.state_mut();
    app.take_scene("triangle.glb".to_owned(), dark_triangle());
    assert!(
        app.viewing.settings.is_auto,
        "files of one's own expose by themselves"
    );
    harness.run_steps(2);
    assert_eq!(sky_of(&harness).as_deref(), Some("studio"));
    click(&mut harness, "Remove sky");
    assert_eq!(sky_of(&harness), None);
    let told: Vec<_> = harness.state().shell.notices.texts().collect();
    assert_eq!(told, ["The sky is removed, and nothing shines now"]);
    click(&mut harness, "Restore sky");
    assert_eq!(sky_of(&harness).as_deref(), Some("studio"));
    assert_eq!(harness.state().shell.notices.texts().count(), 0);
    harness.state_mut().shell.page = Page::Scene;
    harness.run_steps(2);
    click(&mut harness, "Environment");
    click(&mut harness, "Sky: sun");
    assert_eq!(sky_of(&harness).as_deref(), Some("sun"));
    click(&mut harness, "Sky: none");
    assert_eq!(sky_of(&harness), None);
    click(&mut harness, "Restore sky");
    assert_eq!(sky_of(&harness).as_deref(), Some("sun"));
}

#[derive(Debug)]

struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|e| e.to_string())
    }
}

fn drop_on(harness: &mut Harness<'_, App>, path: &Path) {
    let file = Arc::new(Dropped(path.to_owned()));
    harness.input_mut().dropped_files.push(file);
    harness.run_steps(2);
}

/// Pictures twice as wide as high are skies, unless neumann rendered them; a click says otherwise.
#[test]
fn dropped_pictures_are_told_apart_and_can_be_taken_for_the_other() {
    let folder = std::env::temp_dir().join(format!("neumann-dropped-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut harness = harness([1280.0, 720.0]);
    for (name, width, is_sky) in [("wide.exr", 16, true), ("square.exr", 8, false)] {
        let path = folder.join(name);
        let pixels = vec![Rgb::WHITE; width * 8];
        neumann_picture::exr_file::write_image_exr(&path, (width, 8), &pixels, &[])
            .expect("it can be written");
        let has_reference = |app: &App| app.session.picture.reference.is_some();
        let before = sky_of(&harness);
        drop_on(&mut harness, &path);
        let other = if is_sky {
            wait(&mut harness, |app| app.session.setup.sky.is_some());
            assert!(!has_reference(harness.state()));
            "Use as reference"
        } else {
            wait(&mut harness, has_reference);
            "Use as sky"
        };
        let label = harness.query_by_label(other);
        assert!(label.is_some(), "{other}");
        click(&mut harness, other);
        if is_sky {
            wait(&mut harness, has_reference);
            assert_eq!(sky_of(&harness), before, "the sky is as it was");
        } else {
            wait(&mut harness, |app| app.session.setup.sky.is_some());
            assert!(!has_reference(harness.state()));
        }
        harness.state_mut().session.picture.reference = None;
        harness.state_mut().session.setup.choose_sky(None);
        harness.state_mut().session.setup.sky = None;
        harness.run_steps(2);
    }
    std::fs::remove_dir_all(folder).expect("it is ours");
}

#[test]
fn without_a_dialog_a_list_of_files_is_walked_by_keys() {
    let folder = std::env::temp_dir().join(format!("neumann-list-{}", std::process::id()));
    let inner = folder.join("inner");
    std::fs::create_dir_all(&inner).expect("a folder");
    for file in ["a.glb", "b.txt", ".hidden.glb", "inner/c.json"] {
        std::fs::write(folder.join(file), "{}").expect("it can be written");
    }
    let mut harness = harness([1280.0, 720.0]);
    let list = FileList::new(Wanted::Scene, folder.clone());
    assert_eq!(list.names().collect::<Vec<_>>(), ["..", "inner", "a.glb"]);
    harness.state_mut().shell.file_list = Some(list);
    harness.run_steps(3);
    let shown = |harness: &Harness<'_, App>| {
        let list = harness.state().shell.file_list.as_ref();
        list.map(|list| list.folder().to_owned())
    };
    press(&mut harness, Key::Enter);
    assert_eq!(shown(&harness), Some(inner));
    press(&mut harness, Key::Backspace);
    assert_eq!(shown(&harness), Some(folder.clone()));
    let part = harness.state().viewing.settings.part;
    press(&mut harness, Key::ArrowDown);
    assert_eq!(
        harness.state().viewing.settings.part,
        part,
        "the key is its"
    );
    press(&mut harness, Key::Enter);
    assert_eq!(shown(&harness), None);
    wait(&mut harness, |app| {
        app.shell.notices.texts().any(|t| t.contains("a.glb"))
    });
    // Esc closes it and nothing else.
    harness.state_mut().list_files(Wanted::Reference);
    harness.run_steps(2);
    press(&mut harness, Key::Escape);
    assert_eq!(shown(&harness), None);
    assert_eq!(harness.state().shell.notices.texts().count(), 1);
    std::fs::remove_dir_all(folder).expect("it is ours");
}

#[test]
fn enter_loads_what_a_path_field_names() {
    let mut harness = harness([1280.0, 2400.0]);
    harness.state_mut().shell.page = Page::Scene;
    harness.run_steps(2);
    click(&mut harness, "Environment");
    for (field, path) in [
        ("Environment map path", "~/no-such-map.exr"),
        ("Scene path", "~/no-such-scene.glb"),
    ] {
        harness.get_by_label(field).focus();
        harness.run_steps(2);
        harness.get_by_label(field).type_text(path);
        harness.run_steps(2);
        press(&mut harness, Key::Enter);
        let name = &path[2..];
        wait(&mut harness, |app| {
            app.shell.notices.texts().any(|text| text.contains(name))
        });
        let told: Vec<_> = harness.state().shell.notices.texts().collect();
        assert!(told.iter().all(|text| !text.contains('~')), "{told:?}");
    }
}

#[test]
fn automatic_exposure_goes_back_to_what_was_set() {
    let mut harness = harness([1280.0, 720.0]);
    let exposure = |harness: &Harness<'_, App>| harness.state().viewing.settings.exposure_ev;
    assert!((exposure(&harness) + 2.0).abs() < 1e-6, "the furnace's own");
    press(&mut harness, Key::E);
    let set = exposure(&harness);
    let toggle = |harness: &mut Harness<'_, App>| {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::E);
        harness.run_steps(3);
    };
    toggle(&mut harness);
    let automatic = exposure(&harness);
    assert!((automatic - set).abs() > 0.1, "{automatic}");
    toggle(&mut harness);
    assert!((exposure(&harness) - set).abs() < 1e-6);
    // By the switch as well.
    harness.state_mut().shell.page = Page::Display;
    toggle(&mut harness);
    click(&mut harness, "Automatic exposure");
    assert!((exposure(&harness) - set).abs() < 1e-6);
    // What is set meanwhile stays.
    toggle(&mut harness);
    press(&mut harness, Key::E);
    assert!((exposure(&harness) - (automatic + 1.0 / 3.0)).abs() < 1e-5);
}

/// The Cornell box from outside, towards its back wall.
fn room_from_outside() -> Arc<Scene> {
    let room = builtin("cornell").expect("a built-in scene");
    let mut room = room.load().expect("a scene as it comes");
    let (eye, target) = (Vec3::new(0.0, 2.7, -14.0), Vec3::Y * 2.7);
    room.cameras[0].world_from_camera = CameraDescription::looking_at(eye, target, Vec3::Y);
    Arc::new(Scene::build(&room))
}

#[test]
fn backs_are_looked_through_at_a_click_and_solid_at_another() {
    let mut harness = harness([1280.0, 2400.0]);
    let n_notices = |harness: &Harness<'_, App>| harness.state().shell.notices.texts().count();
    assert_eq!(n_notices(&harness), 0, "the furnace is seen from inside");
    let app = harness.state_mut();
    app.take_scene("room.glb".to_owned(), room_from_outside());
    harness.run_steps(2);
    let told: Vec<_> = harness.state().shell.notices.texts().collect();
    let says = |text: &&str| text.starts_with("Backs of single-sided surfaces hide ");
    assert!(told.iter().any(says), "{told:?}");
    let started = |harness: &Harness<'_, App>| {
        let job = harness.state().session.link.started().expect("it renders");
        job.scene.sees_through_backs()
    };
    assert!(!started(&harness));
    click(&mut harness, "Look through");
    assert!(started(&harness));
    assert_eq!(n_notices(&harness), 0);
    harness.state_mut().shell.page = Page::Scene;
    harness.run_steps(2);
    click(&mut harness, "Look through backs");
    assert!(!started(&harness));
    // The switch takes the offer back, and another scene begins anew.
    let app = harness.state_mut();
    app.take_scene("room.glb".to_owned(), room_from_outside());
    harness.run_steps(2);
    assert_eq!(n_notices(&harness), 1);
    click(&mut harness, "Look through backs");
    assert!(started(&harness));
    assert_eq!(n_notices(&harness), 0);
}

/// The model in an unlit hull was shown by the hull alone: once that is looked through, it needs a
/// sky.
#[test]
fn what_stands_in_the_dark_behind_backs_gets_a_sky() {
    let mut harness = harness([1280.0, 960.0]);
    let mesh = |z: f32, material| MeshDescription {
        positions: vec![
            Vec3::new(0.0, 0.0, z),
            Vec3::new(1.0, 0.0, z),
            Vec3::new(0.0, 1.0, z),
        ],
        // The front of the first is away from the camera.
        triangles: vec![if material == 0 { [0, 2, 1] } else { [0, 1, 2] }],
        material: Some(material),
        ..MeshDescription::default()
    };
    let instance = |mesh| InstanceDescription {
        name: String::new(),
        mesh,
        world_from_mesh: Mat4::IDENTITY,
    };
    let hull = MaterialDescription {
        is_unlit: true,
        ..MaterialDescription::default()
    };
    let scene = Scene::build(&SceneDescription {
        meshes: vec![mesh(0.01, 0), mesh(0.0, 1)],
        materials: vec![hull, MaterialDescription::default()],
        instances: vec![instance(0), instance(1)],
        ..SceneDescription::default()
    });
    let app = harness.state_mut();
    app.take_scene("hull.glb".to_owned(), Arc::new(scene));
    harness.run_steps(2);
    assert_eq!(sky_of(&harness), None);
    click(&mut harness, "Look through");
    assert_eq!(sky_of(&harness).as_deref(), Some("studio"));
    click(&mut harness, "Remove sky");
    assert_eq!(sky_of(&harness), None);
}
