//! What is refused before any work is done, and what survives when a file is replaced.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::Folder;

/// A render that would take far longer than a test may.
const LONG: &str = "render cornell --size 256x256 --time 1000";

/// Runs what must be refused at once, in one sentence that has the given words; nothing is written.
fn refused(folder: &Folder, line: &str, expected: &str) {
    let names = folder.names();
    let start = Instant::now();
    let stderr = folder.fail(line, 2);
    assert!(start.elapsed() < Duration::from_secs(60), "{line}");
    assert!(stderr.contains(expected), "neumann {line}: {stderr}");
    let errors = stderr.lines().filter(|line| line.starts_with("error:"));
    assert_eq!(errors.count(), 1, "neumann {line}: {stderr}");
    assert_eq!(folder.names(), names, "neumann {line}");
}

/// A scene with a texture, a buffer and a sky beside it.
fn write_scene(folder: &Folder) {
    let png = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av4N70a4\
        AAAAAElFTkSuQmCC";
    let scene = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0,
        "scenes": [{{"nodes": [0],
            "extras": {{"neumann": {{"environment": {{"uri": "sky.exr"}}}}}}}}],
        "nodes": [{{"mesh": 0}}],
        "meshes": [{{"primitives": [
            {{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}, "material": 0}}]}}],
        "materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}}}}],
        "textures": [{{"source": 0}}], "images": [{{"uri": "wood.png"}}],
        "buffers": [{{"uri": "data.png", "byteLength": 60}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}},
            {{"buffer": 0, "byteOffset": 36, "byteLength": 24}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}},
                      {{"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}}],
        "extras": "{png}"}}"#
    );
    fs::write(folder.join("scene.gltf"), scene).unwrap();
    let floats = [0f32, 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 1.];
    let bytes: Vec<u8> = floats.iter().flat_map(|v| v.to_le_bytes()).collect();
    fs::write(folder.join("data.png"), bytes).unwrap();
    folder.succeed("render cornell --size 8x4 --iterations 1 -o sky.exr -o wood.png");
}

#[test]
fn an_output_is_no_input() {
    let folder = Folder::new();
    write_scene(&folder);
    folder.succeed("render cornell --size 8x4 --iterations 1 -o a.exr");
    folder.succeed("render cornell --size 8x4 --iterations 1 --first-iteration 1 -o b.exr");
    fs::hard_link(folder.join("a.exr"), folder.join("hard.exr")).unwrap();
    fs::create_dir(folder.join("sub")).unwrap();
    let mut lines = vec![
        "compare a.exr b.exr -o a.exr".to_owned(),
        "compare a.exr b.exr -o b.exr".to_owned(),
        "compare a.exr b.exr -o hard.exr".to_owned(),
        "compare a.exr b.exr -o sub/../a.exr".to_owned(),
        "merge a.exr b.exr -o c.exr -o b.exr".to_owned(),
        format!("{LONG} --env a.exr -o a.exr"),
        format!("{LONG} --env a.exr -o hard.exr"),
    ];
    let render = LONG.replace("cornell", "scene.gltf");
    lines.extend(["sky.exr", "wood.png", "data.png"].map(|name| format!("{render} -o {name}")));
    lines.push("series scene.gltf --time 1000 -o out".to_owned());
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a.exr", folder.join("soft.exr")).unwrap();
        std::os::unix::fs::symlink("scene.gltf", folder.join("scene.png")).unwrap();
        lines.push("compare soft.exr b.exr -o a.exr".to_owned());
        lines.push(format!("{render} -o scene.png"));
        lines.push("view scene.gltf --screenshot scene.png".to_owned());
    }
    // The sheet of the series is a texture of the scene.
    fs::create_dir(folder.join("out")).unwrap();
    fs::rename(folder.join("wood.png"), folder.join("out/sheet.png")).unwrap();
    let scene = fs::read_to_string(folder.join("scene.gltf")).unwrap();
    let before = fs::read(folder.join("a.exr")).unwrap();
    for line in lines {
        let texture = if line.contains("wood.png") {
            fs::copy(folder.join("out/sheet.png"), folder.join("wood.png")).unwrap();
            "wood.png"
        } else {
            "out/sheet.png"
        };
        fs::write(
            folder.join("scene.gltf"),
            scene.replace("wood.png", texture),
        )
        .unwrap();
        refused(&folder, &line, "is read");
    }
    assert_eq!(fs::read(folder.join("a.exr")).unwrap(), before);
    // A file that a render goes on from is read and written.
    folder.succeed("render cornell --size 8x4 --iterations 2 --resume -o a.exr");
}

#[test]
fn places_that_cannot_be_written_to_are_refused_before_the_work() {
    let folder = Folder::new();
    fs::create_dir(folder.join("folder.exr")).unwrap();
    let long = "a".repeat(300);
    refused(&folder, &format!("{LONG} -o {long}.exr"), "too long");
    refused(&folder, &format!("{LONG} -o folder.exr"), "is a folder");
    refused(&folder, &format!("{LONG} -o no/such.exr"), "does not exist");
    refused(&folder, &format!("{LONG} -o a.exr -o ./a.exr"), "twice");
    refused(
        &folder,
        &format!("{LONG} -o a.exr -o no/a.png"),
        "does not exist",
    );
    fs::write(folder.join("file"), b"").unwrap();
    refused(&folder, &format!("{LONG} -o file/a.exr"), "file/a.exr");
    refused(
        &folder,
        &format!("{LONG} -o a.exr --techniques file"),
        "file",
    );
    refused(&folder, "series cornell --time 1000 -o file", "file");
}

/// Runs the command as another user; needs root.
#[cfg(unix)]
fn run_as_nobody(folder: &Folder, line: &str) -> Option<(Option<i32>, String)> {
    use std::os::unix::process::CommandExt;

    let program = Path::new(env!("CARGO_BIN_EXE_neumann"));
    let output = Command::new(program)
        .args(line.split(' '))
        .current_dir(folder.join("."))
        .stdin(Stdio::null())
        .uid(65534)
        .gid(65534)
        .output()
        .ok()?;
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    Some((output.status.code(), stderr))
}

#[cfg(unix)]
#[test]
fn files_of_others_are_refused_in_a_sticky_folder_and_read_only_ones_anywhere() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};

    let folder = Folder::new();
    let set_mode = |name: &str, mode| {
        fs::set_permissions(folder.join(name), fs::Permissions::from_mode(mode)).unwrap();
    };
    set_mode(".", 0o1777);
    fs::write(folder.join("a.exr"), b"other").unwrap();
    set_mode("a.exr", 0o666);
    let Some((code, stderr)) = run_as_nobody(&folder, &format!("{LONG} -o a.exr")) else {
        eprintln!("left out: needs root, and a folder that all may read");
        return;
    };
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("somebody else"), "{stderr}");
    fs::write(folder.join("b.exr"), b"own").unwrap();
    chown(folder.join("b.exr"), Some(65534), Some(65534)).unwrap();
    set_mode("b.exr", 0o444);
    let (code, stderr) = run_as_nobody(&folder, &format!("{LONG} -o b.exr")).unwrap();
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("read-only"), "{stderr}");
    // Whoever may replace a file of somebody else leaves it theirs.
    set_mode("b.exr", 0o640);
    folder.succeed("render cornell --size 8x8 --iterations 1 -o b.exr");
    let found = fs::metadata(folder.join("b.exr")).unwrap();
    assert_eq!((found.uid(), found.mode() & 0o777), (65534, 0o640));
    assert_eq!(fs::read(folder.join("a.exr")).unwrap(), b"other");
}

#[test]
fn odd_values_are_answered_in_one_sentence() {
    let folder = Folder::new();
    fs::write(folder.join("a.exr"), b"precious").unwrap();
    let render = "render cornell -o a.exr";
    let cases = [
        ("--time -1", "above 0"),
        ("--time -inf", "above 0"),
        ("--time nan", "above 0"),
        ("--time 0", "above 0"),
        ("--time --json", "above 0"),
        ("--until-error -1e-3", "above 0"),
        ("--iterations -1", "whole number"),
        ("--iterations 0", "whole number"),
        ("--iterations 1.5", "whole number"),
        ("--iterations 99999999999", "whole number"),
        ("--first-iteration -1", "whole number"),
        ("--first-iteration 4294967295", "--first-iteration"),
        ("--first-iteration 4294967295 --time 1", "--first-iteration"),
        (
            "--first-iteration 4294967290 --iterations 9",
            "--first-iteration",
        ),
        ("--size -1x4", "WIDTHxHEIGHT"),
        ("--size 1e9x1", "WIDTHxHEIGHT"),
        ("--seed -1", "whole number"),
        ("--threads 0", "whole number"),
        ("--threads -4", "whole number"),
        ("--layers 0", "whole number"),
        ("--layers 65", "whole number"),
        ("--max-bounces -1", "whole number"),
        ("--max-bounces 65536", "whole number"),
        ("--fov 0", "degrees"),
        ("--fov -30", "degrees"),
        ("--fov nan", "degrees"),
        ("--fov 180", "degrees"),
        ("--aperture -1", "from 0"),
        ("--focus 0", "above 0"),
        ("--eye nan,0,0", "three numbers"),
        ("--eye 1,2", "three numbers"),
        ("--exposure nan", "stops"),
        ("--exposure 1e30", "stops"),
        ("--env-intensity -1", "from 0"),
        ("--env-rotation inf", "number"),
        ("--techniques p --techniques-divisor 0", "whole number"),
        ("--checkpoint -1", "number"),
        ("--checkpoint nan", "number"),
        ("--shard 0/4", "--shard"),
        ("--shard -1/4", "--shard"),
        ("--memory -1", "bytes"),
        ("--memory 0", "bytes"),
        ("--set roulette=maybe", "on or off"),
        ("--set radius=nan --integrator ppm", "radius"),
        ("--set radius=-1 --integrator ppm", "radius"),
    ];
    for (option, expected) in cases {
        refused(&folder, &format!("{render} {option}"), expected);
    }
    assert_eq!(fs::read(folder.join("a.exr")).unwrap(), b"precious");
}

#[cfg(feature = "window")]
#[test]
fn what_no_graphics_device_can_draw_is_refused() {
    let folder = Folder::new();
    let lines = [
        "view cornell --screenshot a.png --window-size 40000x100",
        "view cornell --screenshot a.png --window-size 100x65535",
        "view cornell --screenshot a.png --size 65535x1",
    ];
    for line in lines {
        let output = folder.run(line);
        let stderr = String::from_utf8_lossy(&output.stderr);
        if stderr.contains("no graphics adapter") && std::env::var_os("CI").is_none() {
            eprintln!("left out: no graphics adapter");
            return;
        }
        assert_eq!(output.status.code(), Some(2), "{line}: {stderr}");
        // Drivers may have something to say as well.
        let told = stderr.lines().filter(|line| line.contains("smaller size"));
        assert_eq!(told.count(), 1, "{line}: {stderr}");
    }
    assert!(folder.names().iter().all(|name| name != "a.png"));
}

#[test]
fn misspelt_words_are_answered_with_what_was_meant() {
    let folder = Folder::new();
    let cases = [
        ("rendr cornell", "did you mean 'render'?"),
        ("rendr cornell -o a.exr", "did you mean 'render'?"),
        ("rendr", "did you mean 'render'?"),
        ("serie", "did you mean 'series'?"),
        ("render cornel -o a.exr", "did you mean 'cornell'?"),
        ("view cornell-glas", "did you mean 'cornell-glass'?"),
        ("info furnance", "did you mean 'furnace'?"),
        ("cornel", "did you mean 'cornell'?"),
        ("render cornell -o a.exr --integrator pt-miss", "pt-mis"),
    ];
    for (line, expected) in cases {
        refused(&folder, line, expected);
    }
}

#[test]
fn hidden_files_are_not_read_by_a_scene() {
    let folder = Folder::new();
    write_scene(&folder);
    fs::create_dir(folder.join(".ssh")).unwrap();
    fs::rename(folder.join("data.png"), folder.join(".ssh/key")).unwrap();
    let scene = fs::read_to_string(folder.join("scene.gltf")).unwrap();
    fs::write(
        folder.join("scene.gltf"),
        scene.replace("data.png", ".ssh/key"),
    )
    .unwrap();
    refused(&folder, "info scene.gltf", "--allow-hidden");
    folder.succeed("info scene.gltf --allow-hidden");
}
