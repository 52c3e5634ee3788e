// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/mesh_file.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>

#include "s2nnds/core/check.h"
#include "s2nnds/problem/file_text.h"

namespace s2nnds {
namespace {

constexpr std::size_t kStlHead = 84, kStlTriangle = 50;  // bytes: title and count; normal, corners, attribute

static_assert(std::endian::native == std::endian::little, "binary files are read as they stand");

template <typename T>
T value_at(const std::string& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

// Collects triangles whose corners are given by their coordinates.
class Corners {
 public:
  void add(const std::array<double, 3>& corner, const std::string& name) {
    // The order below takes what is not a number for another corner.
    check(std::isfinite(corner[0]) && std::isfinite(corner[1]) && std::isfinite(corner[2]),
          "{}: found the vertex ({}, {}, {}), expected finite numbers", name, corner[0], corner[1],
          corner[2]);
    // Adding 0 makes one zero of both.
    const auto [known, is_new] = index_.try_emplace({corner[0] + 0.0, corner[1] + 0.0, corner[2] + 0.0},
                                                    static_cast<int>(index_.size()));
    if (is_new) vertices_.push_back(corner);
    corners_.push_back(known->second);
  }
  std::size_t count() const { return corners_.size(); }
  // The triangles that name no vertex twice.
  TriangleMesh mesh() const {
    TriangleMesh result{Points(static_cast<Eigen::Index>(vertices_.size()), 3),
                        Eigen::MatrixXi(static_cast<Eigen::Index>(corners_.size() / 3), 3)};
    for (std::size_t k = 0; k < vertices_.size(); ++k) {
      result.vertices.row(static_cast<Eigen::Index>(k)) =
          Eigen::Map<const Eigen::RowVector3d>(vertices_[k].data());
    }
    Eigen::Index kept = 0;
    for (std::size_t k = 0; k + 2 < corners_.size(); k += 3) {
      const int a = corners_[k], b = corners_[k + 1], c = corners_[k + 2];
      if (a != b && b != c && c != a) result.triangles.row(kept++) << a, b, c;
    }
    result.triangles.conservativeResize(kept, 3);
    return result;
  }

 private:
  std::map<std::array<double, 3>, int> index_;
  std::vector<std::array<double, 3>> vertices_;
  std::vector<int> corners_;
};

TriangleMesh read_binary_stl(const std::string& bytes, const std::string& name) {
  Corners corners;
  for (std::size_t offset = kStlHead; offset < bytes.size(); offset += kStlTriangle) {
    for (std::size_t corner = 1; corner <= 3; ++corner) {  // 0 is the normal, which the corners say as well
      std::array<double, 3> x;
      for (std::size_t i = 0; i < 3; ++i) {
        x[i] = value_at<float>(bytes, offset + 12 * corner + 4 * i);
      }
      corners.add(x, name);
    }
  }
  return corners.mesh();
}

TriangleMesh read_stl_text(const std::string& bytes, const std::string& name) {
  Corners corners;
  FileText text(bytes, name);
  std::vector<std::string_view> words;
  bool ended = false;
  while (text.next(words)) {
    ended = words[0] == "endsolid";
    if (words[0] == "endloop") {
      check(corners.count() % 3 == 0, "{}: found a loop of other than 3 vertices, expected triangles",
            text.where());
    }
    if (words[0] != "vertex") continue;
    check(words.size() == 4, "{}: found a vertex of {} numbers, expected 3", text.where(), words.size() - 1);
    corners.add({text.number(words[1]), text.number(words[2]), text.number(words[3])}, name);
  }
  check(ended && corners.count() % 3 == 0, "{}: ends within a solid, expected 'endsolid'", text.where());
  return corners.mesh();
}

TriangleMesh read_stl(const std::string& bytes, const std::string& name) {
  // Some binary files begin with "solid" too, so the length decides.
  if (bytes.size() >= kStlHead) {
    const auto count = value_at<std::uint32_t>(bytes, 80);
    if (bytes.size() == kStlHead + kStlTriangle * std::size_t{count}) return read_binary_stl(bytes, name);
  }
  if (bytes.starts_with("solid")) return read_stl_text(bytes, name);
  check(bytes.size() >= kStlHead, "{}: found {} bytes, expected STL of at least {}", name, bytes.size(),
        kStlHead);
  const auto count = value_at<std::uint32_t>(bytes, 80);
  fail("{}: found {} bytes, expected {} of the {} triangles that its head says (binary STL)", name,
       bytes.size(), kStlHead + kStlTriangle * std::size_t{count}, count);
}

TriangleMesh read_obj(const std::string& bytes, const std::string& name) {
  std::vector<std::array<double, 3>> vertices;
  Corners corners;
  FileText text(bytes, name);
  std::vector<std::string_view> words;
  while (text.next(words)) {
    if (words[0] == "v") {
      check(words.size() >= 4, "{}: found a vertex of {} numbers, expected 3", text.where(),
            words.size() - 1);
      vertices.push_back({text.number(words[1]), text.number(words[2]), text.number(words[3])});
    }
    if (words[0] != "f") continue;
    check(words.size() >= 4, "{}: found a face of {} corners, expected at least 3", text.where(),
          words.size() - 1);
    std::vector<std::size_t> face;
    for (std::size_t k = 1; k < words.size(); ++k) {
      const std::int64_t index = text.integer(words[k].substr(0, words[k].find('/')));
      const auto count = static_cast<std::int64_t>(vertices.size());
      check(index != 0 && index <= count && index >= -count, "{}: found vertex {}, expected one of {}",
            text.where(), index, count);
      face.push_back(static_cast<std::size_t>(index > 0 ? index - 1 : count + index));
    }
    for (std::size_t k = 2; k < face.size(); ++k) {
      for (const std::size_t corner : {face[0], face[k - 1], face[k]}) corners.add(vertices[corner], name);
    }
  }
  return corners.mesh();
}

}  // namespace

TriangleMesh read_mesh(const std::string& bytes, const std::string& name) {
  const std::string ending = ending_of(name);
  check(ending == "stl" || ending == "obj", "{}: expected a mesh with the ending .stl or .obj", name);
  TriangleMesh mesh = ending == "stl" ? read_stl(bytes, name) : read_obj(bytes, name);
  check(mesh.triangles.rows() > 0, "{}: found no triangles, expected a mesh", name);
  return mesh;
}

}  // namespace s2nnds
