//! Buttons that undo and redo.

use egui::Ui;

use crate::history::History;
use crate::keys::Action;
use crate::shell::Shell;
use crate::widgets::button;

/// Two buttons; each says where the pointer rests on it what it would do.
pub(super) fn show(ui: &mut Ui, history: &History, shell: &mut Shell) {
    let buttons = [
        ("Undo", "Ctrl Z", history.to_undo(), Action::Undo),
        ("Redo", "Ctrl Y", history.to_redo(), Action::Redo),
    ];
    ui.horizontal(|ui| {
        for (name, keys, what, action) in buttons {
            ui.add_enabled_ui(what.is_some(), |ui| {
                let what = what.unwrap_or("nothing yet");
                let response = button(ui, name);
                let about = format!("{name}: {what}  ({keys})");
                if response
                    .on_hover_text(&about)
                    .on_disabled_hover_text(about)
                    .clicked()
                {
                    shell.act(ui.ctx(), action);
                }
            });
        }
    });
}
