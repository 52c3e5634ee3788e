# SPDX-License-Identifier: BSD-3-Clause
"""Starts the program s2nnds, which lies in this folder: the command `s2nnds` of a wheel, and `python -m s2nnds`."""

import os
import sys


def main():
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "s2nnds")
    # The figures are drawn by the Python that the package is installed in.
    os.environ.setdefault("S2NNDS_PYTHON", sys.executable)
    os.execv(program, [program, *sys.argv[1:]])


if __name__ == "__main__":
    main()
