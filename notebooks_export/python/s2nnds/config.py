# SPDX-License-Identifier: BSD-3-Clause
"""Configurations as the functions of this package take them: the path of a TOML file, or a dict like its content."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from typing import Any, Union

from ._native import ConfigText

# A dict is nested as the TOML is, or has dotted keys: {"data": {"motion": "Sine"}} or {"data.motion": "Sine"}.
Config = Union[str, "os.PathLike[str]", Mapping[str, Any]]


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value))
    if isinstance(value, bool):
        return "true" if value else "false"
    if hasattr(value, "tolist"):  # of NumPy
        return _toml(value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return repr(value)


def _settings(values: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _settings(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}={_toml(value)}"


def config_text(config: Config, settings: Mapping[str, Any] | None = None) -> ConfigText:
    """The configuration with `settings` on top, dotted or nested keys. Raises OSError if its file cannot be read."""
    more = list(_settings(settings or {}))
    if isinstance(config, Mapping):
        return ConfigText("", "configuration", [*_settings(config), *more])
    path = os.fspath(config)
    with open(path, encoding="utf-8") as file:
        return ConfigText(file.read(), path, more)
