//! Matrices of Sobol's sequence, with the direction numbers of Joe and Kuo 2008, "Constructing
//! Sobol' Sequences with Better Two-Dimensional Projections" (their list `new-joe-kuo-6`).

/// Pairs of numbers that are made at once.
pub(super) const N_PAIRS: usize = 4;

/// A point of a block, the bits of its coordinates reversed: the first half of the lanes are the
/// first dimensions of the block's pairs, the second half their second.
pub(super) type Point = [u32; 2 * N_PAIRS];

/// The matrices of a block: `digits[i][d]` is what digit number i of an index, to the base 16, adds
/// to a point if it is d. Sums modulo 2 of the columns of the matrices.
pub(super) type Digits = [[Point; 16]; 8];

/// Blocks whose dimensions belong to one sequence: the camera's and those of the first two bounces.
pub(super) const N_JOINT_BLOCKS: usize = 3;

/// Which pair of dimensions each pair of a block is. Low dimensions are the better spread, so they
/// go to what varies an image most: position in the pixel, direction of the first bounce, places on
/// the lights.
const PAIRS: [[usize; N_PAIRS]; N_JOINT_BLOCKS] = [[0, 7, 10, 11], [1, 8, 5, 2], [4, 9, 6, 3]];

const N_DIMENSIONS: usize = 2 * N_PAIRS * N_JOINT_BLOCKS;

/// Primitive polynomial of each dimension, and its first direction numbers.
const DIMENSIONS: [(u32, &[u32]); N_DIMENSIONS] = [
    (1, &[]),
    (3, &[1]),
    (7, &[1, 3]),
    (11, &[1, 3, 1]),
    (13, &[1, 1, 1]),
    (19, &[1, 1, 3, 3]),
    (25, &[1, 3, 5, 13]),
    (37, &[1, 1, 5, 5, 17]),
    (41, &[1, 1, 5, 5, 5]),
    (47, &[1, 1, 7, 11, 19]),
    (55, &[1, 1, 5, 1, 1]),
    (59, &[1, 1, 1, 3, 11]),
    (61, &[1, 3, 5, 5, 31]),
    (67, &[1, 3, 3, 9, 7, 49]),
    (91, &[1, 1, 1, 15, 21, 21]),
    (97, &[1, 3, 1, 13, 27, 49]),
    (103, &[1, 1, 1, 15, 7, 5]),
    (109, &[1, 3, 1, 15, 13, 25]),
    (115, &[1, 1, 5, 5, 19, 61]),
    (131, &[1, 3, 7, 11, 23, 15, 103]),
    (137, &[1, 3, 7, 13, 13, 15, 69]),
    (143, &[1, 1, 3, 13, 7, 35, 63]),
    (145, &[1, 3, 5, 9, 1, 25, 53]),
    (157, &[1, 3, 1, 13, 9, 35, 107]),
];

static DIGITS: [Digits; N_JOINT_BLOCKS] = all_digits();

/// The matrices of a block, if its dimensions belong to the one sequence: the first block of the
/// camera and of the first bounces does.
#[inline]
pub(super) fn digits(block: u32, blocks_per_bounce: u32) -> Option<&'static Digits> {
    if block.is_multiple_of(blocks_per_bounce) {
        DIGITS.get((block / blocks_per_bounce) as usize)
    } else {
        None
    }
}

/// The point of an index.
#[inline(always)]
pub(super) fn point(digits: &Digits, mut index: u32) -> Point {
    let mut point = [0; 2 * N_PAIRS];
    for values in digits {
        if index == 0 {
            break;
        }
        for (sum, value) in point.iter_mut().zip(&values[index as usize % 16]) {
            *sum ^= value;
        }
        index >>= 4;
    }
    point
}

const fn all_digits() -> [Digits; N_JOINT_BLOCKS] {
    let mut all = [[[[0; 2 * N_PAIRS]; 16]; 8]; N_JOINT_BLOCKS];
    let mut i = 0;
    while i < N_DIMENSIONS {
        let (block, lane) = (i / (2 * N_PAIRS), i % (2 * N_PAIRS));
        let dimension = 2 * PAIRS[block][lane % N_PAIRS] + lane / N_PAIRS;
        let numbers = direction_numbers(dimension);
        let mut digit = 0;
        while digit < 8 {
            let mut value = 1;
            while value < 16 {
                // As the value without its lowest bit, and the column of that bit.
                let bit = 4 * digit + (value as u32).trailing_zeros() as usize;
                let column = (numbers[bit] << (31 - bit)).reverse_bits();
                all[block][digit][value][lane] =
                    all[block][digit][value & (value - 1)][lane] ^ column;
                value += 1;
            }
            digit += 1;
        }
        i += 1;
    }
    all
}

/// `m_k` of Joe and Kuo, by their recurrence (eq. 2.3).
const fn direction_numbers(dimension: usize) -> [u32; 32] {
    let (polynomial, first) = DIMENSIONS[dimension];
    let degree = first.len();
    let mut m = [1u32; 32];
    let mut k = 0;
    while k < 32 {
        if k < degree {
            m[k] = first[k];
        } else if degree > 0 {
            m[k] = m[k - degree] ^ m[k - degree] << degree;
            let mut i = 1;
            while i < degree {
                if polynomial >> (degree - i) & 1 == 1 {
                    m[k] ^= m[k - i] << i;
                }
                i += 1;
            }
        }
        k += 1;
    }
    m
}

#[cfg(test)]
mod tests {
    use super::{DIGITS, N_PAIRS, point};

    #[test]
    fn the_first_dimensions_are_sobols() {
        // Points 0 to 7 of the first two dimensions, times 8.
        let points = |lane: usize| -> Vec<u32> {
            (0..8)
                .map(|index| point(&DIGITS[0], index)[lane].reverse_bits() >> 29)
                .collect()
        };
        assert_eq!(points(0), [0, 4, 2, 6, 1, 5, 3, 7]);
        assert_eq!(points(N_PAIRS), [0, 4, 6, 2, 5, 1, 3, 7]);
    }

    #[test]
    fn every_dimension_is_stratified() {
        // Any 4096 indices in a row that begin at a multiple of as many have one point in each of
        // 4096 cells.
        for digits in &DIGITS {
            for lane in 0..2 * N_PAIRS {
                for first in [0u32, 4096, 0xabcd_e000] {
                    let mut seen = [false; 4096];
                    for index in first..first + 4096 {
                        let cell = (point(digits, index)[lane].reverse_bits() >> 20) as usize;
                        assert!(!std::mem::replace(&mut seen[cell], true));
                    }
                }
            }
        }
    }
}
