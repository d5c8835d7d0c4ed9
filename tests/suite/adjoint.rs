//! Is light the same forwards and backwards?
//!
//! Shading normals and refraction make a BSDF differ from its adjoint ([Veach 1997] ch. 5): light
//! tracing must correct what path tracing needs no correction for. Facets much larger than their
//! normals suggest, and glass that radiance squeezes into, would show each error as a factor that
//! varies over the image.

use std::sync::Arc;

use glam::Vec3;
use neumann_core::integrator::method;
use neumann_core::radiometry::Rgb;
use neumann_core::scene::Scene;
use neumann_core::scene::description::{MaterialDescription, VolumeDescription};
use neumann_tests::renders::{Block, Setup};
use neumann_tests::scenes::{Stage, emitter, lambert, looking, rectangle, smooth_octahedron};
use neumann_tests::statistics::Family;

fn compare(name: &str, scene: &Arc<Scene>, layers: std::ops::Range<usize>) {
    let mut family = Family::default();
    let batches = |id: &str, n| {
        Setup::new(scene, 24, 24)
            .by(method(id).expect("a method of the registry"))
            .up_to(4)
            .batches(24, n, 60)
    };
    let expected = batches("pt-mis", 32);
    for id in ["lt", "bdpt"] {
        let found = batches(id, 16);
        for block in Block::grid(&expected.films[0], 3, 3) {
            for layer in layers.clone() {
                let (a, b) = (
                    found.block(block, layer)[1],
                    expected.block(block, layer)[1],
                );
                // Blocks that hardly any light reaches say nothing.
                let least = 0.01 * expected.layer(layer)[1].mean;
                if b.mean <= least || b.standard_error > 0.05 * b.mean {
                    continue;
                }
                let what = format!("{name}, {id}, T{layer}: {a:?} against {b:?}");
                family.add(a.p_value_against(&b, 1e-5), what);
            }
        }
    }
    assert!(family.len() > 12, "{name}: {} comparisons", family.len());
    family.judge();
}

#[test]
fn smooth_normals_on_coarse_facets() {
    let plastic = MaterialDescription {
        base_color: Rgb::new(0.8, 0.7, 0.3),
        metallic: 0.0,
        roughness: 0.5,
        ..MaterialDescription::default()
    };
    let metal = MaterialDescription {
        base_color: Rgb::new(0.9, 0.8, 0.7),
        roughness: 0.5,
        ..MaterialDescription::default()
    };
    let glass = MaterialDescription {
        metallic: 0.0,
        roughness: 0.6,
        transmission: 1.0,
        ..MaterialDescription::default()
    };
    for (name, material) in [
        ("lambert", lambert(0.8)),
        ("plastic", plastic),
        ("metal", metal),
        ("glass", glass),
    ] {
        let mut stage = Stage::default();
        let floor = rectangle(Vec3::ZERO, Vec3::Z * 1.2, Vec3::X * 1.2);
        stage.add("floor", floor, lambert(0.7));
        stage.add("ball", smooth_octahedron(Vec3::Y * 0.7, 0.6), material);
        let lamp = rectangle(Vec3::new(0.8, 1.6, 0.4), Vec3::X * 0.4, Vec3::Z * 0.4);
        stage.add("lamp", lamp, emitter(6.0));
        stage.description.cameras = vec![looking(Vec3::new(0.0, 1.0, 1.4), Vec3::Y * 0.5)];
        compare(name, &stage.scene(), 1..4);
    }
}

/// A slab of rough glass with a wall behind it: radiance is squeezed on the way in and widened on
/// the way out, and the light that is seen inside of it would be off by the square of its index.
#[test]
fn a_slab_of_rough_glass() {
    let glass = MaterialDescription {
        metallic: 0.0,
        roughness: 0.5,
        transmission: 1.0,
        ior: 1.6,
        volume: Some(VolumeDescription {
            attenuation_color: Rgb::splat(0.8),
            attenuation_distance: 1.0,
        }),
        ..MaterialDescription::default()
    };
    let mut stage = Stage::default();
    let (x, y) = (Vec3::X, Vec3::Y);
    let mut slab = rectangle(Vec3::new(0.0, 1.0, 0.1), x, y);
    let back = rectangle(Vec3::new(0.0, 1.0, -0.1), -x, y);
    let first = slab.positions.len() as u32;
    slab.positions.extend(back.positions);
    slab.triangles
        .extend(back.triangles.iter().map(|t| t.map(|i| i + first)));
    stage.add("slab", slab, glass);
    stage.add(
        "wall",
        rectangle(Vec3::new(0.0, 1.0, -0.6), x, y),
        lambert(0.7),
    );
    let lamp = rectangle(Vec3::new(0.0, 2.2, -0.3), Vec3::X * 0.8, Vec3::Z * 0.3);
    stage.add("lamp", lamp, emitter(8.0));
    stage.description.cameras = vec![looking(Vec3::new(0.0, 1.0, 1.0), Vec3::Y)];
    compare("slab", &stage.scene(), 1..5);
}
