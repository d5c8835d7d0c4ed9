//! The texels of an image, as its file keeps them: an image of one bit a texel takes one bit.

use std::sync::Arc;

use crate::memory::Share;

/// Texels of an image in the format of its file; copies share them.
#[derive(Clone, Debug, Default)]
pub struct Texels {
    kept: Arc<Kept>,
}

#[derive(Debug, Default)]
struct Kept {
    stored: StoredTexels,
    /// What they take of the process's allowance.
    _memory: Share,
}

/// `texels[y * width + x]`, row 0 on top; numbers stand for 0 to 1.
#[derive(Clone, Debug)]
pub enum StoredTexels {
    /// Red, green, blue and alpha.
    Rgba8(Vec<[u8; 4]>),
    /// Red, green and blue.
    Rgb8(Vec<[u8; 3]>),
    /// Grey.
    Grey8(Vec<u8>),
    /// Grey and alpha.
    GreyAlpha8(Vec<[u8; 2]>),
    /// Red, green, blue and alpha.
    Rgba16(Vec<[u16; 4]>),
    /// Red, green and blue.
    Rgb16(Vec<[u16; 3]>),
    /// Grey.
    Grey16(Vec<u16>),
    /// Grey and alpha.
    GreyAlpha16(Vec<[u16; 2]>),
    /// Few colours.
    Indexed(Indexed),
}

/// Texels of 1, 2, 4 or 8 bits that name colours of a palette.
#[derive(Clone, Debug)]
pub struct Indexed {
    n_bits: usize,
    bytes_per_row: usize,
    /// The leftmost texel in the highest bits; rows begin with a byte.
    rows: Vec<u8>,
    /// RGBA.
    palette: Box<[[u8; 4]; 256]>,
}

impl Default for StoredTexels {
    fn default() -> Self {
        Self::Rgba8(Vec::new())
    }
}

impl From<Vec<[u8; 4]>> for Texels {
    fn from(rgba: Vec<[u8; 4]>) -> Self {
        Self::new(StoredTexels::Rgba8(rgba), Share::default())
    }
}

impl FromIterator<[u8; 4]> for Texels {
    fn from_iter<I: IntoIterator<Item = [u8; 4]>>(rgba: I) -> Self {
        rgba.into_iter().collect::<Vec<_>>().into()
    }
}

impl Texels {
    /// Texels, and the memory that they were decoded into.
    #[must_use]
    pub fn new(stored: StoredTexels, memory: Share) -> Self {
        Self {
            kept: Arc::new(Kept {
                stored,
                _memory: memory,
            }),
        }
    }

    /// As the file keeps them.
    #[inline]
    #[must_use]
    pub fn stored(&self) -> &StoredTexels {
        &self.kept.stored
    }

    /// True for copies of the same texels.
    #[must_use]
    pub fn are_those_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.kept, &other.kept)
    }

    /// True if there are enough for so many columns and rows, and any at all.
    #[must_use]
    pub fn fill(&self, width: usize, height: usize) -> bool {
        let n = match self.stored() {
            StoredTexels::Rgba8(t) => t.len(),
            StoredTexels::Rgb8(t) => t.len(),
            StoredTexels::Grey8(t) => t.len(),
            StoredTexels::GreyAlpha8(t) => t.len(),
            StoredTexels::Rgba16(t) => t.len(),
            StoredTexels::Rgb16(t) => t.len(),
            StoredTexels::Grey16(t) => t.len(),
            StoredTexels::GreyAlpha16(t) => t.len(),
            StoredTexels::Indexed(t) => {
                let is_wide_enough = t.bytes_per_row * 8 >= width * t.n_bits;
                t.rows.len() / t.bytes_per_row.max(1) * if is_wide_enough { width } else { 0 }
            }
        };
        width > 0 && height > 0 && width.checked_mul(height).is_some_and(|wanted| n >= wanted)
    }

    /// Red, green, blue and alpha of a texel as they are in the file, 0 to 1.
    #[must_use]
    pub fn rgba(&self, width: usize, x: usize, y: usize) -> [f32; 4] {
        let i = y * width + x;
        let byte = |c: u8| f32::from(c) / 255.0;
        let word = |c: u16| f32::from(c) / 65535.0;
        match self.stored() {
            StoredTexels::Rgba8(t) => t[i].map(byte),
            StoredTexels::Rgb8(t) => opaque(t[i].map(byte)),
            StoredTexels::Grey8(t) => opaque([byte(t[i]); 3]),
            StoredTexels::GreyAlpha8(t) => grey(t[i].map(byte)),
            StoredTexels::Rgba16(t) => t[i].map(word),
            StoredTexels::Rgb16(t) => opaque(t[i].map(word)),
            StoredTexels::Grey16(t) => opaque([word(t[i]); 3]),
            StoredTexels::GreyAlpha16(t) => grey(t[i].map(word)),
            StoredTexels::Indexed(t) => t.color(x, y).map(byte),
        }
    }
}

fn opaque([r, g, b]: [f32; 3]) -> [f32; 4] {
    [r, g, b, 1.0]
}

fn grey([g, a]: [f32; 2]) -> [f32; 4] {
    [g, g, g, a]
}

impl Indexed {
    /// Rows of texels of `n_bits` (1, 2, 4 or 8), and their colours; missing ones are black.
    #[must_use]
    pub fn new(width: usize, n_bits: usize, rows: Vec<u8>, colors: &[[u8; 4]]) -> Self {
        let mut palette = Box::new([[0, 0, 0, 255]; 256]);
        for (entry, color) in palette.iter_mut().zip(colors) {
            *entry = *color;
        }
        Self {
            n_bits,
            bytes_per_row: (width * n_bits).div_ceil(8),
            rows,
            palette,
        }
    }

    /// Red, green, blue and alpha of a texel.
    #[inline]
    #[must_use]
    pub fn color(&self, x: usize, y: usize) -> [u8; 4] {
        let bit = x * self.n_bits;
        let byte = self.rows[y * self.bytes_per_row + bit / 8];
        let index = (byte << (bit % 8)) >> (8 - self.n_bits);
        self.palette[usize::from(index)]
    }
}

#[cfg(test)]
mod tests {
    use super::{Indexed, StoredTexels, Texels};
    use crate::memory::Share;

    #[test]
    fn packed_texels_are_found_from_the_left() {
        let colors: Vec<[u8; 4]> = (0..=255).map(|i| [i, 0, 0, 255]).collect();
        let read = |n_bits: usize, width: usize, rows: &[u8]| -> Vec<u8> {
            let texels = Indexed::new(width, n_bits, rows.to_vec(), &colors);
            (0..width).map(|x| texels.color(x, 1)[0]).collect()
        };
        assert_eq!(
            read(1, 9, &[0, 0, 0b1010_0000, 0b1000_0000]),
            [1, 0, 1, 0, 0, 0, 0, 0, 1]
        );
        assert_eq!(read(2, 3, &[0, 0b0110_1100]), [1, 2, 3]);
        assert_eq!(read(4, 3, &[0, 0, 0xab, 0xc0]), [10, 11, 12]);
        assert_eq!(read(8, 2, &[0, 0, 200, 7]), [200, 7]);
    }

    #[test]
    fn texels_know_whether_they_fill_a_picture() {
        let texels: Texels = vec![[1, 2, 3, 4]; 6].into();
        assert!(texels.fill(3, 2) && !texels.fill(3, 3) && !texels.fill(0, 0));
        let packed = Indexed::new(9, 1, vec![0; 4], &[]);
        let texels = Texels::new(StoredTexels::Indexed(packed), Share::default());
        assert!(texels.fill(9, 2) && !texels.fill(17, 2) && !texels.fill(9, 3));
    }
}
