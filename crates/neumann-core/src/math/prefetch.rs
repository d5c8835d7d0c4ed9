//! Asking for memory before it is needed.

/// Asks for the line of memory that a value begins on, so that reading it later need not wait; does
/// nothing where the processor has no such instruction.
#[inline(always)]
pub(crate) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};

        #[allow(unsafe_code, reason = "an intrinsic")]
        // SAFETY: it changes nothing but what is in the caches, and any 64-bit processor has it.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast());
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}
