// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include "studio.h"

namespace s2nnds::studio {

// Serves the page of a studio to browsers on this machine, at http://127.0.0.1:PORT/TOKEN/, until SIGINT or SIGTERM.
// A request needs the token in its path, this host in Host and, where a page sends it, this page's Origin; a body has
// at most 16 MB. `port` 0: any that is free. `ready` is called with the address when it can be opened. Throws Error
// when the port cannot be had, or when this program was built without cpp-httplib.
void serve(Studio& studio, int port, const std::function<void(const std::string& address)>& ready);

}  // namespace s2nnds::studio
