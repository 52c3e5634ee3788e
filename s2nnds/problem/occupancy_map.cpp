// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/problem/occupancy_map.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <vector>

#include "s2nnds/core/check.h"
#include "s2nnds/core/printable.h"
#include "s2nnds/data/delimited_text.h"
#include "s2nnds/problem/file_text.h"

namespace s2nnds {
namespace {

constexpr std::int64_t kMostCells = 100'000'000;

// The values of each key of a flat YAML file, lists in either style. Such files are all that map servers
// write.
class FlatYaml {
 public:
  FlatYaml(const std::string& bytes, const std::string& name) : name_(name) {
    FileText text(bytes, name, ":[],\"'");
    std::vector<std::string_view> words;
    std::vector<std::string>* last = nullptr;
    while (text.next(words)) {
      if (words[0] == "---") continue;
      const bool is_item = words[0] == "-";
      check(!is_item || last != nullptr, "{}: found a list without a key", text.where());
      if (!is_item) last = &values_[std::string(words[0])];
      last->insert(last->end(), words.begin() + 1, words.end());
    }
  }

  bool has(const std::string& key) const { return values_.contains(key); }
  std::string text(const std::string& key) const {
    const auto found = values_.find(key);
    check(found != values_.end() && found->second.size() == 1, "{}: expected one value of the key {}", name_,
          key);
    return found->second[0];
  }
  double number(const std::string& key) const { return as_number(text(key), key); }
  std::vector<double> numbers(const std::string& key, std::size_t count) const {
    const auto found = values_.find(key);
    check(found != values_.end() && found->second.size() == count, "{}: expected {} numbers of the key {}",
          name_, count, key);
    std::vector<double> result;
    for (const std::string& word : found->second) result.push_back(as_number(word, key));
    return result;
  }

 private:
  double as_number(const std::string& word, const std::string& key) const {
    return FileText("", name_ + ": " + key).number(word);
  }

  std::string name_;
  std::map<std::string, std::vector<std::string>> values_;
};

struct Image {
  std::int64_t width = 0, height = 0;
  double white = 255.0;             // the greatest brightness
  std::vector<std::uint8_t> shade;  // row by row from the top
};

Image read_pgm(const std::string& bytes, const std::string& name) {
  const bool is_text = bytes.starts_with("P2");
  check(is_text || bytes.starts_with("P5"), "{}: expected a PGM image, which begins with P2 or P5", name);
  std::size_t at = 2;
  const auto next = [&]() -> std::int64_t {
    while (at < bytes.size() && (std::isspace(static_cast<unsigned char>(bytes[at])) || bytes[at] == '#')) {
      at = bytes[at] == '#' ? std::min(bytes.find('\n', at), bytes.size()) : at + 1;
    }
    std::int64_t value = 0;
    const std::size_t first = at;
    for (; at < bytes.size() && std::isdigit(static_cast<unsigned char>(bytes[at])) && at < first + 9; ++at) {
      value = 10 * value + (bytes[at] - '0');
    }
    check(at > first, "{}: ends or is no PGM image at byte {}, expected a number", name, at);
    return value;
  };
  Image image;
  image.width = next();
  image.height = next();
  const std::int64_t white = next();
  check(image.width > 0 && image.height > 0 && image.width <= kMostCells / image.height,
        "{}: found {} x {} pixels, expected at least 1 and at most {} in all", name, image.width,
        image.height, kMostCells);
  check(white >= 1 && white <= 255, "{}: found the greatest value {}, expected at most 255 (8 bits)", name,
        white);
  image.white = static_cast<double>(white);
  const auto count = static_cast<std::size_t>(image.width * image.height);
  if (is_text) {
    for (std::size_t k = 0; k < count; ++k) {
      const std::int64_t value = next();
      check(value <= white, "{}: found the value {}, expected at most {}", name, value, white);
      image.shade.push_back(static_cast<std::uint8_t>(value));
    }
    return image;
  }
  ++at;  // one blank
  check(at <= bytes.size() && bytes.size() - at >= count, "{}: found {} bytes of pixels, expected {} x {}",
        name, bytes.size() - std::min(at, bytes.size()), image.width, image.height);
  image.shade.assign(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                     bytes.begin() + static_cast<std::ptrdiff_t>(at + count));
  const std::int64_t greatest = *std::max_element(image.shade.begin(), image.shade.end());
  check(greatest <= white, "{}: found the value {}, expected at most {}", name, greatest, white);
  return image;
}

}  // namespace

OccupancyMap read_occupancy_map(const std::string& name, RegionFiles& files) {
  const std::string ending = ending_of(name);
  check(ending == "yaml" || ending == "yml", "{}: expected the YAML file of a map, with the ending .yaml",
        name);
  const FlatYaml yaml(files.bytes(name), name);
  const std::string mode = yaml.has("mode") ? yaml.text("mode") : "trinary";
  check(mode == "trinary" || mode == "scale", "{}: found the mode {}, expected trinary or scale", name,
        shown(mode));
  // No thresholds are guessed: a file that was cut off would be another map.
  const double occupied = yaml.number("occupied_thresh"), free = yaml.number("free_thresh");
  check(0.0 <= free && free < occupied && occupied <= 1.0,
        "{}: found free_thresh {} and occupied_thresh {}, expected 0 <= free_thresh < occupied_thresh <= 1",
        name, free, occupied);
  const double negate = yaml.number("negate");
  check(negate == 0.0 || negate == 1.0, "{}: found negate {}, expected 0 or 1", name, negate);
  OccupancyMap map;
  map.resolution = yaml.number("resolution");
  check(map.resolution > 0.0, "{}: found the resolution {}, expected > 0", name, map.resolution);
  const std::vector<double> origin = yaml.numbers("origin", 3);
  map.origin = Vector{{origin[0], origin[1]}};
  map.yaw = origin[2];
  const std::string image_name = (std::filesystem::path(name).parent_path() / yaml.text("image")).string();
  check(image_name.size() <= 1000, "{}: found an image's name of {} bytes, expected that of a file", name,
        image_name.size());
  const Image image = read_pgm(files.bytes(image_name), printable(image_name));
  map.cells.resize(image.width, image.height);
  for (std::int64_t row = 0; row < image.height; ++row) {
    for (std::int64_t column = 0; column < image.width; ++column) {
      const double value = image.shade[static_cast<std::size_t>(row * image.width + column)];
      const double shade = (negate == 1.0 ? value : image.white - value) / image.white;
      map.cells(column, image.height - 1 - row) = shade >= occupied ? Cell::occupied
                                                  : shade < free    ? Cell::free
                                                                    : Cell::unknown;
    }
  }
  return map;
}

}  // namespace s2nnds
