//! How large texts and controls are: kept from one start to the next.

use std::path::PathBuf;

use egui::{Context, Vec2};

use crate::memory;

/// Size of texts and controls, as a share of their usual size.
#[derive(Clone, Debug)]
pub struct TextScale {
    /// In tenths, so that steps come back to where they began.
    tenths: u32,
    /// Where it is kept; `None` keeps it for this run only.
    file: Option<PathBuf>,
}

const USUAL: u32 = 10;
const RANGE: (u32, u32) = (5, 30);

/// Least room for bars and panel, points: they are not enlarged beyond it.
const LEAST_ROOM: Vec2 = Vec2::new(480.0, 300.0);

/// Height of a window that is presented, points.
const PRESENTED_HEIGHT: f32 = 540.0;

impl Default for TextScale {
    fn default() -> Self {
        Self {
            tenths: USUAL,
            file: None,
        }
    }
}

impl TextScale {
    /// That of the last run.
    #[must_use]
    pub fn load() -> Self {
        Self::load_from(memory::file("text-scale.txt"))
    }

    /// That in a file, where it is kept; the usual one if there is none.
    #[must_use]
    pub fn load_from(file: Option<PathBuf>) -> Self {
        let text = file.as_ref().and_then(|f| std::fs::read_to_string(f).ok());
        let number = text.and_then(|text| text.trim().parse::<f32>().ok());
        let tenths = number.map_or(USUAL, |scale| (scale * 10.0).round() as u32);
        Self {
            tenths: tenths.clamp(RANGE.0, RANGE.1),
            file,
        }
    }

    /// Larger or smaller by so many tenths; 0 is the usual size.
    pub fn step(&mut self, tenths: i32) {
        self.tenths = match tenths {
            0 => USUAL,
            _ => self
                .tenths
                .saturating_add_signed(tenths)
                .clamp(RANGE.0, RANGE.1),
        };
        if let Some(file) = &self.file {
            memory::keep(file, &format!("{}\n", self.factor()));
        }
    }

    /// 1 is the usual size.
    #[must_use]
    pub fn factor(&self) -> f32 {
        self.tenths as f32 / 10.0
    }

    /// Has the next frame drawn in this size, as far as the window has room for it; so large that
    /// it is read from the last row of a lecture room, if `is_presenting`.
    pub fn apply(&self, ctx: &Context, is_presenting: bool) {
        let window = ctx.content_rect().size() * ctx.zoom_factor();
        let most = (window / LEAST_ROOM).min_elem().max(1.0);
        let presented = if is_presenting {
            window.y / PRESENTED_HEIGHT
        } else {
            0.0
        };
        let factor = self.factor().max(presented).min(most);
        if (factor - ctx.zoom_factor()).abs() > 1e-3 {
            ctx.set_zoom_factor(factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::TextScale;

    #[test]
    fn it_stays_within_bounds_and_is_kept() {
        let folder = format!("neumann-text-scale-{}", std::process::id());
        let folder = std::env::temp_dir().join(folder);
        let file = folder.join("neumann").join("text-scale.txt");
        let mut scale = TextScale::load_from(Some(file.clone()));
        assert_eq!(scale.factor(), 1.0, "nothing is kept yet");
        scale.step(3);
        assert_eq!(TextScale::load_from(Some(file.clone())).factor(), 1.3);
        scale.step(100);
        assert_eq!(scale.factor(), 3.0);
        scale.step(-100);
        assert_eq!(scale.factor(), 0.5);
        scale.step(0);
        assert_eq!(TextScale::load_from(Some(file.clone())).factor(), 1.0);
        std::fs::write(&file, "nonsense").expect("it can be written");
        assert_eq!(TextScale::load_from(Some(file)).factor(), 1.0);
        std::fs::remove_dir_all(folder).expect("it is ours");
    }
}
