#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The measuring half of compare.sh: runs the programs in turns and makes ratios of medians."""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys

PYTHON = "/usr/bin/python3"  # Debian's, which has torch
LEAST_PEER_RATE = 0.5  # of the best rate of matrix products on this machine: less is a peer without a BLAS worth the name
# The rate at which the peer multiplies matrices, GFLOP/s.
PEER_RATE = """
import json, statistics, sys, time, torch
torch.set_num_threads(int(sys.argv[1]))
a, b = torch.rand(1024, 1024), torch.rand(1024, 1024)
times = []
for _ in range(12):
    begin = time.perf_counter()
    a @ b
    times.append(time.perf_counter() - begin)
print(json.dumps({"sgemm_gflops": 2e-9 * 1024 ** 3 / statistics.median(times[2:])}))
"""


def run_json(*command, threads=None):
    """The JSON object that a program prints last."""
    environment = dict(os.environ)
    if threads is not None:
        environment["OMP_NUM_THREADS"] = str(threads)
    done = subprocess.run([str(word) for word in command], env=environment, stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def processor():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        for line in file:
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor()


def medians(results, key):
    """{threads: median over the rounds}"""
    return {threads: statistics.median(each[key] for each in rounds) for threads, rounds in results.items()}


def fastest(results, key):
    """(threads, seconds) of the better number of threads."""
    return min(medians(results, key).items(), key=lambda item: item[1])


def measure(arguments, programs):
    counts = arguments.threads or sorted({1, min(2, os.cpu_count() or 1)})
    peer, jax, ours, rates = ({n: [] for n in counts} for _ in range(4))
    check_peer(arguments, programs, counts)
    latency = []
    for k in range(arguments.rounds):
        for n in counts:
            print(f"round {k + 1} of {arguments.rounds}, threads {n}", file=sys.stderr)
            peer[n].append(run_json(PYTHON, arguments.peer, "--threads", n, "--steps", arguments.steps, threads=n))
            ours[n].append(run_json(f"{programs}/paired_timing", "--threads", n, "--steps", arguments.steps, threads=n))
            if arguments.jax:
                words = (arguments.jax, arguments.jax_peer, "--threads", n, "--steps", arguments.steps)
                jax[n].append(run_json(*words, threads=n))
            rates[n].append(run_json(f"{programs}/gemm_rate", n, threads=n))
        latency.append(run_json(f"{programs}/evaluation_latency", 1000000, threads=1))
    return peer, jax, ours, rates, latency


def check_peer(arguments, programs, counts):
    """Refuses a comparison with a lame peer: Debian's torch takes its matrix products from whatever libblas there is."""
    for n in counts:
        best = run_json(f"{programs}/gemm_rate", n, threads=n)["sgemm_gflops"]
        found = run_json(PYTHON, "-c", PEER_RATE, n, threads=n)["sgemm_gflops"]
        arguments.peer_rates[n] = found
        if found < LEAST_PEER_RATE * best:
            sys.exit(f"compare.sh: the peer multiplies matrices at {found:.1f} GFLOP/s with {n} threads, this machine can "
                     f"do {best:.1f}: install libopenblas0-pthread before comparing")


def summarise(peer, jax, ours, rates, latency):
    result = {}
    for work, key, flops in (("step", "step_s", "step_flops"), ("score", "score_200k_s", "score_flops")):
        peer_threads, peer_seconds = fastest(peer, key)
        our_threads, our_seconds = fastest(ours, key)
        if any(jax.values()):
            jax_threads, jax_seconds = fastest(jax, key)
            result[f"{work}_jax_ratio"] = jax_seconds / our_seconds
            result[f"{work}_jax_ms"] = 1e3 * jax_seconds
            result[f"{work}_jax_threads"] = jax_threads
        gflops = 1e-9 * ours[our_threads][0][flops] / our_seconds
        result[f"{work}_ratio"] = peer_seconds / our_seconds
        result[f"{work}_roofline"] = gflops / medians(rates, "sgemm_gflops")[our_threads]
        result[f"{work}_roofline_dgemm"] = gflops / medians(rates, "dgemm_gflops")[our_threads]
        result[f"{work}_gflops"] = gflops
        result[f"{work}_ms"] = 1e3 * our_seconds
        result[f"{work}_peer_ms"] = 1e3 * peer_seconds
        result[f"{work}_threads"] = our_threads
        result[f"{work}_peer_threads"] = peer_threads
    threads = result["step_threads"]  # whose rates are told
    for kind in ("sgemm", "dgemm"):
        result[f"{kind}_gflops"] = medians(rates, f"{kind}_gflops")[threads]
        result[f"{kind}_gflops_by_threads"] = medians(rates, f"{kind}_gflops")
        result[f"{kind}_library"] = rates[threads][0][f"{kind}_library"]
    for name in ("eval", "eval_double", "torchscript"):
        for figure in ("median_us", "p999_us"):
            result[f"{name}_{figure}"] = statistics.median(each[f"{name}_{figure}"] for each in latency)
    result["eval_p999_us_best"] = min(each["eval_p999_us"] for each in latency)
    result["rounds"] = len(latency)
    result["torch"] = peer[threads][0]["torch"]
    result["instruction_set"] = ours[threads][0]["instruction_set"]
    result["processor"] = processor()
    result["cores"] = os.cpu_count()
    result["load"] = os.getloadavg()[1]  # what else ran: five minutes' average
    return result


def table(headings, rows):
    widths = [max(len(str(row[i])) for row in [headings, *rows]) for i in range(len(headings))]
    for row in [headings, ["-" * width for width in widths], *rows]:
        print("| " + " | ".join(str(cell).ljust(width) for cell, width in zip(row, widths)) + " |")


def growth(programs):
    words = [f"{programs}/growth_benchmark", "--benchmark_format=json", "--benchmark_min_time=0.2"]
    report = json.loads(subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True).stdout)
    rows = []
    for each in report["benchmarks"]:
        if each.get("error_occurred"):
            continue
        parts = each["name"].replace("/real_time", "").split("/")
        size = " ".join(parts[1:])
        extra = f"{each['gflops']:.1f} GFLOP/s" if "gflops" in each else ""
        if "boxes" in each:
            extra = f"{each['boxes']:.0f} boxes, {each['boxes_per_s']:.0f} a second, {each.get('label', '')}"
        rows.append([parts[0], size, f"{each['real_time']:.4g} {each['time_unit']}", extra])
    table(["work", "size", "time", "rate"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("programs")
    parser.add_argument("root")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--threads", type=int, nargs="+")
    parser.add_argument("--peer")
    parser.add_argument("--jax", default=os.environ.get("S2NNDS_JAX_PYTHON"), help="a Python with JAX, the second peer")
    parser.add_argument("--jax-peer")
    parser.add_argument("--out")
    parser.add_argument("--baseline", action="store_true")
    parser.add_argument("--growth", action="store_true")
    arguments = parser.parse_args()
    if arguments.growth:
        return growth(arguments.programs)
    arguments.peer = arguments.peer or os.path.join(arguments.root, "../shared/anchors/pytorch_step.py")
    if not os.path.isfile(arguments.peer):
        sys.exit(f"compare.sh: {arguments.peer}: no such file; --peer names the peer's script")
    arguments.jax_peer = arguments.jax_peer or os.path.join(os.path.dirname(arguments.peer), "jax_step.py")
    arguments.peer_rates = {}
    result = summarise(*measure(arguments, arguments.programs))
    result["peer_sgemm_gflops_by_threads"] = arguments.peer_rates
    rounded = {key: float(f"{value:.4g}") if isinstance(value, float) else value for key, value in result.items()}
    outputs = [arguments.out] if arguments.out else []
    if arguments.baseline:
        outputs.append(os.path.join(arguments.root, "tests/benchmarks/baselines", platform.node() + ".json"))
    for path in outputs:
        with open(path, "w", encoding="utf-8") as file:
            json.dump(rounded, file, indent=2)
            file.write("\n")
    print(json.dumps(rounded))


if __name__ == "__main__":
    main()
