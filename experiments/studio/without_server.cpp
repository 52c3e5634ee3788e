// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/check.h"
#include "server.h"

// Where cpp-httplib is missing.
namespace s2nnds::studio {

void serve(Studio&, int, const std::function<void(const std::string&)>&) {
  fail(
      "studio: this program was built without cpp-httplib; expected its Debian package libcpp-httplib-dev, "
      "then a "
      "new build");
}

}  // namespace s2nnds::studio
