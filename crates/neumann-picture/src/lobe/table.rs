//! Values as comma-separated text.

use std::fmt::Write;

use neumann_core::radiometry::Rgb;
use neumann_core::render::lobe::{Lobes, Viewed};

/// The curves of polar plots (`polar`: the viewer's angle, that of the direction with the viewer's
/// side negative, `f` in red, green and blue, 1/sr, the density, 1/sr), mirror-like lobes
/// (`specular`: the share of the light, and the probability), and the albedo over the viewer's
/// angle (`albedo`).
#[must_use]
pub fn csv(lobes: &Lobes) -> String {
    let mut text = "curve,viewer_deg,direction_deg,red,green,blue,pdf_w\n".to_owned();
    let mut row = |curve: &str, viewer: f32, direction: Option<f32>, rgb: Rgb, p: Option<f32>| {
        let some = |value: Option<f32>| value.map_or(String::new(), |v| v.to_string());
        let (direction, p) = (some(direction), some(p));
        let [r, g, b] = rgb.to_array();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{curve},{viewer},{direction},{r},{g},{b},{p}");
    };
    for view in &lobes.views {
        let Viewed { angle, polar, .. } = view;
        for point in polar {
            row(
                "polar",
                *angle,
                Some(point.angle),
                point.f,
                Some(point.pdf_w),
            );
        }
        for lobe in &view.drawn.deltas {
            let direction = lobe.wi.x.atan2(lobe.wi.z).to_degrees();
            let p = Some(lobe.probability);
            row("specular", *angle, Some(direction), lobe.share, p);
        }
    }
    for at in &lobes.albedo {
        row("albedo", at.angle, None, at.albedo, None);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::csv;
    use crate::lobe::tests::grey;

    #[test]
    fn every_row_has_its_columns() {
        let lobes = grey();
        let text = csv(&lobes);
        assert!(text.lines().all(|line| line.split(',').count() == 7));
        let n = |curve: &str| text.lines().filter(|l| l.starts_with(curve)).count();
        assert_eq!(n("albedo,"), lobes.albedo.len());
        assert_eq!(
            n("polar,"),
            lobes.views.iter().map(|v| v.polar.len()).sum::<usize>()
        );
        let row = text.lines().find(|line| line.starts_with("albedo,30,"));
        let cells: Vec<&str> = row.expect("a row").split(',').collect();
        let red: f32 = cells[3].parse().expect("a number");
        assert!((red - 0.5).abs() < 1e-5 && cells[2].is_empty() && cells[6].is_empty());
    }
}
