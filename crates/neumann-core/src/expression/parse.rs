//! Reading expressions.

use super::automaton::{Automaton, Node};
use super::states::States;
use super::{Expression, ExpressionError, Light, Names, PRESETS, Pattern};
use crate::transport::Source;

/// Times that something may be repeated, at most, where a number says so.
const MAX_REPEATS: u32 = 64;
/// Brackets within brackets, at most.
const MAX_DEPTH: u32 = 32;
/// What light without a surface is called.
const ENVIRONMENT: &str = "environment";
const TOO_LARGE: &str = "the expression is too large; repeat less, or fewer things at once";

/// Letters of an expression's own name, at most.
const MAX_NAME: usize = 60;
/// Expressions side by side, at most.
const MAX_ALTERNATIVES: usize = 64;

/// Reads an expression.
pub(super) fn expression(text: &str, names: &Names<'_>) -> Result<Expression, ExpressionError> {
    let preset = PRESETS.iter().find(|(name, _)| *name == text.trim());
    let text = preset.map_or_else(|| text.to_owned(), |(name, text)| format!("{name}={text}"));
    let mut reader = Reader {
        letters: text.chars().collect(),
        at: 0,
        depth: 0,
        names,
    };
    if reader.letters.len() > Expression::MAX_LENGTH {
        reader.at = Expression::MAX_LENGTH;
        let what = format!(
            "an expression has at most {} characters",
            Expression::MAX_LENGTH
        );
        return Err(reader.error(what));
    }
    let name = reader.own_name()?;
    let start = reader.at;
    let (mut lights, mut automata) = (Vec::new(), Vec::new());
    loop {
        let (light, automaton) = reader.alternative()?;
        lights.push(light);
        automata.push(automaton);
        if !reader.take('|') {
            break;
        }
        if lights.len() == MAX_ALTERNATIVES {
            let what = format!("at most {MAX_ALTERNATIVES} expressions stand side by side");
            return Err(reader.error(what));
        }
    }
    if reader.peek().is_some() {
        return Err(reader.error("the expression has ended before this"));
    }
    let states = States::new(&automata).ok_or_else(|| reader.error(TOO_LARGE))?;
    let text: String = reader.letters[start..].iter().collect();
    let text = text.trim().to_owned();
    Ok(Expression {
        name: name.unwrap_or_else(|| text.clone()),
        text,
        lights,
        states,
    })
}

struct Reader<'a> {
    letters: Vec<char>,
    at: usize,
    depth: u32,
    names: &'a Names<'a>,
}

impl Reader<'_> {
    fn error(&self, what: impl Into<String>) -> ExpressionError {
        let letters = self.letters.iter();
        ExpressionError {
            // One line, however it was written.
            text: letters
                .map(|c| if c.is_control() { ' ' } else { *c })
                .collect(),
            at: self.at.min(self.letters.len()),
            what: what.into(),
        }
    }

    /// The name that stands before the expression, if there is one.
    fn own_name(&mut self) -> Result<Option<String>, ExpressionError> {
        let Some(end) = self.letters.iter().position(|letter| *letter == '=') else {
            return Ok(None);
        };
        let name: String = self.letters[..end].iter().collect();
        let name = name.trim().to_owned();
        let is_plain = |c: char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
        if name.is_empty() || name.len() > MAX_NAME || !name.chars().all(is_plain) {
            let what = format!(
                "a name before '=' has letters, digits, spaces, '-' and '_', {MAX_NAME} at most"
            );
            return Err(self.error(what));
        }
        self.at = end + 1;
        Ok(Some(name))
    }

    /// The next letter that means something.
    fn peek(&mut self) -> Option<char> {
        while self.letters.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
        self.letters.get(self.at).copied()
    }

    fn take(&mut self, letter: char) -> bool {
        let is_it = self.peek() == Some(letter);
        self.at += usize::from(is_it);
        is_it
    }

    /// An expression from one end to the other.
    fn alternative(&mut self) -> Result<(Light, Automaton), ExpressionError> {
        let is_from_light = match self.peek() {
            Some('L') => true,
            Some('E') => false,
            _ => {
                let what = "an expression begins with L or E, or is one of those with names";
                return Err(self.error(what));
            }
        };
        let mut light = self.end()?;
        let row = self.row()?;
        let last = if is_from_light { 'E' } else { 'L' };
        if self.peek() != Some(last) {
            let what = match self.peek() {
                None => format!("the expression ends without {last}"),
                Some(_) => format!("here stands what is no bounce; {last} ends the expression"),
            };
            return Err(self.error(what));
        }
        if is_from_light {
            self.end()?;
        } else {
            light = self.end()?;
        }
        // All are read from the eye on.
        let row = if is_from_light { row.reversed() } else { row };
        let automaton = Automaton::new(&row).ok_or_else(|| self.error(TOO_LARGE))?;
        Ok((light, automaton))
    }

    /// `L` or `E`.
    fn end(&mut self) -> Result<Light, ExpressionError> {
        let is_light = self.take('L');
        if !is_light {
            self.take('E');
            return Ok(Light::Any);
        }
        let at = self.at;
        match self.name()? {
            None => Ok(Light::Any),
            Some(name) if name == ENVIRONMENT => Ok(Light::Sources(vec![Source::Environment])),
            Some(name) => Ok(Light::Sources(self.sources(&name, at)?)),
        }
    }

    /// Parts one after the other.
    fn row(&mut self) -> Result<Node, ExpressionError> {
        let mut row = Vec::new();
        while let Some(node) = self.repeated()? {
            row.push(node);
        }
        Ok(Node::Row(row))
    }

    /// A part, with how often.
    fn repeated(&mut self) -> Result<Option<Node>, ExpressionError> {
        let Some(mut node) = self.part()? else {
            return Ok(None);
        };
        loop {
            let (least, most) = match self.peek() {
                Some('*') => (0, None),
                Some('+') => (1, None),
                Some('?') => (0, Some(1)),
                Some('{') => {
                    let (least, most) = self.numbers()?;
                    node = Node::Repeat(Box::new(node), least, most);
                    continue;
                }
                _ => return Ok(Some(node)),
            };
            self.at += 1;
            node = Node::Repeat(Box::new(node), least, most);
        }
    }

    /// `{2}`, `{2,5}` or `{2,}`.
    fn numbers(&mut self) -> Result<(u32, Option<u32>), ExpressionError> {
        let start = self.at;
        self.at += 1;
        let least = self.number()?;
        let most = if !self.take(',') {
            Some(least)
        } else if self.peek() == Some('}') {
            None
        } else {
            Some(self.number()?)
        };
        if !self.take('}') {
            return Err(self.error("'}' is missing here"));
        }
        if most.is_some_and(|most| most < least) {
            self.at = start;
            return Err(self.error("the second number is less than the first"));
        }
        Ok((least, most))
    }

    fn number(&mut self) -> Result<u32, ExpressionError> {
        self.peek();
        let start = self.at;
        while self.letters.get(self.at).is_some_and(char::is_ascii_digit) {
            self.at += 1;
        }
        let digits: String = self.letters[start..self.at].iter().collect();
        let number = digits.parse().ok().filter(|n| *n <= MAX_REPEATS);
        number.ok_or_else(|| {
            self.at = start;
            self.error(format!("use a whole number from 0 to {MAX_REPEATS}"))
        })
    }

    /// A bounce, or something in brackets; `None` where none begins.
    fn part(&mut self) -> Result<Option<Node>, ExpressionError> {
        if self.take('(') {
            self.deeper()?;
            let mut either = vec![self.row()?];
            while self.take('|') {
                either.push(self.row()?);
            }
            self.depth -= 1;
            if !self.take(')') {
                return Err(self.error("')' is missing here"));
            }
            return Ok(Some(Node::Either(either)));
        }
        if self.take('[') {
            let is_none = self.take('^');
            let mut patterns = Vec::new();
            while let Some(pattern) = self.pattern()? {
                patterns.push(pattern);
            }
            if !self.take(']') {
                return Err(self.error("']' is missing here; between [ and ] stand single bounces"));
            }
            if patterns.is_empty() {
                return Err(self.error("[] holds nothing"));
            }
            return Ok(Some(Node::One { patterns, is_none }));
        }
        let pattern = self.pattern()?;
        Ok(pattern.map(|pattern| Node::One {
            patterns: vec![pattern],
            is_none: false,
        }))
    }

    fn deeper(&mut self) -> Result<(), ExpressionError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.error("brackets are too deep"));
        }
        Ok(())
    }

    /// What may happen at a bounce; `None` where none begins.
    fn pattern(&mut self) -> Result<Option<Pattern>, ExpressionError> {
        let mut pattern = Pattern::ANY;
        match self.peek() {
            Some('D') => pattern.lobes = [true, false, false],
            Some('G') => pattern.lobes = [false, true, false],
            Some('S') => pattern.lobes = [false, false, true],
            Some('R') => pattern.directions = [true, false],
            Some('T') => pattern.directions = [false, true],
            Some('.') => {}
            Some('\'' | '"') => {
                let at = self.at;
                let name = self.name()?.unwrap_or_default();
                pattern.materials = Some(self.materials(&name, at)?);
                return Ok(Some(pattern));
            }
            Some('L' | 'E' | '|' | ')' | ']' | '*' | '+' | '?' | '{' | '}') | None => {
                return self.no_bounce();
            }
            Some(other) => {
                let what =
                    format!("'{other}' is no bounce; use D, G, S, R, T, . or a name in quotes");
                return Err(self.error(what));
            }
        }
        let is_lobe = pattern.directions == [true; 2] && pattern.lobes != [true; 3];
        self.at += 1;
        if is_lobe {
            match self.letters.get(self.at) {
                Some('r') => pattern.directions = [true, false],
                Some('t') => pattern.directions = [false, true],
                _ => self.at -= 1,
            }
            self.at += 1;
        }
        let at = self.at;
        if let Some(name) = self.name()? {
            pattern.materials = Some(self.materials(&name, at)?);
        }
        Ok(Some(pattern))
    }

    /// Nothing, unless it is how often nothing is repeated.
    fn no_bounce(&mut self) -> Result<Option<Pattern>, ExpressionError> {
        match self.peek() {
            Some(sign @ ('*' | '+' | '?' | '{')) => {
                Err(self.error(format!("'{sign}' says how often, but not what")))
            }
            _ => Ok(None),
        }
    }

    /// A name in quotes, if one begins right here.
    fn name(&mut self) -> Result<Option<String>, ExpressionError> {
        let Some(&quote @ ('\'' | '"')) = self.letters.get(self.at) else {
            return Ok(None);
        };
        let start = self.at;
        let rest = &self.letters[start + 1..];
        let Some(length) = rest.iter().position(|letter| *letter == quote) else {
            return Err(self.error("the name that begins here does not end"));
        };
        let name = rest[..length].iter().collect();
        self.at = start + length + 2;
        Ok(Some(name))
    }

    /// The materials and lights of a name that was read at `at`.
    fn sources(&mut self, name: &str, at: usize) -> Result<Vec<Source>, ExpressionError> {
        let materials = (self.names.materials)(name).into_iter();
        let lights = (self.names.lights)(name).into_iter();
        let materials = materials.map(Source::Material);
        let found: Vec<Source> = materials.chain(lights.map(Source::Punctual)).collect();
        if found.is_empty() {
            self.at = at;
            let what = format!("no material or light of the scene is called '{name}'");
            return Err(self.error(what));
        }
        Ok(found)
    }

    /// The materials of a name that was read at `at`.
    fn materials(&mut self, name: &str, at: usize) -> Result<Vec<u32>, ExpressionError> {
        let found = (self.names.materials)(name);
        if found.is_empty() {
            self.at = at;
            return Err(self.error(format!("no material of the scene is called '{name}'")));
        }
        Ok(found)
    }
}
