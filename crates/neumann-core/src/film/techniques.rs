//! What each technique of a method adds, kept apart: the pyramid of Veach's thesis.
//!
//! For each technique (s, t) and each merge: the mean of its contributions as they are, the mean of
//! the same times their MIS weights, and the mean weight. It is kept at reduced resolution and only
//! while somebody looks, since it takes [`TechniqueFilm::bytes`] of memory.

use super::{Contribution, Joint, Strategy};
use crate::radiometry::Rgb;

/// The techniques of a method, each with its images.
#[derive(Clone, Debug)]
pub struct TechniqueFilm {
    width: usize,
    height: usize,
    divisor: usize,
    n_bounces: usize,
    n_iterations: u32,
    planes: Vec<Option<Plane>>,
    /// Weighted contributions of longer paths.
    rest: Vec<Sum>,
}

/// Sums over all iterations.
#[derive(Clone, Debug)]
struct Plane {
    raw: Vec<Sum>,
    weighted: Vec<Sum>,
    weights: Vec<f64>,
    counts: Vec<f64>,
}

/// Of colours: in double precision, in which millions of iterations add up without loss.
type Sum = [f64; 3];

const NOTHING: Sum = [0.0; 3];

fn add(sum: &mut Sum, value: Rgb) {
    for (sum, channel) in sum.iter_mut().zip(value.to_array()) {
        *sum += f64::from(channel);
    }
}

fn luminance_of(sums: &[Sum]) -> f64 {
    let luminance = |sum: &Sum| f64::from(Rgb::from(sum.map(|s| s as f32)).luminance());
    sums.iter().map(luminance).sum()
}

/// Which image of a technique.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TechniqueImage {
    /// Contributions as they are: what the image would be by this technique alone.
    Raw,
    /// Times their MIS weights: these add up to L.
    #[default]
    Weighted,
    /// The mean weight alone.
    Weight,
}

impl TechniqueImage {
    /// All of them, in the order of menus.
    pub const ALL: [Self; 3] = [Self::Weighted, Self::Raw, Self::Weight];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Weighted => "weighted",
            Self::Weight => "weight",
        }
    }
}

/// A contribution on its way to a [`TechniqueFilm`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Record {
    pixel: u32,
    /// Index of the technique; `u32::MAX` for longer paths.
    technique: u32,
    value: Rgb,
    mis_weight: f32,
}

/// Where records come from: enough of a [`TechniqueFilm`] to make them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecordShape {
    width: u32,
    divisor: u32,
    n_bounces: u32,
}

impl RecordShape {
    #[inline]
    pub(crate) fn record(self, (x, y): (u32, u32), contribution: &Contribution) -> Record {
        let strategy = contribution.strategy;
        let technique = if strategy.bounce() < self.n_bounces {
            index_of(strategy) as u32
        } else {
            u32::MAX
        };
        Record {
            pixel: y / self.divisor * self.width + x / self.divisor,
            technique,
            value: contribution.value,
            mis_weight: contribution.mis_weight,
        }
    }
}

/// Techniques in rows and columns, [`TechniqueFilm::table`].
///
/// A column is a number of vertices from the light, s; merges have columns of their own, behind the
/// others. A cell is there for every technique that is like one that has made something: as many
/// vertices from the light as any has, subpaths of light that meet the lens if one does, and merges
/// if there are some.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TechniqueTable {
    /// One row for each bounce, from 0 on.
    pub rows: Vec<TechniqueRow>,
    /// Columns, those of merges among them.
    pub n_columns: usize,
    /// The first column of merges, if there are some.
    pub first_merge: Option<usize>,
}

/// The techniques of a bounce.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TechniqueRow {
    /// Stops by which images of the row are brightened, so that it is about as bright as the
    /// brightest row that light was scattered in.
    pub gain: u8,
    /// Its techniques.
    pub cells: Vec<TechniqueCell>,
}

/// A technique in its table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TechniqueCell {
    /// The technique.
    pub strategy: Strategy,
    /// Where it stands in its row.
    pub column: usize,
    /// Its [`TechniqueFilm::share`].
    pub share: f64,
    /// False if it has made nothing yet.
    pub is_made: bool,
}

impl TechniqueTable {
    /// Most stops by which a row is brightened.
    pub const MOST_GAIN: u8 = 10;

    fn choose_gains(&mut self) {
        let energy = |row: &TechniqueRow| row.cells.iter().map(|cell| cell.share).sum::<f64>();
        let brightest = self.rows.iter().skip(1).map(energy).fold(0.0, f64::max);
        for row in self.rows.iter_mut().skip(1) {
            let energy = energy(row);
            if energy > 0.0 {
                let stops = (brightest / energy).log2().round();
                row.gain = stops.clamp(0.0, f64::from(Self::MOST_GAIN)) as u8;
            }
        }
    }
}

/// Bounce by bounce, k + 3 techniques without a merge (s = 0 … k + 2), then k merges
/// (s = 2 … k + 1).
fn index_of(strategy: Strategy) -> usize {
    let k = strategy.bounce() as usize;
    let first = k * k + 2 * k;
    match strategy.joint {
        Joint::Hit | Joint::Connect => first + strategy.s as usize,
        Joint::Merge => first + k + 3 + strategy.s as usize - 2,
    }
}

/// The techniques of bounce `k`, in the order of [`index_of`].
fn techniques_of(k: usize) -> impl Iterator<Item = Strategy> {
    let n = k as u16 + 2;
    let without = (0..=n).map(move |s| match s {
        0 => Strategy::hit(n),
        s if s == n => Strategy::lens(s),
        s => Strategy::connect(s, n - s),
    });
    let merges = (2..n).map(move |s| Strategy::merge(s, n + 1 - s));
    without.chain(merges)
}

impl TechniqueFilm {
    /// An empty one for an image of `width × height` pixels, `divisor` times smaller each way,
    /// with techniques of fewer than `n_bounces` bounces apart.
    #[must_use]
    pub fn new(width: usize, height: usize, divisor: usize, n_bounces: usize) -> Self {
        let divisor = divisor.max(1);
        let (width, height) = (width.div_ceil(divisor), height.div_ceil(divisor));
        Self {
            width,
            height,
            divisor,
            n_bounces,
            n_iterations: 0,
            planes: vec![None; n_bounces * n_bounces + 2 * n_bounces],
            rest: vec![NOTHING; width * height],
        }
    }

    /// Pixels per row of its images.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of its images.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Pixels of the film along an edge of one pixel here.
    #[must_use]
    pub fn divisor(&self) -> usize {
        self.divisor
    }

    /// Techniques of fewer bounces than this are apart.
    #[must_use]
    pub fn n_bounces(&self) -> usize {
        self.n_bounces
    }

    /// Iterations it is the mean of.
    #[must_use]
    pub fn n_iterations(&self) -> u32 {
        self.n_iterations
    }

    /// Memory of its images at most, bytes: 64 for each pixel and technique.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let n_planes = self.planes.len();
        (n_planes * size_of::<[f64; 8]>() + size_of::<Sum>()) * self.rest.len()
    }

    /// The techniques of a bounce that have made anything yet: hits, connections, then merges.
    #[must_use]
    pub fn techniques(&self, bounce: usize) -> Vec<Strategy> {
        if bounce >= self.n_bounces {
            return Vec::new();
        }
        techniques_of(bounce)
            .filter(|strategy| self.planes[index_of(*strategy)].is_some())
            .collect()
    }

    /// One image of a technique, `[y * width + x]`, row 0 on top; empty if it has made nothing.
    /// Weights are grey.
    #[must_use]
    pub fn image(&self, strategy: Strategy, image: TechniqueImage) -> Vec<Rgb> {
        let plane = self.planes.get(index_of(strategy)).and_then(Option::as_ref);
        let Some(plane) = plane else {
            return Vec::new();
        };
        match image {
            TechniqueImage::Raw => self.mean(&plane.raw),
            TechniqueImage::Weighted => self.mean(&plane.weighted),
            TechniqueImage::Weight => plane
                .weights
                .iter()
                .zip(&plane.counts)
                .map(|(w, n)| Rgb::splat(if *n > 0.0 { w / n } else { 0.0 } as f32))
                .collect(),
        }
    }

    /// Weighted contributions of all paths with more bounces.
    #[must_use]
    pub fn rest(&self) -> Vec<Rgb> {
        self.mean(&self.rest)
    }

    /// Share of a technique in the energy (mean luminance) of the image.
    #[must_use]
    pub fn share(&self, strategy: Strategy) -> f64 {
        let planes = self.planes.iter().flatten();
        let total =
            planes.map(|p| luminance_of(&p.weighted)).sum::<f64>() + luminance_of(&self.rest);
        let plane = self.planes.get(index_of(strategy)).and_then(Option::as_ref);
        match plane {
            Some(plane) if total > 0.0 => luminance_of(&plane.weighted) / total,
            _ => 0.0,
        }
    }

    /// The techniques as a table: one row for each bounce, up to the last that any technique has
    /// made something of.
    #[must_use]
    pub fn table(&self) -> TechniqueTable {
        let is_made = |strategy: Strategy| self.planes[index_of(strategy)].is_some();
        let all = || (0..self.n_bounces).flat_map(techniques_of);
        let is_merge = |strategy: &Strategy| strategy.joint == Joint::Merge;
        let made: Vec<Strategy> = all().filter(|strategy| is_made(*strategy)).collect();
        let most = made.iter().filter(|s| !is_merge(s)).map(|s| s.s).max();
        let meets_lens = made.iter().any(|s| s.t == 0);
        let merges = made.iter().any(is_merge);
        let is_there = |strategy: &Strategy| {
            if is_merge(strategy) {
                return merges;
            }
            let is_reached = most.is_some_and(|most| strategy.s <= most);
            is_reached && (meets_lens || strategy.t > 0)
        };
        let first_merge = most.map_or(0, |most| usize::from(most) + 1);
        let mut table = TechniqueTable {
            rows: Vec::new(),
            n_columns: first_merge,
            first_merge: merges.then_some(first_merge),
        };
        let n_rows = made.iter().map(|s| s.bounce() as usize + 1).max();
        let mut total = luminance_of(&self.rest);
        for bounce in 0..n_rows.unwrap_or(0) {
            let there = techniques_of(bounce).filter(is_there);
            let cells = there.map(|strategy| {
                let plane = self.planes[index_of(strategy)].as_ref();
                let s = usize::from(strategy.s);
                TechniqueCell {
                    strategy,
                    column: if is_merge(&strategy) {
                        first_merge + s - 2
                    } else {
                        s
                    },
                    share: plane.map_or(0.0, |plane| luminance_of(&plane.weighted)),
                    is_made: plane.is_some(),
                }
            });
            let cells: Vec<_> = cells.collect();
            let last = cells.iter().map(|cell| cell.column + 1).max();
            table.n_columns = table.n_columns.max(last.unwrap_or(0));
            total += cells.iter().map(|cell| cell.share).sum::<f64>();
            table.rows.push(TechniqueRow { gain: 0, cells });
        }
        if total > 0.0 {
            for cell in table.rows.iter_mut().flat_map(|row| &mut row.cells) {
                cell.share /= total;
            }
        }
        table.choose_gains();
        table
    }

    /// Sums over iterations and pixels to means; pixels at the lower and right edge may be cut.
    fn mean(&self, sums: &[Sum]) -> Vec<Rgb> {
        let n = (self.divisor * self.divisor) as f64 * f64::from(self.n_iterations.max(1));
        let mean = |sum: &Sum| Rgb::from(sum.map(|s| (s / n) as f32));
        sums.iter().map(mean).collect()
    }

    pub(crate) fn shape(&self) -> RecordShape {
        RecordShape {
            width: self.width as u32,
            divisor: self.divisor as u32,
            n_bounces: self.n_bounces as u32,
        }
    }

    pub(crate) fn take(&mut self, records: &[Record]) {
        let n = self.rest.len();
        for record in records {
            let weighted = record.value * record.mis_weight;
            let pixel = record.pixel as usize;
            let Some(plane) = self.planes.get_mut(record.technique as usize) else {
                add(&mut self.rest[pixel], weighted);
                continue;
            };
            let plane = plane.get_or_insert_with(|| Plane {
                raw: vec![NOTHING; n],
                weighted: vec![NOTHING; n],
                weights: vec![0.0; n],
                counts: vec![0.0; n],
            });
            add(&mut plane.raw[pixel], record.value);
            add(&mut plane.weighted[pixel], weighted);
            plane.weights[pixel] += f64::from(record.mis_weight);
            plane.counts[pixel] += 1.0;
        }
    }

    /// An empty one of the same shape.
    pub(crate) fn emptied(&self) -> Self {
        Self {
            n_iterations: 0,
            planes: vec![None; self.planes.len()],
            rest: vec![NOTHING; self.rest.len()],
            ..*self
        }
    }

    pub(crate) fn end_iteration(&mut self) {
        self.n_iterations += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::{Contribution, Strategy, TechniqueFilm, TechniqueTable, index_of, techniques_of};
    use crate::radiometry::Rgb;

    fn filled(n_bounces: usize, contributions: &[(Strategy, f32)]) -> TechniqueFilm {
        let mut film = TechniqueFilm::new(2, 1, 1, n_bounces);
        let shape = film.shape();
        let records = contributions.iter().map(|(strategy, value)| {
            let contribution = Contribution {
                value: Rgb::splat(*value),
                mis_weight: 0.5,
                bounce: strategy.bounce(),
                strategy: *strategy,
            };
            shape.record((0, 0), &contribution)
        });
        film.take(&records.collect::<Vec<_>>());
        film.end_iteration();
        film
    }

    #[test]
    fn the_table_has_the_shares_of_each() {
        let (seen, aimed) = (Strategy::hit(2), Strategy::connect(1, 2));
        let film = filled(2, &[(seen, 1.0), (aimed, 3.0), (Strategy::hit(9), 4.0)]);
        let table = film.table();
        assert_eq!(table.rows.len(), 2);
        let share = |k: usize, column: usize| {
            let cells = table.rows[k].cells.iter();
            let mut cells = cells.filter(|cell| cell.column == column);
            cells.next().map(|cell| (cell.strategy, cell.share))
        };
        assert_eq!(share(0, 0), Some((seen, film.share(seen))));
        let (strategy, share) = share(1, 1).expect("light was aimed at");
        assert_eq!(strategy, aimed);
        assert!((share - 3.0 / 8.0).abs() < 1e-6, "{share}");
        assert!((film.share(aimed) - share).abs() < 1e-12);
    }

    /// A path tracer has two columns, whatever the bounce; a bidirectional one has as many as there
    /// are vertices, and merges behind them. Where nothing was made the cell is there.
    #[test]
    fn columns_of_the_table_keep_their_vertices_from_the_light() {
        let columns = |film: &TechniqueFilm| -> Vec<Vec<(usize, bool)>> {
            let rows = film.table().rows.into_iter();
            let cells = rows.map(|row| row.cells.into_iter());
            let places = cells.map(|cells| cells.map(|cell| (cell.column, cell.is_made)).collect());
            places.collect()
        };
        let path = filled(
            4,
            &[(Strategy::hit(2), 1.0), (Strategy::connect(1, 3), 1.0)],
        );
        let [there, empty] = [true, false];
        assert_eq!(
            columns(&path),
            [
                vec![(0, there), (1, empty)],
                vec![(0, empty), (1, empty)],
                vec![(0, empty), (1, there)]
            ]
        );
        let merging = filled(
            4,
            &[(Strategy::connect(2, 1), 1.0), (Strategy::merge(2, 2), 1.0)],
        );
        assert_eq!(
            columns(&merging),
            [
                vec![(0, empty), (1, empty)],
                vec![(0, empty), (1, empty), (2, there), (3, there)]
            ]
        );
        assert_eq!(merging.table().first_merge, Some(3));
        assert_eq!(merging.table().n_columns, 4);
    }

    #[test]
    fn dark_rows_are_brightened_by_whole_stops() {
        let film = filled(
            4,
            &[
                (Strategy::hit(2), 100.0),
                (Strategy::hit(3), 8.0),
                (Strategy::hit(4), 1.0),
                (Strategy::hit(5), 1e-6),
            ],
        );
        let gains: Vec<_> = film.table().rows.iter().map(|row| row.gain).collect();
        assert_eq!(gains, [0, 0, 3, TechniqueTable::MOST_GAIN]);
    }

    #[test]
    fn techniques_are_numbered_without_gaps() {
        let mut next = 0;
        for k in 0..6 {
            for strategy in techniques_of(k) {
                assert_eq!(strategy.bounce() as usize, k, "{strategy:?}");
                assert_eq!(index_of(strategy), next, "{strategy:?}");
                next += 1;
            }
        }
    }
}
