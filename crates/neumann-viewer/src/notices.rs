//! Notices: what the window has to say, until it has been read.

use std::path::PathBuf;

use egui::{Align2, Context, Frame, Id, Label, Margin, RichText, Stroke};

use crate::setup::Snapshot;
use crate::theme::{self, GRID, Palette};
use crate::widgets::{Icon, button, button_width, icon_button};

/// Sentences for the user, newest last.
#[derive(Debug, Default)]
pub struct Notices {
    entries: Vec<Notice>,
}

/// What a notice can do at a click.
#[derive(Clone, Debug)]
pub enum Offer {
    /// Take away the sky that was added by default.
    RemoveSky,
    /// Look through the backs of single-sided surfaces.
    LookThroughBacks,
    /// Put back a sky that was removed.
    PutSkyBack(Box<Snapshot>),
    /// A dropped file that was taken for a sky is a reference; the sky was that of this one.
    TakeAsReference(PathBuf, Option<Box<Snapshot>>),
    /// A dropped file that was taken for a reference is a sky.
    TakeAsSky(PathBuf),
    /// Show the folder of a file that was saved.
    ShowFolder(PathBuf),
}

impl Offer {
    /// What comes of it, in a sentence.
    fn about(&self) -> &'static str {
        match self {
            Self::RemoveSky => "Takes away the sky that was added to the scene.",
            Self::LookThroughBacks => {
                "Leaves out single-sided surfaces that the camera sees from behind."
            }
            Self::PutSkyBack(_) => "Brings back the sky that was removed.",
            Self::TakeAsReference(..) => "Takes the dropped file for a reference to compare with.",
            Self::ShowFolder(_) => "Opens the folder of the file, or copies its path.",
            Self::TakeAsSky(_) => "Takes the dropped file for an environment map.",
        }
    }
}

#[derive(Debug)]
struct Notice {
    text: String,
    /// A button with these words.
    offer: Option<(&'static str, Offer)>,
    /// Seconds of egui's clock after which it goes by itself; failures stay.
    until: Option<f64>,
}

impl Notices {
    /// Something went wrong: stays until closed.
    pub fn failure(&mut self, text: impl Into<String>) {
        self.push(text.into(), None, None);
    }

    /// Something can be done otherwise at a click: stays until closed or clicked.
    pub fn offer(&mut self, text: impl Into<String>, label: &'static str, offer: Offer) {
        self.push(text.into(), Some((label, offer)), None);
    }

    /// Something was done: goes by itself.
    pub fn remark(&mut self, ctx: &Context, text: impl Into<String>) {
        let until = ctx.input(|i| i.time) + 6.0;
        self.push(text.into(), None, Some(until));
    }

    /// A file was saved: goes by itself; a button shows its folder until then.
    pub fn saved(&mut self, ctx: &Context, path: PathBuf) {
        let until = ctx.input(|i| i.time) + 12.0;
        let text = format!("Saved {}", path.display());
        self.push(
            text,
            Some(("Show folder", Offer::ShowFolder(path))),
            Some(until),
        );
    }

    /// As [`Self::remark`], in place of those that begin so.
    pub fn remark_instead(&mut self, ctx: &Context, beginnings: &[&str], text: String) {
        let is_older = |text: &str| beginnings.iter().any(|b| text.starts_with(b));
        self.entries.retain(|n| !is_older(&n.text));
        self.remark(ctx, text);
    }

    fn push(&mut self, text: String, offer: Option<(&'static str, Offer)>, until: Option<f64>) {
        self.entries.retain(|n| n.text != text);
        self.entries.push(Notice { text, offer, until });
        let excess = self.entries.len().saturating_sub(4);
        self.entries.drain(..excess);
    }

    /// The texts now shown.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|n| n.text.as_str())
    }

    /// Closes the newest; true if there was one.
    pub fn close_newest(&mut self) -> bool {
        self.entries.pop().is_some()
    }

    /// Takes back what is no longer to be had.
    pub fn withdraw(&mut self, is_gone: impl Fn(&Offer) -> bool) {
        self.entries
            .retain(|n| n.offer.as_ref().is_none_or(|(_, offer)| !is_gone(offer)));
    }

    /// Draws them in the lower left corner of `area`; yields the offer that was taken.
    pub fn show(&mut self, ctx: &Context, area: egui::Rect) -> Option<Offer> {
        let now = ctx.input(|i| i.time);
        self.entries.retain(|n| n.until.is_none_or(|t| t > now));
        if let Some(next) = self.entries.iter().filter_map(|n| n.until).reduce(f64::min) {
            ctx.request_repaint_after_secs((next - now).max(0.05) as f32);
        }
        if self.entries.is_empty() {
            return None;
        }
        let mut closed = None;
        let mut taken = None;
        egui::Area::new(Id::unique("notices"))
            .anchor(
                Align2::LEFT_BOTTOM,
                egui::vec2(
                    area.left() + 2.0 * GRID,
                    area.bottom() - ctx.content_rect().bottom() - 2.0 * GRID,
                ),
            )
            .show(ctx, |ui| {
                let p = Palette::of(ui);
                for (i, notice) in self.entries.iter().enumerate() {
                    Frame::new()
                        .fill(p.panel)
                        .stroke(Stroke::new(1.0, p.line))
                        .corner_radius(6)
                        .inner_margin(Margin {
                            left: 12,
                            right: 4,
                            top: 4,
                            bottom: 4,
                        })
                        .show(ui, |ui| {
                            ui.horizontal(|ui| {
                                let beside = notice.offer.as_ref().map_or(0.0, |(label, _)| {
                                    button_width(ui, label) + ui.spacing().item_spacing.x
                                });
                                let room = area.width() - 100.0 - beside;
                                let width = room.clamp(120.0, 480.0);
                                ui.scope(|ui| {
                                    ui.set_max_width(width);
                                    let text = RichText::new(&notice.text).font(theme::body());
                                    ui.add(Label::new(text).wrap());
                                });
                                if let Some((label, offer)) = &notice.offer
                                    && button(ui, label).on_hover_text(offer.about()).clicked()
                                {
                                    taken = Some(offer.clone());
                                    closed = Some(i);
                                }
                                let about = "Takes it away; it has been read.";
                                let (icon, name) = (Icon::Close, "Close notice");
                                if icon_button(ui, icon, name, "Esc", about).clicked() {
                                    closed = Some(i);
                                }
                            });
                        });
                }
            });
        if let Some(i) = closed {
            self.entries.remove(i);
        }
        taken
    }
}
