//! Renders that go on: resumed, merged, in shards, interrupted and killed.

use std::path::Path;
use std::process::Command;

use neumann_picture::exr_file::Checkpoint;

use super::Folder;

/// The largest difference of any channel of any layer, relative to the brightest value.
fn distance(a: &Checkpoint, b: &Checkpoint) -> f32 {
    let (mut largest, mut brightest) = (0f32, 0f32);
    for (a, b) in a.film.layers().iter().zip(b.film.layers()) {
        for (a, b) in a.iter().zip(b) {
            largest = largest.max((*a - b).map(f32::abs).max_channel());
            brightest = brightest.max(a.max_channel());
        }
    }
    assert!(brightest > 0.0, "black films are always alike");
    largest / brightest
}

#[test]
fn resumed_and_merged_renders_equal_the_uninterrupted_one() {
    let folder = Folder::new();
    let base = "render cornell --size 32x32";
    folder.succeed(&format!("{base} -o whole.exr --iterations 24"));
    let whole = folder.film("whole.exr");
    // An interrupted render, finished by the same line.
    folder.succeed(&format!("{base} -o part.exr --iterations 10"));
    assert!(
        distance(&whole, &folder.film("part.exr")) > 1e-3,
        "10 iterations are not 24"
    );
    folder.succeed(&format!("{base} -o part.exr --iterations 24 --resume"));
    let resumed = folder.film("part.exr");
    assert_eq!(resumed.metadata.iterations, whole.metadata.iterations);
    assert!(
        distance(&whole, &resumed) <= 1e-6,
        "{}",
        distance(&whole, &resumed)
    );
    // Two parts, merged in either order.
    folder.succeed(&format!("{base} -o a.exr --iterations 8"));
    folder.succeed(&format!(
        "{base} -o b.exr --iterations 16 --first-iteration 8"
    ));
    folder.succeed("merge b.exr a.exr -o merged.exr");
    folder.succeed("merge a.exr b.exr -o again.exr");
    let merged = folder.film("merged.exr");
    assert_eq!(merged.metadata.iterations.to_string(), "0-23");
    assert!(
        distance(&whole, &merged) <= 1e-6,
        "{}",
        distance(&whole, &merged)
    );
    assert_eq!(distance(&merged, &folder.film("again.exr")), 0.0);
    for pixel in [0, 500, 1000] {
        let (v, w) = (
            whole.film.variance_of_mean(pixel).g,
            merged.film.variance_of_mean(pixel).g,
        );
        assert!((v - w).abs() <= 1e-4 * v.max(1e-12), "{v} {w}");
    }
    // There is nothing left to do.
    folder.succeed(&format!("{base} -o part.exr --iterations 24 --resume"));
    assert_eq!(distance(&resumed, &folder.film("part.exr")), 0.0);
}

#[test]
fn what_does_not_belong_together_is_neither_resumed_nor_merged() {
    let folder = Folder::new();
    let base = "render cornell --size 16x16 --iterations 2";
    folder.succeed(&format!("{base} -o a.exr"));
    let cases = [
        ("--seed 1", "seed"),
        ("--integrator pt-nee", "integrator"),
        ("--max-bounces 3", "max-bounces"),
        ("--fov 20", "camera's projection"),
        ("--eye 0,1,3", "camera's position"),
        ("--layers 3", "layers"),
        ("--size 8x8", "size"),
        ("--backs see-through", "backs"),
    ];
    for (option, field) in cases {
        let base = base.replace(
            if option.starts_with("--size") {
                " --size 16x16"
            } else {
                "\0"
            },
            "",
        );
        let stderr = folder.fail(
            &format!("{base} -o a.exr {option} --iterations 4 --resume")
                .replace(" --iterations 2", ""),
            2,
        );
        assert!(stderr.contains(field), "{option}: {stderr}");
        folder.succeed(&format!("{base} -o b.exr --first-iteration 2 {option}"));
        let stderr = folder.fail("merge a.exr b.exr -o c.exr", 2);
        assert!(stderr.contains(field), "{option}: {stderr}");
    }
    folder.succeed("render furnace --size 16x16 --iterations 2 --first-iteration 2 -o b.exr");
    assert!(
        folder
            .fail("merge a.exr b.exr -o c.exr", 2)
            .contains("scene")
    );
    folder.succeed(&format!("{base} -o b.exr --first-iteration 1"));
    let stderr = folder.fail("merge a.exr b.exr -o c.exr", 2);
    assert!(stderr.contains("iterations 1-1"), "{stderr}");
    assert!(!folder.join("c.exr").exists());
}

#[test]
fn a_killed_render_keeps_what_was_saved_and_goes_on_from_there() {
    let folder = Folder::new();
    let base = "render cornell --size 24x24 -o a.exr";
    let line = format!("{base} --iterations 4000000000 --checkpoint 0.1");
    let mut child = Command::new(env!("CARGO_BIN_EXE_neumann"))
        .args(line.split(' '))
        .current_dir(&folder.0)
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let start = std::time::Instant::now();
    while !folder.join("a.exr").exists() && start.elapsed().as_secs() < 60 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let saved = folder.film("a.exr");
    let n = saved.film.n_iterations();
    assert!(n > 0);
    assert!(saved.features.is_some(), "it is whole");
    folder.succeed(&format!("{base} --iterations {} --resume", n + 3));
    folder.succeed(&format!(
        "render cornell --size 24x24 -o b.exr --iterations {}",
        n + 3
    ));
    assert_eq!(distance(&folder.film("a.exr"), &folder.film("b.exr")), 0.0);
    let stderr = folder.fail("render cornell -o a.png --checkpoint 5", 2);
    assert!(stderr.contains("--checkpoint"), "{stderr}");
}

#[test]
fn shards_together_are_the_whole() {
    let folder = Folder::new();
    let base = "render cornell --size 16x16 --iterations 10 --first-iteration 5";
    folder.succeed(&format!("{base} -o whole.exr"));
    for shard in 1..=4 {
        folder.succeed(&format!("{base} -o {shard}.exr --shard {shard}/4"));
    }
    folder.succeed("merge 4.exr 2.exr 1.exr 3.exr -o merged.exr");
    let (whole, merged) = (folder.film("whole.exr"), folder.film("merged.exr"));
    assert_eq!(merged.metadata.iterations.to_string(), "5-14");
    assert!(distance(&whole, &merged) <= 1e-6);
    let stderr = folder.fail(&format!("{base} -o a.exr --shard 1/11"), 2);
    assert!(stderr.contains("at most 10 parts"), "{stderr}");
    let stderr = folder.fail("render cornell -o a.exr --time 1 --shard 1/2", 2);
    assert!(stderr.contains("--iterations"), "{stderr}");
}

#[test]
fn an_interrupted_render_keeps_its_iterations() {
    let folder = Folder::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_neumann"))
        .args("render cornell --size 64x64 --time 600 -o a.exr".split(' '))
        .current_dir(&folder.0)
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_secs(4));
    let pid = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &pid])
            .status()
            .unwrap()
            .success()
    );
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(1), "interrupted is not done");
    let film = folder.film("a.exr");
    assert!(film.film.n_iterations() > 0);
    assert_eq!(film.metadata.iterations.count(), film.film.n_iterations());
    let path: &Path = &folder.join("a.exr");
    assert!(path.exists());
}
