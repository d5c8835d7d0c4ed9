//! Which part of the series is looked at.

use std::fmt;
use std::str::FromStr;

/// One term of the series, a partial sum, or all of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum View {
    /// `L`, the whole sum.
    #[default]
    Total,
    /// `T^k L_e` alone.
    Term(usize),
    /// Every bounce beyond the kept layers.
    Tail,
    /// `L_e + … + T^k L_e`.
    Upto(usize),
}

impl View {
    /// The layers that add up to this view on a film of `n_layers` bounce layers
    /// and a tail (layer number `n_layers`); `None` if the film does not keep them apart.
    #[must_use]
    pub fn layers(self, n_layers: usize) -> Option<std::ops::Range<usize>> {
        match self {
            Self::Total => Some(0..n_layers + 1),
            Self::Term(k) if k < n_layers => Some(k..k + 1),
            Self::Tail => Some(n_layers..n_layers + 1),
            Self::Upto(k) if k < n_layers => Some(0..k + 1),
            Self::Term(_) | Self::Upto(_) => None,
        }
    }

    /// One line on what the view shows.
    #[must_use]
    pub fn caption(self) -> String {
        match self {
            Self::Total => "all light".to_owned(),
            Self::Term(0) => "light emitted towards the camera".to_owned(),
            Self::Term(1) => "light scattered exactly once".to_owned(),
            Self::Term(2) => "light scattered exactly twice".to_owned(),
            Self::Term(k) => format!("light scattered exactly {k} times"),
            Self::Tail => "light scattered more often than the terms shown".to_owned(),
            Self::Upto(0) => "emitted light alone".to_owned(),
            Self::Upto(1) => "light scattered at most once".to_owned(),
            Self::Upto(2) => "light scattered at most twice".to_owned(),
            Self::Upto(k) => format!("light scattered at most {k} times"),
        }
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Total => write!(f, "L"),
            Self::Term(k) => write!(f, "T{k}"),
            Self::Tail => write!(f, "tail"),
            Self::Upto(k) => write!(f, "upto:{k}"),
        }
    }
}

/// The text is not the name of a view.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is not a view; use L, T0, T1, …, tail, or upto:K")]
pub struct ViewError(String);

impl FromStr for View {
    type Err = ViewError;

    fn from_str(text: &str) -> Result<Self, ViewError> {
        let error = || ViewError(text.to_owned());
        match text {
            "L" => Ok(Self::Total),
            "tail" => Ok(Self::Tail),
            _ => {
                if let Some(k) = text.strip_prefix("upto:") {
                    k.parse().map(Self::Upto).map_err(|_| error())
                } else if let Some(k) = text.strip_prefix('T') {
                    k.parse().map(Self::Term).map_err(|_| error())
                } else {
                    Err(error())
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::View;

    #[test]
    fn names_read_back() {
        for view in [View::Total, View::Term(3), View::Tail, View::Upto(2)] {
            assert_eq!(view.to_string().parse(), Ok(view));
        }
        assert!("T".parse::<View>().is_err());
    }
}
