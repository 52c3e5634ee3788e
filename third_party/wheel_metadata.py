# SPDX-License-Identifier: BSD-3-Clause
"""What pyproject.toml leaves to the moment of building: the version, and the torch that the wheel is built against.

The compiled module and the program use LibTorch's C++ interface, which changes with every minor version. So the wheel
requires the minor version that CMake finds: of the Python that it is installed into, or, where that has none, of the
build environment, which then gets the newest.
"""

import importlib.metadata
import re
import sys
import sysconfig


def installed_torch():
    """Its version; None if there is none. An isolated build does not import from the folder that comes first here."""
    for distribution in importlib.metadata.distributions(name="torch", path=[sysconfig.get_path("purelib"), *sys.path]):
        return distribution.version
    return None


def get_requires_for_dynamic_metadata(_settings):
    return [] if installed_torch() else ["torch"]


def dynamic_metadata(_settings, _project):
    with open("CMakeLists.txt", encoding="utf-8") as file:
        version = re.search(r"project\(s2nnds VERSION ([0-9.]+)", file.read())[1]
    torch = installed_torch()
    minor = re.match(r"\d+\.\d+", torch)[0] if torch else None
    return {
        "version": version,
        "dependencies": ["numpy", "h5py", "matplotlib", f"torch=={minor}.*" if minor else "torch"],
    }
