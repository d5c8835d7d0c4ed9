//! The window by itself: `cargo run -p neumann-viewer --example window [SCENE]`.
//!
//! With `SHOT=file.png` it draws itself to a file; `SIZE=1280x720`, `LIGHT=1`, `AFTER=16`.

use neumann_viewer::{Screenshot, ViewOptions};

fn main() {
    let var = |name: &str| std::env::var(name).ok();
    let screenshot = var("SHOT").map(|path| {
        let size = var("SIZE").unwrap_or_else(|| "1280x720".to_owned());
        let (w, h) = size.split_once('x').unwrap_or(("1280", "720"));
        Screenshot {
            path: path.into(),
            after_iterations: var("AFTER").and_then(|n| n.parse().ok()).unwrap_or(16),
            size: (w.parse().unwrap_or(1280), h.parse().unwrap_or(720)),
            light_theme: var("LIGHT").is_some(),
        }
    });
    let options = ViewOptions {
        scene: std::env::args().nth(1).unwrap_or_default(),
        part: var("VIEW").and_then(|v| v.parse().ok()).unwrap_or_default(),
        screenshot,
        ..ViewOptions::default()
    };
    if let Err(error) = neumann_viewer::run(options) {
        // An example may speak to its user.
        let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("{error}\n"));
        std::process::exit(1);
    }
}
