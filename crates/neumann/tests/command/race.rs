//! `neumann race`: methods at equal processor time.

use serde_json::Value;

use super::Folder;

#[test]
fn methods_race_and_their_errors_are_those_of_compare() {
    let folder = Folder::new();
    let said = folder.succeed(
        "race cornell pt-nee pt-mis:roulette=off --size 48x32 --time 0.4 -o race.png \
         --csv race.csv --svg race.svg --pictures out --json",
    );
    let racers: Value = serde_json::from_str(&said).unwrap();
    let racers = racers.as_array().unwrap();
    assert_eq!(racers.len(), 2);
    for (racer, file) in racers.iter().zip(["pt-nee.exr", "pt-mis-roulette=off.exr"]) {
        let curve = racer["curve"].as_array().unwrap();
        assert!(curve.len() > 3, "{racer}");
        let last = curve.last().unwrap();
        let compared = folder.succeed(&format!("compare out/{file} race.reference.exr --json"));
        let compared: Value = serde_json::from_str(&compared).unwrap();
        for error in ["rel_mse", "flip"] {
            assert_eq!(last[error], compared[error], "{error} of {file}");
        }
    }
    // A line for each point, behind the names of the columns.
    let csv = std::fs::read_to_string(folder.join("race.csv")).unwrap();
    let n_points: usize = racers
        .iter()
        .map(|racer| racer["curve"].as_array().unwrap().len())
        .sum();
    assert_eq!(csv.lines().count(), 1 + n_points);
    assert!(csv.starts_with("method,seconds,iterations,relmse,flip\n\"pt-nee\","));
    // A dot for each point in both charts, and one for each name.
    let svg = std::fs::read_to_string(folder.join("race.svg")).unwrap();
    assert_eq!(svg.matches("<circle").count(), 2 * n_points + 2);
    assert!(svg.contains("pt-mis:roulette=off"), "{svg}");
    // What was rendered for it can be used again.
    let again = "race cornell pt-nee lt --size 48x32 --time 0.1 -o b.png --reference \
                 race.reference.exr";
    let table = folder.succeed(again);
    assert!(table.lines().any(|line| line.starts_with("lt ")), "{table}");
    assert!(!folder.join("b.reference.exr").exists());
}

#[test]
fn a_race_that_cannot_be_held_is_refused() {
    let folder = Folder::new();
    let refused = |line: &str, words: &str| {
        let stderr = folder.fail(line, 2);
        assert!(stderr.contains(words), "{line}: {stderr}");
    };
    refused("race cornell pt-nee -o a.png", "METHOD");
    refused(
        "race cornell pt-nee pt-mos -o a.png",
        "no integrator 'pt-mos'",
    );
    refused(
        "race cornell pt-nee pt-nee -o a.png",
        "pt-nee: is named twice",
    );
    refused(
        "race cornell pt-nee pt-mis:roulette -o a.png",
        "is no NAME=VALUE",
    );
    refused("race cornell pt-nee pt-mis:rulette=on -o a.png", "rulette");
    refused(
        "race cornell pt-nee pt-mis --set roulette=on -o a.png",
        "--set:",
    );
    refused(
        "race cornell pt-nee pt-mis -o a.exr",
        "a.exr: the sheet is a .png",
    );
    for (file, words) in [("a.pdf", "drawn as .svg"), ("no/a.svg", "does not exist")] {
        let line = format!("race cornell pt-nee pt-mis -o a.png --svg {file}");
        refused(&line, words);
    }
    folder.succeed("render cornell --size 16x16 --iterations 1 -o r.png");
    refused(
        "race cornell pt-nee pt-mis --size 32x32 --reference r.png -o a.png",
        "--reference: has 16x16 pixels, the race 32x32",
    );
    assert!(!folder.join("a.png").exists());
}
