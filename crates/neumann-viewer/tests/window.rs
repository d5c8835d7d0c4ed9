//! The window through its accessibility tree: what a person can press, and what follows.
//!
//! The renderer is replaced by a small film that never changes, so nothing here depends on time.

mod support;

use std::sync::Arc;

use egui::{Key, Modifiers, Theme};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::{Mat4, Vec3};
use neumann_core::film::{Film, Strategy, TechniqueImage, View};
use neumann_core::integrator::METHODS;
use neumann_core::radiometry::Rgb;
use neumann_core::render::StopRule;
use neumann_core::scene::Scene;
use neumann_core::scene::builtin::builtin;
use neumann_core::scene::description::{
    CameraDescription, InstanceDescription, MaterialDescription, MeshDescription, SceneDescription,
};
use neumann_picture::exr_file::{Metadata, write_exr};
use neumann_picture::photons::PhotonColours;
use neumann_picture::png_file::Pixels8;
use neumann_viewer::ViewOptions;
use neumann_viewer::app::App;
use neumann_viewer::command_line;
use neumann_viewer::compared::Compared;
use neumann_viewer::display::{Against, Slot};
use neumann_viewer::file_list::FileList;
use neumann_viewer::panels::Page;
use neumann_viewer::scene_source::Wanted;
use neumann_viewer::setup::FilmSize;
use neumann_viewer::views::photons::PhotonView;
use neumann_viewer::views::techniques::TechniqueView;

use support::{app, app_of, app_with_photons, app_with_techniques, published, published_with};

fn harness(size: [f32; 2]) -> Harness<'static, App> {
    harness_of(size, app())
}

fn harness_of(size: [f32; 2], app: App) -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size(size)
        .with_pixels_per_point(1.0)
        .with_theme(Theme::Dark)
        .build_ui_state(|ui, app: &mut App| app.ui(ui), app);
    harness.run_steps(4);
    harness
}

fn press(harness: &mut Harness<'_, App>, key: Key) {
    harness.key_press(key);
    harness.run_steps(2);
}

fn click(harness: &mut Harness<'_, App>, label: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(3);
}

#[test]
fn thumbnails_choose_the_view() {
    for size in [[1280.0, 720.0], [900.0, 600.0]] {
        let mut harness = harness(size);
        if size[0] < 1000.0 {
            click(&mut harness, "row: terms");
        }
        click(&mut harness, "term T^2 L_e");
        assert_eq!(harness.state().viewing.settings.part, View::Term(2));
        if size[0] < 1000.0 {
            click(&mut harness, "row: sums");
        }
        click(&mut harness, "sum up to 3");
        assert_eq!(harness.state().viewing.settings.part, View::Upto(3));
        assert_eq!(
            harness.state().session.link.n_starts(),
            1,
            "a view never restarts"
        );
    }
}

/// Where there is no room for all places of the strip it scrolls to the one that is chosen.
#[test]
fn a_long_strip_scrolls_to_what_is_chosen() {
    for size in [[1000.0, 640.0], [640.0, 420.0]] {
        let options = ViewOptions {
            size: Some((96, 96)),
            layers: Some(16),
            ..ViewOptions::default()
        };
        let mut harness = harness_of(size, app_of(published_with(16), options));
        press(&mut harness, Key::Num0);
        harness.run_steps(20);
        let tile = |harness: &Harness<'_, App>, name: &str| {
            let mut found = harness.query_all_by_label(name);
            found.next().map(|node| node.rect())
        };
        let first = tile(&harness, "term L_e").expect("it is seen");
        assert!(tile(&harness, "tail").is_none(), "{size:?}: no room for it");
        assert!(first.width() > 40.0, "{size:?}: {first:?}");
        for _ in 0..16 {
            press(&mut harness, Key::ArrowRight);
        }
        harness.run_steps(20);
        let last = tile(&harness, "tail").expect("the tail is chosen");
        assert!(last.right() <= size[0], "{size:?}: {last:?}");
        assert!(tile(&harness, "term L_e").is_none(), "{size:?}");
    }
}

#[test]
fn keys_choose_the_view() {
    let mut harness = harness([1280.0, 720.0]);
    let mut after = |key: Key, modifiers: Modifiers| {
        harness.key_press_modifiers(modifiers, key);
        harness.run_steps(2);
        harness.state().viewing.settings.part
    };
    assert_eq!(after(Key::Num3, Modifiers::NONE), View::Term(3));
    assert_eq!(after(Key::ArrowRight, Modifiers::NONE), View::Term(4));
    assert_eq!(after(Key::ArrowDown, Modifiers::NONE), View::Upto(4));
    assert_eq!(after(Key::Num1, Modifiers::SHIFT), View::Upto(1));
    assert_eq!(after(Key::ArrowUp, Modifiers::NONE), View::Term(1));
    assert_eq!(after(Key::ArrowLeft, Modifiers::NONE), View::Term(0));
    assert_eq!(after(Key::L, Modifiers::NONE), View::Total);
    assert_eq!(after(Key::Num9, Modifiers::NONE), View::Tail);
    assert_eq!(
        harness.state().session.link.n_starts(),
        1,
        "a view never restarts"
    );
}

#[test]
fn methods_change_by_click_and_by_key_and_keep_camera_and_view() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::Num2);
    let camera = harness.state().session.setup.settings().unwrap().camera;
    click(&mut harness, &format!("method: {}", METHODS[0].id));
    assert_eq!(harness.state().session.setup.method(), METHODS[0]);
    press(&mut harness, Key::CloseBracket);
    assert_eq!(harness.state().session.setup.method(), METHODS[1]);
    press(&mut harness, Key::OpenBracket);
    let app = harness.state();
    let job = app.session.link.started().unwrap();
    assert_eq!(job.settings.method, METHODS[0]);
    assert_eq!(
        job.settings.camera.world_from_camera,
        camera.world_from_camera
    );
    assert_eq!(app.viewing.settings.part, View::Term(2));
    assert_eq!(app.session.link.n_starts(), 4);
}

#[test]
fn a_bad_path_says_so_and_keeps_the_scene() {
    let mut harness = harness([1280.0, 960.0]);
    press(&mut harness, Key::F2);
    assert_eq!(harness.state().shell.page, Page::Scene);
    harness.get_by_label("Path of a scene").focus();
    harness.run_steps(2);
    harness
        .get_by_label("Path of a scene")
        .type_text("no-such-scene.glb");
    harness.run_steps(2);
    click(&mut harness, "Open");
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
    click(&mut harness, "Open");
    wait(&mut harness, |app| !app.is_loading());
    assert_eq!(
        harness.state().session.setup.open.as_ref().unwrap().source,
        "cornell"
    );
    assert_eq!(harness.state().session.link.n_starts(), 2);
}

fn wait(harness: &mut Harness<'_, App>, is_done: impl Fn(&App) -> bool) {
    for _ in 0..1000 {
        harness.run_steps(2);
        if is_done(harness.state()) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("nothing came from the background");
}

#[test]
fn pausing_by_key_and_by_button() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::Space);
    assert!(harness.state().session.link.is_paused());
    click(&mut harness, "Resume rendering");
    assert!(!harness.state().session.link.is_paused());
    let n = harness.state().session.link.n_starts();
    press(&mut harness, Key::R);
    assert_eq!(harness.state().session.link.n_starts(), n + 1);
}

#[test]
fn a_slider_steps_with_the_keyboard_and_resets() {
    let mut harness = harness([1280.0, 960.0]);
    assert_eq!(harness.state().session.setup.max_bounces, 16);
    harness
        .get_by_role_and_label(egui::accesskit::Role::Slider, "Longest path")
        .focus();
    harness.run_steps(2);
    press(&mut harness, Key::ArrowRight);
    assert_eq!(harness.state().session.setup.max_bounces, 17);
    assert_eq!(
        harness.state().viewing.settings.part,
        View::Total,
        "the arrow stays with the slider"
    );
    assert_eq!(harness.state().session.link.n_starts(), 2);
    click(&mut harness, "Reset longest path");
    assert_eq!(harness.state().session.setup.max_bounces, 16);
}

#[test]
fn parameters_of_the_method_can_be_changed() {
    let mut harness = harness([1280.0, 960.0]);
    let method = harness.state().session.setup.method();
    let parameter = method.parameters.first().expect("pt-mis has roulette");
    let before = harness.state().session.setup.settings().unwrap().values;
    click(&mut harness, parameter.title);
    let after = harness
        .state()
        .session
        .link
        .started()
        .unwrap()
        .settings
        .values
        .clone();
    assert_ne!(before, after);
}

#[test]
fn stopping_after_iterations_does_not_restart() {
    let mut harness = harness([1280.0, 960.0]);
    click(&mut harness, "Stop after: iterations");
    assert_eq!(
        harness.state().session.setup.stop,
        StopRule::Iterations(256)
    );
    assert_eq!(harness.state().session.link.n_starts(), 1);
}

#[test]
fn tab_hides_the_panels_and_f6_gives_them_the_keyboard() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::Tab);
    assert!(harness.state().shell.is_bare);
    press(&mut harness, Key::Tab);
    assert!(!harness.state().shell.is_bare);
    press(&mut harness, Key::Tab);
    press(&mut harness, Key::F6);
    assert!(!harness.state().shell.is_bare);
    assert!(harness.get_by_label("Method").is_focused(), "its page");
    press(&mut harness, Key::F6);
    assert!(harness.ctx.memory(|m| m.focused()).is_none());
    press(&mut harness, Key::F6);
    press(&mut harness, Key::Tab);
    assert!(
        !harness.state().shell.is_bare,
        "Tab goes on to the next control"
    );
    press(&mut harness, Key::Escape);
    assert!(harness.ctx.memory(|m| m.focused()).is_none());
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

    // It is copied by its key.
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::L);
    harness.run_steps(2);
    let notices: Vec<_> = harness.state().shell.notices.texts().collect();
    assert_eq!(notices, ["Copied the command"]);
}

/// A film that is worth something keeps its size, whatever becomes of the window; it gets another
/// one by wish, or where it begins anew anyway.
#[test]
fn panels_and_window_change_their_size_and_the_film_keeps_its_own() {
    let app = app_of(published(), ViewOptions::default());
    let mut harness = harness_of([1280.0, 720.0], app);
    let size = harness.state().session.setup.size;
    assert_eq!(size.0, size.1, "the camera of the scene asks for a square");
    assert!(size.1 > 400, "it fills the room: {size:?}");
    press(&mut harness, Key::Tab);
    std::thread::sleep(std::time::Duration::from_millis(250));
    harness.run_steps(2);
    harness.set_size(egui::vec2(1000.0, 640.0));
    harness.run_steps(2);
    std::thread::sleep(std::time::Duration::from_millis(250));
    harness.run_steps(2);
    let session = &harness.state().session;
    assert_eq!(session.setup.size, size);
    assert_eq!(session.link.n_starts(), 1);
    assert!(session.can_fit());

    // By wish, and the old picture is there meanwhile.
    harness.key_press_modifiers(Modifiers::SHIFT, Key::Z);
    harness.run_steps(3);
    let session = &harness.state().session;
    assert_eq!(session.setup.size, (640, 640));
    assert_eq!(session.link.n_starts(), 2);
    assert!(!session.can_fit());

    // Not while a picture is held, which the next one is to be compared with.
    press(&mut harness, Key::H);
    press(&mut harness, Key::Tab);
    press(&mut harness, Key::CloseBracket);
    assert_eq!(harness.state().session.setup.size, (640, 640));
    harness.state_mut().session.picture.held[0] = None;

    // With what begins anew anyway.
    assert_eq!(harness.state().session.setup.size, (640, 640));
    press(&mut harness, Key::CloseBracket);
    let room = harness.state().session.setup.size;
    assert!(room.1 < 640, "{room:?}");

    // Not if it is to stay.
    harness.state_mut().session.setup.film_size = FilmSize::Locked;
    press(&mut harness, Key::Tab);
    press(&mut harness, Key::CloseBracket);
    assert_eq!(harness.state().session.setup.size, room);
}

/// A film of a tenth of a second, which follows the room when that has come to rest.
fn app_with_young_film() -> App {
    let mut published = published();
    published.stats.seconds = 0.1;
    app_of(published, ViewOptions::default())
}

fn rest(harness: &mut Harness<'_, App>) {
    for _ in 0..2 {
        harness.run_steps(3);
        std::thread::sleep(std::time::Duration::from_millis(250));
    }
    harness.run_steps(3);
}

#[test]
fn text_grows_and_shrinks_and_even_a_young_film_stays() {
    let mut harness = harness_of([1280.0, 720.0], app_with_young_film());
    let size = harness.state().session.setup.size;
    let mut factor_after = |key: Key, n: usize| {
        for _ in 0..n {
            harness.key_press_modifiers(Modifiers::COMMAND, key);
            harness.run_steps(2);
        }
        rest(&mut harness);
        assert_eq!(harness.state().session.setup.size, size);
        assert_eq!(harness.state().session.link.n_starts(), 1);
        harness.ctx.zoom_factor()
    };
    assert!((factor_after(Key::Plus, 3) - 1.3).abs() < 1e-6);
    assert!((factor_after(Key::Minus, 5) - 0.8).abs() < 1e-6);
    assert!((factor_after(Key::Num0, 1) - 1.0).abs() < 1e-6);
    let most = factor_after(Key::Equals, 40);
    assert!(most > 2.0 && most < 3.0, "bars keep their room: {most}");
    assert!((factor_after(Key::Minus, 40) - 0.5).abs() < 1e-6);
    // The window's own size is another matter.
    harness.set_size(egui::vec2(1000.0, 640.0));
    rest(&mut harness);
    assert_ne!(harness.state().session.setup.size, size);
}

#[test]
fn presenting_shows_method_and_filmstrip_alone_and_large_and_keeps_the_samples() {
    let mut harness = harness_of([1920.0, 1080.0], app_with_young_film());
    let has = |harness: &Harness<'_, App>, label: &str| harness.query_by_label(label).is_some();
    let method = format!("method: {}", METHODS[3].name);
    assert_eq!(harness.state().session.setup.method(), METHODS[3]);
    press(&mut harness, Key::F5);
    rest(&mut harness);
    assert!(harness.ctx.zoom_factor() >= 2.0);
    assert!(has(&harness, &method) && has(&harness, "term T^2 L_e"));
    assert!(!has(&harness, "Pause rendering") && !has(&harness, "Scene"));
    click(&mut harness, "sum up to 3");
    assert_eq!(harness.state().viewing.settings.part, View::Upto(3));
    assert_eq!(harness.state().session.link.n_starts(), 1);
    press(&mut harness, Key::Escape);
    rest(&mut harness);
    assert!(has(&harness, "Pause rendering") && !has(&harness, &method));
    assert_eq!(harness.ctx.zoom_factor(), 1.0);
    assert_eq!(harness.state().session.link.n_starts(), 1);
    // A page that is asked for is shown.
    press(&mut harness, Key::F5);
    press(&mut harness, Key::F2);
    assert!(!harness.state().shell.is_presenting);
}

#[test]
fn display_keys_do_not_render_anew() {
    let mut harness = harness([1280.0, 720.0]);
    for key in [Key::E, Key::T, Key::C, Key::Plus, Key::Plus, Key::X] {
        press(&mut harness, key);
    }
    let app = harness.state();
    assert!((app.viewing.settings.exposure_ev - (1.0 / 3.0 - 2.0)).abs() < 1e-6);
    assert!(app.viewing.settings.is_false_colour && app.viewing.settings.is_wiping);
    assert!(app.viewing.settings.zoom.is_some());
    assert_eq!(app.session.link.n_starts(), 1);
}

#[test]
fn the_camera_moves_and_comes_home() {
    let mut harness = harness([1280.0, 720.0]);
    let home = harness.state().session.setup.camera.as_ref().unwrap().eye();
    press(&mut harness, Key::W);
    assert_ne!(
        harness.state().session.setup.camera.as_ref().unwrap().eye(),
        home
    );
    press(&mut harness, Key::Home);
    assert_eq!(
        harness.state().session.setup.camera.as_ref().unwrap().eye(),
        home
    );
}

/// The ground of the built-in `sky` is eighty metres wide, and its largest ball not two.
#[test]
fn all_is_framed_without_the_ground_and_the_wheel_changes_how_fast_one_flies() {
    let mut harness = harness([1280.0, 720.0]);
    let sky = builtin("sky").expect("a built-in scene");
    let sky = sky.load().expect("a scene as it comes");
    let scene = Arc::new(Scene::build(&sky));
    harness
        .state_mut()
        .take_scene("sky".to_owned(), Arc::clone(&scene));
    harness.run_steps(2);
    press(&mut harness, Key::F);
    let camera = |harness: &Harness<'_, App>| harness.state().session.setup.camera.clone().unwrap();
    let framed = camera(&harness);
    let distance = (framed.eye() - framed.target()).length();
    assert!(distance > 3.0 && distance < 12.0, "{distance} m away");
    let aimed = (framed.target() - Vec3::Y * framed.target().y).length();
    assert!(aimed < 3.0, "at what stands there: {}", framed.target());

    let step = |harness: &mut Harness<'_, App>| {
        let before = camera(harness).eye();
        press(harness, Key::D);
        (camera(harness).eye() - before).length()
    };
    let slow = step(&mut harness);
    assert!(slow > 0.0 && slow < distance / 4.0, "{slow} m");
    let middle = harness.get_by_label_contains("picture: ").rect().center();
    harness.hover_at(middle);
    harness.key_down(Key::D);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 4.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(20);
    harness.key_up(Key::D);
    harness.run_steps(2);
    let now = camera(&harness);
    let apart = (now.eye() - now.target()).length();
    assert!((apart - distance).abs() < 1e-3, "the wheel does not dolly");
    let fast = step(&mut harness);
    assert!(fast > 1.5 * slow, "{slow} m, then {fast} m");
}

#[test]
fn the_title_names_scene_and_method_and_cameras_stand_on_their_page() {
    let mut harness = harness([1280.0, 720.0]);
    assert_eq!(harness.state().title(), "furnace – pt-mis – neumann");
    press(&mut harness, Key::CloseBracket);
    assert_eq!(harness.state().title(), "furnace – drt – neumann");
    let room = builtin("cornell").expect("a built-in scene");
    let mut room = room.load().expect("a scene as it comes");
    room.cameras[0].name = "front".to_owned();
    let mut back = room.cameras[0].clone();
    back.name = "back".to_owned();
    back.world_from_camera.w_axis.z += 1.0;
    room.cameras.push(back.clone());
    let scene = Arc::new(Scene::build(&room));
    harness.state_mut().take_scene("room.glb".to_owned(), scene);
    harness.state_mut().shell.page = Page::Scene;
    harness.run_steps(2);
    assert!(harness.query_by_label("back").is_none());
    press(&mut harness, Key::F3);
    click(&mut harness, "back");
    let camera = harness.state().session.setup.settings().unwrap().camera;
    assert_eq!(camera.world_from_camera, back.world_from_camera);
    assert_eq!(harness.state().title(), "room – drt – neumann");
}

#[test]
fn figures_choices_and_items_of_the_bar_say_what_they_are() {
    let mut harness = harness([1280.0, 720.0]);
    let bar = harness.get_by_label("method: bdpt").rect().center();
    let pause = harness.get_by_label("Pause rendering").rect().center();
    let status = harness.get_by_label_contains("estimated error").rect();
    let choice = harness.get_by_label("Choose lights: tree").rect().center();
    for (at, about) in [
        (bar, "Bidirectional path tracing. "),
        (pause, "Keeps all samples"),
        (
            status.left_center() + egui::vec2(24.0, 0.0),
            "Complete estimates",
        ),
        (choice, "The light to aim at is chosen"),
    ] {
        harness.hover_at(at);
        for _ in 0..8 {
            std::thread::sleep(std::time::Duration::from_millis(100));
            harness.run_steps(4);
        }
        let n = harness.query_all_by_label_contains(about).count();
        assert!(n > 0, "{about}");
    }
}

#[test]
fn a_light_can_be_switched_off_and_a_material_edited() {
    let mut harness = harness([1280.0, 2400.0]);
    press(&mut harness, Key::F2);
    let app = harness.state_mut();
    let material = app
        .session
        .setup
        .open
        .as_ref()
        .unwrap()
        .scene
        .appearance()
        .materials[0]
        .name
        .clone();
    harness.run_steps(2);
    click(&mut harness, &material);
    let scene = &harness.state().session.setup.open.as_ref().unwrap().scene;
    assert!(!scene.appearance().material_levels[0].is_on);
    assert_eq!(harness.state().session.link.n_starts(), 2);
}

#[test]
fn help_lists_the_keys_and_escape_closes_it() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::Questionmark);
    assert!(harness.state().shell.is_help_open);
    assert!(harness.query_by_label("keys").is_some());
    press(&mut harness, Key::Escape);
    assert!(!harness.state().shell.is_help_open);
}

#[test]
fn every_method_can_be_reached_and_keeps_camera_view_and_exposure() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::Num3);
    press(&mut harness, Key::E);
    let camera = harness.state().session.setup.settings().unwrap().camera;
    let first = harness.state().session.setup.method;
    for (key, step) in [
        (Key::CloseBracket, 1),
        (Key::OpenBracket, METHODS.len() - 1),
    ] {
        for n in 1..=METHODS.len() {
            press(&mut harness, key);
            let app = harness.state();
            let expected = METHODS[(first + n * step) % METHODS.len()];
            let job = app.session.link.started().unwrap();
            assert_eq!(job.settings.method, expected);
            assert_eq!(
                job.settings.camera.world_from_camera,
                camera.world_from_camera
            );
            assert_eq!(app.viewing.settings.part, View::Term(3));
            assert!((app.viewing.settings.exposure_ev - (1.0 / 3.0 - 2.0)).abs() < 1e-6);
        }
    }
}

fn techniques<'a>(harness: &'a Harness<'_, App>) -> &'a TechniqueView {
    harness.state().viewing.views.get().expect("a row of VIEWS")
}

fn is_apart(harness: &Harness<'_, App>) -> bool {
    harness.state().viewing.views.shown().id == "techniques"
}

#[test]
fn techniques_open_enlarge_and_close() {
    for size in [[1280.0, 720.0], [900.0, 600.0]] {
        let mut harness = harness_of(size, app_with_techniques());
        assert!(!harness.state().session.link.is_recording());
        press(&mut harness, Key::V);
        assert!(harness.state().session.link.is_recording());
        for strategy in ["s=0 t=2", "s=0 t=3", "s=1 t=2", "s=1 t=3", "s=2 t=2"] {
            let label = format!("technique {strategy}");
            assert!(harness.query_by_label(&label).is_some(), "{label}");
        }
        let sum: f64 = techniques(&harness).techniques().map(|t| t.1).sum();
        assert!(sum > 0.5 && sum < 1.0 + 1e-6, "shares add up to {sum}");
        click(&mut harness, "technique image: raw");
        assert_eq!(techniques(&harness).image, TechniqueImage::Raw);
        click(&mut harness, "technique s=1 t=2");
        let enlarged = techniques(&harness).enlarged;
        assert_eq!(enlarged, Some(Strategy::connect(1, 2)));
        click(&mut harness, "enlarged technique s=1 t=2");
        assert_eq!(techniques(&harness).enlarged, None);
        click(&mut harness, "technique s=1 t=3");
        press(&mut harness, Key::F6);
        press(&mut harness, Key::Escape);
        assert!(harness.ctx.memory(|m| m.focused()).is_none());
        assert!(techniques(&harness).enlarged.is_some());
        press(&mut harness, Key::Escape);
        assert!(is_apart(&harness), "back to all of them");
        press(&mut harness, Key::Escape);
        assert!(!is_apart(&harness));
        assert!(!harness.state().session.link.is_recording());
        assert_eq!(
            harness.state().session.link.n_starts(),
            1,
            "a view never restarts"
        );
    }
}

#[test]
fn what_is_saved_is_what_is_shown() {
    let mut harness = harness_of([1280.0, 720.0], app_with_techniques());
    let saved = |harness: &Harness<'_, App>| {
        let app = harness.state();
        let image = app
            .viewing
            .views
            .image(&app.session, &app.viewing.settings)
            .expect("there is something to save");
        let pixels = (image.pixels)();
        (image.name, pixels.width, pixels.height)
    };
    assert_eq!(saved(&harness), ("L".to_owned(), 96, 96));
    press(&mut harness, Key::V);
    let (name, width, _) = saved(&harness);
    assert_eq!(name, "techniques");
    assert!(width > 32 * 5, "all of them on a sheet");
    click(&mut harness, "technique s=1 t=2");
    let name = format!("s=1 t=2-{}", TechniqueImage::default().name());
    assert_eq!(saved(&harness), (name, 32, 32));
}

/// A folder that goes with the test.
struct Folder(std::path::PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let name = format!("neumann-window-{name}-{}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).expect("a folder of its own");
        Self(path)
    }

    fn write(&self, name: &str, film: &Film, metadata: &Metadata) -> std::path::PathBuf {
        let path = self.0.join(name);
        write_exr(&path, film, None, metadata).expect("it can be written");
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A film whose term k is 2^-k everywhere, and whose tail is 1/2.
fn even_film(width: usize, height: usize) -> Film {
    let term = |value: f32| vec![Rgb::splat(value); width * height];
    let mut layers: Vec<_> = (0..8).map(|k| term(0.5f32.powi(k))).collect();
    layers.push(term(0.5));
    let total = layers.iter().map(|layer| layer[0].r).sum();
    let film = Film::from_parts((width, height), 512, layers, term(total), &term(1e-4), 0);
    film.expect("planes of one size")
}

/// How the film of the window was made, had it the iterations of [`even_film`].
fn metadata_of(harness: &Harness<'_, App>) -> Metadata {
    let (_, metadata) = harness.state().session.film().expect("there is a film");
    Metadata {
        iterations: "0-511".parse().expect("a range"),
        seconds: 12.0,
        ..metadata
    }
}

fn load(harness: &mut Harness<'_, App>, path: std::path::PathBuf) {
    let n_taken = harness.state().session.picture.n_taken;
    harness.state_mut().shell.background.open_reference(path);
    wait(harness, |app| app.session.picture.n_taken > n_taken);
    harness.run_steps(2);
}

fn compared(harness: &Harness<'_, App>) -> Compared {
    let app = harness.state();
    Compared::of(&app.session, &app.viewing.settings)
}

/// The radiance that the screen has in the middle of a slot.
fn on_screen(harness: &Harness<'_, App>, slot: Slot) -> f32 {
    let planes = harness.state().session.picture.planes.lock();
    let plane = planes.plane(slot);
    let middle = 4 * (plane.height / 2 * plane.width + plane.width / 2);
    plane.pixels[middle].to_f32() * plane.scale
}

fn says(harness: &Harness<'_, App>, text: &str) -> bool {
    harness.query_all_by_label_contains(text).count() > 0
}

#[test]
fn a_difference_holds_each_part_against_the_same_part() {
    for size in [[1280.0, 720.0], [640.0, 420.0]] {
        let mut harness = harness(size);
        let folder = Folder::new(&format!("parts-{}", size[0]));
        let metadata = metadata_of(&harness);
        let path = folder.write("even.exr", &even_film(96, 96), &metadata);
        load(&mut harness, path);
        let terms = 2.0 - 0.5f32.powi(7);
        assert!((on_screen(&harness, Slot::Reference) - terms - 0.5).abs() < 0.01);
        assert!(says(&harness, "compared: picture − even.exr"));
        let here = harness.state().session.origin().expect("it is known");
        assert!(says(&harness, &format!("picture:  L · {}", here.words())));
        let there = format!("even.exr:  L · {} · 512 iterations · 12.0 s", here.method);
        assert!(says(&harness, &there), "{there}");
        assert!(!says(&harness, "cameras"));
        for (key, modifiers, expected, name) in [
            (Key::Num2, Modifiers::NONE, 0.25, "T2"),
            (Key::Num3, Modifiers::SHIFT, 1.875, "upto:3"),
            (Key::Num9, Modifiers::NONE, 0.5, "tail"),
        ] {
            harness.key_press_modifiers(modifiers, key);
            harness.run_steps(3);
            let shown = on_screen(&harness, Slot::Reference);
            assert!((shown - expected).abs() < 2e-3, "{name}: {shown}");
            assert!(says(&harness, &format!("even.exr:  {name} ·")), "{name}");
            let Compared::Difference([picture, reference]) = compared(&harness) else {
                panic!("{name} is compared");
            };
            let app = harness.state();
            let pixels = reference.pixels(&app.session).pixels;
            assert!((pixels[0].r - expected).abs() < 1e-6, "{name}");
            assert_eq!((picture.part, reference.part), (picture.part, picture.part));
        }
        let n_starts = harness.state().session.link.n_starts();
        assert_eq!(n_starts, 1, "a comparison never restarts");
    }
}

#[test]
fn what_cannot_be_compared_is_refused_in_a_sentence() {
    let mut harness = harness([1280.0, 720.0]);
    let folder = Folder::new("refused");
    let metadata = metadata_of(&harness);
    let refusal = |harness: &Harness<'_, App>| match compared(harness) {
        Compared::Refused(why) => {
            assert!(says(harness, &why), "{why}");
            why
        }
        other => panic!("{other:?}"),
    };
    // Of another size.
    let path = folder.write("small.exr", &even_film(48, 96), &metadata);
    load(&mut harness, path);
    let why = refusal(&harness);
    assert!(why.contains("96×96") && why.contains("48×96"), "{why}");
    // Of another scene.
    let other = Metadata {
        scene: "somewhere else".to_owned(),
        ..metadata.clone()
    };
    let path = folder.write("other.exr", &even_film(96, 96), &other);
    load(&mut harness, path);
    assert!(refusal(&harness).contains("'somewhere else'"));
    // Seen by another camera: that is said, no more.
    let elsewhere = Metadata {
        camera: "perspective 1; pinhole; elsewhere".to_owned(),
        ..metadata.clone()
    };
    let path = folder.write("elsewhere.exr", &even_film(96, 96), &elsewhere);
    load(&mut harness, path);
    assert!(matches!(compared(&harness), Compared::Difference(_)));
    assert!(says(&harness, "seen by two different cameras"));
    // Without layers.
    let path = folder.0.join("plain.png");
    let pixels = Pixels8 {
        width: 96,
        height: 96,
        pixels: vec![[128; 3]; 96 * 96],
    };
    neumann_picture::png_file::write_png(&path, &pixels).expect("it can be written");
    load(&mut harness, path);
    assert!(matches!(compared(&harness), Compared::Difference(_)));
    press(&mut harness, Key::Num2);
    let why = refusal(&harness);
    assert_eq!(
        why,
        "No difference: the reference plain.png has only L, not T2"
    );
    // A has one part alone, as it was held.
    press(&mut harness, Key::H);
    harness.state_mut().shell.refer_to_held(0);
    harness.run_steps(3);
    assert!(matches!(compared(&harness), Compared::Difference(_)));
    press(&mut harness, Key::L);
    assert_eq!(
        refusal(&harness),
        "No difference: the reference A has only T2, not L"
    );
}

#[test]
fn what_is_held_can_be_subtracted() {
    let mut harness = harness([1280.0, 960.0]);
    press(&mut harness, Key::Num1);
    press(&mut harness, Key::H);
    harness.state_mut().viewing.settings.difference = Some(Against::Held);
    harness.run_steps(2);
    assert!(says(&harness, "compared: A − B (live)"));
    press(&mut harness, Key::Num2);
    assert_eq!(
        compared(&harness),
        Compared::Refused("No difference: A is T1, B (live) is T2".to_owned())
    );
    // Side by side they may differ in their part, not in their size.
    press(&mut harness, Key::X);
    assert!(matches!(compared(&harness), Compared::Wipe(_)));
    if let Some(held) = &mut harness.state_mut().session.picture.held[0] {
        held.size = (48, 32);
    }
    let why = "No wipe: A has 48×32 pixels, B (live) has 96×96".to_owned();
    assert_eq!(compared(&harness), Compared::Refused(why));
}

#[test]
fn the_page_display_takes_what_is_held_as_the_reference() {
    let mut harness = harness([1280.0, 1400.0]);
    press(&mut harness, Key::F4);
    assert_eq!(harness.state().shell.page, Page::Display);
    press(&mut harness, Key::Num1);
    click(&mut harness, "Hold as A");
    press(&mut harness, Key::Num2);
    click(&mut harness, "Hold as B");
    click(&mut harness, "A − B");
    let why = "No difference: A is T1, B is T2";
    assert_eq!(compared(&harness), Compared::Refused(why.to_owned()));
    assert!(says(&harness, why));
    click(&mut harness, "Use B as reference");
    assert!(says(&harness, "compared: picture − B"));
    click(&mut harness, "Use A as reference");
    let why = "No difference: the reference A has only T1, not T2";
    assert_eq!(compared(&harness), Compared::Refused(why.to_owned()));
    press(&mut harness, Key::Num1);
    assert!(says(&harness, "compared: picture − A"));
    click(&mut harness, "Difference");
    assert_eq!(compared(&harness), Compared::Nothing);
}

#[test]
fn how_far_two_pictures_are_apart_is_measured_meanwhile() {
    let mut harness = harness([1280.0, 960.0]);
    let folder = Folder::new("measured");
    let path = folder.write("even.exr", &even_film(96, 96), &metadata_of(&harness));
    load(&mut harness, path);
    press(&mut harness, Key::Num2);
    let of = |app: &App| {
        let compared = Compared::of(&app.session, &app.viewing.settings);
        app.session.measuring.of(&app.session, &compared)
    };
    wait(&mut harness, |app| of(app).is_some());
    let app = harness.state();
    let measured = of(app).expect("it is there");
    let film = app.session.film().expect("there is a film").0;
    let image = |film: &Film| {
        let mut pixels = vec![Rgb::BLACK; film.n_pixels()];
        film.compose(View::Term(2), &mut pixels);
        neumann_picture::Image {
            width: film.width(),
            height: film.height(),
            pixels,
            ..Default::default()
        }
    };
    let display = app.viewing.settings.display();
    let expected =
        neumann_picture::compare::compare(&image(&film), &image(&even_film(96, 96)), &display);
    let expected = expected.expect("both have one size");
    assert_eq!(measured.rel_mse, expected.rel_mse);
    assert_eq!(measured.flip, expected.flip);
    harness.run_steps(2);
    assert!(says(&harness, &measured.words()), "{}", measured.words());
}

#[test]
fn the_probe_reads_what_is_compared() {
    let mut harness = harness([1280.0, 720.0]);
    let folder = Folder::new("probe");
    let path = folder.write("even.exr", &even_film(96, 96), &metadata_of(&harness));
    load(&mut harness, path);
    press(&mut harness, Key::Num2);
    let read = |harness: &Harness<'_, App>, fraction| {
        let app = harness.state();
        let (session, settings) = (&app.session, &app.viewing.settings);
        neumann_viewer::views::picture::read(session, settings, fraction).lines
    };
    // The film has x/8 in red there, and the reference 1/4.
    assert_eq!(
        read(&harness, [0.999, 0.999]),
        [
            "x 95  y 95",
            "picture  0.125  0.125  0",
            "even.exr  0.25  0.25  0.25",
            "difference  -0.125  -0.125  -0.25",
            "W m⁻² sr⁻¹"
        ]
    );
    press(&mut harness, Key::H);
    press(&mut harness, Key::Num1);
    press(&mut harness, Key::X);
    assert_eq!(
        read(&harness, [0.0, 0.999])[..2],
        ["A  x 0  y 95", "0  0.125  0.125"]
    );
    let right = read(&harness, [0.999, 0.999]);
    assert_eq!(right[..2], ["B (live)  x 95  y 95", "0.25  0.25  0"]);
}

#[test]
fn what_is_saved_is_what_the_screen_shows() {
    let mut harness = harness([1280.0, 720.0]);
    let folder = Folder::new("saved");
    let saved = |harness: &Harness<'_, App>| {
        let app = harness.state();
        let image = app.viewing.views.image(&app.session, &app.viewing.settings);
        let image = image.expect("there is something to save");
        (image.name, (image.pixels)())
    };
    let has_row = |page: &Pixels8, row: &[[u8; 3]]| page.pixels.windows(96).any(|w| w == row);
    // Row 95 of the film's T2.
    let row: Vec<Rgb> = (0..96)
        .map(|x| {
            let x = x as f32 / 95.0;
            Rgb::new(x, 1.0, 1.0 - x) * 0.125
        })
        .collect();
    press(&mut harness, Key::Num2);
    press(&mut harness, Key::C);
    let (name, page) = saved(&harness);
    assert_eq!(name, "T2-luminance");
    let settings = harness.state().viewing.settings.clone();
    let coloured: Vec<_> = row.iter().map(|p| settings.code(*p)).collect();
    assert!(has_row(&page, &coloured), "false colours");
    let top = settings.scale(false).colours[255];
    assert!(page.pixels.contains(&top), "their legend");
    press(&mut harness, Key::C);

    press(&mut harness, Key::H);
    press(&mut harness, Key::Num1);
    press(&mut harness, Key::X);
    let (name, page) = saved(&harness);
    assert_eq!(name, "wipe");
    let settings = harness.state().viewing.settings.clone();
    let mut both: Vec<_> = row.iter().map(|p| settings.code(*p)).collect();
    for (x, code) in both.iter_mut().enumerate().skip(49) {
        *code = settings.code(row[x] * 2.0);
    }
    assert!(page.pixels.windows(48).any(|w| w == &both[..48]), "A is T2");
    assert!(page.pixels.windows(47).any(|w| w == &both[49..]), "B is T1");

    let path = folder.write("even.exr", &even_film(96, 96), &metadata_of(&harness));
    load(&mut harness, path);
    press(&mut harness, Key::Num2);
    let (name, page) = saved(&harness);
    assert_eq!(name, "T2-difference");
    let settings = harness.state().viewing.settings.clone();
    let apart = |p: &Rgb| settings.difference_code(*p, Rgb::splat(0.25));
    let apart: Vec<_> = row.iter().map(apart).collect();
    assert!(has_row(&page, &apart), "the difference");
    let end = settings.scale(true).colours[255];
    assert!(page.pixels.contains(&end), "its legend");
}

#[test]
fn techniques_close_with_their_method_and_with_another_view() {
    let mut harness = harness_of([1280.0, 720.0], app_with_techniques());
    click(&mut harness, "Show techniques");
    assert!(harness.state().session.link.is_recording());
    press(&mut harness, Key::CloseBracket);
    assert!(!is_apart(&harness), "pm has none");
    assert!(!harness.state().session.link.is_recording());
    press(&mut harness, Key::V);
    assert!(!is_apart(&harness));
    assert_eq!(harness.state().shell.notices.texts().count(), 1);
    press(&mut harness, Key::OpenBracket);
    press(&mut harness, Key::V);
    press(&mut harness, Key::Num2);
    assert!(!is_apart(&harness), "the view is shown");
}

fn photons<'a>(harness: &'a Harness<'_, App>) -> &'a PhotonView {
    harness.state().viewing.views.get().expect("a row of VIEWS")
}

#[test]
fn photons_are_shown_by_their_key_in_both_colours_and_closed() {
    for size in [[1280.0, 720.0], [640.0, 420.0]] {
        let mut harness = harness_of(size, app_with_photons());
        let shown = |harness: &Harness<'_, App>| harness.state().viewing.views.shown().id;
        assert!(!harness.state().session.link.draws_photons());
        press(&mut harness, Key::P);
        assert_eq!(shown(&harness), "photons");
        assert!(harness.state().session.link.draws_photons());
        let is_said = |harness: &Harness<'_, App>, text: &str| {
            let n = harness.query_all_by_label_contains(text).count();
            assert_eq!(n, 1, "{text}");
        };
        is_said(&harness, "photons by bounce, 9,216 light paths · ");
        is_said(&harness, "legend, bounce, share of photons: 1 ");
        let picture = harness.query_all_by_label_contains("all light").count();
        assert_eq!(picture, 0, "this is no picture of light");
        click(&mut harness, "colour photons by: power");
        assert_eq!(photons(&harness).colours, PhotonColours::Power);
        is_said(&harness, "photons by power, ");
        is_said(&harness, "legend, power in a pixel: ≥ ");
        click(&mut harness, "colour photons by: bounce");
        // A part of the series chooses bounces.
        press(&mut harness, Key::Num2);
        is_said(&harness, "photons by bounce: of bounce 2, ");
        press(&mut harness, Key::Num0);
        is_said(&harness, "no photons: emitted light has none, ");
        press(&mut harness, Key::Escape);
        assert_eq!(shown(&harness), "picture");
        assert!(!harness.state().session.link.draws_photons());
        let n_starts = harness.state().session.link.n_starts();
        assert_eq!(n_starts, 1, "a view never restarts");
    }
}

#[test]
fn photons_are_saved_with_their_legend() {
    let mut harness = harness_of([1280.0, 720.0], app_with_photons());
    press(&mut harness, Key::P);
    let app = harness.state();
    let views = &app.viewing.views;
    let image = views.image(&app.session, &app.viewing.settings);
    let image = image.expect("there is something to save");
    assert_eq!(image.name, "photons-bounce");
    let pixels = (image.pixels)();
    assert!(
        pixels.width > 96 + 200,
        "the legend stands beside the picture"
    );
}

#[test]
fn photons_of_a_method_without_are_refused_in_a_sentence() {
    let mut harness = harness([1280.0, 720.0]);
    press(&mut harness, Key::P);
    assert_eq!(harness.state().viewing.views.shown().id, "picture");
    let notice = harness.state().shell.notices.texts().next();
    let notice = notice.expect("it says why").to_owned();
    assert!(
        notice.ends_with("the photons view needs pm or ppm"),
        "{notice}"
    );
    // Photons close with their method.
    let mut harness = harness_of([1280.0, 720.0], app_with_photons());
    click(&mut harness, "Show photons");
    assert_eq!(harness.state().viewing.views.shown().id, "photons");
    press(&mut harness, Key::OpenBracket);
    assert_eq!(harness.state().viewing.views.shown().id, "picture");
    assert!(!harness.state().session.link.draws_photons());
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
    click(&mut harness, "Put back");
    assert_eq!(sky_of(&harness).as_deref(), Some("studio"));
    assert_eq!(harness.state().shell.notices.texts().count(), 0);
    harness.state_mut().shell.page = Page::Scene;
    harness.run_steps(2);
    click(&mut harness, "Environment");
    click(&mut harness, "Sky: sun");
    assert_eq!(sky_of(&harness).as_deref(), Some("sun"));
    click(&mut harness, "Sky: none");
    assert_eq!(sky_of(&harness), None);
    click(&mut harness, "Put back");
    assert_eq!(sky_of(&harness).as_deref(), Some("sun"));
}

#[derive(Debug)]
struct Dropped(std::path::PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &std::path::Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|e| e.to_string())
    }
}

fn drop_on(harness: &mut Harness<'_, App>, path: &std::path::Path) {
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
        ("Path of a .hdr or .exr map", "~/no-such-map.exr"),
        ("Path of a scene", "~/no-such-scene.glb"),
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
    click(&mut harness, "Automatic");
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
