//! `view --state`: what is wrong with a state file is told in one line, before anything is opened.

use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use glam::Vec3;
use neumann_core::scene::description::{CameraDescription, Projection};
use neumann_picture::state::{RegionState, State};

use super::Folder;

/// A state whose text is `text` is refused with those words.
fn refused(text: &str, expected: &str) {
    let folder = Folder::new();
    fs::write(folder.join("a.json"), text).unwrap();
    let stderr = folder.fail("view --state a.json --screenshot a.png", 2);
    assert!(stderr.contains(expected), "{text}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{text}: {stderr}");
    assert!(!folder.join("a.png").exists());
}

#[test]
fn states_that_cannot_be_shown_are_refused() {
    refused("", "a.json: ");
    refused("{", "a.json: ");
    refused(r#"{"scene": "cornell", "camera": {}}"#, "a.json: camera");
    refused(
        r#"{"scene": "none.glb"}"#,
        "a.json: scene: there is no file none.glb; put",
    );
    refused(
        r#"{"scene": "cornell", "method": "best"}"#,
        "a.json: method: there is no method 'best'; use one of naive",
    );
    refused(r#"{"scene": "cornell", "tone": "film"}"#, "a.json: tone: ");
    refused(
        r#"{"scene": "cornell", "region": {"of": [64, 48], "at": [60, 0], "size": [8, 8]}}"#,
        "a.json: region.size[0]: 8 is out of range; use 1 to 4",
    );
    let folder = Folder::new();
    let stderr = folder.fail("view --state none.json", 2);
    assert!(stderr.contains("none.json: cannot read"), "{stderr}");
}

#[test]
fn a_state_stands_for_the_options_of_the_picture() {
    let folder = Folder::new();
    fs::write(folder.join("a.json"), r#"{"scene": "cornell"}"#).unwrap();
    for more in [
        "cornell",
        "--integrator lt",
        "--view T1",
        "--eye 0,0,1",
        "--tone agx",
    ] {
        let stderr = folder.fail(&format!("view --state a.json {more}"), 2);
        assert!(stderr.contains("cannot be used with"), "{more}: {stderr}");
    }
    let stderr = folder.fail("view --state a.json --screenshot a.json", 2);
    assert!(stderr.contains(".png"), "{stderr}");
    assert!(folder.fail("view", 2).contains("SCENE"));
}

#[test]
fn a_state_is_drawn_and_what_nobody_knows_in_it_is_told() {
    let folder = Folder::new();
    let state = r#"{"scene": "cornell", "part": "T1", "shine": 3, "size": [24, 16]}"#;
    fs::write(folder.join("a.json"), state).unwrap();
    let line = "view --state a.json --screenshot a.png --after 1 --window-size 640x420";
    let output = folder.run(line);
    let stderr = String::from_utf8_lossy(&output.stderr);
    let has_adapter = !stderr.contains("no graphics adapter");
    assert!(has_adapter || std::env::var_os("CI").is_none(), "{stderr}");
    assert!(
        stderr.contains("a.json: shine: there is no such field"),
        "{stderr}"
    );
    if has_adapter {
        assert!(output.status.success(), "{stderr}");
        assert!(folder.join("a.png").exists());
    }
}

/// What a command has rendered can be taken up by the window.
#[test]
fn a_rendered_picture_has_its_state() {
    let folder = Folder::new();
    let line = "render cornell -o a.exr --integrator pt-nee --eye 0,2,7 --target 0.1,2.5,0 \
                --fov 40 --size 24x16 --region 2,3,8,6 --iterations 1 \
                --env sun --env-intensity 2 --max-bounces 3";
    assert!(folder.run(line).status.success());
    let (state, warnings) = State::read(&folder.join("a.exr")).unwrap();
    assert_eq!(warnings, Vec::<String>::new());
    let expected = State {
        scene: "cornell".to_owned(),
        method: "pt-nee".to_owned(),
        max_bounces: 3,
        size: Some([24, 16]),
        region: Some(RegionState {
            of: [24, 16],
            at: [2, 3],
            size: [8, 6],
        }),
        parameters: state.parameters.clone(),
        camera: state.camera.clone(),
        environment: state.environment.clone(),
        ..State::default()
    };
    assert_eq!(state, expected);
    assert_eq!(state.parameters["lights"], "tree");
    assert_eq!(state.environment.sky, "sun");
    assert_eq!(state.environment.brightness.0, 2.0);
    let camera = state.camera.unwrap().description(String::new());
    let (eye, target) = (Vec3::new(0.0, 2.0, 7.0), Vec3::new(0.1, 2.5, 0.0));
    let matrix = CameraDescription::looking_at(eye, target, Vec3::Y);
    assert_eq!(camera.world_from_camera, matrix);
    let yfov = 40f32.to_radians();
    assert_eq!(camera.projection, Projection::Perspective { yfov });
}

/// What was copied in a window comes by a pipe.
#[test]
fn a_state_comes_from_standard_input() {
    let folder = Folder::new();
    let run = |text: &str| {
        let mut child = Command::new(env!("CARGO_BIN_EXE_neumann"))
            .args([
                "view",
                "--state",
                "-",
                "--screenshot",
                "a.png",
                "--after",
                "1",
            ])
            .args(["--window-size", "640x420"])
            .current_dir(folder.join(""))
            .stdin(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stdin = child.stdin.take().unwrap();
        stdin.write_all(text.as_bytes()).unwrap();
        drop(stdin);
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), stderr)
    };
    let (code, stderr) = run(r#"{"scene": "cornell", "max_bounces": -1}"#);
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("standard input: max_bounces: "), "{stderr}");
    let (code, stderr) = run(r#"{"scene":"cornell","part":"T1"}"#);
    if code != Some(0) && std::env::var_os("CI").is_none() {
        assert!(stderr.contains("no graphics adapter"), "{stderr}");
        return;
    }
    assert_eq!(code, Some(0), "{stderr}");
    assert!(folder.join("a.png").exists());
}
