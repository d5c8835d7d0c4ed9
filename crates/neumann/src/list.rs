//! `neumann list`: built-in scenes, integrators, their parameters, light path expressions.

use neumann_core::expression::PRESETS;
use neumann_core::integrator::{DEFAULT_METHOD, METHODS, Parameter, ParameterKind};
use neumann_core::scene::builtin::BUILTINS;
use serde_json::{Value, json};

use crate::cli::{ListArguments, Listing};
use crate::console;
use crate::failure::Outcome;

pub(crate) fn run(arguments: &ListArguments) -> Outcome {
    if arguments.json {
        return console::json(&match arguments.what {
            Listing::Scenes => scenes_json(),
            Listing::Integrators => integrators_json(),
            Listing::Parameters => parameters_json(),
            Listing::Expressions => expressions_json(),
        });
    }
    console::result(&match arguments.what {
        Listing::Scenes => scenes(),
        Listing::Integrators => integrators(),
        Listing::Parameters => parameters(),
        Listing::Expressions => expressions(),
    })
}

fn scenes() -> String {
    let widest = BUILTINS.iter().map(|s| s.name.len()).max().unwrap_or(0);
    let line = |name: &str, about: &str| format!("{name:widest$}  {about}");
    let lines: Vec<_> = BUILTINS.iter().map(|s| line(s.name, s.about)).collect();
    lines.join("\n")
}

fn scenes_json() -> Value {
    BUILTINS
        .iter()
        .map(|s| json!({ "name": s.name, "about": s.about }))
        .collect()
}

fn expressions() -> String {
    let widest = PRESETS
        .iter()
        .map(|(name, _)| name.len())
        .max()
        .unwrap_or(0);
    let lines: Vec<_> = PRESETS
        .iter()
        .map(|(name, text)| format!("{name:widest$}  {text}"))
        .collect();
    lines.join("\n")
}

fn expressions_json() -> Value {
    PRESETS
        .iter()
        .map(|(name, text)| json!({ "name": name, "expression": text }))
        .collect()
}

fn integrators() -> String {
    let widest = METHODS.iter().map(|m| m.id.len()).max().unwrap_or(0);
    let mut lines = Vec::new();
    for m in METHODS {
        let default = if m.id == DEFAULT_METHOD {
            " (default)"
        } else {
            ""
        };
        lines.push(format!(
            "{:widest$}  {}{default}. {}",
            m.id, m.name, m.about
        ));
        if !m.blind_spots.is_empty() {
            lines.push(format!("{:widest$}  Cannot see: {}", "", m.blind_spots));
        }
        if let Some(bias) = m.bias {
            lines.push(format!("{:widest$}  Biased: {bias}", ""));
        }
    }
    lines.join("\n")
}

fn integrators_json() -> Value {
    METHODS
        .iter()
        .map(|m| {
            json!({
                "id": m.id,
                "title": m.title,
                "name": m.name,
                "about": m.about,
                "blind_spots": m.blind_spots,
                "bias": m.bias,
                "is_default": m.id == DEFAULT_METHOD,
                "parameters": m.parameters.iter().map(|p| p.name).collect::<Vec<_>>(),
            })
        })
        .collect()
}

fn parameters() -> String {
    let mut lines = Vec::new();
    for m in METHODS {
        if m.parameters.is_empty() {
            lines.push(format!("{}: none", m.id));
            continue;
        }
        lines.push(format!("{}:", m.id));
        for p in m.parameters {
            let unit = if p.unit.is_empty() {
                String::new()
            } else {
                format!(", {}", p.unit)
            };
            // The first word is what --set takes.
            lines.push(format!(
                "  {}={}  {} ({}{unit})",
                p.name,
                p.format(p.default_value()),
                p.about,
                p.expected()
            ));
        }
    }
    lines.join("\n")
}

fn parameters_json() -> Value {
    METHODS
        .iter()
        .flat_map(|m| m.parameters.iter().map(|p| parameter_json(m.id, p)))
        .collect()
}

fn parameter_json(integrator: &str, p: &Parameter) -> Value {
    let (kind, default, range) = match p.kind {
        ParameterKind::Integer { default, min, max } => {
            ("integer", json!(default), json!([min, max]))
        }
        ParameterKind::Real {
            default, min, max, ..
        } => ("real", json!(default), json!([min, max])),
        ParameterKind::Switch { default } => ("switch", json!(default), Value::Null),
        ParameterKind::Choice { default, options } => {
            ("choice", json!(options.get(default)), json!(options))
        }
    };
    json!({
        "integrator": integrator,
        "name": p.name,
        "title": p.title,
        "unit": p.unit,
        "about": p.about,
        "kind": kind,
        "default": default,
        "range": range,
    })
}

#[cfg(test)]
mod tests {
    use neumann_core::integrator::{METHODS, ParameterValues};

    #[test]
    fn what_is_listed_is_what_set_takes() {
        let text = super::parameters();
        let mut n_taken = 0;
        for method in METHODS {
            let block = text.split_once(&format!("{}:", method.id)).unwrap().1;
            for p in method.parameters {
                let line = block
                    .lines()
                    .find(|line| line.trim_start().starts_with(&format!("{}=", p.name)))
                    .unwrap();
                let (name, value) = line
                    .split_whitespace()
                    .next()
                    .unwrap()
                    .split_once('=')
                    .unwrap();
                let defaults = ParameterValues::defaults(method.parameters);
                // In both spellings: words joined by hyphens, and as they once were.
                for name in [name.to_owned(), name.replace('-', "_")] {
                    let mut values = defaults.clone();
                    values.set(method.parameters, &name, value).unwrap();
                    assert_eq!(values, defaults, "{} {line}", method.id);
                }
                assert!(!p.name.contains('_'), "{}: join words by hyphens", p.name);
                n_taken += 1;
            }
        }
        assert!(n_taken > 20, "{n_taken}");
    }
}
