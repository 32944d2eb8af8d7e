//! Loops in the widest vectors of the machine.

use pulp::Arch;
pub use pulp::NullaryFnOnce;

/// Runs what is compiled once for each kind of machine; all that it calls must be `#[inline(always)]` to be among that.
pub fn widest<Work: NullaryFnOnce>(work: Work) -> Work::Output {
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(simd) => simd.vectorize(work),
        #[cfg(target_arch = "x86_64")]
        Arch::V3(simd) => simd.vectorize(work),
        _ => work.call(),
    }
}
