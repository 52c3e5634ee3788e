# SPDX-License-Identifier: BSD-3-Clause
"""The folders of s2nnds/ are layers: a file includes its own folder and layers below, never those beside or above.

Run without arguments. Prints every line that breaks a rule, and fails if there is one.
"""

import os
import re
import sys

LAYERS = [  # from the lowest; those of one line stand beside each other
    ["core"],
    ["data"],
    ["problem"],
    ["networks"],
    ["conditions"],
    ["training", "verification", "evaluation"],
    ["runs"],
    ["sweeps", "deployment"],
]
WITHOUT_TORCH = {"core", "data", "problem"}

LICENCE = "// SPDX-License-Identifier: BSD-3-Clause"
LIBRARY = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../s2nnds")
INCLUDE = re.compile(r'\s*#\s*include\s*(["<])([^">]+)[">]')
LEVEL = {folder: level for level, folders in enumerate(LAYERS) for folder in folders}


def may_include(folder, other):
    return folder == other or LEVEL[other] < LEVEL[folder]


def complaints_of(path, lines, is_file):
    """Of one file, as (line, text). `path` counts from s2nnds/; is_file tells whether such a path is there."""
    folder, name = path.split("/")[0], os.path.splitext(path)[0]
    if folder not in LEVEL:
        return [(1, f"the folder {folder} has no layer")]
    found = []
    if path.endswith(".h") and "#pragma once" not in (line.strip() for line in lines):
        found.append((1, "a header begins with #pragma once"))
    licence = 1 if lines[:1] == [LICENCE] else 0
    includes = [(k, m[1], m[2]) for k, m in ((k, INCLUDE.match(line)) for k, line in enumerate(lines, 1)) if m]
    if path.endswith(".cpp") and is_file(name + ".h") and includes[:1] != [(1 + licence, '"', f"s2nnds/{name}.h")]:
        found.append((1, f"the first line includes the file's own header, s2nnds/{name}.h"))
    for line, quote, what in includes:
        if quote == '"' and not what.startswith("s2nnds/"):
            found.append((line, f"{what}: files of the project are named from s2nnds/ on"))
        elif quote == '"' and not may_include(folder, what.split("/")[1]):
            found.append((line, f"{folder} stands below or beside {what.split('/')[1]}: it cannot include {what}"))
        elif folder in WITHOUT_TORCH and what.split("/")[0] in ("torch", "ATen", "c10", "caffe2"):
            found.append((line, f"{folder} does without LibTorch: it cannot include {what}"))
    return found


def check_the_rules():
    """Files made up for it: what is right passes, what is wrong does not."""
    def complains(path, *lines, files=()):
        return [line for line, _ in complaints_of(path, list(lines), lambda name: name in files)]

    assert not complains("networks/a.h", "#pragma once", '#include "s2nnds/networks/b.h"', '#include "s2nnds/core/b.h"')
    assert not complains("networks/a.h", "#pragma once", "#include <torch/torch.h>")
    assert complains("networks/a.h", '#include "s2nnds/core/b.h"') == [1]
    assert complains("core/a.h", "#pragma once", '#include "s2nnds/data/b.h"') == [2]
    assert complains("training/a.h", "#pragma once", '#include "s2nnds/verification/b.h"') == [2]
    assert complains("problem/a.h", "#pragma once", "# include <torch/torch.h>") == [2]
    assert complains("core/a.h", "#pragma once", '#include "check.h"') == [2]
    assert complains("core/a.cpp", "#include <map>", '#include "s2nnds/core/a.h"', files=["core/a.h"]) == [1]
    assert not complains("core/a.cpp", '#include "s2nnds/core/a.h"', files=["core/a.h"])
    assert not complains("core/a.cpp", LICENCE, '#include "s2nnds/core/a.h"', files=["core/a.h"])
    assert not complains("core/a.cpp", "#include <map>")
    assert complains("elsewhere/a.cpp", "") == [1]


def main():
    check_the_rules()
    count = 0
    for folder, _, names in sorted(os.walk(LIBRARY)):
        for name in sorted(names):
            path = os.path.relpath(os.path.join(folder, name), LIBRARY).replace(os.sep, "/")
            if not path.endswith((".h", ".cpp", ".inl")):
                continue
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                lines = file.read().splitlines()
            for line, text in complaints_of(path, lines, lambda other: os.path.isfile(os.path.join(LIBRARY, other))):
                print(f"s2nnds/{path}:{line}: {text}")
                print(f"    {lines[line - 1] if lines else ''}")
                count += 1
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
