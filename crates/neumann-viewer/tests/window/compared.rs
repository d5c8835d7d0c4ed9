//! The picture held against others, and what is saved of it.

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;
use neumann_picture::exr_file::{Metadata, write_exr};
use neumann_picture::png_file::Pixels8;
use neumann_viewer::app::App;
use neumann_viewer::compared::Compared;
use neumann_viewer::display::{Against, Slot};
use neumann_viewer::panels::Page;

use crate::{click, harness, press, wait};

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
    click(&mut harness, "Difference A − B");
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
    click(&mut harness, "Difference from reference");
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
