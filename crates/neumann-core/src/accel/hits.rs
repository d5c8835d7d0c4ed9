//! What rays meet, as kernels and traversals hand it on.

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance along the ray, metres.
    pub t: f32,
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentric coordinates of the second and third corner.
    pub barycentrics: [f32; 2],
}

/// A hit on the way of a ray, and by how much its distance may be wrong.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub(crate) hit: Hit,
    pub(crate) slack: f32,
}

/// The nearest hit so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub(super) hit: Hit,
    slack: f32,
    /// False if another one may be as near,
    is_alone: bool,
    /// or if one may be behind the origin or before it.
    is_start_clear: bool,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met {
    pub(crate) hit: Option<Hit>,
    /// False if single precision cannot tell which is the first, or whether anything is met at all.
    pub(crate) is_sure: bool,
}

/// Whether anything is in the way of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Occlusion {
    /// Nothing.
    Clear,
    /// Something.
    Stopped,
    /// Single precision cannot tell.
    Unsure,
}

/// What a ray has met first as a kernel hands it back: in two registers. By way of memory, the
/// first read of it would have to wait
/// for the pieces that were written. Distances have no sign; it says whether the hit is not sure.
#[derive(Clone, Copy)]
pub(super) struct PackedHit(u64, u64);

impl Occlusion {
    #[inline(always)]
    pub(super) fn new(is_stopped: bool, is_sure: bool) -> Self {
        if is_stopped {
            Self::Stopped
        } else if is_sure {
            Self::Clear
        } else {
            Self::Unsure
        }
    }
}

impl Best {
    /// No hit before `end`.
    #[inline(always)]
    pub(super) fn none_before(end: f32) -> Self {
        Self {
            hit: Hit::none_before(end),
            slack: 0.0,
            is_alone: true,
            is_start_clear: true,
        }
    }

    /// One found elsewhere.
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    pub(super) fn found(hit: Hit, slack: f32, is_alone: bool) -> Self {
        Self {
            hit,
            slack,
            is_alone,
            is_start_clear: true,
        }
    }

    /// What begins behind this is not before it for sure.
    #[inline(always)]
    pub(super) fn end(&self) -> f32 {
        self.hit.t + self.slack
    }

    /// False if another one may be as near.
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    pub(super) fn is_alone(&self) -> bool {
        self.is_alone
    }

    /// False if one may be behind the origin or before it.
    #[inline(always)]
    #[cfg(target_arch = "x86_64")]
    pub(super) fn is_start_clear(&self) -> bool {
        self.is_start_clear
    }

    /// False if single precision cannot tell.
    #[inline(always)]
    pub(super) fn is_sure(&self) -> bool {
        self.is_alone & self.is_start_clear
    }

    /// Takes another hit in its place, if that is nearer.
    #[inline(always)]
    pub(super) fn offer(&mut self, hit: Hit, slack: f32) {
        let low = hit.t - slack;
        if low <= 0.0 {
            let may_count = hit.t + slack > 0.0;
            self.is_start_clear &= !may_count;
            if hit.t <= 0.0 {
                return;
            }
        }
        if hit.is_before(&self.hit) {
            self.is_alone = hit.t + slack < self.hit.t - self.slack;
            (self.hit, self.slack) = (hit, slack);
        } else {
            // A leaf that is not full has a triangle more than once.
            self.is_alone &= low >= self.end() || hit.triangle == self.hit.triangle;
        }
    }

    /// The same of what was found among triangles that are numbered from `first_triangle` on.
    #[inline(always)]
    pub(super) fn offer_all(&mut self, found: &Self, first_triangle: u32) {
        if found.hit.is_there() {
            let mut hit = found.hit;
            hit.triangle += first_triangle;
            self.offer(hit, found.slack);
        }
        self.is_alone &= found.is_alone;
        self.is_start_clear &= found.is_start_clear;
    }
}

impl From<Best> for PackedHit {
    #[inline(always)]
    fn from(best: Best) -> Self {
        let pair = |a: u32, b: u32| u64::from(a) << 32 | u64::from(b);
        let unsure = u32::from(!best.is_sure()) << 31;
        let hit = best.hit;
        let [u, v] = hit.barycentrics;
        Self(
            pair(hit.t.to_bits() | unsure, hit.triangle),
            pair(u.to_bits(), v.to_bits()),
        )
    }
}

impl From<PackedHit> for Met {
    #[inline(always)]
    fn from(PackedHit(a, b): PackedHit) -> Self {
        let upper = |x: u64| f32::from_bits((x >> 32) as u32);
        let hit = Hit {
            t: upper(a).abs(),
            triangle: a as u32,
            barycentrics: [upper(b), f32::from_bits(b as u32)],
        };
        Self {
            hit: hit.is_there().then_some(hit),
            is_sure: a >> 63 == 0,
        }
    }
}

impl Hit {
    /// What stands for no hit before `t`.
    #[inline]
    pub(super) fn none_before(t: f32) -> Self {
        Self {
            t,
            triangle: u32::MAX,
            barycentrics: [0.0; 2],
        }
    }

    /// True unless it stands for no hit.
    #[inline]
    pub(super) fn is_there(&self) -> bool {
        self.triangle != u32::MAX
    }

    /// True if a ray has this one rather than the other: it is nearer, or as near and of a lower
    /// index.
    #[inline]
    pub(super) fn is_before(&self, other: &Self) -> bool {
        self.t < other.t || (self.t == other.t && self.triangle < other.triangle)
    }
}
