#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Puts the tables of the results files into Markdown pages, or checks that they are there.

    experiments/readme_tables.py [PAGE.md...]            writes the pages
    experiments/readme_tables.py --check [PAGE.md...]    exit code 1, naming page and table, when a page says something else

Without pages: README.md and experiments/README.md, where they exist. A table stands between `<!-- NAME TABLE -->` and
`<!-- end -->`: NAME is a file of experiments/results, TABLE one of its tables, or `summary`, columns chosen from several.
"""

import argparse
import json
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PAGES = [os.path.join(ROOT, name) for name in ("README.md", "experiments/README.md")]
MARKED = re.compile(r"(<!-- (\w+) (\w+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)

SUMMARY = {  # of a results file: (heading, table, column)
    "lasa_table": [
        ("motion", "guarantees", "motion"),
        ("proved", "guarantees", "invariant"),
        ("first proof [s]", "guarantees", "first s"),
        ("training [s]", "guarantees", "train s"),
        ("error", "accuracy", "mean of splits"),
        ("without", "accuracy", "uncertified mean"),
        ("GP", "accuracy", "GP mean"),
        ("best", "accuracy", "best"),
        ("paper", "accuracy", "published"),
        ("safe", "guarantees", "of true"),
    ]
}


def summary_of(name, tables):
    """The rows that all chosen tables have, by their first column."""
    def column(table, head):
        at = tables[table]["head"].index(head)
        return {row[0]: row[at] for row in tables[table]["rows"]}

    columns = [column(table, head) for _, table, head in SUMMARY[name]]
    rows = [key for key in columns[0] if all(key in cells for cells in columns)]
    return {
        "head": [heading for heading, _, _ in SUMMARY[name]],
        "rows": [[cells[key] for cells in columns] for key in rows],
    }


def table_of(name, table):
    with open(os.path.join(ROOT, "experiments/results", name + ".json"), encoding="utf-8") as file:
        tables = json.load(file)["tables"]
    table = summary_of(name, tables) if table == "summary" else tables[table]
    lines = [" | ".join(row) for row in (table["head"], *table["rows"])]
    rule = "|" + "---|" * len(table["head"])
    return "\n".join([f"| {lines[0]} |", rule, *(f"| {line} |" for line in lines[1:])]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--check", action="store_true")
    parser.add_argument("pages", nargs="*", default=list(filter(os.path.exists, PAGES)))
    options = parser.parse_args()
    different = []
    for page in options.pages:
        with open(page, encoding="utf-8") as file:
            text = file.read()
        changed = [f"{m[2]} {m[3]}" for m in MARKED.finditer(text) if m[4] != table_of(m[2], m[3])]
        different += [f"{page}: the table {name}" for name in changed]
        if changed and not options.check:
            with open(page, "w", encoding="utf-8") as file:
                file.write(MARKED.sub(lambda m: m[1] + table_of(m[2], m[3]) + m[5], text))
    for name in different:
        print(f"{name} {'is not that of experiments/results' if options.check else 'changed'}", file=sys.stderr)
    return 1 if options.check and different else 0


if __name__ == "__main__":
    sys.exit(main())
