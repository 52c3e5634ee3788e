// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "s2nnds/problem/mesh.h"

namespace s2nnds {

// The mesh in a file's bytes: STL, as text or binary, or Wavefront OBJ (v and f lines; faces of more corners
// become fans); `name`, by whose ending the format is known, stands in messages. Vertices with equal
// coordinates become one, and triangles that name a vertex twice are left out. Throws Error where the file is
// not whole, has another format or no triangles.
TriangleMesh read_mesh(const std::string& bytes, const std::string& name);

}  // namespace s2nnds
