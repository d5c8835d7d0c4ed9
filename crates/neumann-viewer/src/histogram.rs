//! The histogram of the picture on the Display page: live, of a sample of its pixels.

use std::time::{Duration, Instant};

use egui::{Align2, Color32, Rect, Role, Sense, Ui, Vec2, WidgetInfo, pos2};
use neumann_core::film::View as Part;
use neumann_core::radiometry::Rgb;
use neumann_picture::histogram::{Channels, Histogram, RANGE, Window};

use crate::display::ViewSettings;
use crate::session::Session;
use crate::theme::{self, GRID, Palette};
use crate::widgets::significant;

/// The histogram, and what it was made of.
#[derive(Clone, Debug, Default)]
pub struct LiveHistogram {
    /// What is counted.
    pub channels: Channels,
    sample: Vec<Rgb>,
    /// Of which version and generation of the picture, and of which part, the sample is, and when
    /// it was taken.
    taken: Option<([u64; 2], Part, Instant)>,
    counted: Option<Counted>,
}

#[derive(Clone, Debug)]
struct Counted {
    channels: Channels,
    window: Window,
    histogram: Histogram,
}

/// A sample is taken no more often than this,
const PERIOD: Duration = Duration::from_millis(250);
/// of so many pixels at most.
const LARGEST_SAMPLE: usize = 1 << 16;
const HEIGHT: f32 = 72.0;

impl LiveHistogram {
    /// Counts the pixels of what is shown, if it has changed and it is time.
    pub fn update(&mut self, session: &Session, settings: &ViewSettings) {
        let version = version_of(session);
        let part = settings.part;
        let is_due = self.taken.is_none_or(|(before, of, at)| {
            of != part || (before != version && at.elapsed() >= PERIOD)
        });
        if is_due && session.picture.is_there() {
            session.picture.read_film(&session.link, |film, _, _| {
                let step = step(film.n_pixels());
                self.sample.clear();
                for y in (step / 2..film.height()).step_by(step) {
                    let row = (step / 2..film.width()).step_by(step);
                    let pixels = row.map(|x| film.radiance(part, y * film.width() + x));
                    self.sample.extend(pixels);
                }
            });
            self.taken = Some((version, part, Instant::now()));
            self.counted = None;
        }
        let window = if settings.is_false_colour {
            Window::of_map(settings.map_range(), settings.exposure_ev)
        } else {
            Window::of_display(&settings.display())
        };
        let channels = self.channels;
        let is_counted =
            |counted: &Counted| counted.channels == channels && counted.window == window;
        if !self.counted.as_ref().is_some_and(is_counted) {
            self.counted = Some(Counted {
                channels,
                window,
                histogram: Histogram::of(&self.sample, channels, &window),
            });
        }
    }

    /// How long a sample of an older picture must wait yet for the next one.
    #[must_use]
    pub fn rest(&self, session: &Session) -> Option<Duration> {
        let (version, _, at) = self.taken?;
        (version != version_of(session)).then(|| PERIOD.saturating_sub(at.elapsed()))
    }

    /// Draws it as wide as the panel, with what cannot be told apart in words below.
    pub fn show(&self, ui: &mut Ui) {
        let Some(Counted {
            window, histogram, ..
        }) = &self.counted
        else {
            return;
        };
        let p = Palette::of(ui);
        let size = Vec2::new(ui.available_width(), HEIGHT + 14.0);
        let (area, response) = ui.allocate_exact_size(size, Sense::hover());
        let rect = Rect::from_min_size(area.min, Vec2::new(size.x, HEIGHT));
        let painter = ui.painter();
        painter.rect_filled(rect, 4, p.ground);
        let (first, last) = (*RANGE.start(), *RANGE.end());
        let x_of = |stops: f32| {
            let t = (stops.clamp(first, last) - first) / (last - first);
            rect.left() + t * rect.width()
        };
        let [dark, bright] = window.ends.map(x_of);
        let inside = Rect::from_x_y_ranges(dark..=bright.max(dark), rect.y_range());
        painter.rect_filled(inside, 0, p.raised);
        bars(ui, rect, histogram);
        for x in [dark, bright] {
            painter.vline(x, rect.y_range(), (1.0, p.amber));
        }
        for stops in [-8.0f32, -4.0, 0.0, 4.0] {
            let x = x_of(stops);
            painter.vline(x, rect.bottom() - 3.0..=rect.bottom(), (1.0, p.weak));
            let sign = if stops > 0.0 { "+" } else { "" };
            let text = format!("{sign}{stops}").replace('-', "−");
            let at = pos2(x, rect.bottom() + 1.0);
            painter.text(at, Align2::CENTER_TOP, text, theme::sized(9.5), p.weak);
        }
        let at = pos2(rect.right(), rect.bottom() + 1.0);
        painter.text(at, Align2::RIGHT_TOP, "EV", theme::sized(9.5), p.weak);
        let words = words(histogram);
        response
            .widget_info(|| WidgetInfo::labeled(Role::Image, true, format!("histogram: {words}")));
        let ends = window.ends.map(|end| significant(f64::from(end), 2));
        response.on_hover_text(format!(
            "Pixels by brightness, in stops about middle grey, after exposure. What is darker than \
             {} EV or brighter than {} EV (amber lines) cannot be told apart on the \
             screen. Heights grow as the root of the number of pixels.",
            ends[0].replace('-', "−"),
            ends[1].replace('-', "−"),
        ));
        ui.add_space(GRID / 2.0);
        crate::widgets::hint(ui, &words);
    }
}

/// Every so many pixels each way are counted.
fn step(n_pixels: usize) -> usize {
    let ratio = n_pixels as f64 / LARGEST_SAMPLE as f64;
    (ratio.sqrt().ceil() as usize).max(1)
}

/// What cannot be told apart.
fn words(histogram: &Histogram) -> String {
    let percent = |share: f32| {
        let percent = 100.0 * f64::from(share);
        let figures = if percent < 1.0 { 1 } else { 2 };
        format!("{} %", significant(percent, figures))
    };
    match (histogram.too_dark > 0.0, histogram.too_bright > 0.0) {
        (false, false) => "nothing too dark or too bright".to_owned(),
        _ => format!(
            "{} too dark, {} too bright",
            percent(histogram.too_dark),
            percent(histogram.too_bright)
        ),
    }
}

/// The bars, the highest of them as high as there is room.
fn bars(ui: &Ui, rect: Rect, histogram: &Histogram) {
    let p = Palette::of(ui);
    let highest = histogram.bars.iter().flatten().copied();
    // A single high bar, such as that of a lamp, does not flatten the others.
    let highest = highest.fold(0.0f32, f32::max).max(1e-6).sqrt();
    let hues = [
        Color32::from_rgb(206, 84, 76),
        Color32::from_rgb(92, 166, 92),
        Color32::from_rgb(86, 128, 214),
    ];
    let is_grey = histogram.bars.len() == 1;
    for (channel, bars) in histogram.bars.iter().enumerate() {
        let colour = if is_grey {
            p.fill
        } else {
            hues[channel].gamma_multiply(0.6)
        };
        let pitch = rect.width() / bars.len() as f32;
        for (i, share) in bars.iter().enumerate() {
            if *share <= 0.0 {
                continue;
            }
            let height = (share.sqrt() / highest * (rect.height() - 4.0)).max(1.0);
            let left = rect.left() + i as f32 * pitch;
            let bar = Rect::from_min_max(
                pos2(left, rect.bottom() - height),
                pos2(left + pitch, rect.bottom()),
            );
            ui.painter().rect_filled(bar, 0, colour);
        }
    }
}

/// What tells one picture from the next; one that is put back after a region has a generation of
/// its own.
fn version_of(session: &Session) -> [u64; 2] {
    [session.picture.version, session.picture.generation]
}

#[cfg(test)]
mod tests {
    use super::{LARGEST_SAMPLE, step};

    #[test]
    fn samples_are_bounded() {
        assert_eq!(step(1), 1);
        assert_eq!(step(LARGEST_SAMPLE), 1);
        for (w, h) in [(1280, 720), (8192, 8192), (8192, 1), (300, 220)] {
            let step = step(w * h);
            let n = |edge: usize| (step / 2..edge).step_by(step).count();
            assert!(n(w) * n(h) <= LARGEST_SAMPLE, "{w} {h}");
        }
    }
}
