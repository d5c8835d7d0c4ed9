//! `neumann agree`: do two methods make the same picture?

use serde_json::Value;

use super::Folder;

#[test]
fn what_agrees_ends_with_0_and_what_does_not_with_1() {
    let folder = Folder::new();
    let common = "--size 32x32 --iterations 2 --batches 16";
    let said = folder.succeed(&format!(
        "agree cornell pt-mis bdpt {common} --json -o a.png"
    ));
    let said: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(said["agree"], true);
    assert_eq!(said["methods"][1]["method"], "bdpt");
    assert_eq!(said["methods"][0]["batches"], 16);
    assert_eq!(said["level"], 0.01);
    assert!(folder.join("a.png").exists());
    // Without light between diffuse surfaces.
    let line = format!("agree cornell pt-mis drt {common} -o b.png");
    let output = folder.run(&line);
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stderr.is_empty(), "everything is said on stdout");
    let text = String::from_utf8(output.stdout).unwrap();
    for words in [
        "They disagree at T2, ",
        "T2: pt-mis is brighter than drt",
        "cells drt found no light at all",
        "drt is biased: no interreflection",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(folder.join("b.png").exists());
    let json = folder.run(&format!("{line} --json"));
    assert_eq!(json.status.code(), Some(1));
    let json: Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["agree"], false);
    let terms = json["terms"].as_array().unwrap();
    let beyond = |name: &str| {
        let term = terms.iter().find(|term| term["term"] == name).unwrap();
        term["beyond"].as_u64().unwrap()
    };
    assert_eq!((beyond("T0"), beyond("T1")), (0, 0), "{json}");
    assert!(beyond("T2") > 0 && beyond("L") > 0, "{json}");
}

#[test]
fn a_method_may_stand_against_itself_and_the_seed_decides() {
    let folder = Folder::new();
    let run = |seed: u32| {
        folder.succeed(&format!(
            "agree furnace pt-mis pt-mis --size 16x16 --iterations 1 --seed {seed} --json"
        ))
    };
    let term = |text: &str| {
        let value: Value = serde_json::from_str(text).unwrap();
        value["terms"].clone()
    };
    let (first, again, other) = (run(7), run(7), run(8));
    assert_eq!(term(&first), term(&again));
    assert_ne!(term(&first), term(&other));
    let means = &term(&first)[2]["mean"];
    assert_ne!(means[0], means[1], "the second has other seeds");
    // By time, the numbers are others each time.
    let table = folder
        .run("agree furnace pt-mis pt-mis --size 16x16 --time 0.1")
        .stdout;
    let table = String::from_utf8(table).unwrap();
    assert!(
        table.contains("against pt-mis again (32 batches of "),
        "{table}"
    );
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = Folder::new();
    for (line, words) in [
        ("agree cornell pt-mis", "METHOD"),
        ("agree cornell pt-mis pt-mos", "no integrator 'pt-mos'"),
        ("agree cornell pt-mis bdpt:x", "is no NAME=VALUE"),
        ("agree cornell pt-mis bdpt --set roulette=off", "--set:"),
        ("agree cornell pt-mis bdpt -o a.exr", "the map is a .png"),
        ("agree cornell pt-mis bdpt --level 1", "between 0 and 1"),
        ("agree cornell pt-mis bdpt --batches 2", "--batches"),
        (
            "agree cornell pt-mis bdpt --time 1 --iterations 1",
            "--time",
        ),
    ] {
        let stderr = folder.fail(line, 2);
        assert!(stderr.contains(words), "{line}: {stderr}");
    }
}
