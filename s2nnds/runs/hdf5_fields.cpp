// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/hdf5_fields.h"

#include <fmt/format.h>

#include <cstdint>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

// Keeps the path of the group that is being visited.
class GroupVisitor : public FieldVisitor {
 public:
  explicit GroupVisitor(const std::string& group) : groups_{group} {}

 protected:
  const std::string& group() const { return groups_.back(); }

  void begin_group(std::string_view name) override { groups_.push_back(fmt::format("{}/{}", group(), name)); }
  void end_group() override { groups_.pop_back(); }
  void visit_list(std::string_view name, StructList& list) override {
    begin_group(name);
    for (std::size_t i = 0; i < list.size(); ++i) {
      begin_group(std::to_string(i));
      list.visit(i, *this);
      end_group();
    }
    end_group();
  }

 private:
  std::vector<std::string> groups_;
};

class FieldWriter final : public UniformVisitor<FieldWriter, GroupVisitor> {
 public:
  FieldWriter(Hdf5Writer& file, const std::string& group) : UniformVisitor(group), file_(file) {
    file_.make_group(group);
  }

  template <typename T, typename Bound>
  void each(std::string_view name, T& value, const Bound&) {
    if constexpr (std::is_same_v<T, bool>) {
      file_.write_attribute(group(), std::string(name), std::int64_t{value});
    } else if constexpr (std::is_same_v<T, std::vector<std::vector<double>>>) {
      fail("{}/{}: lists of lists are not stored as an attribute", group(), name);
    } else if constexpr (std::is_same_v<T, WordOrNumbers>) {
      file_.write_attribute(group(), std::string(name), value.word);
      file_.write_attribute(group(), std::string(name) + "_numbers", value.numbers);
    } else {
      file_.write_attribute(group(), std::string(name), value);
    }
  }

 protected:
  void begin_group(std::string_view name) override {
    GroupVisitor::begin_group(name);
    file_.make_group(group());
  }

 private:
  Hdf5Writer& file_;
};

class FieldReader final : public UniformVisitor<FieldReader, GroupVisitor> {
 public:
  FieldReader(const Hdf5Reader& file, const std::string& group) : UniformVisitor(group), file_(file) {}

  template <typename T, typename Bound>
  void each(std::string_view name, T& value, const Bound&) {
    if constexpr (std::is_same_v<T, bool>) {
      value = file_.attribute<std::int64_t>(group(), std::string(name)) != 0;
    } else if constexpr (std::is_same_v<T, std::vector<std::vector<double>>>) {
      fail("{}/{}: lists of lists are not stored as an attribute", group(), name);
    } else if constexpr (std::is_same_v<T, WordOrNumbers>) {
      value.word = file_.attribute<std::string>(group(), std::string(name));
      value.numbers = file_.attribute<std::vector<double>>(group(), std::string(name) + "_numbers");
    } else {
      value = file_.attribute<T>(group(), std::string(name));
    }
  }

 protected:
  void visit_list(std::string_view name, StructList& list) override {
    list.resize(file_.children(fmt::format("{}/{}", group(), name)).size());
    GroupVisitor::visit_list(name, list);
  }

 private:
  const Hdf5Reader& file_;
};

}  // namespace

void options_detail::write_fields(Hdf5Writer& file, const std::string& group, const Visit& visit) {
  FieldWriter writer(file, group);
  visit(writer);
}

void options_detail::read_fields(const Hdf5Reader& file, const std::string& group, const Visit& visit) {
  FieldReader reader(file, group);
  visit(reader);
}

}  // namespace s2nnds
