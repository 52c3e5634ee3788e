# SPDX-License-Identifier: BSD-3-Clause
"""Runs a notebook of this folder for the tests, by the Python that runs them."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
KERNEL = "tests"


def execute_notebook(name, folder, **environment):
    """The text of the notebook after it ran, which is left in `folder`. It must be stored without outputs.

    The kernel is this Python, not the one that Jupyter has installed: that may hold another torch than the one that the
    compiled module is linked to. Raises SkipTest where Jupyter is missing.
    """
    with open(os.path.join(HERE, name), encoding="utf-8") as file:
        assert not [cell for cell in json.load(file)["cells"] if cell.get("outputs")], f"{name} is stored with outputs"
    if shutil.which("jupyter-nbconvert") is None:
        raise unittest.SkipTest("found no jupyter-nbconvert (Debian: jupyter-nbconvert python3-ipykernel)")
    if importlib.util.find_spec("ipykernel") is None:
        raise unittest.SkipTest(f"found no ipykernel in {sys.executable} (Debian: python3-ipykernel)")
    kernel = os.path.join(folder, "jupyter/kernels", KERNEL)
    os.makedirs(kernel, exist_ok=True)
    with open(os.path.join(kernel, "kernel.json"), "w", encoding="utf-8") as file:
        command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
        json.dump({"argv": command, "display_name": KERNEL, "language": "python"}, file)
    done = subprocess.run(
        ["jupyter-nbconvert", "--to", "notebook", "--execute", f"--ExecutePreprocessor.kernel_name={KERNEL}",
         "--output-dir", folder, name],
        cwd=HERE,
        env={**os.environ, "JUPYTER_PATH": os.path.join(folder, "jupyter"), "JUPYTER_RUNTIME_DIR": folder, **environment},
        capture_output=True,
        text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    with open(os.path.join(folder, name), encoding="utf-8") as file:
        return file.read()
