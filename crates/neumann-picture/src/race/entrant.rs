//! What is entered into a race: a method with its parameters.

use neumann_core::integrator::{Method, ParameterValues, method};
use neumann_core::render::RenderSettings;

/// A method with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Entrant {
    /// What it is called: id, and after a colon those parameters that are not as usual.
    pub name: String,
    /// The method.
    pub method: &'static Method,
    /// Its parameters.
    pub values: ParameterValues,
}

impl Entrant {
    /// A method by its id, with parameters behind a colon: `pt-mis:roulette=off,casters=off`.
    ///
    /// # Errors
    /// Says what is wrong with the name.
    pub fn parse(name: &str) -> Result<Self, String> {
        let (id, set) = name.split_once(':').unwrap_or((name, ""));
        let method = method(id).ok_or_else(|| {
            format!("no integrator '{id}'; 'neumann list integrators' names them")
        })?;
        let mut values = ParameterValues::defaults(method.parameters);
        for assignment in set.split(',').filter(|text| !text.is_empty()) {
            let (parameter, value) = assignment
                .split_once('=')
                .ok_or_else(|| format!("{name}: '{assignment}' is no NAME=VALUE"))?;
            values
                .set(method.parameters, parameter, value)
                .map_err(|e| format!("{name}: {e}"))?;
        }
        Ok(Self {
            name: name.to_owned(),
            method,
            values,
        })
    }

    /// A method with parameters, named so that [`Self::parse`] reads them back.
    #[must_use]
    pub fn new(method: &'static Method, values: &ParameterValues) -> Self {
        let unusual = method.parameters.iter().filter_map(|parameter| {
            let value = values.value(parameter.name)?;
            let text = parameter.format(value);
            let is_usual = text == parameter.format(parameter.default_value());
            (!is_usual).then(|| format!("{}={text}", parameter.name))
        });
        let set: Vec<String> = unusual.collect();
        let colon = if set.is_empty() { "" } else { ":" };
        Self {
            name: format!("{}{colon}{}", method.id, set.join(",")),
            method,
            values: values.clone(),
        }
    }

    /// What renders it; everything but the method is as in `common`.
    #[must_use]
    pub fn settings(&self, common: &RenderSettings) -> RenderSettings {
        RenderSettings {
            method: self.method,
            values: self.values.clone(),
            ..common.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Entrant;

    #[test]
    fn a_name_is_read_back_as_it_was_written() {
        for name in ["pt-mis", "pt-mis:roulette=off", "bdpt"] {
            let entrant = Entrant::parse(name).unwrap();
            let written = Entrant::new(entrant.method, &entrant.values);
            assert_eq!(written, entrant);
        }
        // What is as usual is not worth a word.
        let entrant = Entrant::parse("pt-mis:roulette=on").unwrap();
        assert_eq!(Entrant::new(entrant.method, &entrant.values).name, "pt-mis");
        let wrong = |name: &str| Entrant::parse(name).unwrap_err();
        assert!(wrong("pt-mos").contains("no integrator 'pt-mos'"));
        assert!(wrong("pt-mis:roulette").contains("is no NAME=VALUE"));
        assert!(wrong("pt-mis:rulette=on").contains("rulette"));
    }
}
