//! The files that a command writes.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use neumann_core::film::{Film, View};
use neumann_core::radiometry::Rgb;
use neumann_core::render::RenderSettings;
use neumann_picture::Image;
use neumann_picture::exr_file::{Beside, Metadata, Precision, write_exr_as};
use neumann_picture::files::{self, check_destination, is_same_place};
use neumann_picture::png_file::{Pixels8, write_png};
use neumann_picture::tone::Display;

use crate::console;
use crate::failure::{OrBadInput, Outcome, bad_input};

/// Kinds of file, by extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Exr,
    Png,
}

/// The kind of file that a name asks for.
pub(crate) fn kind(path: &Path) -> Outcome<Kind> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("exr") => Ok(Kind::Exr),
        Some("png") => Ok(Kind::Png),
        _ => Err(bad_input(format!(
            "{}: not a kind of file that can be written; use .exr or .png",
            path.display()
        ))),
    }
}

/// Finds out, before any work is done, whether all files could be written.
pub(crate) fn check(paths: &[PathBuf]) -> Outcome {
    for (i, path) in paths.iter().enumerate() {
        kind(path)?;
        check_destination(path).or_bad_input()?;
        if paths[..i].iter().any(|other| is_same_place(path, other)) {
            return Err(bad_input(format!(
                "{}: is named twice; name each output once",
                path.display()
            )));
        }
    }
    Ok(())
}

/// Finds out whether a map, which is a PNG file, could be written.
pub(crate) fn check_map(map: Option<&PathBuf>) -> Outcome {
    let Some(map) = map else {
        return Ok(());
    };
    if kind(map)? != Kind::Png {
        return Err(bad_input(format!("{}: the map is a .png", map.display())));
    }
    check(std::slice::from_ref(map))
}

/// Finds out, before any work is done, whether a vector figure could be written.
pub(crate) fn check_figure(path: &Path) -> Outcome {
    let extension = path.extension();
    if extension.is_none_or(|ending| !ending.eq_ignore_ascii_case("svg")) {
        return Err(bad_input(format!(
            "{}: curves are drawn as .svg; name such a file",
            path.display()
        )));
    }
    check_destination(path).or_bad_input()
}

/// Refuses to write over a file that is read.
pub(crate) fn refuse_inputs<'a>(
    outputs: &[PathBuf],
    inputs: impl IntoIterator<Item = &'a PathBuf>,
) -> Outcome {
    for input in inputs {
        if let Some(output) = outputs.iter().find(|output| is_same_place(output, input)) {
            return Err(bad_input(format!(
                "{}: is read as {}, and would be lost; choose another output",
                output.display(),
                input.display()
            )));
        }
    }
    Ok(())
}

/// Refuses a render whose file will not find room: a film is hardly ever made smaller than to an
/// eighth by compression.
pub(crate) fn check_space(paths: &[PathBuf], film: &RenderSettings) -> Outcome {
    let n_pixels = film.width as u64 * film.height as u64;
    for path in paths {
        let bytes_of_pixel = match kind(path)? {
            // Colour of all layers, the tail, L, variance, albedo and normal, and depth.
            Kind::Exr => 4 * (3 * (film.n_layers as u64 + 5) + 1),
            Kind::Png => 3,
        };
        files::check_space(path, n_pixels * bytes_of_pixel / 8).or_bad_input()?;
    }
    Ok(())
}

/// The file that a render can be resumed from, which `option` needs.
pub(crate) fn checkpoint<'p>(option: &str, paths: &'p [PathBuf]) -> Outcome<&'p Path> {
    paths
        .iter()
        .find(|path| matches!(kind(path), Ok(Kind::Exr)))
        .map(PathBuf::as_path)
        .ok_or_else(|| bad_input(format!("{option}: needs an .exr output; add one with -o")))
}

/// A film on its way to files.
pub(crate) struct Picture<'a> {
    pub(crate) film: &'a Film,
    pub(crate) beside: Beside<'a>,
    pub(crate) metadata: &'a Metadata,
    pub(crate) display: Display,
    pub(crate) precision: Precision,
}

impl Picture<'_> {
    /// Writes one file: all layers as EXR, or L as shown as PNG.
    pub(crate) fn write(&self, path: &Path) -> Outcome {
        match kind(path)? {
            Kind::Exr => {
                let clamped =
                    write_exr_as(path, self.film, self.beside, self.metadata, self.precision)?;
                if clamped.n_values > 0 {
                    console::note(&format!(
                        "warning: {}: half floats end at 65504: {} values beyond were clamped, \
                         the largest {:e}; leave out --half to keep them",
                        path.display(),
                        clamped.n_values,
                        clamped.largest
                    ));
                }
            }
            Kind::Png => {
                let image = Image {
                    width: self.film.width(),
                    height: self.film.height(),
                    pixels: self.shown(),
                    ..Image::default()
                };
                write_png(path, &Pixels8::of(&image, &self.display))?;
                note_clipping(path, &image.pixels, &self.display);
            }
        }
        Ok(())
    }

    /// L, in the light that is asked for.
    pub(crate) fn shown(&self) -> Vec<Rgb> {
        let Beside { classes, mix, .. } = self.beside;
        let classes = classes.filter(|_| !mix.is_empty());
        let mixed = classes.and_then(|classes| classes.mixed(View::Total, mix));
        mixed.unwrap_or_else(|| self.film.total())
    }

    /// Writes all files; one that fails does not keep the others from being written.
    pub(crate) fn write_all(&self, paths: &[PathBuf]) -> Outcome {
        let failures: Vec<String> = paths
            .iter()
            .filter_map(|path| self.write(path).err())
            .map(|e| format!("{e:#}"))
            .collect();
        if failures.is_empty() {
            Ok(())
        } else {
            Err(anyhow!(failures.join("; ")))
        }
    }
}

/// Says so if hardly anything of a picture can be told apart for want of exposure.
pub(crate) fn note_clipping(path: &Path, pixels: &[Rgb], display: &Display) {
    if let Some(what) = clipping(pixels, display) {
        console::note(&format!(
            "warning: {}: {what}; try --exposure auto",
            path.display()
        ));
    }
}

/// From this share of the lit pixels on, a picture is as good as of one colour.
const NEARLY_ALL: f64 = 0.95;

/// What is wrong with a picture of which nearly all that is lit is shown as white or as black.
fn clipping(pixels: &[Rgb], display: &Display) -> Option<String> {
    // Black from black is no matter of exposure; white from 1 is no more than white.
    let lit: Vec<&Rgb> = pixels.iter().filter(|p| !p.is_black()).collect();
    let scale = display.exposure_ev.exp2();
    let is_beyond = |p: &Rgb| p.r.min(p.g).min(p.b) * scale > 1.01;
    let share = |is_clipped: &dyn Fn(&Rgb) -> bool| {
        lit.iter().filter(|p| is_clipped(p)).count() as f64 / lit.len().max(1) as f64
    };
    let white = share(&|p| is_beyond(p) && display.srgb8(*p) == [255; 3]);
    let black = share(&|p| display.srgb8(*p) == [0; 3]);
    let (share, colour) = if white >= black {
        (white, "white")
    } else {
        (black, "black")
    };
    (share >= NEARLY_ALL).then(|| {
        format!(
            "{:.0} % of what is lit is shown as {colour}",
            (share * 100.0).floor()
        )
    })
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use neumann_core::radiometry::Rgb;
    use neumann_picture::tone::Display;

    use super::{Kind, check, checkpoint, clipping, kind, refuse_inputs};

    #[test]
    fn pictures_beyond_the_screen_are_told() {
        let display = |exposure_ev| Display {
            exposure_ev,
            ..Display::default()
        };
        // Two of a hundred can be told apart, on a black ground.
        let mut pixels = vec![Rgb::BLACK; 1000];
        pixels.extend((0..100).map(|i| Rgb::splat(if i < 2 { 0.3 } else { 400.0 })));
        assert!(
            clipping(&pixels, &display(0.0))
                .unwrap()
                .contains("98 % of what is lit is shown as white")
        );
        assert_eq!(clipping(&pixels, &display(-9.5)), None);
        assert!(
            clipping(&pixels, &display(-22.0))
                .unwrap()
                .contains("black")
        );
        // A white sky is white and no more; a colour is not white.
        assert_eq!(clipping(&[Rgb::WHITE; 9], &display(0.0)), None);
        assert_eq!(clipping(&[Rgb::new(9.0, 0.5, 0.0); 9], &display(0.0)), None);
        assert_eq!(clipping(&[Rgb::BLACK; 9], &display(0.0)), None);
    }

    #[test]
    fn kinds_follow_from_names() {
        assert_eq!(kind(Path::new("a/b.EXR")).unwrap(), Kind::Exr);
        assert_eq!(kind(Path::new("b.png")).unwrap(), Kind::Png);
        assert!(kind(Path::new("b.jpg")).is_err() && kind(Path::new("exr")).is_err());
    }

    #[test]
    fn outputs_are_checked_together() {
        let folder = std::env::temp_dir();
        let paths = vec![folder.join("neumann-a.png"), folder.join("neumann-a.exr")];
        check(&paths).unwrap();
        assert_eq!(checkpoint("--resume", &paths).unwrap(), paths[1]);
        assert!(checkpoint("--resume", &paths[..1]).is_err());
        let twice = vec![paths[0].clone(), paths[0].clone()];
        assert!(check(&twice).unwrap_err().to_string().contains("twice"));
        let spelt = vec![paths[0].clone(), folder.join("./neumann-a.png")];
        assert!(check(&spelt).unwrap_err().to_string().contains("twice"));
        let error = refuse_inputs(&paths, &[folder.join(".").join("neumann-a.exr")]);
        assert!(error.unwrap_err().to_string().contains("is read"));
        refuse_inputs(&paths, &[folder.join("neumann-b.exr")]).unwrap();
        assert!(check(&[PathBuf::from("/no/such/folder/a.png")]).is_err());
    }
}
