#!/usr/bin/env python3
"""Puts the tables of the results files into the README, or checks that they are there.

    experiments/readme_tables.py            writes README.md
    experiments/readme_tables.py --check    exit code 1, naming the table, when the README says something else

A table stands between `<!-- NAME TABLE -->` and `<!-- end -->`: NAME is a file of experiments/results, TABLE one of its tables.
"""

import argparse
import json
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MARKED = re.compile(r"(<!-- (\w+) (\w+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)


def markdown(table):
    lines = [table["head"], ["---"] * len(table["head"]), *table["rows"]]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines).replace("| --- |", "|---|").replace(" --- |", "---|")


def table_of(name, table):
    with open(os.path.join(ROOT, "experiments/results", name + ".json"), encoding="utf-8") as file:
        return markdown(json.load(file)["tables"][table])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    path = os.path.join(ROOT, "README.md")
    with open(path, encoding="utf-8") as file:
        text = file.read()
    different = [f"{m[2]} {m[3]}" for m in MARKED.finditer(text) if m[4] != table_of(m[2], m[3])]
    if options.check:
        for name in different:
            print(f"README.md: the table {name} is not that of experiments/results", file=sys.stderr)
        return 1 if different else 0
    with open(path, "w", encoding="utf-8") as file:
        file.write(MARKED.sub(lambda m: m[1] + table_of(m[2], m[3]) + m[5], text))
    print(f"README.md: {len(different)} tables changed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
