//! Reads images at texture coordinates.

use std::sync::{Arc, LazyLock};

use glam::{Mat3, Vec2, Vec4};

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
    image: TextureImage,
    /// Which of the mesh's sets of coordinates it reads.
    pub uv_set: usize,
    image_from_mesh_uv: Mat3,
    wrap_u: Wrap,
    wrap_v: Wrap,
    filter: Filter,
    /// What the bytes of the colour channels stand for.
    values: &'static [f32; 256],
}

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| linear(i as u8)));

static LINEAR_FROM_SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let c = i as f32 / 255.0;
        // IEC 61966-2-1.
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    })
});

impl Texture {
    /// A texture as described, over the scene's images.
    #[must_use]
    pub fn new(
        description: &TextureDescription,
        images: &[TextureImage],
        color_space: ColorSpace,
    ) -> Option<Self> {
        let image = images.get(description.image)?;
        (!image.texels.is_empty()).then(|| Self {
            image: Arc::clone(image),
            uv_set: description.uv_set,
            image_from_mesh_uv: description.image_from_mesh_uv,
            wrap_u: description.wrap_u,
            wrap_v: description.wrap_v,
            filter: description.filter,
            values: match color_space {
                ColorSpace::Linear => &LINEAR,
                ColorSpace::Srgb => &LINEAR_FROM_SRGB,
            },
        })
    }

    /// Linear RGBA at the mesh's texture coordinates; (0, 0) is the image's top left corner.
    #[must_use]
    pub fn at(&self, uv: Vec2) -> Vec4 {
        let p = (self.image_from_mesh_uv * uv.extend(1.0)).truncate();
        if !p.is_finite() {
            return Vec4::ONE;
        }
        let size = Vec2::new(self.image.width as f32, self.image.height as f32);
        let scaled = p * size;
        if self.filter == Filter::Nearest {
            return self.texel(self.column(floor(scaled.x)), self.row(floor(scaled.y)));
        }
        let shifted = scaled - 0.5;
        let (x, y) = (floor(shifted.x), floor(shifted.y));
        let s = shifted - Vec2::new(x as f32, y as f32);
        let columns = [self.column(x), self.column(x + 1)];
        let [top, bottom] = [y, y + 1].map(|y| {
            let row = self.row(y);
            let [left, right] = columns.map(|column| self.texel(column, row));
            left.lerp(right, s.x)
        });
        top.lerp(bottom, s.y)
    }

    /// Texels per unit of the mesh's coordinates, the larger of both axes.
    #[must_use]
    pub fn texels_per_uv(&self) -> f32 {
        let m = self.image_from_mesh_uv;
        let scale = m
            .x_axis
            .truncate()
            .length()
            .max(m.y_axis.truncate().length());
        scale * self.image.width.max(self.image.height) as f32
    }

    #[inline]
    fn column(&self, x: i64) -> usize {
        wrapped(x, self.image.width as i64, self.wrap_u)
    }

    #[inline]
    fn row(&self, y: i64) -> usize {
        wrapped(y, self.image.height as i64, self.wrap_v)
    }

    #[inline]
    fn texel(&self, column: usize, row: usize) -> Vec4 {
        let [r, g, b, a] = self.image.texels[row * self.image.width + column];
        let [r, g, b] = [r, g, b].map(|c| self.values[usize::from(c)]);
        Vec4::new(r, g, b, linear(a))
    }
}

#[inline]
fn linear(c: u8) -> f32 {
    f32::from(c) * (1.0 / 255.0)
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
            texels: vec![[0, 0, 0, 255], [255, 255, 255, 255]],
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
}
