//! Many numbers side by side: the same is done for each lane, and the compiler makes vectors of it.
//!
//! A loop over all [`LANES`] in a [`vectorized`] function is compiled for each kind of vectors that
//! processors have, and the longest that this one has is chosen when it runs. The loop is written
//! for one lane, with the functions that single paths use: it has the same bits on every processor,
//! since none of the compilations reorders or fuses anything.

use glam::Vec3;

/// Lanes: as many as the longest vectors have room for.
pub(crate) const LANES: usize = 16;

/// A number in each lane.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Lanes<T>(pub(crate) [T; LANES]);

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

/// What can stand side by side, one in each lane; [`side_by_side`] makes it of its fields.
pub(crate) trait Laned: Copy {
    /// One in each lane.
    type Lanes;

    /// That of a lane.
    fn of_lane(lanes: &Self::Lanes, lane: usize) -> Self;

    /// Sets a lane.
    fn set_lane(self, lanes: &mut Self::Lanes, lane: usize);

    /// Sets a lane if `is_set`, without a branch.
    fn set_lane_if(self, is_set: bool, lanes: &mut Self::Lanes, lane: usize);
}

/// Numbers are kept as they are.
macro_rules! number_side_by_side {
    ($type:ty) => {
        impl Laned for $type {
            type Lanes = Lanes<$type>;

            #[inline(always)]
            fn of_lane(lanes: &Self::Lanes, lane: usize) -> Self {
                lanes.get(lane)
            }

            #[inline(always)]
            fn set_lane(self, lanes: &mut Self::Lanes, lane: usize) {
                lanes.set(lane, self);
            }

            #[inline(always)]
            fn set_lane_if(self, is_set: bool, lanes: &mut Self::Lanes, lane: usize) {
                lanes.set_if(is_set, lane, self);
            }
        }
    };
}

number_side_by_side!(f32);
number_side_by_side!(u32);

/// So many of one kind.
impl<T: Laned + Default, const N: usize> Laned for [T; N] {
    type Lanes = [T::Lanes; N];

    #[inline(always)]
    fn of_lane(lanes: &Self::Lanes, lane: usize) -> Self {
        // `std::array::from_fn` is not always inlined.
        let mut all = [T::default(); N];
        for (value, lanes) in all.iter_mut().zip(lanes) {
            *value = T::of_lane(lanes, lane);
        }
        all
    }

    #[inline(always)]
    fn set_lane(self, lanes: &mut Self::Lanes, lane: usize) {
        for (value, lanes) in self.into_iter().zip(lanes) {
            value.set_lane(lanes, lane);
        }
    }

    #[inline(always)]
    fn set_lane_if(self, is_set: bool, lanes: &mut Self::Lanes, lane: usize) {
        for (value, lanes) in self.into_iter().zip(lanes) {
            value.set_lane_if(is_set, lanes, lane);
        }
    }
}

/// Makes of a struct one of which each field has all lanes.
macro_rules! side_by_side {
    ($(#[$attribute:meta])* $visibility:vis struct $lanes:ident of $type:ident {
        $($field:ident: $of:ty),* $(,)?
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, Default)]
        $visibility struct $lanes {
            $($field: <$of as $crate::math::lanes::Laned>::Lanes),*
        }

        #[allow(dead_code, reason = "not every one is asked for everything")]
        impl $lanes {
            /// That of a lane.
            #[inline(always)]
            $visibility fn get(&self, lane: usize) -> $type {
                $type {
                    $($field: <$of as $crate::math::lanes::Laned>::of_lane(&self.$field, lane)),*
                }
            }

            /// Sets a lane.
            #[inline(always)]
            $visibility fn set(&mut self, lane: usize, value: $type) {
                $($crate::math::lanes::Laned::set_lane(value.$field, &mut self.$field, lane);)*
            }

            /// Sets a lane if `is_set`, without a branch.
            #[inline(always)]
            $visibility fn set_if(&mut self, is_set: bool, lane: usize, value: $type) {
                $($crate::math::lanes::Laned::set_lane_if(
                    value.$field, is_set, &mut self.$field, lane,
                );)*
            }
        }

        impl $crate::math::lanes::Laned for $type {
            type Lanes = $lanes;

            #[inline(always)]
            fn of_lane(lanes: &$lanes, lane: usize) -> Self {
                lanes.get(lane)
            }

            #[inline(always)]
            fn set_lane(self, lanes: &mut $lanes, lane: usize) {
                lanes.set(lane, self);
            }

            #[inline(always)]
            fn set_lane_if(self, is_set: bool, lanes: &mut $lanes, lane: usize) {
                lanes.set_if(is_set, lane, self);
            }
        }
    };
}

pub(crate) use side_by_side;

side_by_side! {
    /// A vector in each lane.
    pub(crate) struct Vec3Lanes of Vec3 { x: f32, y: f32, z: f32 }
}

impl Vec3Lanes {
    #[inline(always)]
    pub(crate) fn axes(&self) -> [&Lanes<f32>; 3] {
        [&self.x, &self.y, &self.z]
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
    (
        $(#[$attribute:meta])*
        $visibility:vis fn $name:ident($($argument:ident: $type:ty),* $(,)?) $body:block
    ) => {
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
                    #[allow(unsafe_code, reason = "the processor was just found to have them")]
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
