//! Many numbers side by side: the same is done for each lane, and the compiler makes vectors of it.
//!
//! A loop over all [`LANES`] in a [`vectorized`] function is compiled for each kind of vectors that processors
//! have, and the longest that this one has is chosen when it runs. The loop is written for one lane, with the functions that
//! single paths use: it has the same bits on every processor, since none of the compilations reorders or fuses anything.

use glam::Vec3;

/// Lanes: as many as the longest vectors have room for.
pub(crate) const LANES: usize = 16;

/// A number in each lane.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Lanes<T>(pub(crate) [T; LANES]);

/// A vector in each lane.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Vec3Lanes {
    x: Lanes<f32>,
    y: Lanes<f32>,
    z: Lanes<f32>,
}

impl<T: Copy + Default> Default for Lanes<T> {
    fn default() -> Self {
        Self([T::default(); LANES])
    }
}

impl<T: Copy> Lanes<T> {
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> T {
        self.0[lane]
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, value: T) {
        self.0[lane] = value;
    }
}

impl Lanes<f32> {
    /// Sets a lane if `is_set`, without a branch.
    #[inline(always)]
    pub(crate) fn set_if(&mut self, is_set: bool, lane: usize, value: f32) {
        self.0[lane] = select(is_set, value, self.0[lane]);
    }
}

impl Lanes<u32> {
    /// Sets a lane if `is_set`, without a branch.
    #[inline(always)]
    pub(crate) fn set_if(&mut self, is_set: bool, lane: usize, value: u32) {
        let mask = u32::from(is_set).wrapping_neg();
        self.0[lane] = value & mask | self.0[lane] & !mask;
    }
}

impl Vec3Lanes {
    #[inline(always)]
    pub(crate) fn axes(&self) -> [&Lanes<f32>; 3] {
        [&self.x, &self.y, &self.z]
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x.0[lane], self.y.0[lane], self.z.0[lane])
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, value: Vec3) {
        self.x.0[lane] = value.x;
        self.y.0[lane] = value.y;
        self.z.0[lane] = value.z;
    }

    /// Sets a lane if `is_set`, without a branch.
    #[inline(always)]
    pub(crate) fn set_if(&mut self, is_set: bool, lane: usize, value: Vec3) {
        self.x.set_if(is_set, lane, value.x);
        self.y.set_if(is_set, lane, value.y);
        self.z.set_if(is_set, lane, value.z);
    }
}

/// `a` or `b`, without a branch.
#[inline(always)]
pub(crate) fn select(is_first: bool, a: f32, b: f32) -> f32 {
    let mask = u32::from(is_first).wrapping_neg();
    f32::from_bits(a.to_bits() & mask | b.to_bits() & !mask)
}

/// The lanes of which the bit is set.
#[inline(always)]
pub(crate) fn lanes_of(mask: u32) -> impl Iterator<Item = usize> {
    let mut rest = mask;
    std::iter::from_fn(move || {
        let lane = rest.trailing_zeros() as usize;
        rest &= rest.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}

/// Makes a function of which the body is compiled for vectors of several lengths.
macro_rules! vectorized {
    ($(#[$attribute:meta])* $visibility:vis fn $name:ident($($argument:ident: $type:ty),* $(,)?) $body:block) => {
        $(#[$attribute])*
        $visibility fn $name($($argument: $type),*) {
            #[inline(always)]
            fn body($($argument: $type),*) $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2,avx512f,avx512vl,avx512bw,avx512dq")]
                fn with_avx512($($argument: $type),*) {
                    body($($argument),*);
                }
                #[target_feature(enable = "avx2")]
                fn with_avx2($($argument: $type),*) {
                    body($($argument),*);
                }
                if $crate::math::lanes::has_avx512() {
                    #[allow(unsafe_code, reason = "the processor was just found to have these features")]
                    // SAFETY: as said.
                    return unsafe { with_avx512($($argument),*) };
                }
                if std::is_x86_feature_detected!("avx2") {
                    #[allow(unsafe_code, reason = "the processor was just found to have AVX2")]
                    // SAFETY: as said.
                    return unsafe { with_avx2($($argument),*) };
                }
            }
            body($($argument),*);
        }
    };
}

pub(crate) use vectorized;

/// True if the processor has vectors of sixteen numbers, and all that is done with them here.
#[cfg(target_arch = "x86_64")]
#[inline]
pub(crate) fn has_avx512() -> bool {
    std::is_x86_feature_detected!("avx512f")
        && std::is_x86_feature_detected!("avx512vl")
        && std::is_x86_feature_detected!("avx512bw")
        && std::is_x86_feature_detected!("avx512dq")
}
