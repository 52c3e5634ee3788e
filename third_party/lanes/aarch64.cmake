# SPDX-License-Identifier: BSD-3-Clause
# CMake's toolchain for third_party/lanes/aarch64.sh: Debian's cross compiler against the arm64 packages that lie in
# the folder S2NNDS_SYSROOT, and qemu to run what was built.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES S2NNDS_SYSROOT)
set(CMAKE_SYSROOT ${S2NNDS_SYSROOT})
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static;-L;${S2NNDS_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
# Asked of the compiler wrapper, which names the folders of the packages; the machine's own would name its own.
set(HDF5_C_COMPILER_EXECUTABLE ${S2NNDS_SYSROOT}/usr/bin/h5cc)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${S2NNDS_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR} ${S2NNDS_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${S2NNDS_SYSROOT}/usr/share/pkgconfig)
