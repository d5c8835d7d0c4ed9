//! Who takes part in a comparison: a method with the parameters of its page, or with some of its
//! own.

use neumann_core::integrator::METHODS;
use neumann_picture::race::{Entrant, MOST};
use neumann_picture::state::Racing;

use crate::setup::Setup;

/// Who takes part.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A method, by its place among all, with the parameters that its page has.
    OfPage(usize),
    /// A method with parameters of its own.
    Own(Entrant),
}

impl Entry {
    /// The method with its parameters.
    #[must_use]
    pub fn entrant(&self, setup: &Setup) -> Entrant {
        match self {
            Self::OfPage(index) => Entrant::new(METHODS[*index], &setup.values[*index]),
            Self::Own(entrant) => entrant.clone(),
        }
    }

    /// As it stands in a state.
    #[must_use]
    pub fn state(&self) -> Racing {
        match self {
            Self::OfPage(index) => Racing::OfPage(METHODS[*index].id.to_owned()),
            Self::Own(entrant) => Racing::Own(entrant.name.clone()),
        }
    }

    /// From a state; `None` if there is no such method.
    #[must_use]
    pub fn of_state(state: &Racing) -> Option<Self> {
        let entrant = state.entrant().ok()?;
        Some(match state {
            Racing::OfPage(id) => Self::OfPage(METHODS.iter().position(|m| m.id == id)?),
            Racing::Own(_) => Self::Own(entrant),
        })
    }

    /// Place of the method among all.
    #[must_use]
    pub fn method(&self, setup: &Setup) -> usize {
        let id = self.entrant(setup).method.id;
        METHODS.iter().position(|m| m.id == id).unwrap_or(0)
    }
}

/// Rows of methods that are worth comparing.
const ROWS: [[&str; 3]; 3] = [
    ["pt-bsdf", "pt-nee", "pt-mis"],
    ["pt-mis", "bdpt", "vcm"],
    ["pm", "ppm", "vcm"],
];

/// Three methods, the given one among them.
pub(super) fn row_with(method: usize) -> Vec<Entry> {
    let id = METHODS[method].id;
    let row = ROWS.into_iter().find(|row| row.contains(&id));
    let row = row.unwrap_or([id, "pt-mis", "bdpt"]);
    let position = |id: &str| METHODS.iter().position(|m| m.id == id);
    row.into_iter()
        .filter_map(position)
        .map(Entry::OfPage)
        .collect()
}

/// A method that sees the same as a given one and is not biased; any other one where there is none.
pub(super) fn partner(method: usize) -> usize {
    let of = METHODS[method];
    let usual = ["pt-mis", "bdpt"].map(|id| METHODS.iter().position(|m| m.id == id));
    let mut others = usual.into_iter().flatten().chain(0..METHODS.len());
    let sees_the_same = |i: &usize| {
        let other = METHODS[*i];
        *i != method && other.sight == of.sight && other.bias.is_none()
    };
    let same = others.clone().find(sees_the_same);
    same.or_else(|| others.find(|i| *i != method))
        .unwrap_or(method)
}

/// Adds a method that is not there yet.
pub(super) fn add(entries: &mut Vec<Entry>) {
    let is_there = |i: &usize| {
        let id = METHODS[*i].id;
        entries.iter().any(|entry| match entry {
            Entry::OfPage(index) => index == i,
            Entry::Own(entrant) => entrant.method.id == id,
        })
    };
    let usual = ROWS.into_iter().flatten();
    let usual = usual.filter_map(|id| METHODS.iter().position(|m| m.id == id));
    let free = usual.chain(0..METHODS.len()).find(|i| !is_there(i));
    if let Some(index) = free.filter(|_| entries.len() < MOST) {
        entries.push(Entry::OfPage(index));
    }
}

#[cfg(test)]
mod tests {
    use neumann_core::integrator::METHODS;

    use super::{Entry, add, partner, row_with};

    #[test]
    fn every_method_has_a_row_of_three_with_it_in_it() {
        for method in 0..METHODS.len() {
            let mut row = row_with(method);
            assert_eq!(row.len(), 3);
            assert!(row.contains(&Entry::OfPage(method)));
            add(&mut row);
            assert_eq!(row.len(), 4);
            for (i, a) in row.iter().enumerate() {
                assert!(!row[i + 1..].contains(a), "{a:?} twice");
            }
            add(&mut row);
            assert_eq!(row.len(), 4, "no more than that");
        }
    }

    #[test]
    fn a_partner_is_another_method_and_sees_the_same_where_there_is_one() {
        let position = |id: &str| METHODS.iter().position(|m| m.id == id).unwrap();
        for (id, other) in [("bdpt", "pt-mis"), ("pt-mis", "bdpt"), ("ppm", "pt-mis")] {
            assert_eq!(partner(position(id)), position(other), "{id}");
        }
        for method in 0..METHODS.len() {
            assert_ne!(partner(method), method);
        }
    }
}
