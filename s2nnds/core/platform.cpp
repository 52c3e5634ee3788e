// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/platform.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "s2nnds/core/check.h"

#if defined(__linux__)
#include <dlfcn.h>
#include <link.h>
#include <sched.h>
#include <sys/prctl.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif
#elif defined(__APPLE__)
#include <dlfcn.h>
#include <mach-o/dyld.h>

#include <cstdint>
#include <thread>
#else
#error "s2nnds/core/platform.cpp knows Linux and macOS"
#endif

namespace s2nnds {
namespace {

timespec duration(double seconds) {
  timespec time;
  time.tv_sec = static_cast<time_t>(seconds);
  time.tv_nsec = static_cast<long>((seconds - std::floor(seconds)) * 1e9);
  return time;
}

}  // namespace

#if defined(__linux__)

std::string executable_path() {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", error);
  check(!error, "/proc/self/exe: cannot read it: {}; expected the path of this program", error.message());
  return path.string();
}

std::string code_path() {
  Dl_info info;
  link_map* file = nullptr;
  const auto address = reinterpret_cast<void*>(&code_path);
  const bool found = ::dladdr1(address, &info, reinterpret_cast<void**>(&file), RTLD_DL_LINKMAP) != 0;
  return found && file->l_name[0] != '\0' ? file->l_name
                                          : executable_path();  // the program itself has no name here
}

int available_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return ::sched_getaffinity(0, sizeof(set), &set) == 0 ? std::max(1, CPU_COUNT(&set)) : 1;
}

void end_with_parent() { ::prctl(PR_SET_PDEATHSIG, SIGKILL); }

int wait_for_signal(const sigset_t& signals, double seconds) {
  const timespec time = duration(seconds);
  return std::max(0, ::sigtimedwait(&signals, nullptr, &time));
}

void keep_freed_memory() {
#if defined(__GLIBC__)
  ::mallopt(M_MMAP_THRESHOLD, 1 << 28);
  ::mallopt(M_TRIM_THRESHOLD, 1 << 28);
#endif
}

#else

std::string executable_path() {
  std::uint32_t size = 0;
  ::_NSGetExecutablePath(nullptr, &size);  // tells the size that it needs
  std::string path(size, '\0');
  check(::_NSGetExecutablePath(path.data(), &size) == 0,
        "found no path of this program; expected the system's");
  path.resize(path.find('\0'));
  std::error_code error;
  const std::filesystem::path real = std::filesystem::canonical(path, error);
  check(!error, "{}: cannot resolve it: {}; expected the path of this program", path, error.message());
  return real.string();
}

std::string code_path() {
  Dl_info info;
  const bool found = ::dladdr(reinterpret_cast<const void*>(&code_path), &info) != 0;
  return found ? info.dli_fname : executable_path();
}

int available_cores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

void end_with_parent() {}

// There is no sigtimedwait. A blocked SIGCHLD without a handler is dropped there, so the caller has to look for
// ended children itself after each of these short sleeps.
int wait_for_signal(const sigset_t& signals, double seconds) {
  const timespec time = duration(std::min(seconds, 0.02));
  ::nanosleep(&time, nullptr);
  sigset_t pending;
  ::sigemptyset(&pending);
  ::sigpending(&pending);
  for (const int signal : {SIGINT, SIGTERM, SIGCHLD}) {
    if (sigismember(&pending, signal) != 1 || sigismember(&signals, signal) != 1) continue;
    sigset_t one;
    ::sigemptyset(&one);
    ::sigaddset(&one, signal);
    int taken = 0;
    return ::sigwait(&one, &taken) == 0 ? taken : 0;
  }
  return 0;
}

void keep_freed_memory() {}

#endif

}  // namespace s2nnds
