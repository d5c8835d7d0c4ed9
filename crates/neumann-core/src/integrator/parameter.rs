//! Parameters that a method declares, so that menus, command line and
//! documentation need to know none of them by name.

use std::fmt;

/// A parameter of a method.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Name on the command line: `--set name=value`; words are joined by hyphens.
    pub name: &'static str,
    /// Name in a menu.
    pub title: &'static str,
    /// Unit, empty if it has none.
    pub unit: &'static str,
    /// What it means, one sentence.
    pub about: &'static str,
    /// Its type, range and default.
    pub kind: ParameterKind,
}

/// Type, range and default of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterKind {
    /// A whole number in `min..=max`.
    Integer {
        /// Where nothing else is asked for.
        default: i64,
        /// Smallest value.
        min: i64,
        /// Largest value.
        max: i64,
    },
    /// A real number in `min..=max`.
    Real {
        /// Where nothing else is asked for.
        default: f64,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
        /// True where a slider should be logarithmic.
        is_logarithmic: bool,
    },
    /// On or off.
    Switch {
        /// Where nothing else is asked for.
        default: bool,
    },
    /// One of several words.
    Choice {
        /// Where nothing else is asked for: an index into `options`.
        default: usize,
        /// The words.
        options: &'static [&'static str],
    },
}

/// The value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Of [`ParameterKind::Integer`].
    Integer(i64),
    /// Of [`ParameterKind::Real`].
    Real(f64),
    /// Of [`ParameterKind::Switch`].
    Switch(bool),
    /// Of [`ParameterKind::Choice`]: an index into its options.
    Choice(usize),
}

/// A parameter's name as it is spelled today: words were once joined by underscores.
#[must_use]
pub fn parameter_name(name: &str) -> String {
    name.replace('_', "-")
}

impl Parameter {
    /// The value where nothing else is asked for.
    #[must_use]
    pub fn default_value(&self) -> Value {
        match self.kind {
            ParameterKind::Integer { default, .. } => Value::Integer(default),
            ParameterKind::Real { default, .. } => Value::Real(default),
            ParameterKind::Switch { default } => Value::Switch(default),
            ParameterKind::Choice { default, .. } => Value::Choice(default),
        }
    }

    /// Reads a value as written on the command line.
    ///
    /// # Errors
    /// If the text is not of the parameter's type, or out of range.
    pub fn parse(&self, text: &str) -> Result<Value, ParameterError> {
        let error = || ParameterError::Value {
            name: self.name,
            text: text.to_owned(),
            expected: self.expected(),
        };
        match self.kind {
            ParameterKind::Integer { min, max, .. } => text
                .parse::<i64>()
                .ok()
                .filter(|v| (min..=max).contains(v))
                .map(Value::Integer)
                .ok_or_else(error),
            ParameterKind::Real { min, max, .. } => text
                .parse::<f64>()
                .ok()
                .filter(|v| (min..=max).contains(v))
                .map(Value::Real)
                .ok_or_else(error),
            ParameterKind::Switch { .. } => match text {
                "on" | "true" | "yes" | "1" => Ok(Value::Switch(true)),
                "off" | "false" | "no" | "0" => Ok(Value::Switch(false)),
                _ => Err(error()),
            },
            ParameterKind::Choice { options, .. } => options
                .iter()
                .position(|option| *option == text)
                .map(Value::Choice)
                .ok_or_else(error),
        }
    }

    /// A value as [`Self::parse`] reads it.
    #[must_use]
    pub fn format(&self, value: Value) -> String {
        match (value, self.kind) {
            (Value::Integer(v), _) => v.to_string(),
            (Value::Real(v), _) => v.to_string(),
            (Value::Switch(v), _) => if v { "on" } else { "off" }.to_owned(),
            (Value::Choice(i), ParameterKind::Choice { options, .. }) => {
                options.get(i).copied().unwrap_or_default().to_owned()
            }
            (Value::Choice(i), _) => i.to_string(),
        }
    }

    /// What values are possible, in words.
    #[must_use]
    pub fn expected(&self) -> String {
        match self.kind {
            ParameterKind::Integer { min, max, .. } => {
                format!("a whole number from {min} to {max}")
            }
            ParameterKind::Real { min, max, .. } => format!("a number from {min} to {max}"),
            ParameterKind::Switch { .. } => "on or off".to_owned(),
            ParameterKind::Choice { options, .. } => format!("one of {}", options.join(", ")),
        }
    }
}

/// The values of all parameters of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterValues {
    entries: Vec<(&'static str, Value)>,
}

impl ParameterValues {
    /// The defaults of the given parameters.
    #[must_use]
    pub fn defaults(parameters: &[Parameter]) -> Self {
        Self {
            entries: parameters
                .iter()
                .map(|p| (p.name, p.default_value()))
                .collect(),
        }
    }

    /// Sets one of the values; the name must be one of the method's, in any spelling that
    /// [`parameter_name`] takes.
    ///
    /// # Errors
    /// If the method has no parameter of that name, or the text is no value of it.
    pub fn set(
        &mut self,
        parameters: &[Parameter],
        name: &str,
        text: &str,
    ) -> Result<(), ParameterError> {
        let name = parameter_name(name);
        let parameter =
            parameters
                .iter()
                .find(|p| p.name == name)
                .ok_or_else(|| ParameterError::Name {
                    name: name.clone(),
                    known: if parameters.is_empty() {
                        "it has none".to_owned()
                    } else {
                        let names: Vec<_> = parameters.iter().map(|p| p.name).collect();
                        format!("it has {}", names.join(", "))
                    },
                })?;
        let value = parameter.parse(text)?;
        self.put(parameter.name, value);
        Ok(())
    }

    /// Sets a value that is known to be of the right type and range.
    pub fn put(&mut self, name: &'static str, value: Value) {
        match self.entries.iter_mut().find(|(n, _)| *n == name) {
            Some(entry) => entry.1 = value,
            None => self.entries.push((name, value)),
        }
    }

    /// The value of a parameter.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<Value> {
        self.entries
            .iter()
            .find(|(n, _)| *n == name)
            .map(|(_, value)| *value)
    }

    /// A whole number; 0 if the method declares none of that name.
    #[must_use]
    pub fn integer(&self, name: &str) -> i64 {
        match self.value(name) {
            Some(Value::Integer(v)) => v,
            _ => 0,
        }
    }

    /// A real number; 0 if the method declares none of that name.
    #[must_use]
    pub fn real(&self, name: &str) -> f64 {
        match self.value(name) {
            Some(Value::Real(v)) => v,
            _ => 0.0,
        }
    }

    /// A switch; off if the method declares none of that name.
    #[must_use]
    pub fn switch(&self, name: &str) -> bool {
        matches!(self.value(name), Some(Value::Switch(true)))
    }

    /// A choice, as an index into its options; 0 if the method declares none of that name.
    #[must_use]
    pub fn choice(&self, name: &str) -> usize {
        match self.value(name) {
            Some(Value::Choice(v)) => v,
            _ => 0,
        }
    }
}

/// A parameter was asked for that does not exist, or given a value that it cannot have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ParameterError {
    /// No such name.
    #[error("the integrator has no parameter '{name}'; {known}")]
    Name {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// No such value.
    #[error("'{text}' is no value for parameter '{name}'; use {expected}")]
    Value {
        /// The parameter.
        name: &'static str,
        /// What was given.
        text: String,
        /// What is possible.
        expected: String,
    },
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} ({})", self.name, self.about, self.expected())
    }
}
