//! How many paths from the camera each pixel has had.

use super::frame::TileGrid;

/// Paths from the camera, pixel by pixel; a method that sends none has none.
#[derive(Clone, Debug)]
pub struct SampleMap {
    size: (usize, usize),
    grid: TileGrid,
    /// For each pixel of a tile, tiles row by row.
    of_tiles: Vec<u32>,
}

impl SampleMap {
    /// That of no iteration.
    #[must_use]
    pub fn new(width: usize, height: usize) -> Self {
        let grid = TileGrid::new(width, height);
        Self {
            size: (width, height),
            of_tiles: vec![0; grid.n_tiles()],
            grid,
        }
    }

    /// Takes in an iteration: the paths of each pixel of a tile, tiles row by row.
    pub(crate) fn add(&mut self, of_tiles: &[u8]) {
        for (sum, n) in self.of_tiles.iter_mut().zip(of_tiles) {
            *sum += u32::from(*n);
        }
    }

    /// Pixels per row, and rows.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.size
    }

    /// Paths of the pixel at `x`, `y`, (0, 0) on the top left.
    ///
    /// # Panics
    /// If there is no such pixel.
    #[must_use]
    pub fn at(&self, x: usize, y: usize) -> u32 {
        self.of_tiles[self.grid.slot(0, x, y).tile as usize]
    }

    /// The fewest and the most paths of a pixel.
    #[must_use]
    pub fn range(&self) -> (u32, u32) {
        let least = self.of_tiles.iter().copied().min();
        let most = self.of_tiles.iter().copied().max();
        (least.unwrap_or(0), most.unwrap_or(0))
    }
}
