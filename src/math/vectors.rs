//! Loops compiled for the widest vector instructions of the machine.

use pulp::Arch;
pub use pulp::NullaryFnOnce;

/// Runs code in the version compiled for the vector instructions of this machine. All functions that the code calls
/// must be `#[inline(always)]`, because functions that are not inlined use the baseline instructions only.
pub fn widest<Work: NullaryFnOnce>(work: Work) -> Work::Output {
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(simd) => simd.vectorize(work),
        #[cfg(target_arch = "x86_64")]
        Arch::V3(simd) => simd.vectorize(work),
        _ => work.call(),
    }
}

/// A loop for [`widest_fused`]. `run` and all functions that it calls must be `#[inline(always)]`.
pub trait Kernel {
    /// Result of the loop.
    type Output;

    /// Runs the loop; `F` is true on machines with fused multiply-add, as in [`super::elementary`].
    fn run<const F: bool>(self) -> Self::Output;
}

/// Runs a loop with the widest vector instructions of the machine, and with fused multiply-add if available.
pub fn widest_fused<K: Kernel>(kernel: K) -> K::Output {
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(simd) => simd.vectorize(Fused(kernel)),
        #[cfg(target_arch = "x86_64")]
        Arch::V3(simd) => simd.vectorize(Fused(kernel)),
        _ => kernel.run::<false>(),
    }
}

struct Fused<K>(K);

impl<K: Kernel> NullaryFnOnce for Fused<K> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        self.0.run::<true>()
    }
}
