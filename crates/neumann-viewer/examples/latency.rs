//! How soon the window answers, as one line of JSON:
//! `cargo run --release -p neumann-viewer --example latency [STEPS] [SCENE] [idle]`.

use std::io::Write;
use std::time::Duration;

use neumann_core::render::StopRule;
use neumann_viewer::ViewOptions;
use neumann_viewer::latency::{Plan, measure};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let n_steps = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(60);
    let options = ViewOptions {
        scene: arguments.next().unwrap_or_default(),
        stop: match arguments.next().as_deref() {
            // Nothing is rendered meanwhile: the interface by itself.
            Some("idle") => StopRule::Iterations(1),
            _ => StopRule::Never,
        },
        ..ViewOptions::default()
    };
    let plan = Plan {
        n_steps,
        quiet: Duration::from_secs(10),
    };
    let text = match measure(options, plan) {
        Ok(report) => report.to_json(),
        Err(error) => error.to_string(),
    };
    let _ = writeln!(std::io::stdout(), "{text}");
}
