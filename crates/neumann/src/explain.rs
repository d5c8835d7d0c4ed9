//! `neumann explain`: how a method estimates light, as a formula and in pseudo-code.

use neumann_core::integrator::{METHODS, Method, NOTATION};
use serde_json::{Value, json};

use crate::cli::ExplainArguments;
use crate::console;
use crate::failure::Outcome;

pub(crate) fn run(arguments: &ExplainArguments) -> Outcome {
    let is_asked = |m: &&&Method| arguments.integrator.as_ref().is_none_or(|id| id == m.id);
    let methods = || METHODS.iter().filter(is_asked);
    if arguments.json {
        return console::json(&methods().map(|m| explanation_json(m)).collect::<Value>());
    }
    let mut texts: Vec<_> = methods().map(|m| explanation(m)).collect();
    texts.push(NOTATION.to_owned());
    console::result(&texts.join("\n\n"))
}

fn explanation(m: &Method) -> String {
    let mut lines = vec![format!("{}: {}", m.id, m.name), format!("  {}", m.formula)];
    lines.push(String::new());
    lines.extend(m.pseudo_code.lines().map(|line| format!("  {line}")));
    lines.join("\n")
}

fn explanation_json(m: &Method) -> Value {
    json!({ "id": m.id, "name": m.name, "formula": m.formula, "pseudo_code": m.pseudo_code })
}
