//! Reads images at texture coordinates.
//!
//! Texels stay in the format of their file ([`StoredTexels`]); what their numbers stand for is
//! looked up as they are read.

use std::sync::{Arc, LazyLock};

use glam::{Mat3, Vec2, Vec4};

use crate::decode::{StoredTexels, Texels};
use crate::scene::description::{Filter, ImageDescription, TextureDescription, Wrap};

/// A decoded image, shared by the textures that use it.
pub type TextureImage = Arc<ImageDescription>;

/// What the colour channels of an image stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorSpace {
    /// Colours with the sRGB transfer function; alpha is linear.
    Srgb,
    /// Numbers.
    Linear,
}

/// A use of an image by a material.
#[derive(Clone, Debug)]
pub struct Texture {
    texels: Texels,
    width: usize,
    height: usize,
    /// Which of the mesh's sets of coordinates it reads.
    pub uv_set: usize,
    image_from_mesh_uv: Mat3,
    wrap_u: Wrap,
    wrap_v: Wrap,
    filter: Filter,
    values: Values,
}

/// What the numbers of the colour channels stand for.
#[derive(Clone, Copy, Debug)]
struct Values {
    bytes: &'static [f32; 256],
    /// Of numbers of 16 bits; `None` for fractions of the largest.
    words: Option<&'static [f32]>,
}

/// Texels farther away than this are not told apart: single precision has no fractions there.
const FARTHEST: f32 = (1 << 30) as f32;

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| byte(i as u8)));

static LINEAR_FROM_SRGB: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| linear_from_srgb(i as f32 / 255.0)));

static LINEAR_FROM_SRGB_WORDS: LazyLock<Vec<f32>> = LazyLock::new(|| {
    (0..=u16::MAX)
        .map(|i| linear_from_srgb(f32::from(i) / 65535.0))
        .collect()
});

/// IEC 61966-2-1.
fn linear_from_srgb(c: f32) -> f32 {
    if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

impl Texture {
    /// A texture as described, over the scene's images.
    #[must_use]
    pub fn new(
        description: &TextureDescription,
        images: &[TextureImage],
        color_space: ColorSpace,
    ) -> Option<Self> {
        let image = images.get(description.image)?;
        let is_whole = image.texels.fill(image.width, image.height);
        is_whole.then(|| Self {
            texels: image.texels.clone(),
            width: image.width,
            height: image.height,
            uv_set: description.uv_set,
            image_from_mesh_uv: description.image_from_mesh_uv,
            wrap_u: description.wrap_u,
            wrap_v: description.wrap_v,
            filter: description.filter,
            values: Values::new(color_space, &image.texels),
        })
    }

    /// Linear RGBA at the mesh's texture coordinates; (0, 0) is the image's top left corner.
    #[must_use]
    pub fn at(&self, uv: Vec2) -> Vec4 {
        let p = self.place(uv);
        if !p.is_finite() {
            return Vec4::ONE;
        }
        let place = p.clamp(Vec2::splat(-FARTHEST), Vec2::splat(FARTHEST));
        let (width, values) = (self.width, self.values);
        match self.texels.stored() {
            StoredTexels::Rgba8(t) => self.filtered(place, |x, y| values.rgba8(t[y * width + x])),
            StoredTexels::Rgb8(t) => self.filtered(place, |x, y| values.rgb8(t[y * width + x])),
            _ => self.filtered(place, |x, y| self.texel(x, y)),
        }
    }

    /// Linear RGBA of one texel, `x` < width, `y` < height, row 0 on top.
    #[must_use]
    pub fn texel(&self, x: usize, y: usize) -> Vec4 {
        let (i, values) = (y * self.width + x, self.values);
        match self.texels.stored() {
            StoredTexels::Rgba8(t) => values.rgba8(t[i]),
            StoredTexels::Rgb8(t) => values.rgb8(t[i]),
            StoredTexels::Grey8(t) => values.rgb8([t[i]; 3]),
            StoredTexels::GreyAlpha8(t) => {
                let [g, a] = t[i];
                values.rgba8([g, g, g, a])
            }
            StoredTexels::Rgba16(t) => values.rgba16(t[i]),
            StoredTexels::Rgb16(t) => {
                let [r, g, b] = t[i];
                values.rgba16([r, g, b, u16::MAX])
            }
            StoredTexels::Grey16(t) => {
                let g = t[i];
                values.rgba16([g, g, g, u16::MAX])
            }
            StoredTexels::GreyAlpha16(t) => {
                let [g, a] = t[i];
                values.rgba16([g, g, g, a])
            }
            StoredTexels::Indexed(t) => values.rgba8(t.color(x, y)),
        }
    }

    /// The texels about a place, by the filter.
    #[inline]
    fn filtered(&self, place: Vec2, texel: impl Fn(usize, usize) -> Vec4) -> Vec4 {
        let (x, y) = (floor(place.x), floor(place.y));
        if self.filter == Filter::Nearest {
            return texel(self.column(x), self.row(y));
        }
        let s = place - Vec2::new(x as f32, y as f32);
        let columns = [self.column(x), self.column(x + 1)];
        let [top, bottom] = [y, y + 1].map(|y| {
            let row = self.row(y);
            let [left, right] = columns.map(|column| texel(column, row));
            left.lerp(right, s.x)
        });
        top.lerp(bottom, s.y)
    }

    /// Where the mesh's texture coordinates are among the cells of the texture, in columns and
    /// rows. The texture is read from
    /// the same texels all over a cell: from one where the nearest counts, else from the four that
    /// its corners are the
    /// middles of, cell (0, 0) having texel (0, 0) for its first.
    #[inline]
    #[must_use]
    pub fn place(&self, uv: Vec2) -> Vec2 {
        let p = (self.image_from_mesh_uv * uv.extend(1.0)).truncate();
        let scaled = p * Vec2::new(self.width as f32, self.height as f32);
        match self.filter {
            Filter::Nearest => scaled,
            Filter::Linear => scaled - 0.5,
        }
    }

    /// The cell that a place is in, by column and row.
    #[inline]
    #[must_use]
    pub fn cell(place: Vec2) -> [i64; 2] {
        [floor(place.x), floor(place.y)]
    }

    /// Columns and rows of texels.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// How columns and rows go on beyond the image.
    #[must_use]
    pub fn wraps(&self) -> [Wrap; 2] {
        [self.wrap_u, self.wrap_v]
    }

    /// How it is read between texels.
    #[must_use]
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// True if it reads the same image as another one.
    #[must_use]
    pub fn has_image_of(&self, other: &Self) -> bool {
        self.texels.are_those_of(&other.texels)
    }

    /// True if it reads the same image as another one, and goes on beyond it and is read between
    /// texels likewise.
    #[must_use]
    pub fn has_cells_of(&self, other: &Self) -> bool {
        self.texels.are_those_of(&other.texels)
            && self.wraps() == other.wraps()
            && self.filter == other.filter
            && std::ptr::eq(self.values.bytes, other.values.bytes)
    }

    /// Linear RGBA of a texel, counted from the top left, which may be beyond the image.
    #[inline]
    #[must_use]
    pub fn texel_at(&self, column: i64, row: i64) -> Vec4 {
        self.texel(self.column(column), self.row(row))
    }

    #[inline]
    fn column(&self, x: i64) -> usize {
        wrapped(x, self.width as i64, self.wrap_u)
    }

    #[inline]
    fn row(&self, y: i64) -> usize {
        wrapped(y, self.height as i64, self.wrap_v)
    }
}

impl Values {
    fn new(color_space: ColorSpace, texels: &Texels) -> Self {
        let is_deep = matches!(
            texels.stored(),
            StoredTexels::Rgba16(_)
                | StoredTexels::Rgb16(_)
                | StoredTexels::Grey16(_)
                | StoredTexels::GreyAlpha16(_)
        );
        match color_space {
            ColorSpace::Linear => Self {
                bytes: &LINEAR,
                words: None,
            },
            ColorSpace::Srgb => Self {
                bytes: &LINEAR_FROM_SRGB,
                words: is_deep.then(|| LINEAR_FROM_SRGB_WORDS.as_slice()),
            },
        }
    }

    #[inline]
    fn rgba8(self, [r, g, b, a]: [u8; 4]) -> Vec4 {
        let [r, g, b] = [r, g, b].map(|c| self.bytes[usize::from(c)]);
        Vec4::new(r, g, b, byte(a))
    }

    #[inline]
    fn rgb8(self, [r, g, b]: [u8; 3]) -> Vec4 {
        self.rgba8([r, g, b, u8::MAX])
    }

    #[inline]
    fn rgba16(self, [r, g, b, a]: [u16; 4]) -> Vec4 {
        let [r, g, b] = [r, g, b].map(|c| match self.words {
            Some(values) => values[usize::from(c)],
            None => word(c),
        });
        Vec4::new(r, g, b, word(a))
    }
}

#[inline]
fn byte(c: u8) -> f32 {
    f32::from(c) * (1.0 / 255.0)
}

#[inline]
fn word(c: u16) -> f32 {
    f32::from(c) * (1.0 / 65535.0)
}

/// Rounds down, without the call that it takes on processors as old as this program may run on.
#[inline]
fn floor(x: f32) -> i64 {
    let towards_zero = x as i32;
    i64::from(towards_zero) - i64::from(towards_zero as f32 > x)
}

#[inline]
fn wrapped(i: i64, n: i64, wrap: Wrap) -> usize {
    if (0..n).contains(&i) {
        // Nothing to divide for, however the image goes on.
        return i as usize;
    }
    let j = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::MirroredRepeat => {
            let k = i.rem_euclid(2 * n);
            if k < n { k } else { 2 * n - 1 - k }
        }
        Wrap::ClampToEdge => i.clamp(0, n - 1),
    };
    j as usize
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Mat3, Vec2};

    use super::{ColorSpace, Texture, wrapped};
    use crate::decode::{StoredTexels, Texels};
    use crate::memory::Share;
    use crate::scene::description::{Filter, ImageDescription, TextureDescription, Wrap};

    #[test]
    fn wrapping_follows_the_modes() {
        let row = |wrap| (-3..5).map(|i| wrapped(i, 2, wrap)).collect::<Vec<_>>();
        assert_eq!(row(Wrap::Repeat), [1, 0, 1, 0, 1, 0, 1, 0]);
        assert_eq!(row(Wrap::MirroredRepeat), [1, 1, 0, 0, 1, 1, 0, 0]);
        assert_eq!(row(Wrap::ClampToEdge), [0, 0, 0, 0, 1, 1, 1, 1]);
    }

    #[test]
    fn bilinear_is_halfway_between_texel_centres() {
        let image = Arc::new(ImageDescription {
            name: String::new(),
            width: 2,
            height: 1,
            texels: vec![[0, 0, 0, 255], [255, 255, 255, 255]].into(),
        });
        let description = TextureDescription {
            image: 0,
            uv_set: 0,
            image_from_mesh_uv: Mat3::IDENTITY,
            wrap_u: Wrap::ClampToEdge,
            wrap_v: Wrap::ClampToEdge,
            filter: Filter::Linear,
        };
        let texture = Texture::new(&description, &[image], ColorSpace::Srgb).unwrap();
        assert!((texture.at(Vec2::new(0.5, 0.5)).x - 0.5).abs() < 1e-6);
        assert!(texture.at(Vec2::new(0.25, 0.5)).x.abs() < 1e-6);
        assert!((texture.at(Vec2::new(2.0, 0.5)).x - 1.0).abs() < 1e-6);
    }

    fn texture(width: usize, stored: StoredTexels, color_space: ColorSpace) -> Texture {
        let image = Arc::new(ImageDescription {
            name: String::new(),
            width,
            height: 1,
            texels: Texels::new(stored, Share::default()),
        });
        let description = TextureDescription {
            image: 0,
            uv_set: 0,
            image_from_mesh_uv: Mat3::IDENTITY,
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            filter: Filter::Linear,
        };
        Texture::new(&description, &[image], color_space).unwrap()
    }

    #[test]
    fn formats_of_one_picture_look_alike() {
        let bytes = [17u8, 200, 0];
        let words = bytes.map(|c| u16::from(c) * 257);
        let formats = [
            StoredTexels::Rgba8(bytes.map(|c| [c, c, c, 255]).to_vec()),
            StoredTexels::Rgb8(bytes.map(|c| [c; 3]).to_vec()),
            StoredTexels::Grey8(bytes.to_vec()),
            StoredTexels::GreyAlpha8(bytes.map(|c| [c, 255]).to_vec()),
            StoredTexels::Rgba16(words.map(|c| [c, c, c, 65535]).to_vec()),
            StoredTexels::Rgb16(words.map(|c| [c; 3]).to_vec()),
            StoredTexels::Grey16(words.to_vec()),
            StoredTexels::GreyAlpha16(words.map(|c| [c, 65535]).to_vec()),
        ];
        for space in [ColorSpace::Srgb, ColorSpace::Linear] {
            let wanted = texture(3, formats[0].clone(), space);
            for format in &formats {
                let texture = texture(3, format.clone(), space);
                for u in [0.0, 0.2, 0.5, 0.77] {
                    let uv = Vec2::new(u, 0.5);
                    let difference = (texture.at(uv) - wanted.at(uv)).abs().max_element();
                    assert!(difference < 1e-6, "{format:?} {space:?} {u}");
                }
                assert_eq!(texture.texel(1, 0), texture.at(Vec2::new(0.5, 0.5)));
            }
        }
    }

    #[test]
    fn dark_words_are_told_apart() {
        let dark = texture(2, StoredTexels::Grey16(vec![9, 20]), ColorSpace::Srgb);
        assert!((dark.texel(0, 0).x * 65535.0 * 12.92 - 9.0).abs() < 1e-4);
        assert!((dark.texel(1, 0).x * 65535.0 * 12.92 - 20.0).abs() < 1e-4);
    }

    #[test]
    fn coordinates_far_away_and_odd_ones_yield_texels() {
        let texels = vec![[10, 20, 30, 255], [200, 100, 50, 0]];
        let texture = texture(2, StoredTexels::Rgba8(texels), ColorSpace::Linear);
        for u in [
            1e9,
            -1e9,
            1e30,
            -1e30,
            f32::MAX,
            f32::MIN,
            f32::NAN,
            f32::INFINITY,
        ] {
            for uv in [Vec2::new(u, 0.3), Vec2::new(0.3, u), Vec2::splat(u)] {
                let color = texture.at(uv);
                let is_color = color.cmpge(glam::Vec4::ZERO) & color.cmple(glam::Vec4::ONE);
                assert!(is_color.all(), "{uv}: {color}");
            }
        }
    }
}
