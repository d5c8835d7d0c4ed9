//! `neumann compare`: how far two pictures are apart.

use std::path::Path;

use neumann_core::memory::{self, Share};
use neumann_core::radiometry::Rgb;
use neumann_picture::Image;
use neumann_picture::compare::{Comparison, compare, difference_picture, working_bytes};
use neumann_picture::exr_file::write_image_exr;
use neumann_picture::image_file::read_layer;
use neumann_picture::png_file::write_png;
use serde_json::json;

use crate::cli::CompareArguments;
use crate::console;
use crate::failure::{OrBadInput, Outcome, bad_input};
use crate::outputs::{self, Kind};

pub(crate) fn run(arguments: &CompareArguments) -> Outcome {
    if let Some(output) = &arguments.output {
        let output = std::slice::from_ref(output);
        outputs::check(output)?;
        outputs::refuse_inputs(output, [&arguments.image, &arguments.reference])?;
    }
    let layer = arguments.layer.as_deref();
    let mut memory = Share::default();
    let image = read_layer(&arguments.image, layer, &mut memory).or_bad_input()?;
    // Before the reference is read, lest that be in vain.
    memory
        .grow(working_bytes(image.pixels.len()))
        .map_err(|shortage| {
            let names = [&arguments.image, &arguments.reference].map(|path| path.display());
            bad_input(format!(
                "{} and {}: comparing them {shortage}; {}",
                names[0],
                names[1],
                memory::REMEDY
            ))
        })?;
    let reference = read_layer(&arguments.reference, layer, &mut memory).or_bad_input()?;
    let display = arguments.display.display(|| reference.pixels.clone());
    let comparison = compare(&image, &reference, &display).or_bad_input()?;
    if let Some(output) = &arguments.output {
        write_difference(output, &image, &reference)?;
    }
    if arguments.json {
        return console::json(&json!({
            "image": arguments.image.display().to_string(),
            "reference": arguments.reference.display().to_string(),
            "layer": layer.unwrap_or("L"),
            "rmse": comparison.rmse,
            "rel_mse": comparison.rel_mse,
            "flip": comparison.flip,
            "mean_ratio": comparison.mean_ratio,
            "mean": comparison.mean,
            "mean_reference": comparison.mean_reference,
            "largest_difference": comparison.largest_difference,
            "n_skipped": comparison.n_skipped,
        }));
    }
    console::result(&table(&comparison))
}

fn write_difference(path: &Path, image: &Image, reference: &Image) -> Outcome {
    match outputs::kind(path)? {
        Kind::Png => {
            let (picture, scale) = difference_picture(image, reference);
            write_png(path, &picture)?;
            console::note(&format!(
                "{}: full colour is a difference in luminance of {scale:.4}",
                path.display()
            ));
        }
        Kind::Exr => {
            let difference: Vec<Rgb> = image
                .pixels
                .iter()
                .zip(&reference.pixels)
                .map(|(a, b)| *a - *b)
                .collect();
            write_image_exr(path, (image.width, image.height), &difference, &[])?;
        }
    }
    Ok(())
}

fn table(c: &Comparison) -> String {
    let three = |v: [f64; 3]| format!("{:.5} {:.5} {:.5}", v[0], v[1], v[2]);
    let mut lines = vec![
        format!("RMSE                {:.6}", c.rmse),
        format!("relMSE              {:.6}", c.rel_mse),
        format!("FLIP                {:.6}", c.flip),
        format!("mean ratio          {}", three(c.mean_ratio)),
        format!("mean                {}", three(c.mean)),
        format!("mean of reference   {}", three(c.mean_reference)),
        format!("largest difference  {:.6}", c.largest_difference),
    ];
    if c.n_skipped > 0 {
        lines.push(format!("pixels not finite   {}", c.n_skipped));
    }
    lines.join("\n")
}
