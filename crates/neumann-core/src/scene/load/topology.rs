//! Triangles out of index lists (glTF 2.0, 3.7.2.1).

/// What the indices of a primitive mean (`mode`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topology {
    Points,
    Lines,
    LineLoop,
    LineStrip,
    Triangles,
    TriangleStrip,
    TriangleFan,
}

impl Topology {
    /// From glTF's number.
    pub(super) fn from_mode(mode: usize) -> Option<Self> {
        match mode {
            0 => Some(Self::Points),
            1 => Some(Self::Lines),
            2 => Some(Self::LineLoop),
            3 => Some(Self::LineStrip),
            4 => Some(Self::Triangles),
            5 => Some(Self::TriangleStrip),
            6 => Some(Self::TriangleFan),
            _ => None,
        }
    }

    /// How many points `n` indices make.
    pub(super) fn n_points(self, n: usize) -> usize {
        if self == Self::Points { n } else { 0 }
    }

    /// How many line segments `n` indices make.
    pub(super) fn n_lines(self, n: usize) -> usize {
        match self {
            Self::Lines => n / 2,
            Self::LineLoop if n >= 2 => n,
            Self::LineStrip => n.saturating_sub(1),
            _ => 0,
        }
    }

    /// How many triangles `n` indices make.
    pub(super) fn n_triangles(self, n: usize) -> usize {
        match self {
            Self::Triangles => n / 3,
            Self::TriangleStrip | Self::TriangleFan => n.saturating_sub(2),
            _ => 0,
        }
    }

    /// Positions, in the index list, of the corners of triangle `i`.
    ///
    /// Every other triangle of a strip is turned, so that all face one way.
    pub(super) fn corners(self, i: usize) -> [usize; 3] {
        match self {
            Self::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Self::TriangleFan => [i + 1, i + 2, 0],
            _ => [3 * i, 3 * i + 1, 3 * i + 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Topology;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        let strip = Topology::TriangleStrip;
        assert_eq!(strip.n_triangles(5), 3);
        assert_eq!(strip.corners(0), [0, 1, 2]);
        assert_eq!(strip.corners(1), [1, 3, 2]);
        assert_eq!(strip.corners(2), [2, 3, 4]);
        let fan = Topology::TriangleFan;
        assert_eq!(fan.n_triangles(4), 2);
        assert_eq!(fan.corners(0), [1, 2, 0]);
        assert_eq!(fan.corners(1), [2, 3, 0]);
        assert_eq!(Topology::Triangles.n_triangles(7), 2);
        assert_eq!(strip.n_triangles(1), 0);
    }

    #[test]
    fn lines_are_counted_by_segment() {
        assert_eq!(Topology::Lines.n_lines(5), 2);
        assert_eq!(Topology::LineStrip.n_lines(5), 4);
        assert_eq!(Topology::LineLoop.n_lines(5), 5);
        assert_eq!(Topology::LineLoop.n_lines(1), 0);
        assert_eq!(Topology::Points.n_points(5), 5);
    }
}
