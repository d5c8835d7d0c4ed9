//! How many rays a second one thread traces through a big tree, beside Embree if a harness wants
//! it.
//!
//! `cargo run --release -p neumann-tests --example rays -- FREQUENCY [--write FILE] [--rounds N]`
//!
//! The scene is that of `neumann_tests::room`: FREQUENCY 32 makes 205 000 triangles, 100 makes two
//! million. With `--write` the triangles and rays go to a file that `scripts/peers/embree.cpp`
//! reads, so that both programs trace the same rays. Prints one line of JSON: seconds to build, and
//! millions of rays a second of this thread's processor time for camera rays, bounce rays
//! (cosine-distributed from what the camera sees, and so in no order) and shadow rays.

use std::io::Write;
use std::time::Instant;

use glam::Vec3;
use neumann_core::accel::Bvh;
use neumann_core::math::Ray;
use neumann_tests::room::{rays, room_with_spheres};

/// Side of the picture that the camera rays make, pixels.
const SIDE: u32 = 1000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value_of = |name: &str| {
        let at = arguments.iter().position(|a| a == name)?;
        arguments.get(at + 1)
    };
    let frequency: u32 = arguments.first().map_or(Ok(32), |a| a.parse())?;
    let n_rounds: usize = value_of("--rounds").map_or(Ok(1), |a| a.parse())?;

    let triangles = room_with_spheres(frequency);
    let start = Instant::now();
    let bvh = Bvh::new(&triangles);
    let build_seconds = start.elapsed().as_secs_f64();

    let kinds = rays(&bvh, &triangles, SIDE);
    if let Some(path) = value_of("--write") {
        write(path, &triangles, &kinds)?;
    }
    for _ in 0..n_rounds {
        let speed = |rays: &[Ray], trace: &dyn Fn(&Ray) -> bool| {
            let start = thread_seconds();
            let n_hits = rays.iter().filter(|ray| trace(ray)).count();
            let speed = rays.len() as f64 / 1e6 / (thread_seconds() - start);
            (speed, n_hits)
        };
        let [primary, bounce, shadow] = &kinds;
        let closest = |ray: &Ray| bvh.closest_hit(ray).is_some();
        let any = |ray: &Ray| bvh.is_occluded(ray);
        let primary = speed(primary, &closest);
        let bounce = speed(bounce, &closest);
        let shadow = speed(shadow, &any);
        #[allow(clippy::print_stdout, reason = "its output")]
        {
            println!(
                "{{\"program\": \"neumann\", \"triangles\": {}, \"build_s\": {build_seconds:.3}, \
                 \"primary\": {:.3}, \"bounce\": {:.3}, \"shadow\": {:.3}, \
                 \"hits\": [{}, {}, {}]}}",
                triangles.len(),
                primary.0,
                bounce.0,
                shadow.0,
                primary.1,
                bounce.1,
                shadow.1
            );
        }
    }
    Ok(())
}

/// Processor time of this thread, seconds.
fn thread_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Numbers of triangles and of each kind of ray (u32), then nine floats a triangle and seven
/// (origin, direction, length) a ray; little-endian.
fn write(path: &str, triangles: &[[Vec3; 3]], kinds: &[Vec<Ray>; 3]) -> std::io::Result<()> {
    let mut file = std::io::BufWriter::new(std::fs::File::create(path)?);
    for n in [triangles.len()]
        .into_iter()
        .chain(kinds.iter().map(Vec::len))
    {
        file.write_all(&(n as u32).to_le_bytes())?;
    }
    let mut floats = |values: &[f32]| {
        values
            .iter()
            .try_for_each(|v| file.write_all(&v.to_le_bytes()))
    };
    for corner in triangles.iter().flatten() {
        floats(&corner.to_array())?;
    }
    for ray in kinds.iter().flatten() {
        floats(&ray.origin().to_array())?;
        floats(&ray.direction().to_array())?;
        floats(&[ray.t_max()])?;
    }
    Ok(())
}
