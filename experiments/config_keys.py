#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes experiments/configs/README.md: every configuration key with its default, what it may be, and its meaning.

Keys, defaults and ranges come from `s2nnds keys`; the meaning is the comment beside the field in the library's headers.
Usage: config_keys.py PROGRAM [--check]   (--check writes nothing and fails where the page is out of date)
"""

import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "experiments" / "configs" / "README.md"
HEAD = """# Configuration keys

A configuration is a TOML file. Every key has a default, so a file names only what differs. `--set key=value` on the command line
overrides the file. A run file holds every value that was used (`s2nnds info RUN.h5 --all`).

This page is written by `experiments/config_keys.py`; a test compares it with the program. Defaults are those of the profile
`robust`; where `smooth`, `paper` or `imitation` differ, the default column says so. The sets of `problem` are in the data's unit
and frame (`problem.frame`). All other lengths and velocities are normalised (goal at the origin, largest coordinate and velocity 1) unless
the meaning says otherwise.

Folders: `handwriting/` needs no data; `lasa/`, `lasa_other/`, `abc_ds/` and `other/` need the data of
[experiments/README.md](../README.md#data); `recordings/robot.toml` shows how to read your own CSV files;
`poses/` trains on the recordings of [experiments/poses](../poses/README.md) and its folder `arms/`.
"""


def comment_text(lines):
    """The words of comment lines, joined."""
    return " ".join(line.strip().removeprefix("//").strip() for line in lines).strip()


def structs(folder):
    """name of a struct -> member -> (type, meaning), from comments before a member and behind it."""
    found = {}
    for path in sorted(folder.rglob("*.h")):
        struct, before, last = None, [], None
        for line in path.read_text().splitlines():
            opened = re.match(r"\s*struct (\w+)(?: : (\w+))?\s*{$", line)
            if opened:
                struct, before, last = opened[1], [], None
                found[struct] = {"base": (opened[2], "")} if opened[2] else {}
                continue
            stripped = line.strip()
            if stripped.startswith("};") or struct is None:
                struct = None if stripped.startswith("};") else struct
                continue
            if stripped.startswith("//"):
                if last and re.match(r"\s{20,}//", line):  # goes on behind a member
                    found[struct][last] = (found[struct][last][0], found[struct][last][1] + " " + comment_text([line]))
                else:
                    before.append(line)
                continue
            member = re.match(r"\s*([\w:<>, ]+?) (\w+)(?: = .*?|{.*?})?;\s*(//.*)?$", line)
            if member:
                behind = comment_text([member[3]]) if member[3] else ""
                words = " ".join(part for part in (comment_text(before), behind) if part)
                found[struct][member[2]] = (member[1], words)
                last = member[2]
            else:
                last = None
            before = []
    return found


def loss_terms(folder):
    """name of a loss term -> its meaning, from the comments of the enumerators."""
    text = (folder / "training" / "loss_term.h").read_text()
    body = re.search(r"enum class LossTerm[^{]*{(.*?)};", text, re.S)[1]
    return {name: words.strip() for name, words in re.findall(r"(\w+),?\s*// (.*)", body)}


def meaning(key, found, terms):
    """The comment of the field that `key` names, following the types of the groups from Config on."""
    struct = "Config"
    parts = key.split(".")
    for part in parts[:-1]:
        while part not in found.get(struct, {}) and "base" in found.get(struct, {}):
            struct = found[struct]["base"][0]
        if part not in found.get(struct, {}):
            return ""
        struct = found[struct][part][0].split("::")[-1]
    if struct == "LossOptions" and parts[-1] in terms:
        return f"weight: {terms[parts[-1]]}"
    while struct:
        members = found.get(struct, {})
        if parts[-1] in members:
            return members[parts[-1]][1]
        struct = (members.get("base") or members.get("network") or ("", ""))[0]  # `network` is visited flat
    return ""


def cell(text):
    return text.replace("|", "\\|")


def page(rows):
    folder = ROOT / "s2nnds"
    found, terms = structs(folder), loss_terms(folder)
    text, section, missing = HEAD, None, []
    for row in rows:
        group, _, name = row["key"].rpartition(".")
        if group != section:
            section = group
            text += f"\n## {group or 'Top level'}\n\n| key | default | may be | meaning |\n|---|---|---|---|\n"
        words = meaning(row["key"], found, terms)
        if not words:
            missing.append(row["key"])
        default = f"`{row['default']}`"
        for profile in ("smooth", "paper", "imitation"):
            if profile in row:
                default += f"; {profile}: `{row[profile]}`"
        when = f"With `{row['when']}`. " if row["when"] else ""
        text += f"| `{name}` | {cell(default)} | {cell(row['expected'])} | {cell(when + words)} |\n"
    if missing:
        sys.exit(f"config_keys.py: no comment beside the field of {', '.join(missing)}; expected one in its header")
    return text


def main():
    program, *options = sys.argv[1:]
    rows = json.loads(subprocess.run([program, "keys"], capture_output=True, text=True, check=True).stdout)
    rows.sort(key=lambda row: row["key"].rpartition(".")[0])
    text = page(rows)
    if "--check" in options:
        if PAGE.read_text() != text:
            sys.exit(f"{PAGE.relative_to(ROOT)}: out of date; remake it with experiments/config_keys.py PROGRAM")
        return
    PAGE.write_text(text)


if __name__ == "__main__":
    main()
