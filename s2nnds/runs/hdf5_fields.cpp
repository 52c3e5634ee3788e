#include "s2nnds/runs/hdf5_fields.h"

#include <fmt/format.h>

namespace s2nnds {
namespace {

class FieldWriter final : public FieldVisitor {
 public:
  FieldWriter(Hdf5Writer& file, const std::string& group) : file_(file), groups_{group} {
    file_.make_group(group);
  }

  void field(std::string_view name, bool& value) override { put(name, std::int64_t{value}); }
  void field(std::string_view name, std::int64_t& value, Range) override { put(name, value); }
  void field(std::string_view name, double& value, Range) override { put(name, value); }
  void field(std::string_view name, std::string& value, const std::vector<std::string>&) override {
    put(name, value);
  }
  void field(std::string_view name, std::vector<double>& value, Range) override { put(name, value); }
  void field(std::string_view name, std::vector<std::int64_t>& value, Range) override { put(name, value); }
  void field(std::string_view name, std::vector<std::string>& value) override { put(name, value); }

 protected:
  void begin_group(std::string_view name) override {
    groups_.push_back(fmt::format("{}/{}", groups_.back(), name));
    file_.make_group(groups_.back());
  }
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
  template <typename T>
  void put(std::string_view name, const T& value) {
    file_.write_attribute(groups_.back(), std::string(name), value);
  }
  Hdf5Writer& file_;
  std::vector<std::string> groups_;
};

class FieldReader final : public FieldVisitor {
 public:
  FieldReader(const Hdf5Reader& file, const std::string& group) : file_(file), groups_{group} {}

  void field(std::string_view name, bool& value) override {
    value = file_.integer_attribute(groups_.back(), std::string(name)) != 0;
  }
  void field(std::string_view name, std::int64_t& value, Range) override {
    value = file_.integer_attribute(groups_.back(), std::string(name));
  }
  void field(std::string_view name, double& value, Range) override {
    value = file_.number_attribute(groups_.back(), std::string(name));
  }
  void field(std::string_view name, std::string& value, const std::vector<std::string>&) override {
    value = file_.text_attribute(groups_.back(), std::string(name));
  }
  void field(std::string_view name, std::vector<double>& value, Range) override {
    value = file_.numbers_attribute(groups_.back(), std::string(name));
  }
  void field(std::string_view name, std::vector<std::int64_t>& value, Range) override {
    value = file_.integers_attribute(groups_.back(), std::string(name));
  }
  void field(std::string_view name, std::vector<std::string>& value) override {
    value = file_.texts_attribute(groups_.back(), std::string(name));
  }

 protected:
  void begin_group(std::string_view name) override {
    groups_.push_back(fmt::format("{}/{}", groups_.back(), name));
  }
  void end_group() override { groups_.pop_back(); }
  void visit_list(std::string_view name, StructList& list) override {
    begin_group(name);
    list.resize(file_.children(groups_.back()).size());
    for (std::size_t i = 0; i < list.size(); ++i) {
      begin_group(std::to_string(i));
      list.visit(i, *this);
      end_group();
    }
    end_group();
  }

 private:
  const Hdf5Reader& file_;
  std::vector<std::string> groups_;
};

}  // namespace

void write_fields(Hdf5Writer& file, const std::string& group, options_detail::AnyOptions& fields) {
  FieldWriter writer(file, group);
  fields.visit(writer);
}

void read_fields(const Hdf5Reader& file, const std::string& group, options_detail::AnyOptions& fields) {
  FieldReader reader(file, group);
  fields.visit(reader);
}

}  // namespace s2nnds
