//! What decides which rows a panel has, while a hand is on one of its controls.

use egui::{AsIdSalt, Ui};

/// What was so when nothing was pressed last. While a slider is dragged the panel keeps the rows
/// that it had then, so that nothing moves under the hand: neither the slider, nor what it would
/// hit next.
pub fn settled<T: Clone + Send + Sync + 'static>(ui: &Ui, name: impl AsIdSalt, now: T) -> T {
    let key = ui.scope_id().with(("settled", name));
    if ui.input(|i| i.pointer.any_down())
        && let Some(kept) = ui.data(|d| d.get_temp(key))
    {
        return kept;
    }
    ui.data_mut(|d| d.insert_temp(key, now.clone()));
    now
}
