//! In which ways two pictures were made differently, in words.
//!
//! The header says what fixes a picture as texts that are the same if and only if the pictures
//! are: a camera is sixteen numbers, an environment has a hash. People are told what those mean.

use super::Metadata;

/// A way in which two pictures were made differently.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// What differs.
    pub field: String,
    /// In the first picture and in the second; `None` where the values would tell nothing.
    pub values: Option<(String, String)>,
}

impl Difference {
    /// Such as `seed (0 and 1)`.
    #[must_use]
    pub fn new(field: &str, first: impl ToString, second: impl ToString) -> Self {
        Self {
            field: field.to_owned(),
            values: Some((first.to_string(), second.to_string())),
        }
    }

    /// Such as `materials and lights`.
    fn only(field: &str) -> Self {
        Self {
            field: field.to_owned(),
            values: None,
        }
    }

    /// Such as `seed (0 asked for, 1 in the file)`.
    #[must_use]
    pub fn told(&self, of_first: &str, of_second: &str) -> String {
        match &self.values {
            None => self.field.clone(),
            Some((first, second)) => {
                format!("{} ({first} {of_first}, {second} {of_second})", self.field)
            }
        }
    }
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.values {
            None => write!(f, "{}", self.field),
            Some((first, second)) => write!(f, "{} ({first} and {second})", self.field),
        }
    }
}

impl Metadata {
    /// Every way in which the expected picture differs: empty if iterations of the one
    /// may be averaged with iterations of the other.
    #[must_use]
    pub fn differences(&self, other: &Self) -> Vec<Difference> {
        let mut found = Vec::new();
        if self.scene != other.scene {
            found.push(Difference::new("scene", &self.scene, &other.scene));
        } else if self.content_hash != other.content_hash {
            found.push(Difference::only("scene (its files have changed)"));
        }
        let mut add = |field: &str, first: String, second: String| {
            if first != second {
                found.push(Difference::new(field, first, second));
            }
        };
        add(
            "integrator",
            self.integrator.clone(),
            other.integrator.clone(),
        );
        if self.integrator == other.integrator {
            for (name, first, second) in unequal_parameters(self, other) {
                add(&format!("parameter {name}"), first, second);
            }
        }
        add("seed", self.seed.to_string(), other.seed.to_string());
        let bounces = |m: &Self| m.max_bounces.to_string();
        add("max-bounces", bounces(self), bounces(other));
        if self.camera != other.camera {
            found.extend(of_cameras(&self.camera, &other.camera));
        }
        if self.environment != other.environment {
            found.extend(of_environments(&self.environment, &other.environment));
        }
        if self.appearance != other.appearance {
            found.push(Difference::only("materials and lights"));
        }
        if self.backs != other.backs {
            let names = (self.backs.name(), other.backs.name());
            found.push(Difference::new("backs", names.0, names.1));
        }
        found
    }
}

/// Name and both values of every parameter that differs.
fn unequal_parameters(a: &Metadata, b: &Metadata) -> Vec<(String, String, String)> {
    let value = |m: &Metadata, name: &str| {
        let entry = m.parameters.iter().find(|(n, _)| n == name);
        entry.map_or_else(|| "unknown".to_owned(), |(_, value)| value.clone())
    };
    let ours = a.parameters.iter().map(|(name, _)| name);
    let theirs = b.parameters.iter().map(|(name, _)| name);
    let only_theirs = theirs.filter(|name| !a.parameters.iter().any(|(n, _)| n == *name));
    ours.chain(only_theirs)
        .map(|name| (name.clone(), value(a, name), value(b, name)))
        .filter(|(_, first, second)| first != second)
        .collect()
}

/// Two texts by [`super::camera_text`] that differ.
fn of_cameras(first: &str, second: &str) -> Vec<Difference> {
    let (a, b) = (CameraWords::of(first), CameraWords::of(second));
    let pairs = [
        ("camera's projection", a.projection, b.projection),
        ("camera's lens", a.lens, b.lens),
        ("camera's position", a.position, b.position),
        ("camera's direction", a.direction, b.direction),
    ];
    let found: Vec<_> = pairs
        .into_iter()
        .filter(|(_, first, second)| first != second)
        .map(|(field, first, second)| Difference::new(field, first, second))
        .collect();
    if found.is_empty() {
        // What is up, or something that a later version wrote.
        return vec![Difference::only("camera")];
    }
    found
}

/// What a camera's text means.
#[derive(Default)]
struct CameraWords {
    projection: String,
    lens: String,
    position: String,
    direction: String,
}

impl CameraWords {
    fn of(text: &str) -> Self {
        let mut words = Self::default();
        for part in text.split("; ") {
            let (kind, rest) = part.split_once(' ').unwrap_or((part, ""));
            let numbers: Vec<f32> = part
                .split(' ')
                .filter_map(|word| word.parse().ok())
                .collect();
            match (kind, numbers.as_slice()) {
                ("perspective", [yfov]) => {
                    words.projection = format!("{}° high", degrees(*yfov));
                }
                ("orthographic", [ymag]) => {
                    words.projection = format!("orthographic, {} m high", 2.0 * ymag);
                }
                ("lens", [aperture, focus]) => {
                    words.lens = format!("aperture {aperture} m, focus {focus} m");
                }
                ("pinhole", []) if rest.is_empty() => words.lens = "pinhole".to_owned(),
                // Columns: right, up, backward, position, four numbers each.
                (_, [_, _, _, _, _, _, _, _, x, y, z, _, eye_x, eye_y, eye_z, _]) => {
                    words.position = format!("{eye_x},{eye_y},{eye_z}");
                    words.direction = format!("{},{},{}", 0.0 - x, 0.0 - y, 0.0 - z);
                }
                _ => {}
            }
        }
        words
    }
}

/// An angle as people write it.
fn degrees(radians: f32) -> f32 {
    (radians.to_degrees() * 1e4).round() / 1e4
}

/// Two texts by [`super::environment_text`] that differ.
fn of_environments(first: &str, second: &str) -> Vec<Difference> {
    let parts = |text: &str| text.split("; ").map(words_of_part).collect::<Vec<_>>();
    let (a, b) = (parts(first), parts(second));
    let mut found: Vec<_> = a
        .iter()
        .zip(&b)
        .filter(|(first, second)| first != second)
        .map(|(first, second)| Difference::new("environment", first, second))
        .collect();
    if a.len() != b.len() && a.first() == b.first() {
        found.push(Difference::only("environment"));
    }
    if found.is_empty() {
        found.push(Difference::only("environment (its texels have changed)"));
    }
    found
}

/// A part of an environment's text without its hash, and with its turn in degrees.
fn words_of_part(part: &str) -> String {
    if let Some(turn) = part.strip_prefix("rotation ") {
        return match turn.parse::<f32>() {
            Ok(radians) => format!("turned by {}°", degrees(radians)),
            Err(_) => part.to_owned(),
        };
    }
    let is_hash = |word: &&str| word.len() == 16 && word.bytes().all(|b| b.is_ascii_hexdigit());
    let words: Vec<_> = part.split(' ').filter(|word| !is_hash(word)).collect();
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::{of_cameras, of_environments};

    fn told(differences: &[super::Difference]) -> String {
        let texts: Vec<_> = differences.iter().map(ToString::to_string).collect();
        texts.join(", ")
    }

    #[test]
    fn cameras_differ_in_words() {
        let matrix = "1 0 0 0 0 1 0 0 0 0 1 0 0 1 6.8 1";
        let camera = format!("perspective 0.5; pinhole; {matrix}");
        let cases = [
            (
                format!("perspective 1; pinhole; {matrix}"),
                "camera's projection (28.6479° high and 57.2958° high)",
            ),
            (
                format!("orthographic 2; pinhole; {matrix}"),
                "camera's projection (28.6479° high and orthographic, 4 m high)",
            ),
            (
                format!("perspective 0.5; lens 0.1 3; {matrix}"),
                "camera's lens (pinhole and aperture 0.1 m, focus 3 m)",
            ),
            (
                camera.replace("6.8", "4"),
                "camera's position (0,1,6.8 and 0,1,4)",
            ),
            (
                camera.replace("0 0 1 0 0 1 6.8", "1 0 0 0 0 1 6.8"),
                "camera's direction (0,0,-1 and -1,0,0)",
            ),
            (camera.replace("1 0 0 0 0 1", "0 1 0 0 1 0"), "camera"),
            ("something new".to_owned(), "camera's projection"),
        ];
        for (other, expected) in cases {
            let text = told(&of_cameras(&camera, &other));
            assert!(text.starts_with(expected), "{other}: {text}");
            assert!(!text.contains(matrix));
        }
    }

    #[test]
    fn environments_differ_in_words() {
        let sky = "a sky.hdr 4x2 0123456789abcdef; intensity 1; rotation 0";
        let cases = [
            ("none".to_owned(), "environment (a sky.hdr 4x2 and none)"),
            (
                sky.replace("sity 1", "sity 2"),
                "environment (intensity 1 and intensity 2)",
            ),
            (
                sky.replace("rotation 0", "rotation 1"),
                "environment (turned by 0° and turned by 57.2958°)",
            ),
            (
                sky.replace("abc", "cba"),
                "environment (its texels have changed)",
            ),
        ];
        for (other, expected) in cases {
            assert_eq!(told(&of_environments(sky, &other)), expected);
        }
    }
}
