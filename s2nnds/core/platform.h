// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>
#include <string>

namespace s2nnds {

// All that Linux and macOS do differently.

// The file of the running program, without symbolic links. Throws Error when the system does not tell.
std::string executable_path();

// The file that this code is part of: the running program, or a shared library that it has loaded. Throws Error when
// the system does not tell.
std::string code_path();

// Processors that this process may use (of its Slurm task, of its container's set; on macOS, all), >= 1.
int available_cores();

// To be called between fork and exec: the kernel kills this process when its parent ends, however that ends.
// macOS cannot: there, a process outlives a parent that was killed by SIGKILL.
void end_with_parent();

// Waits until one of `signals`, which must be blocked, is pending, and takes it: its number. 0 when none came
// within `seconds` (>= 0), or earlier; so call it in a loop. On macOS it tells of no SIGCHLD, returns 0 after
// at most 20 ms instead.
int wait_for_signal(const sigset_t& signals, double seconds);

// For programs that allocate and free the same few megabytes at every step: they stay with this process
// instead of going back to the system. Where the allocator cannot be told (macOS), nothing.
void keep_freed_memory();

}  // namespace s2nnds
