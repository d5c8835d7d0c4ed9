//! What stands below a picture: its formula and its share.

use neumann_core::film::View;

/// The formula of a view, with `^{…}` and `_{…}` for superscripts and subscripts.
#[must_use]
pub fn formula(view: View, n_layers: usize) -> String {
    match view {
        View::Total => "L".to_owned(),
        View::Term(0) | View::Upto(0) => "L_{e}".to_owned(),
        View::Term(1) => "TL_{e}".to_owned(),
        View::Term(k) => format!("T^{{{k}}}L_{{e}}"),
        View::Tail => format!("T^{{{n_layers}}}L_{{e}} + …"),
        View::Upto(1) => "L_{e} + TL_{e}".to_owned(),
        View::Upto(k) => format!("L_{{e}} + … + T^{{{k}}}L_{{e}}"),
    }
}

/// A share with as many figures as it deserves.
pub(super) fn percent(share: f64) -> String {
    let percent = share * 100.0;
    if percent == 0.0 {
        "0 %".to_owned()
    } else if percent < 0.01 {
        "< 0.01 %".to_owned()
    } else if percent < 1.0 {
        format!("{percent:.2} %")
    } else if percent < 99.95 {
        format!("{percent:.1} %")
    } else {
        "100 %".to_owned()
    }
}

#[cfg(test)]
mod tests {
    use neumann_core::film::View;

    use super::{formula, percent};

    #[test]
    fn formulas_and_shares_read_well() {
        assert_eq!(formula(View::Term(0), 8), "L_{e}");
        assert_eq!(formula(View::Term(12), 16), "T^{12}L_{e}");
        assert_eq!(formula(View::Tail, 8), "T^{8}L_{e} + …");
        assert_eq!(percent(0.5), "50.0 %");
        assert_eq!(percent(0.001_234), "0.12 %");
        assert_eq!(percent(1.0), "100 %");
        assert_eq!(percent(0.0), "0 %");
        assert_eq!(percent(1e-9), "< 0.01 %");
    }
}
