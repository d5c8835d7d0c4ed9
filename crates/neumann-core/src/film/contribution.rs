//! One path's share of one pixel, labelled.

use crate::radiometry::Rgb;

/// One path's share of one pixel: radiance (times pixel response), before its MIS weight.
#[derive(Clone, Copy, Debug)]
pub struct Contribution {
    /// Estimate without its MIS weight, W m⁻² sr⁻¹.
    pub value: Rgb,
    /// MIS weight in [0, 1].
    pub mis_weight: f32,
    /// Number of scattering events between emission and sensor: the power of T.
    pub bounce: u32,
    /// The technique that made the path.
    pub strategy: Strategy,
}

/// How the two parts of a path were joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Joint {
    /// One part alone ran into the other end (s = 0, or t = 0).
    Hit,
    /// A segment connects the ends of both parts.
    Connect,
    /// The ends of both parts were taken for one point.
    Merge,
}

/// The technique (s, t) that made a path, endpoints included ([Veach 1997] 10.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Strategy {
    /// Vertices of the light subpath.
    pub s: u16,
    /// Vertices of the camera subpath.
    pub t: u16,
    /// How they were joined.
    pub joint: Joint,
}

impl Strategy {
    /// A camera subpath of `t` vertices that ran into an emitter.
    #[inline]
    #[must_use]
    pub const fn hit(t: u16) -> Self {
        Self {
            s: 0,
            t,
            joint: Joint::Hit,
        }
    }

    /// A light subpath of `s` vertices, the last of them on the lens, which it ran into.
    #[inline]
    #[must_use]
    pub const fn lens(s: u16) -> Self {
        Self {
            s,
            t: 0,
            joint: Joint::Hit,
        }
    }

    /// Subpaths of `s` and `t` vertices whose ends were taken for one point.
    #[inline]
    #[must_use]
    pub const fn merge(s: u16, t: u16) -> Self {
        Self {
            s,
            t,
            joint: Joint::Merge,
        }
    }

    /// Subpaths of `s` and `t` vertices with a segment between them.
    #[inline]
    #[must_use]
    pub const fn connect(s: u16, t: u16) -> Self {
        Self {
            s,
            t,
            joint: Joint::Connect,
        }
    }

    /// Number of scattering events of the path; the only code that knows this.
    ///
    /// A path of n vertices scatters at all but its two ends; a merge counts
    /// one point twice.
    #[inline]
    #[must_use]
    pub const fn bounce(self) -> u32 {
        let n = self.s as u32 + self.t as u32;
        match self.joint {
            Joint::Hit | Joint::Connect => n - 2,
            Joint::Merge => n - 3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Strategy;

    #[test]
    fn bounces_follow_from_the_technique() {
        assert_eq!(Strategy::hit(2).bounce(), 0, "a directly seen emitter");
        assert_eq!(Strategy::connect(1, 2).bounce(), 1, "direct illumination");
        assert_eq!(Strategy::lens(3).bounce(), 1, "one bounce, then the lens");
        assert_eq!(Strategy::merge(2, 2).bounce(), 1, "one point counted twice");
    }
}
