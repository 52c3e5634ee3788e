// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fuzz/hdf5_edits.h"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

namespace s2nnds::fuzz {
namespace {

// The input, byte by byte; zeros after its end.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  bool empty() const { return left_ == 0; }
  std::uint8_t next() { return left_ > 0 ? (--left_, *data_++) : std::uint8_t{0}; }
  std::uint64_t word() {
    std::uint64_t value = 0;
    for (int i = 0; i < 8; ++i) value = value << 8 | next();
    return value;
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

// An object of the file, or an attribute of one.
struct Item {
  std::string object;
  std::string attribute;  // empty: the object itself
};

herr_t add_attribute(hid_t, const char* name, const H5A_info_t*, void* out) {
  auto& items = *static_cast<std::vector<Item>*>(out);
  items.push_back({items.back().object, name});
  return 0;
}

herr_t add_object(hid_t file, const char* name, const H5O_info_t*, void* out) {
  auto& items = *static_cast<std::vector<Item>*>(out);
  items.push_back({name, ""});
  const hid_t object = H5Oopen(file, name, H5P_DEFAULT);
  H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, add_attribute, out);
  H5Oclose(object);
  return 0;
}

// A type, with values of it for any shape below: 4 sides of at most 4.
struct Value {
  explicit Value(Bytes& bytes) {
    const int kind = bytes.next() % 5;
    const std::uint64_t word = bytes.word();
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = word + (kind == 1 ? i : 0);
    for (char& c : text) c = static_cast<char>(std::max<std::uint8_t>(1, bytes.next()));
    text.back() = '\0';
    texts.fill(text.data());
    file_type = H5Tcopy(kind == 0   ? H5T_NATIVE_DOUBLE
                        : kind == 1 ? H5T_NATIVE_INT64
                        : kind == 2 ? H5T_NATIVE_FLOAT
                                    : H5T_C_S1);
    if (kind == 3) H5Tset_size(file_type, H5T_VARIABLE);
    if (kind == 3) values = texts.data();
    if (kind == 4) H5Tset_size(file_type, 4);
  }
  ~Value() { H5Tclose(file_type); }
  Value(const Value&) = delete;
  Value& operator=(const Value&) = delete;

  std::array<std::uint64_t, 256> numbers{};
  std::array<char, 12> text{};
  std::array<const char*, 256> texts{};
  hid_t file_type = -1;
  const void* values = numbers.data();
};

void put(hid_t file, const Item& item, Bytes& bytes) {
  const Value value(bytes);
  const int rank = bytes.next() % 5;
  std::array<hsize_t, 4> shape{};
  for (int i = 0; i < rank; ++i) shape[static_cast<std::size_t>(i)] = bytes.next() % 5;
  const hid_t space = rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(rank, shape.data(), nullptr);
  if (item.attribute.empty()) {
    const hid_t made =
        H5Dcreate2(file, item.object.c_str(), value.file_type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(made, value.file_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, value.values);
    H5Dclose(made);
  } else {
    const hid_t made = H5Acreate_by_name(file, item.object.c_str(), item.attribute.c_str(), value.file_type,
                                         space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(made, value.file_type, value.values);
    H5Aclose(made);
  }
  H5Sclose(space);
}

}  // namespace

void edit_hdf5(const std::string& path, const std::uint8_t* data, std::size_t size) {
  H5E_auto2_t print = nullptr;
  void* to = nullptr;
  H5Eget_auto2(H5E_DEFAULT, &print, &to);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  if (file < 0) std::abort();
  std::vector<Item> items;
  H5Ovisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, add_object, &items);
  Bytes bytes(data, size);
  for (int edits = 0; edits < 8 && !bytes.empty(); ++edits) {
    const std::size_t high = bytes.next();
    const Item& item = items[(high * 256 + bytes.next()) % items.size()];
    const bool replaced = bytes.next() % 4 != 0;
    if (item.attribute.empty()) {
      if (item.object != ".") H5Ldelete(file, item.object.c_str(), H5P_DEFAULT);
    } else {
      H5Adelete_by_name(file, item.object.c_str(), item.attribute.c_str(), H5P_DEFAULT);
    }
    if (replaced) put(file, item, bytes);
  }
  H5Fclose(file);
  H5Eset_auto2(H5E_DEFAULT, print, to);
}

}  // namespace s2nnds::fuzz
