//! How the window looks, and that the shader shows what the files show.
//!
//! Both need a graphics adapter; without one the tests say so and pass, unless `CI` is set.

mod support;

use egui::{Key, Rect, Theme, Vec2};
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use egui_kittest::{Harness, HarnessBuilder, SnapshotResults};
use egui_wgpu::{RendererOptions, wgpu};
use neumann_core::film::View;
use neumann_core::radiometry::Rgb;
use neumann_picture::tone::ToneCurve;
use neumann_viewer::app::App;
use neumann_viewer::display::{Draw, FilmGpu, Mode, SharedPlanes, Slot, ViewSettings};
use neumann_viewer::panels::Page;

use support::{app, app_with_photons, app_with_quantities, app_with_race, app_with_techniques};

/// True if there is an adapter; otherwise says so, and fails where tests must really run.
fn has_adapter() -> bool {
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    let instance = wgpu::Instance::new(descriptor);
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()));
    if let Err(error) = &adapter {
        assert!(
            std::env::var_os("CI").is_none(),
            "no graphics adapter: {error}"
        );
        // Through the writer, since tests of a library may not print.
        use std::io::Write;
        let _ = writeln!(std::io::stderr(), "skipped: no graphics adapter ({error})");
    }
    adapter.is_ok()
}

fn builder<State>(size: [f32; 2], theme: Theme) -> HarnessBuilder<State> {
    let state = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
    let gpu = FilmGpu::new(&state.device, &state.queue, state.target_format);
    state.renderer.write().callback_resources.insert(gpu);
    Harness::builder()
        .with_size(size)
        .with_pixels_per_point(1.0)
        .with_theme(theme)
        .renderer(WgpuTestRenderer::from_render_state(state))
}

#[test]
fn the_window_looks_as_it_did() {
    if !has_adapter() {
        return;
    }
    let mut results = SnapshotResults::new();
    for (name, size, theme, view) in [
        ("window_dark", [1280.0, 720.0], Theme::Dark, View::Total),
        ("window_light", [1280.0, 720.0], Theme::Light, View::Term(2)),
        ("window_small", [900.0, 600.0], Theme::Dark, View::Upto(5)),
    ] {
        let mut app = app();
        app.viewing.settings.part = view;
        // The film is no furnace.
        app.viewing.settings.exposure_ev = 0.0;
        let mut harness = builder(size, theme).build_ui_state(|ui, app: &mut App| app.ui(ui), app);
        harness.run_steps(4);
        results.add(harness.try_snapshot(name));
    }
    let size = [1280.0, 720.0];
    let mut app = app_with_techniques();
    app.viewing.settings.exposure_ev = 0.0;
    let mut harness =
        builder(size, Theme::Dark).build_ui_state(|ui, app: &mut App| app.ui(ui), app);
    harness.run_steps(4);
    harness.key_press(Key::V);
    // Each frame makes one picture at least.
    harness.run_steps(32);
    results.add(harness.try_snapshot("techniques"));
    for (name, size, theme) in [
        ("photons", [1280.0, 720.0], Theme::Dark),
        ("photons_small", [640.0, 420.0], Theme::Light),
    ] {
        let mut harness =
            builder(size, theme).build_ui_state(|ui, app: &mut App| app.ui(ui), app_with_photons());
        harness.run_steps(4);
        harness.key_press(Key::P);
        harness.run_steps(4);
        results.add(harness.try_snapshot(name));
    }
    for (name, size, theme) in [
        ("race", [1280.0, 720.0], Theme::Dark),
        ("race_small", [640.0, 420.0], Theme::Light),
    ] {
        let mut app = app_with_race();
        app.viewing.settings.exposure_ev = 0.0;
        let mut harness = builder(size, theme).build_ui_state(|ui, app: &mut App| app.ui(ui), app);
        harness.run_steps(4);
        harness.key_press(Key::K);
        harness.run_steps(4);
        results.add(harness.try_snapshot(name));
    }
    for (name, size, theme, view) in [
        ("normals", [1280.0, 720.0], Theme::Dark, "normal"),
        ("depths_small", [640.0, 420.0], Theme::Light, "depth"),
    ] {
        let mut harness = builder(size, theme)
            .build_ui_state(|ui, app: &mut App| app.ui(ui), app_with_quantities());
        harness.state_mut().shell.show_page(Page::Display);
        harness.run_steps(4);
        let app = harness.state_mut();
        let (views, settings) = (&mut app.viewing.views, &app.viewing.settings);
        let shown = views.show(view, &app.session.setup, settings);
        assert_eq!(shown, Ok(()), "{view}");
        harness.run_steps(4);
        results.add(harness.try_snapshot(name));
    }
}

#[test]
fn the_shader_shows_what_the_files_show() {
    if !has_adapter() {
        return;
    }
    let n = 64;
    let pixels: Vec<Rgb> = (0..n * n)
        .map(|i| {
            let (x, y) = ((i % n) as f32 / 63.0, (i / n) as f32 / 63.0);
            Rgb::new((8.0 * x - 5.0).exp2(), (8.0 * y - 5.0).exp2(), 0.3 * x * y)
        })
        .collect();
    let tones = ToneCurve::ALL.map(|tone| (tone, false, false));
    let looks = [
        (ToneCurve::None, true, false),
        (ToneCurve::None, false, true),
    ];
    for (tone, is_false_colour, is_difference) in tones.into_iter().chain(looks) {
        let settings = ViewSettings {
            tone,
            exposure_ev: 0.5,
            is_false_colour,
            ..ViewSettings::default()
        };
        let reference = Rgb::splat(0.2);
        let planes = SharedPlanes::default();
        planes.lock().put(Slot::HeldA, n, n, &pixels);
        planes
            .lock()
            .put(Slot::Reference, n, n, &vec![reference; n * n]);
        let (look, mut variant) = (settings.look(), settings.variant(false));
        if is_difference {
            variant.mode = Mode::Difference;
        }
        let mut harness = builder([n as f32, n as f32], Theme::Dark).build_ui(move |ui| {
            let rect = Rect::from_min_size(egui::Pos2::ZERO, Vec2::splat(n as f32));
            let draw = Draw {
                planes: planes.clone(),
                left: Slot::HeldA,
                right: if is_difference {
                    Slot::Reference
                } else {
                    Slot::HeldA
                },
                look,
                variant,
                index: 0,
            };
            let callback = egui_wgpu::Callback::new_paint_callback(rect, draw);
            ui.ctx().debug_painter().add(callback);
        });
        harness.run_steps(2);
        let image = harness.render().expect("an adapter renders");
        let mut worst = 0;
        for (shown, radiance) in image.pixels().zip(&pixels) {
            let expected = if is_difference {
                settings.difference_code(*radiance, reference)
            } else {
                settings.code(*radiance)
            };
            for (a, b) in shown.0.into_iter().zip(expected) {
                worst = worst.max(a.abs_diff(b));
            }
        }
        // Where colours are steps of a map, a rounded value may be on the next one.
        let most = if is_false_colour || is_difference {
            4
        } else {
            2
        };
        let what = format!("{tone}, {is_false_colour}, {is_difference}");
        assert!(worst <= most, "{what}: {worst} codes apart");
    }
}
