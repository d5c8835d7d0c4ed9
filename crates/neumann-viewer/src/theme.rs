//! How the window looks: neutral greys, one amber, one typeface, two text sizes, an 8-pixel grid.
//!
//! Every grey has r = g = b, so that no colour of ours tints the picture. Amber marks what is
//! chosen, and the bias badge; nothing else has a hue.

use std::sync::Arc;

use egui::{
    Color32, Context, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Id, Margin,
    Stroke, Style, TextStyle, Theme, Ui, Vec2, Visuals,
};

/// Size of ordinary text, points.
pub const BODY: f32 = 13.0;
/// Size of secondary text, points.
pub const SMALL: f32 = 11.5;
/// Size of the formula that stands on the picture, points.
pub const CAPTION: f32 = 26.0;
/// The unit of the grid, points.
pub const GRID: f32 = 8.0;
/// Height of a row with one control, points.
pub const ROW: f32 = 24.0;

const REGULAR: &str = "Inter";
const SEMIBOLD: &str = "Inter SemiBold";
const INSTALLED: &str = "neumann theme";
const CLEARED: &str = "neumann target is cleared";

/// The greys and the amber of a theme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Palette {
    /// Behind the picture.
    pub ground: Color32,
    /// Behind controls.
    pub panel: Color32,
    /// A control that can be pressed, or a thumbnail's tile.
    pub raised: Color32,
    /// The same with the pointer on it.
    pub hovered: Color32,
    /// The chosen one of several.
    pub chosen: Color32,
    /// Hairlines and empty tracks.
    pub line: Color32,
    /// The filled part of a track.
    pub fill: Color32,
    /// Text.
    pub text: Color32,
    /// Secondary text.
    pub weak: Color32,
    /// Knobs and icons.
    pub strong: Color32,
    /// What is chosen.
    pub amber: Color32,
    /// Text on amber.
    pub on_amber: Color32,
}

const DARK: Palette = Palette {
    ground: Color32::from_gray(20),
    panel: Color32::from_gray(29),
    raised: Color32::from_gray(37),
    hovered: Color32::from_gray(47),
    chosen: Color32::from_gray(63),
    line: Color32::from_gray(51),
    fill: Color32::from_gray(144),
    text: Color32::from_gray(226),
    weak: Color32::from_gray(150),
    strong: Color32::from_gray(240),
    amber: Color32::from_rgb(229, 168, 60),
    on_amber: Color32::from_gray(20),
};

const LIGHT: Palette = Palette {
    ground: Color32::from_gray(205),
    panel: Color32::from_gray(240),
    raised: Color32::from_gray(228),
    hovered: Color32::from_gray(216),
    chosen: Color32::from_gray(255),
    line: Color32::from_gray(205),
    fill: Color32::from_gray(128),
    text: Color32::from_gray(24),
    weak: Color32::from_gray(92),
    strong: Color32::from_gray(48),
    amber: Color32::from_rgb(196, 126, 0),
    on_amber: Color32::from_gray(255),
};

impl Palette {
    /// The palette of the theme that `ui` is drawn in.
    #[must_use]
    pub fn of(ui: &Ui) -> Self {
        Self::of_theme(ui.visuals().dark_mode)
    }

    /// The palette of the dark or of the light theme.
    #[must_use]
    pub fn of_theme(is_dark: bool) -> Self {
        if is_dark { DARK } else { LIGHT }
    }
}

/// Ordinary text.
#[must_use]
pub fn body() -> FontId {
    FontId::new(BODY, FontFamily::Name(REGULAR.into()))
}

/// Secondary text.
#[must_use]
pub fn small() -> FontId {
    FontId::new(SMALL, FontFamily::Name(REGULAR.into()))
}

/// Headings and what is chosen.
#[must_use]
pub fn semibold() -> FontId {
    FontId::new(BODY, FontFamily::Name(SEMIBOLD.into()))
}

/// Regular text of any size, for formulas.
#[must_use]
pub fn sized(size: f32) -> FontId {
    FontId::new(size, FontFamily::Name(REGULAR.into()))
}

/// True once [`install`] has been called and a frame has begun since.
#[must_use]
pub fn is_installed(ctx: &Context) -> bool {
    ctx.data(|data| data.get_temp::<()>(Id::unique(INSTALLED)).is_some())
}

/// Sets typeface, styles and visuals of both themes; takes effect with the next frame.
pub fn install(ctx: &Context) {
    ctx.data_mut(|data| data.insert_temp(Id::unique(INSTALLED), ()));
    ctx.set_fonts(fonts());
    ctx.set_style_of(Theme::Dark, style(Theme::Dark));
    ctx.set_style_of(Theme::Light, style(Theme::Light));
    ctx.options_mut(|options| options.zoom_with_keyboard = false);
}

/// Says that the target is cleared to the panels' grey, so that they need not be filled: on a
/// software adapter every pixel that is painted twice costs.
pub fn set_cleared(ctx: &Context) {
    ctx.data_mut(|data| data.insert_temp(Id::unique(CLEARED), true));
}

/// Fills the ground of a panel or bar, unless the target has been cleared to it.
pub fn fill_panel(ui: &Ui, rect: egui::Rect) {
    let is_cleared = ui.data(|data| data.get_temp(Id::unique(CLEARED)).unwrap_or(false));
    if !is_cleared {
        ui.painter().rect_filled(rect, 0, Palette::of(ui).panel);
    }
}

fn fonts() -> FontDefinitions {
    let mut fonts = FontDefinitions::default();
    let faces: [(&str, &'static [u8]); 2] = [
        (
            REGULAR,
            include_bytes!("../../../assets/fonts/Inter-Regular.otf"),
        ),
        (
            SEMIBOLD,
            include_bytes!("../../../assets/fonts/Inter-SemiBold.otf"),
        ),
    ];
    let fallback = fonts
        .families
        .get(&FontFamily::Proportional)
        .cloned()
        .unwrap_or_default();
    for (name, bytes) in faces {
        fonts
            .font_data
            .insert(name.to_owned(), Arc::new(FontData::from_static(bytes)));
        let mut family = vec![name.to_owned()];
        family.extend(fallback.iter().cloned());
        if name == REGULAR {
            fonts
                .families
                .insert(FontFamily::Proportional, family.clone());
        }
        fonts.families.insert(FontFamily::Name(name.into()), family);
    }
    fonts
}

fn style(theme: Theme) -> Style {
    let mut style = Style {
        visuals: visuals(theme),
        ..Style::default()
    };
    style.text_styles = [
        (TextStyle::Small, small()),
        (TextStyle::Body, body()),
        (TextStyle::Button, body()),
        (TextStyle::Monospace, body()),
        (TextStyle::Heading, semibold()),
    ]
    .into();
    style.spacing.item_spacing = Vec2::new(GRID, GRID / 2.0);
    style.spacing.interact_size.y = ROW;
    style.spacing.window_margin = Margin::same(16);
    style.spacing.menu_margin = Margin::same(4);
    style.spacing.scroll = egui::style::ScrollStyle::floating();
    style.interaction.selectable_labels = false;
    style.animation_time = 0.0;
    style
}

fn visuals(theme: Theme) -> Visuals {
    let is_dark = theme == Theme::Dark;
    let p = Palette::of_theme(is_dark);
    let mut v = if is_dark {
        Visuals::dark()
    } else {
        Visuals::light()
    };
    v.override_text_color = Some(p.text);
    v.weak_text_color = Some(p.weak);
    v.panel_fill = p.panel;
    v.window_fill = p.panel;
    v.window_stroke = Stroke::new(1.0, p.line);
    v.window_corner_radius = CornerRadius::same(6);
    v.menu_corner_radius = CornerRadius::same(6);
    v.extreme_bg_color = p.ground;
    v.text_edit_bg_color = Some(if is_dark { p.ground } else { p.chosen });
    v.faint_bg_color = p.raised;
    v.code_bg_color = p.raised;
    v.hyperlink_color = p.text;
    v.warn_fg_color = p.amber;
    v.error_fg_color = p.text;
    v.selection.bg_fill = p.amber.gamma_multiply(0.35);
    v.selection.stroke = Stroke::new(1.0, p.amber);
    v.text_cursor.stroke = Stroke::new(1.5, p.strong);
    for w in [
        &mut v.widgets.noninteractive,
        &mut v.widgets.inactive,
        &mut v.widgets.hovered,
        &mut v.widgets.active,
        &mut v.widgets.open,
    ] {
        w.bg_fill = p.raised;
        w.weak_bg_fill = p.raised;
        w.bg_stroke = Stroke::new(1.0, p.line);
        w.fg_stroke = Stroke::new(1.0, p.text);
        w.corner_radius = CornerRadius::same(4);
        w.expansion = 0.0;
    }
    v.widgets.hovered.weak_bg_fill = p.hovered;
    v.widgets.hovered.bg_fill = p.hovered;
    v.widgets.active.weak_bg_fill = p.chosen;
    v.widgets.active.bg_fill = p.chosen;
    v.popup_shadow = egui::Shadow {
        offset: [0, 4],
        blur: 12,
        spread: 0,
        color: Color32::from_black_alpha(if is_dark { 96 } else { 40 }),
    };
    v.window_shadow = v.popup_shadow;
    v
}

/// Ground that lets text be read over any picture.
#[must_use]
pub fn plate(p: &Palette) -> Color32 {
    p.ground.gamma_multiply(0.78)
}

#[cfg(test)]
mod tests {
    use super::{DARK, LIGHT};

    #[test]
    fn greys_have_no_hue() {
        for p in [DARK, LIGHT] {
            for grey in [
                p.ground, p.panel, p.raised, p.hovered, p.chosen, p.line, p.fill, p.text, p.weak,
                p.strong, p.on_amber,
            ] {
                assert!(grey.r() == grey.g() && grey.g() == grey.b(), "{grey:?}");
            }
        }
    }
}
