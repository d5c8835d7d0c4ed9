//! Memory that rays jump about in.

use rayon::prelude::*;

/// Below this size, bytes, large pages gain nothing.
#[cfg(target_os = "linux")]
const MIN_BYTES: usize = 4 << 20;
/// Values that one task writes at least.
const CHUNK: usize = 1 << 12;

/// `n` copies of a value, in large pages where the system has them: a ray through a big tree finds
/// most of its nodes on pages whose addresses the processor does not have at hand. On the one
/// machine where it was measured, a virtual one, rays were as fast without.
pub(super) fn in_large_pages<T: Copy + Send + Sync>(value: T, n: usize) -> Vec<T> {
    let mut values = Vec::with_capacity(n);
    #[cfg(target_os = "linux")]
    ask_for_large_pages(values.spare_capacity_mut());
    // Pages are cleared where they are first touched, so all threads do it.
    (0..n)
        .into_par_iter()
        .with_min_len(CHUNK)
        .map(|_| value)
        .collect_into_vec(&mut values);
    values
}

#[cfg(target_os = "linux")]
fn ask_for_large_pages<T>(room: &mut [T]) {
    use rustix::mm::{Advice, madvise};

    if size_of_val(room) < MIN_BYTES {
        return;
    }
    let page = rustix::param::page_size();
    let start = room.as_mut_ptr();
    let skipped = start.addr().next_multiple_of(page) - start.addr();
    let whole_pages = (size_of_val(room) - skipped) / page * page;
    let start = start.wrapping_byte_add(skipped).cast();
    #[allow(unsafe_code, reason = "no crate wraps this advice safely")]
    // SAFETY: the pages are the vector's own, and the advice changes nothing about what they hold.
    // It may be refused.
    let _ = unsafe { madvise(start, whole_pages, Advice::LinuxHugepage) };
}
