//! The window around the picture: its pages, fields and notices, and what runs in the background.
//!
//! Panels and bars that want more than they are given leave a [`Command`] here; the window carries
//! it out as soon as they are drawn.

use std::sync::Arc;

use egui::Context;

use crate::bookmarks::Bookmarks;
use crate::file_list::FileList;
use crate::gallery::Gallery;
use crate::histogram::LiveHistogram;
use crate::keys::{Action, Places};
use crate::notices::Notices;
use crate::panels::Page;
use crate::pick::Picked;
use crate::recent::Recent;
use crate::scene_source::Background;
use crate::sending::Sending;
use crate::text_scale::TextScale;

/// What stands around the picture.
pub struct Shell {
    /// The page of the panel.
    pub page: Page,
    /// Bars, panel and filmstrip are hidden.
    pub is_bare: bool,
    /// Picture, caption, method and filmstrip are shown alone and large.
    pub is_presenting: bool,
    /// How large texts are.
    pub text_scale: TextScale,
    /// The help page is shown.
    pub is_help_open: bool,
    /// What the keyboard prints, for the help page.
    pub places: Places,
    /// The menu of methods is open.
    pub is_menu_open: bool,
    /// The list of files to choose from, where the desktop has no dialog.
    pub file_list: Option<FileList>,
    /// What stands in the text fields.
    pub fields: Fields,
    /// The material that is being edited.
    pub material: Option<usize>,
    /// What was picked in the picture last.
    pub picked: Option<Picked>,
    /// The Scene page scrolls to it in this frame.
    pub(crate) reveals_pick: bool,
    /// The histogram of the Display page.
    pub histogram: LiveHistogram,
    /// Small pictures of the built-in scenes.
    pub gallery: Gallery,
    /// Scenes and states opened lately.
    pub recent: Recent,
    /// Views of scenes that were kept.
    pub bookmarks: Bookmarks,
    /// What the window has to say.
    pub notices: Notices,
    /// The film on its way to tev.
    pub sending: Sending,
    /// What runs in the background.
    pub background: Background,
    /// The panel is given the keyboard in this frame.
    pub(crate) gives_panel_the_keyboard: bool,
    /// What the window itself is to do.
    pub requests: Vec<WindowRequest>,
    /// A control had the keyboard at the end of the last frame; the toolkit takes it away at Esc
    /// itself.
    pub(crate) had_focus: bool,
    commands: Vec<Command>,
}

/// What stands in the text fields.
#[derive(Clone, Debug, Default)]
pub struct Fields {
    /// Path of a scene.
    pub scene: String,
    /// Path of an environment map.
    pub environment: String,
    /// Path of a reference picture.
    pub reference: String,
}

/// What a panel wants done that needs more than it was given.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// What a key would do.
    Do(Action),
    /// Open a scene by name or path, or a state by its path.
    OpenScene(String),
    /// Take what is held as A (0) or B (1) as the reference.
    ReferToHeld(usize),
    /// Save what is shown where the desktop's dialog says.
    SaveAs,
}

/// What only the window can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowRequest {
    /// Close.
    Quit,
    /// Fill the screen, or no longer.
    Fullscreen,
}

impl Shell {
    /// A window at its first frame. `wake` asks for another one, from any thread.
    #[must_use]
    pub fn new(wake: Arc<dyn Fn() + Send + Sync>) -> Self {
        Self {
            page: Page::default(),
            is_bare: false,
            is_presenting: false,
            text_scale: TextScale::default(),
            is_help_open: false,
            places: Places::default(),
            is_menu_open: false,
            file_list: None,
            fields: Fields::default(),
            material: None,
            picked: None,
            reveals_pick: false,
            histogram: LiveHistogram::default(),
            gallery: Gallery::new(Arc::clone(&wake)),
            recent: Recent::default(),
            bookmarks: Bookmarks::default(),
            notices: Notices::default(),
            sending: Sending::default(),
            background: Background::new(wake),
            gives_panel_the_keyboard: false,
            requests: Vec::new(),
            had_focus: false,
            commands: Vec::new(),
        }
    }

    /// Shows a page of the panel, whatever has hidden it.
    pub fn show_page(&mut self, page: Page) {
        self.is_bare = false;
        self.is_presenting = false;
        self.page = page;
    }

    /// Shows what was picked on the Scene page.
    pub fn show_picked(&mut self, picked: Picked) {
        self.show_page(Page::Scene);
        self.reveals_pick = true;
        if let Picked::Surface { material, .. } = &picked {
            self.material = Some(*material);
        }
        self.picked = Some(picked);
    }

    /// Asks for what a key would do.
    pub fn act(&mut self, ctx: &Context, action: Action) {
        self.commands.push(Command::Do(action));
        ctx.request_repaint();
    }

    /// Asks for a scene to be opened by name or path, or a state by its path.
    pub fn open_scene(&mut self, source: impl Into<String>) {
        self.commands.push(Command::OpenScene(source.into()));
    }

    /// Asks for what is held as A (0) or B (1) to be taken as the reference.
    pub fn refer_to_held(&mut self, which: usize) {
        self.commands.push(Command::ReferToHeld(which));
    }

    /// Asks for what is shown to be saved where the desktop's dialog says.
    pub fn save_as(&mut self) {
        self.commands.push(Command::SaveAs);
    }

    /// What has been asked for since.
    pub(crate) fn take_commands(&mut self) -> Vec<Command> {
        std::mem::take(&mut self.commands)
    }
}
