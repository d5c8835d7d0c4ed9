//! A list of files to choose from, where the desktop has no dialog for it.

use std::path::{Path, PathBuf};

use egui::{
    Align2, Area, Context, Frame, Id, Key, Margin, Modifiers, Order, ScrollArea, Stroke, Ui,
};

use crate::scene_source::Wanted;
use crate::theme::{GRID, Palette};
use crate::widgets::{heading, hint, row_button};

/// Folders and files of one folder, one of them chosen.
#[derive(Debug)]
pub struct FileList {
    wanted: Wanted,
    folder: PathBuf,
    entries: Vec<Entry>,
    chosen: usize,
    /// The chosen one is to be scrolled to.
    has_moved: bool,
}

#[derive(Debug)]
struct Entry {
    name: String,
    is_folder: bool,
}

/// What came of a frame.
#[derive(Debug, PartialEq, Eq)]
pub enum Choice {
    /// A file.
    File(Wanted, PathBuf),
    /// Nothing, and nothing is wanted any more.
    Closed,
}

impl FileList {
    /// What is wanted of the files in a folder.
    #[must_use]
    pub fn new(wanted: Wanted, folder: PathBuf) -> Self {
        let mut list = Self {
            wanted,
            folder: PathBuf::new(),
            entries: Vec::new(),
            chosen: 0,
            has_moved: false,
        };
        list.enter(folder);
        list
    }

    /// The folder that is shown.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Names of what it holds, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|entry| entry.name.as_str())
    }

    /// Takes its keys, which do nothing else while it is shown.
    pub fn take_keys(&mut self, ctx: &Context) -> Option<Choice> {
        let presses = |key| ctx.input_mut(|i| i.count_and_consume_key(Modifiers::NONE, key));
        let down = presses(Key::ArrowDown) + 10 * presses(Key::PageDown);
        let up = presses(Key::ArrowUp) + 10 * presses(Key::PageUp);
        if down + up > 0 {
            let last = self.entries.len().saturating_sub(1);
            self.chosen = (self.chosen + down).min(last).saturating_sub(up);
            self.has_moved = true;
        }
        if presses(Key::Backspace) > 0 {
            self.leave();
        }
        if presses(Key::Escape) > 0 {
            return Some(Choice::Closed);
        }
        if presses(Key::Enter) > 0 {
            return self.take(self.chosen);
        }
        None
    }

    /// Draws it over the window.
    pub fn show(&mut self, ctx: &Context) -> Option<Choice> {
        let mut clicked = None;
        let window = ctx.content_rect().size();
        let area = Area::new(Id::unique("file list"))
            .order(Order::Foreground)
            .anchor(Align2::CENTER_CENTER, egui::Vec2::ZERO)
            .show(ctx, |ui| {
                let p = Palette::of(ui);
                Frame::new()
                    .fill(p.panel)
                    .stroke(Stroke::new(1.0, p.line))
                    .corner_radius(8)
                    .inner_margin(Margin::symmetric(16, 8))
                    .show(ui, |ui| {
                        ui.set_width((window.x - 8.0 * GRID).min(480.0));
                        heading(ui, self.wanted.title());
                        hint(ui, &self.folder.display().to_string());
                        clicked = self.rows(ui, (window.y - 20.0 * GRID).clamp(80.0, 360.0));
                        hint(ui, "Enter opens, Backspace goes up, Esc closes");
                    });
            });
        if area.response.clicked_elsewhere() {
            return Some(Choice::Closed);
        }
        self.take(clicked?)
    }

    fn rows(&mut self, ui: &mut Ui, height: f32) -> Option<usize> {
        let mut clicked = None;
        ScrollArea::vertical()
            .max_height(height)
            .auto_shrink([false, true])
            .show(ui, |ui| {
                for (i, entry) in self.entries.iter().enumerate() {
                    let remark = if entry.is_folder { "folder" } else { "" };
                    let is_chosen = i == self.chosen;
                    let response = row_button(ui, &entry.name, remark, is_chosen);
                    if is_chosen && self.has_moved {
                        response.scroll_to_me(None);
                    }
                    if response.clicked() {
                        clicked = Some(i);
                    }
                }
            });
        self.has_moved = false;
        clicked
    }

    fn take(&mut self, index: usize) -> Option<Choice> {
        let entry = self.entries.get(index)?;
        if entry.name == UP {
            self.leave();
            return None;
        }
        let path = self.folder.join(&entry.name);
        if entry.is_folder {
            self.enter(path);
            return None;
        }
        Some(Choice::File(self.wanted, path))
    }

    /// Goes up, with the folder that was left chosen.
    fn leave(&mut self) {
        let Some(parent) = self.folder.parent().map(Path::to_owned) else {
            return;
        };
        let left = self
            .folder
            .file_name()
            .map(|n| n.to_string_lossy().into_owned());
        self.enter(parent);
        let place = self
            .entries
            .iter()
            .position(|e| Some(&e.name) == left.as_ref());
        self.chosen = place.unwrap_or(0);
        self.has_moved = true;
    }

    /// Reads a folder: folders first, then files that can be read, hidden ones left out.
    fn enter(&mut self, folder: PathBuf) {
        let endings = self.wanted.endings();
        let found = std::fs::read_dir(&folder).into_iter().flatten().flatten();
        let mut entries: Vec<Entry> = found
            .filter_map(|entry| {
                let name = entry.file_name().into_string().ok()?;
                let is_folder = entry.path().is_dir();
                let ending = Path::new(&name).extension().unwrap_or_default();
                let is_readable = endings.iter().any(|e| ending.eq_ignore_ascii_case(e));
                let is_shown = (is_folder || is_readable) && !name.starts_with('.');
                is_shown.then_some(Entry { name, is_folder })
            })
            .collect();
        entries.sort_by(|a, b| (b.is_folder, &a.name).cmp(&(a.is_folder, &b.name)));
        if folder.parent().is_some() {
            let up = Entry {
                name: UP.to_owned(),
                is_folder: true,
            };
            entries.insert(0, up);
        }
        *self = Self {
            wanted: self.wanted,
            folder,
            chosen: usize::from(entries.len() > 1),
            entries,
            has_moved: true,
        };
    }
}

/// The row that goes up.
const UP: &str = "..";
