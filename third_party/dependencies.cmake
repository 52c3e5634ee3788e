# Every dependency of the library, where it is found, and the least version. third_party/install.sh installs them.
# LibTorch is the distribution's or pip's (CMAKE_PREFIX_PATH=$(python3 -c "import torch; print(torch.utils.cmake_prefix_path)")).
# pip's searches for a CUDA toolkit unless this target is there; only its part for the processor is linked.
if(NOT TARGET torch::cudart)
  add_library(torch::cudart INTERFACE IMPORTED)
endif()
set(kineto_LIBRARY c10)  # pip's has it inside torch_cpu, and warns that it is nowhere else
find_package(Threads REQUIRED)
find_package(TBB 2021 REQUIRED)                               # loops shared among threads
# Where site-packages is a prefix, as pip has it, Torch is found there and its parts in the system's folders first.
foreach(prefix IN LISTS CMAKE_PREFIX_PATH)
  if(EXISTS ${prefix}/torch/share/cmake/Torch)
    list(PREPEND CMAKE_PREFIX_PATH ${prefix}/torch/share/cmake)
  endif()
endforeach()
find_package(Torch 1.13 REQUIRED QUIET)                       # networks, autograd, TorchScript
# Not quiet, it names the libtorch.so of the system also where it uses another.
message(STATUS "Found Torch: ${TORCH_INSTALL_PREFIX} (found version \"${Torch_VERSION}\")")
find_package(Eigen3 3.4 REQUIRED NO_MODULE)                   # plain matrices
find_package(Boost 1.74 REQUIRED CONFIG)                      # Math (incomplete beta), Odeint, Random (Sobol), Multiprecision (tests)
find_package(HDF5 1.10 REQUIRED COMPONENTS C)                 # run files
find_package(fmt 9 REQUIRED)                                  # all messages
find_package(ZLIB 1.2 REQUIRED)                               # the sizes in compressed MATLAB files
find_package(OpenSSL 3 REQUIRED COMPONENTS Crypto)            # SHA-256 of the certified weights
find_package(nlohmann_json 3.11 REQUIRED)                     # --json, published polynomials
find_package(tomlplusplus 3.3 QUIET)                          # run configurations
if(NOT TARGET tomlplusplus::tomlplusplus)
  find_path(TOMLPLUSPLUS_INCLUDE_DIR toml++/toml.h REQUIRED)
  add_library(tomlplusplus::tomlplusplus INTERFACE IMPORTED)
  target_include_directories(tomlplusplus::tomlplusplus INTERFACE ${TOMLPLUSPLUS_INCLUDE_DIR})
endif()
find_path(MATIO_INCLUDE_DIR matio.h REQUIRED)                 # MATLAB files (1.5)
find_library(MATIO_LIBRARY matio REQUIRED)
if(NOT TARGET s2nnds_matio)
  add_library(s2nnds_matio INTERFACE IMPORTED)
  target_include_directories(s2nnds_matio INTERFACE ${MATIO_INCLUDE_DIR})
  target_link_libraries(s2nnds_matio INTERFACE ${MATIO_LIBRARY})
endif()
find_path(LIBZIP_INCLUDE_DIR zip.h REQUIRED)                  # NumPy's .npz files (1.7)
find_library(LIBZIP_LIBRARY zip REQUIRED)
if(NOT TARGET s2nnds_libzip)
  add_library(s2nnds_libzip INTERFACE IMPORTED)
  target_include_directories(s2nnds_libzip INTERFACE ${LIBZIP_INCLUDE_DIR})
  target_link_libraries(s2nnds_libzip INTERFACE ${LIBZIP_LIBRARY})
endif()
find_package(Protobuf 3.21 REQUIRED)                          # what ONNX files are written with
find_path(ONNX_INCLUDE_DIR onnx/onnx_pb.h REQUIRED)           # exported policies (1.12)
find_library(ONNX_PROTO_LIBRARY onnx_proto REQUIRED)
if(NOT TARGET s2nnds_onnx)
  add_library(s2nnds_onnx INTERFACE IMPORTED)
  target_include_directories(s2nnds_onnx SYSTEM INTERFACE ${ONNX_INCLUDE_DIR})
  target_compile_definitions(s2nnds_onnx INTERFACE ONNX_NAMESPACE=onnx ONNX_ML=1)
  target_link_libraries(s2nnds_onnx INTERFACE ${ONNX_PROTO_LIBRARY} protobuf::libprotobuf
    ${Protobuf_LIBRARIES})  # by name: pip's torch defines the target too, empty
endif()
if(S2NNDS_BUILD_EXPERIMENTS)
  # Arb, the ball arithmetic of s2nnds-check: a part of FLINT since 3.0, before a library of its own (2.23, flint-arb on Debian).
  find_path(ARB_INCLUDE_DIR NAMES flint/arb.h arb.h)
  find_library(FLINT_LIBRARY flint)
  find_library(ARB_LIBRARY NAMES flint-arb arb)
  if(ARB_INCLUDE_DIR AND FLINT_LIBRARY AND (ARB_LIBRARY OR EXISTS ${ARB_INCLUDE_DIR}/flint/arb.h))
    add_library(s2nnds_arb INTERFACE IMPORTED)
    if(EXISTS ${ARB_INCLUDE_DIR}/flint/arb.h)
      target_include_directories(s2nnds_arb SYSTEM INTERFACE ${ARB_INCLUDE_DIR} ${ARB_INCLUDE_DIR}/flint)
    else()
      target_include_directories(s2nnds_arb SYSTEM INTERFACE ${ARB_INCLUDE_DIR})
      target_link_libraries(s2nnds_arb INTERFACE ${ARB_LIBRARY})
    endif()
    target_link_libraries(s2nnds_arb INTERFACE ${FLINT_LIBRARY})
  endif()
  find_package(PkgConfig QUIET)                               # it tells what cpp-httplib was compiled with
  if(PKG_CONFIG_FOUND)
    pkg_check_modules(HTTPLIB QUIET IMPORTED_TARGET cpp-httplib>=0.11)  # s2nnds studio; left out without it
  endif()
endif()
if(S2NNDS_BUILD_EXPERIMENTS)
  find_package(mujoco 2.2 QUIET)                              # experiments/robot_drawing; left out without it
  find_path(MUJOCO_INCLUDE_DIR mujoco/mujoco.h)
  if(TARGET mujoco::mujoco AND MUJOCO_INCLUDE_DIR)  # Debian's also names a folder of a package that it does not ask for
    set_target_properties(mujoco::mujoco PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${MUJOCO_INCLUDE_DIR}")
  endif()
  find_package(Franka 0.18 QUIET)                             # experiments/fci_drawing; left out without libfranka
endif()
if(S2NNDS_BUILD_BENCHMARKS)
  find_package(benchmark 1.7 QUIET)                           # tests/benchmarks/; without it they are left out
endif()
if(NOT TARGET s2nnds_libtorch)
  add_library(s2nnds_libtorch INTERFACE IMPORTED)
  target_link_libraries(s2nnds_libtorch INTERFACE torch_cpu_library c10)
  # pip's torch brings the headers of a newer fmt than the library that is linked: those of the latter go first.
  get_target_property(fmt_include fmt::fmt INTERFACE_INCLUDE_DIRECTORIES)
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/before_torch)
  file(CREATE_LINK ${fmt_include}/fmt ${CMAKE_BINARY_DIR}/before_torch/fmt SYMBOLIC)
  target_include_directories(s2nnds_libtorch SYSTEM INTERFACE ${CMAKE_BINARY_DIR}/before_torch ${TORCH_INCLUDE_DIRS})
  separate_arguments(torch_cxx_flags UNIX_COMMAND "${TORCH_CXX_FLAGS}")  # of releases with the old C++ ABI
  target_compile_options(s2nnds_libtorch INTERFACE ${torch_cxx_flags})
endif()
