//! The time that a thread computed.

/// CPU seconds of `work`, the least of `passes`.
#[cfg(unix)]
pub fn least(passes: usize, mut work: impl FnMut()) -> f64 {
    let now = || {
        let t = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
    };
    (0..passes)
        .map(|_| {
            let start = now();
            work();
            now() - start
        })
        .fold(f64::INFINITY, f64::min)
}
