#!/usr/bin/python3
"""Table I: the eight LASA problems, several seeds and five fixed splits, beside the published figures.

    experiments/lasa_table.py --data DIR --out FOLDER [--seeds 0 1 2] [--splits] [--jobs 2]

Trains experiments/configs/lasa/*.toml with one thread a run: on the configs' own split (test demonstrations 5 and 6) for
every seed and, with --splits, on the other four fixed splits for seed 0. Runs whose results are in FOLDER already are not
repeated. Prints a Markdown table; FOLDER/lasa_table.json has every figure. Expected: every run `invariant`. A full table
takes 64 runs of half a minute to two minutes each on one core.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SHAPES = "Sine Sshape CShape Worm Angle GShape PShape NShape".split()
SPLITS = [(5, 6), (0, 1), (2, 3), (4, 5), (6, 0), (1, 5)]  # the first is the configs' own, the other five are METHOD's
PUBLISHED_MSE = dict(zip(SHAPES, [0.015, 0.016, 0.019, 0.026, 0.044, 0.019, 0.008, 0.084]))  # the paper's split
GP_MEAN = dict(zip(SHAPES, [0.0247, 0.0176, 0.0251, 0.0219, 0.0262, 0.0241, 0.0136, 0.0212]))  # no certificates


def run(arguments, shape, seed, split):
    name = f"{shape}-seed{seed}-test{split[0]}{split[1]}"
    result = os.path.join(arguments.out, name + ".json")
    if not os.path.exists(result):
        command = [arguments.program, "train", f"{ROOT}/experiments/configs/lasa/{shape}.toml", "--data", arguments.data,
                   "--seed", str(seed), "--set", f"data.test=[{split[0]}, {split[1]}]", "--threads", "1", "--json",
                   "--out", os.path.join(arguments.out, name + ".h5")]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode not in (0, 3):
            sys.exit(f"{name}: {done.stderr.strip()}")
        with open(result + ".partial", "w") as file:
            file.write(done.stdout.strip().split("\n")[-1])
        os.replace(result + ".partial", result)
    with open(result) as file:
        found = json.load(file)
    print(f"{name}: {found['guarantee']}, {found['rounds']} rounds, test mse {found['mse_test']:.4f}", file=sys.stderr)
    return dict(found, shape=shape, split=split)


def row(shape, runs, splits):
    seeds = [r for r in runs if r["shape"] == shape and r["split"] == SPLITS[0]]
    fixed = [r["mse_test"] for r in runs if r["shape"] == shape and r["split"] in SPLITS[1:]]
    median = lambda key: statistics.median(key(r) for r in seeds)
    invariant = sum(r["guarantee"] == "invariant" for r in seeds)
    conformal = sum(all(m["conformal"]["verdict"] == "passed" for m in r["conditions"].values() if "conformal" in m)
                    for r in seeds)
    cells = [shape, f"{invariant}/{len(seeds)}", f"{conformal}/{len(seeds)}",
             f"{median(lambda r: r['seconds']['training']):.0f}", f"{median(lambda r: r['rounds']):.0f}",
             f"{median(lambda r: r['seconds'].get('proof', float('nan'))):.2f}",
             f"{median(lambda r: r['mse_train']):.4f}", f"{median(lambda r: r['mse_test']):.4f}",
             f"{median(lambda r: r['sd_test']):.3f}"]
    if splits:
        cells += [f"{statistics.mean(fixed):.4f}", f"{min(fixed):.4f}"]
    cells += [f"{PUBLISHED_MSE[shape]:.3f}", f"{GP_MEAN[shape]:.4f}", f"{median(lambda r: r['safe_area']):.2f}",
              f"{median(lambda r: r['safe_area_ratio']):.3f}", f"{median(lambda r: r['disturbance_margin']):.2g}"]
    return "| " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--data", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--program", default=f"{ROOT}/build/release/experiments/s2nnds")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--splits", action="store_true")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    os.makedirs(arguments.out, exist_ok=True)
    tasks = [(shape, seed, SPLITS[0]) for shape in SHAPES for seed in arguments.seeds]
    if arguments.splits:
        tasks += [(shape, 0, split) for shape in SHAPES for split in SPLITS[1:]]
    with ThreadPoolExecutor(arguments.jobs) as pool:
        runs = list(pool.map(lambda task: run(arguments, *task), tasks))
    with open(os.path.join(arguments.out, "lasa_table.json"), "w") as file:
        json.dump(runs, file, indent=1)
    head = ["motion", "invariant", "conformal", "train s", "rounds", "proof s", "train MSE", "test MSE", "test SD"]
    head += ["mean of 5 splits", "best"] if arguments.splits else []
    head += ["published MSE", "GP mean", "safe area", "of true", "margin"]
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for shape in SHAPES:
        print(row(shape, runs, arguments.splits))


if __name__ == "__main__":
    main()
