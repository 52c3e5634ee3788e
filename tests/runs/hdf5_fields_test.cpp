// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/hdf5_fields.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include "tests/runs/temporary_directory.h"

namespace s2nnds {
namespace {

struct Leaf {
  std::string kind = "a";
  double size = 0.0;

  void visit(FieldVisitor& v) {
    v.field("kind", kind, {"a", "b"});
    if (kind == "b") v.field("size", size, above(0.0));
  }
  bool operator==(const Leaf&) const = default;
};

struct Tree {
  bool yes = false;
  bool no = true;
  std::int64_t count = 1;
  double number = 1.0;
  std::string text = {};
  std::vector<double> numbers = {1.0};
  std::vector<std::int64_t> counts = {1};
  std::vector<std::string> texts = {"x"};
  Leaf leaf = {};
  std::vector<Leaf> leaves = {{}, {}};
  std::vector<Leaf> none = {{}};

  void visit(FieldVisitor& v) {
    v.field("yes", yes);
    v.field("no", no);
    v.field("count", count, any_number());
    v.field("number", number, any_number());
    v.field("text", text);
    v.field("numbers", numbers, any_number());
    v.field("counts", counts, any_number());
    v.field("texts", texts);
    v.group("leaf", leaf);
    v.list("leaves", leaves);
    v.list("none", none);
  }
  bool operator==(const Tree&) const = default;
};

Tree unusual_tree() {
  Tree tree;
  tree.yes = true;
  tree.no = false;
  tree.count = std::numeric_limits<std::int64_t>::min();
  tree.number = -std::numeric_limits<double>::infinity();
  tree.text = "two\nlines ö";
  tree.numbers = {0.1, -0.0};
  tree.counts = {};
  tree.texts = {"", "a,b"};
  tree.leaf = {.kind = "b", .size = 0.25};
  tree.none.clear();
  for (int i = 0; i < 12; ++i)
    tree.leaves.push_back({.kind = "b", .size = i + 0.5});  // "10" sorts before "2"
  return tree;
}

TEST(Hdf5Fields, EveryFieldComesBack) {
  const TemporaryDirectory directory;
  {
    Hdf5Writer file(directory.file("a.h5"));
    write_fields(file, "/some/tree", unusual_tree());
    file.commit();
  }
  const Hdf5Reader file(directory.file("a.h5"));
  EXPECT_EQ(read_fields<Tree>(file, "/some/tree"), unusual_tree());
}

TEST(Hdf5Fields, NotANumberComesBack) {
  const TemporaryDirectory directory;
  Tree tree;
  tree.number = std::nan("");
  {
    Hdf5Writer file(directory.file("a.h5"));
    write_fields(file, "/tree", tree);
    file.commit();
  }
  EXPECT_TRUE(std::isnan(read_fields<Tree>(Hdf5Reader(directory.file("a.h5")), "/tree").number));
}

TEST(Hdf5Fields, AMissingFieldIsNamed) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("a.h5");
  {
    Hdf5Writer file(path);
    write_fields(file, "/leaf", Leaf{});
    file.write_attribute("/other", "kind", std::string("b"));
    file.commit();
  }
  const Hdf5Reader file(path);
  EXPECT_EQ(error_of([&] { read_fields<Tree>(file, "/leaf"); }),
            path + ": expected an attribute yes of /leaf, found none");
  EXPECT_EQ(error_of([&] { read_fields<Leaf>(file, "/other"); }),
            path + ": expected an attribute size of /other, found none");
}

}  // namespace
}  // namespace s2nnds
