//! Memory that a program which does nothing does not keep.

// Calls of the C library that have no safe wrapper.
#![allow(unsafe_code)]

use std::time::Duration;

/// Heaps of a program: each thread that allocates gets one of its own, and what is freed in one is of no use to another.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const HEAPS: libc::c_int = 2;
/// Bytes of a page where the system does not tell.
#[cfg(target_os = "linux")]
const PAGE: u64 = 4096;
/// Until what a start has freed is given back: it is over then.
const SOON: Duration = Duration::from_secs(1);
/// Time between two looks for more.
const LATER: Duration = Duration::from_secs(60);

/// Keeps the heaps few. To be called before there are threads.
pub fn few_heaps() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: it sets a number of the allocator, and touches nothing that was allocated.
    unsafe {
        libc::mallopt(libc::M_ARENA_MAX, HEAPS);
    }
}

/// Gives what was freed back to the system.
pub fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: it gives back what nobody has allocated, under the allocator's own locks.
    unsafe {
        libc::malloc_trim(0);
    }
}

/// Unmaps what the program is made of, but for what can be written to. What runs again is mapped again, 64 KiB at a time,
/// from the kernel's copy of the file: what only a start needs stays out.
pub fn unmap_unused() {
    if is_debugged() {
        return;
    }
    #[cfg(all(target_os = "linux", target_pointer_width = "64"))]
    // SAFETY: the callback only reads what it is given, and only while it runs.
    unsafe {
        libc::dl_iterate_phdr(Some(unmap_first), std::ptr::null_mut());
    }
}

/// Breakpoints are written into the program, and would be gone.
fn is_debugged() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mut tracers = status.lines().filter_map(|l| l.strip_prefix("TracerPid:"));
    tracers.any(|pid| pid.trim() != "0")
}

/// Unmaps the first object, which is the program, and asks for no other.
#[cfg(all(target_os = "linux", target_pointer_width = "64"))]
unsafe extern "C" fn unmap_first(
    object: *mut libc::dl_phdr_info,
    _: libc::size_t,
    _: *mut libc::c_void,
) -> libc::c_int {
    // SAFETY: the C library passes an object that is valid during the call.
    let Some(object) = (unsafe { object.as_ref() }) else {
        return 1;
    };
    if object.dlpi_phdr.is_null() {
        return 1;
    }
    // SAFETY: as many headers are there as it says.
    let headers =
        unsafe { std::slice::from_raw_parts(object.dlpi_phdr, usize::from(object.dlpi_phnum)) };
    // SAFETY: it only tells a number.
    let page = unsafe { libc::sysconf(libc::_SC_PAGESIZE) };
    let page = u64::try_from(page).unwrap_or(PAGE).max(1);
    let fixed = |header: &&libc::Elf64_Phdr| {
        header.p_type == libc::PT_LOAD && header.p_flags & libc::PF_W == 0
    };
    for header in headers.iter().filter(fixed) {
        let begin = object.dlpi_addr + header.p_vaddr;
        let end = (begin + header.p_memsz) / page * page;
        let begin = begin.next_multiple_of(page);
        if let Some(length) = end.checked_sub(begin).filter(|length| *length > 0) {
            // SAFETY: whole pages of a mapping of the program's file that the program cannot write to: the same bytes come
            // back. Only a debugger writes there (breakpoints), and nothing is unmapped while there is one. That they could not
            // be unmapped changes nothing.
            unsafe {
                libc::madvise(
                    begin as *mut libc::c_void,
                    length as usize,
                    libc::MADV_DONTNEED,
                );
            }
        }
    }
    1
}

/// Gives back what a start needed, soon, and what was freed, now and then, for ever.
pub async fn keep_small() {
    tokio::time::sleep(SOON).await;
    unmap_unused();
    loop {
        give_back();
        tokio::time::sleep(LATER).await;
    }
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;

    /// KiB of the program's own unwritable pages that are mapped.
    fn mapped() -> u64 {
        let program = std::env::current_exe().unwrap();
        let program = program.to_str().unwrap();
        let maps = std::fs::read_to_string("/proc/self/smaps").unwrap();
        let mut counts = false;
        let mut sum = 0;
        for line in maps.lines() {
            if line.contains('-') && line.contains(" r") {
                counts = line.ends_with(program) && line.contains(" r-xp ");
            } else if let (true, Some(rest)) = (counts, line.strip_prefix("Rss:")) {
                sum += rest.trim().trim_end_matches(" kB").parse::<u64>().unwrap();
            }
        }
        sum
    }

    #[test]
    fn what_is_unmapped_runs_all_the_same() {
        let sum = |from: u64| (from..1000).map(|n| n * n % 7).sum::<u64>();
        let (before, was) = (mapped(), sum(std::hint::black_box(1)));
        unmap_unused();
        let after = mapped();
        assert!(after < before, "{before} KiB before, {after} KiB after");
        assert_eq!(sum(std::hint::black_box(1)), was);
    }
}
