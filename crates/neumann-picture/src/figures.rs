//! Numbers as people read them.

/// A number with its name.
#[derive(Clone, Debug)]
pub struct Figure {
    /// What it is called.
    pub name: &'static str,
    /// Its value.
    pub text: String,
    /// What it is, in a sentence.
    pub about: &'static str,
}

/// A number with so many significant figures, without needless zeros.
#[must_use]
pub fn significant(value: f64, figures: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 {
            "0".to_owned()
        } else {
            value.to_string()
        };
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-4..7).contains(&magnitude) {
        return format!("{value:.*e}", figures.saturating_sub(1));
    }
    let decimals = (figures as i32 - 1 - magnitude).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn numbers_are_short() {
        assert_eq!(significant(0.30, 3), "0.3");
        assert_eq!(significant(12.345, 3), "12.3");
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(significant(1234.0, 3), "1234");
    }
}
