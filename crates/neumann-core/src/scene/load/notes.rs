//! What the loader tells the user.

use super::error::one_line;

/// More warnings than this are only counted.
const MOST_WARNINGS: usize = 100;

/// Warnings and counts gathered on the way.
#[derive(Debug, Default)]
pub(super) struct Notes {
    warnings: Vec<String>,
    n_unsaid: usize,
    /// Points left out.
    pub(super) n_points_skipped: usize,
    /// Line segments left out.
    pub(super) n_lines_skipped: usize,
}

impl Notes {
    /// Notes a sentence for the user.
    pub(super) fn warn(&mut self, sentence: impl AsRef<str>) {
        if self.warnings.len() < MOST_WARNINGS {
            self.warnings.push(one_line(sentence.as_ref()));
        } else {
            self.n_unsaid += 1;
        }
    }

    /// The warnings, the last of which counts those left unsaid.
    pub(super) fn into_warnings(mut self) -> Vec<String> {
        if self.n_unsaid > 0 {
            self.warnings
                .push(format!("there are {} further warnings", self.n_unsaid));
        }
        self.warnings
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST_WARNINGS, Notes};

    #[test]
    fn warnings_beyond_the_limit_are_counted() {
        let mut notes = Notes::default();
        for i in 0..MOST_WARNINGS + 5 {
            notes.warn(format!("{i}"));
        }
        let warnings = notes.into_warnings();
        assert_eq!(warnings.len(), MOST_WARNINGS + 1);
        assert_eq!(warnings[MOST_WARNINGS], "there are 5 further warnings");
    }
}
