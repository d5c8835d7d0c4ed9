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
    color_space: ColorSpace,
}

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
            color_space,
        })
    }

    /// Linear RGBA at the mesh's texture coordinates; (0, 0) is the image's top left corner.
    #[must_use]
    pub fn at(&self, uv: Vec2) -> Vec4 {
        let p = (self.image_from_mesh_uv * uv.extend(1.0)).truncate();
        if !p.is_finite() {
            return Vec4::ONE;
        }
        let (w, h) = (self.image.width as i64, self.image.height as i64);
        let scaled = p * Vec2::new(w as f32, h as f32);
        if self.filter == Filter::Nearest {
            return self.texel(scaled.x.floor() as i64, scaled.y.floor() as i64);
        }
        let shifted = scaled - 0.5;
        let base = shifted.floor();
        let s = shifted - base;
        let (x, y) = (base.x as i64, base.y as i64);
        let top = self.texel(x, y).lerp(self.texel(x + 1, y), s.x);
        let bottom = self.texel(x, y + 1).lerp(self.texel(x + 1, y + 1), s.x);
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

    fn texel(&self, x: i64, y: i64) -> Vec4 {
        let x = wrapped(x, self.image.width as i64, self.wrap_u);
        let y = wrapped(y, self.image.height as i64, self.wrap_v);
        let [r, g, b, a] = self.image.texels[y * self.image.width + x];
        let linear = |c: u8| f32::from(c) * (1.0 / 255.0);
        match self.color_space {
            ColorSpace::Linear => Vec4::new(linear(r), linear(g), linear(b), linear(a)),
            ColorSpace::Srgb => {
                let table = &*LINEAR_FROM_SRGB;
                Vec4::new(
                    table[usize::from(r)],
                    table[usize::from(g)],
                    table[usize::from(b)],
                    linear(a),
                )
            }
        }
    }
}

fn wrapped(i: i64, n: i64, wrap: Wrap) -> usize {
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
