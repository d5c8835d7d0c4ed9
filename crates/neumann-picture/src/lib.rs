//! Pictures and their files, for the command and for the window.
//!
//! Rooms, in reading order: [`tone`] and [`false_colour`] take radiance to the screen;
//! [`files`] writes without ever leaving half a file; [`png_file`] and [`exr_file`] keep
//! pictures, the latter a whole film with its history, so that a render can be gone on with;
//! [`image_file`] reads any picture back; [`compare`] measures how far two are apart,
//! [`agreement`] whether that is chance, [`radius_bias`] how much of it is, and [`race`] lets
//! methods come near at equal time;
//! [`photons`] colours photons, [`quantity`] what a pixel holds beside radiance; [`histogram`]
//! counts how bright they are; [`inspection`] says by which paths light came to one,
//! [`hemisphere`] from where; [`lobe`] plots BSDFs; [`energy`] says what the terms are worth;
//! [`axis`] is one of a chart; [`sheet`] lays out the series, and [`figure`] draws charts for
//! print; [`figures`] writes numbers; [`state`] keeps all that a person has chosen; [`tev`] shows a
//! film in the viewer of that name.
//!
//! Knows no window and no terminal.

pub mod agreement;
pub mod axis;
pub mod compare;
pub mod energy;
mod error;
pub mod exr_file;
pub mod false_colour;
pub mod figure;
pub mod figures;
pub mod files;
pub mod hemisphere;
pub mod histogram;
pub mod image_file;
pub mod inspection;
pub mod lobe;
pub mod photons;
pub mod png_file;
pub mod quantity;
pub mod race;
pub mod radius_bias;
pub mod sheet;
pub mod state;
pub mod tev;
pub mod tone;

pub use error::PictureError;
pub use image_file::Image;
