//! `neumann render --tev`: the picture and its layers in tev, while they are rendered.

use neumann_core::radiometry::Rgb;

use super::Folder;
use fake::{FakeTev, Received};

#[path = "../../../../tests/support/tev.rs"]
pub(super) mod fake;

/// Holds that the only image has what is in the file, channel by channel.
fn shows_the_file(received: &Received, name: &str, folder: &Folder, file: &str) {
    let names: Vec<_> = received.images.keys().collect();
    assert_eq!(names, [name]);
    let image = &received.images[name];
    let film = folder.film(file).film;
    assert_eq!(image.size, (film.width(), film.height()));
    let mut layers = vec![(String::new(), film.total())];
    for k in 0..film.n_layers() {
        layers.push((format!("T{k}."), film.layer(k)));
    }
    layers.push(("tail.".to_owned(), film.layer(film.n_layers())));
    let mut order = Vec::new();
    for (layer, pixels) in layers {
        let of = |channel: fn(&Rgb) -> f32| pixels.iter().map(channel).collect::<Vec<_>>();
        let planes = [of(|p| p.r), of(|p| p.g), of(|p| p.b)];
        assert_ne!(planes[0], planes[1], "{layer} has a colour");
        for (channel, plane) in ["R", "G", "B"].into_iter().zip(planes) {
            let channel = format!("{layer}{channel}");
            assert_eq!(image.channels[&channel], plane, "{channel}");
            order.push(channel);
        }
    }
    assert_eq!(image.order, order);
}

#[test]
fn tev_has_what_the_file_has() {
    let folder = Folder::new();
    let tev = FakeTev::listen();
    folder.succeed(&format!(
        "render cornell --size 40x24 --layers 3 --integrator pt-nee --time 1.5 -o a.exr --tev {}",
        tev.address()
    ));
    let received = tev.finish();
    shows_the_file(&received, "cornell, pt-nee", &folder, "a.exr");
    assert_eq!(received.n_created, 1);
    // At most a few a second, and the last one.
    let n_frames = received.images["cornell, pt-nee"].n_updates / 5;
    assert!((3..=8).contains(&n_frames), "{n_frames} frames");
}

#[test]
fn no_file_is_needed_to_look_on() {
    let folder = Folder::new();
    let tev = FakeTev::listen();
    let line = "render cornell --size 16x16 --iterations 3 --json --tev";
    let report = folder.succeed(&format!("{line} {}", tev.address()));
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["iterations"], 3);
    assert_eq!(tev.finish().images.len(), 1);
    assert!(folder.names().is_empty());
}

#[test]
fn a_tev_that_goes_away_does_not_end_the_render() {
    let folder = Folder::new();
    for n_packets in [0, 1, 4] {
        let tev = FakeTev::leaving_after(n_packets);
        let said = super::stderr_of(
            &folder,
            &format!(
                "render cornell --size 64x64 --time 1.2 -o a.exr --tev {}",
                tev.address()
            ),
        );
        assert_eq!(said.matches("rendering goes on").count(), 1, "{said}");
        assert!(said.contains("tev takes no more pictures"), "{said}");
        assert!(folder.film("a.exr").film.n_iterations() > 0);
        std::fs::remove_file(folder.join("a.exr")).unwrap();
    }
}

#[test]
fn where_nobody_listens_nothing_is_rendered() {
    let folder = Folder::new();
    // A port that was free a moment ago.
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    drop(listener);
    let line = "render cornell --size 16x16 --iterations 1 -o a.exr --tev";
    let stderr = folder.fail(&format!("{line} {address}"), 2);
    assert!(
        stderr.contains(&format!("{address}: no tev can be reached"))
            && stderr.contains("start tev"),
        "{stderr}"
    );
    for wrong in [
        "here",
        ":80",
        "localhost:",
        "localhost:0",
        "localhost:99999",
    ] {
        let stderr = folder.fail(&format!("{line} {wrong}"), 2);
        assert!(stderr.contains("use HOST:PORT"), "{stderr}");
    }
    assert!(folder.names().is_empty());
}
