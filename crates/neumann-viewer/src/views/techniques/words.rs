//! What a technique is called, and what it does, in a sentence.

use neumann_core::film::{Joint, Strategy, TechniqueImage};

/// Its name: `s=1 t=2`, or `merge s=2 t=2`.
#[must_use]
pub fn label(strategy: Strategy) -> String {
    let (s, t) = (strategy.s, strategy.t);
    match strategy.joint {
        Joint::Merge => format!("merge s={s} t={t}"),
        Joint::Hit | Joint::Connect => format!("s={s} t={t}"),
    }
}

/// What it does.
#[must_use]
pub fn description(strategy: Strategy) -> String {
    let (s, t) = (strategy.s, strategy.t);
    match (strategy.joint, s, t) {
        (Joint::Hit, 0, _) => format!("a camera subpath of {t} vertices that runs into a light"),
        (Joint::Hit, ..) => format!("a light subpath of {s} vertices that runs into the lens"),
        (Joint::Connect, 1, 1) => "a point on a light connected to the lens".to_owned(),
        (Joint::Connect, 1, _) => {
            format!("a point on a light connected to a camera subpath of {t} vertices")
        }
        (Joint::Connect, _, 1) => format!("a light subpath of {s} vertices connected to the lens"),
        (Joint::Connect, ..) => {
            format!("a light subpath of {s} vertices connected to a camera subpath of {t}")
        }
        (Joint::Merge, ..) => format!(
            "a light subpath of {s} vertices and a camera subpath of {t}, their nearby ends taken \
             for one point"
        ),
    }
}

/// What an image of a technique shows, in a sentence.
pub(super) fn about_image(image: TechniqueImage) -> &'static str {
    match image {
        TechniqueImage::Raw => "What the technique would make of the picture alone, unweighted.",
        TechniqueImage::Weighted => {
            "What the technique adds to the picture: its contributions times their MIS weights."
        }
        TechniqueImage::Weight => "The mean MIS weight of the technique, from 0 to 1.",
    }
}

#[cfg(test)]
mod tests {
    use neumann_core::film::Strategy;

    use super::{description, label};

    #[test]
    fn techniques_have_names_and_sentences() {
        assert_eq!(label(Strategy::connect(1, 2)), "s=1 t=2");
        assert_eq!(label(Strategy::merge(2, 2)), "merge s=2 t=2");
        assert_eq!(
            description(Strategy::connect(2, 3)),
            "a light subpath of 2 vertices connected to a camera subpath of 3"
        );
        assert_eq!(
            description(Strategy::hit(2)),
            "a camera subpath of 2 vertices that runs into a light"
        );
    }
}
