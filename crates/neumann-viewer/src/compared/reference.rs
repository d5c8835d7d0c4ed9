//! The picture that the film is held against: a file with its layers, or what was held as A or B.

use std::path::Path;
use std::sync::Arc;

use neumann_core::film::View as Part;
use neumann_core::radiometry::Rgb;
use neumann_picture::Image;
use neumann_picture::exr_file::read_metadata;
use neumann_picture::image_file::read_image_with_layers;

use super::Origin;
use crate::picture::Held;

/// A picture to hold the film against, in those parts of the series that it has.
#[derive(Clone, Debug)]
pub struct Reference {
    /// What it is called: the name of its file, or A or B.
    pub name: String,
    /// Pixels per row, and rows.
    pub size: (usize, usize),
    /// How it was made, if that is known.
    pub origin: Option<Origin>,
    /// Terms before the tail.
    n_layers: usize,
    parts: Vec<(Part, Arc<Vec<Rgb>>)>,
}

impl Reference {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, in a sentence.
    pub fn read(path: &Path) -> Result<Self, String> {
        let image = read_image_with_layers(path).map_err(|e| e.to_string())?;
        let name = path.file_name().unwrap_or(path.as_os_str());
        let origin = read_metadata(path).ok();
        let origin = origin.as_ref().map(Origin::of_file);
        Ok(Self::of_image(&name.to_string_lossy(), image, origin))
    }

    /// A picture with the terms that stand among its layers.
    #[must_use]
    pub fn of_image(name: &str, mut image: Image, origin: Option<Origin>) -> Self {
        let mut parts = vec![(Part::Total, Arc::new(image.pixels))];
        let mut n_layers = 0;
        let mut take = |part: Part| {
            let pixels = image.layers.remove(&part.to_string())?;
            parts.push((part, Arc::new(pixels)));
            Some(())
        };
        while take(Part::Term(n_layers)).is_some() {
            n_layers += 1;
        }
        if n_layers > 0 {
            take(Part::Tail);
        }
        Self {
            name: name.to_owned(),
            size: (image.width, image.height),
            origin,
            n_layers,
            parts,
        }
    }

    /// What was held, in the one part that it was held with.
    #[must_use]
    pub fn of_held(name: &str, held: &Held) -> Self {
        Self {
            name: name.to_owned(),
            size: held.size,
            origin: held.origin.clone(),
            n_layers: held.n_layers,
            parts: vec![(held.view, Arc::clone(&held.pixels))],
        }
    }

    /// Its pixels of a part of the series, the tail beginning after `n_layers` terms.
    ///
    /// # Errors
    /// Says what it has, if it has not this one.
    pub fn pixels(&self, part: Part, n_layers: usize) -> Result<Arc<Vec<Rgb>>, String> {
        let summands = self.summands(part, n_layers)?;
        if let [only] = summands[..] {
            return Ok(Arc::clone(only));
        }
        let mut sum = vec![Rgb::BLACK; self.size.0 * self.size.1];
        for pixels in summands {
            for (s, p) in sum.iter_mut().zip(pixels.iter()) {
                *s += *p;
            }
        }
        Ok(Arc::new(sum))
    }

    /// Why it has not a part of the series, if it has not.
    #[must_use]
    pub fn refusal(&self, part: Part, n_layers: usize) -> Option<String> {
        self.summands(part, n_layers).err()
    }

    /// The planes that add up to a part.
    fn summands(&self, part: Part, n_layers: usize) -> Result<Vec<&Arc<Vec<Rgb>>>, String> {
        let is_same_tail = part != Part::Tail || self.n_layers == n_layers;
        if let Some(pixels) = self.plane(part).filter(|_| is_same_tail) {
            return Ok(vec![pixels]);
        }
        let terms: Vec<Part> = match part {
            Part::Upto(last) => (0..=last).map(Part::Term).collect(),
            Part::Tail if n_layers < self.n_layers => (n_layers..self.n_layers)
                .map(Part::Term)
                .chain([Part::Tail])
                .collect(),
            _ => Vec::new(),
        };
        let planes: Option<Vec<_>> = terms.into_iter().map(|term| self.plane(term)).collect();
        let planes = planes.filter(|planes| !planes.is_empty());
        planes.ok_or_else(|| self.lacks(part))
    }

    fn plane(&self, part: Part) -> Option<&Arc<Vec<Rgb>>> {
        let mut parts = self.parts.iter();
        parts
            .find(|(has, _)| *has == part)
            .map(|(_, pixels)| pixels)
    }

    fn lacks(&self, part: Part) -> String {
        let name = &self.name;
        match &self.parts[..] {
            [(only, _)] => format!("the reference {name} has only {only}, not {part}"),
            _ => format!(
                "the reference {name} has the terms up to T{}, but not {part}",
                self.n_layers.saturating_sub(1)
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use neumann_core::film::View as Part;
    use neumann_core::radiometry::Rgb;
    use neumann_picture::Image;

    use super::Reference;

    /// One pixel, whose term k has the radiance 2^k and whose tail has 100.
    fn layered(n_terms: usize) -> Reference {
        let mut layers = BTreeMap::new();
        for k in 0..n_terms {
            let value = (k as f32).exp2();
            layers.insert(format!("T{k}"), vec![Rgb::splat(value)]);
        }
        if n_terms > 0 {
            layers.insert("tail".to_owned(), vec![Rgb::splat(100.0)]);
            layers.insert("albedo".to_owned(), vec![Rgb::WHITE]);
        }
        let image = Image {
            width: 1,
            height: 1,
            pixels: vec![Rgb::splat(1000.0)],
            layers,
        };
        Reference::of_image("a.exr", image, None)
    }

    fn value(reference: &Reference, part: Part, n_layers: usize) -> Option<f32> {
        let pixels = reference.pixels(part, n_layers).ok()?;
        assert_eq!(reference.refusal(part, n_layers), None);
        Some(pixels[0].r)
    }

    #[test]
    fn each_part_is_that_of_the_layers() {
        let reference = layered(4);
        assert_eq!(value(&reference, Part::Total, 4), Some(1000.0));
        assert_eq!(value(&reference, Part::Term(2), 4), Some(4.0));
        assert_eq!(value(&reference, Part::Upto(2), 4), Some(7.0));
        assert_eq!(value(&reference, Part::Tail, 4), Some(100.0));
        assert_eq!(
            value(&reference, Part::Tail, 2),
            Some(112.0),
            "T2, T3 and beyond"
        );
        assert_eq!(
            value(&reference, Part::Tail, 6),
            None,
            "it keeps fewer apart"
        );
        assert_eq!(value(&reference, Part::Term(4), 6), None);
        assert_eq!(value(&reference, Part::Upto(4), 6), None);
    }

    #[test]
    fn a_picture_without_layers_has_nothing_but_the_whole() {
        let reference = layered(0);
        assert_eq!(value(&reference, Part::Total, 8), Some(1000.0));
        let refusal = reference.refusal(Part::Term(2), 8).unwrap();
        assert_eq!(refusal, "the reference a.exr has only L, not T2");
        for part in [Part::Upto(0), Part::Tail] {
            assert!(reference.pixels(part, 8).is_err(), "{part}");
        }
    }
}
