#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Lets Optuna choose the settings: asks it for them, trains with the command line's --json, tells it the result.

    optuna_sweep.py SWEEP.toml --trials 50 --out FOLDER [--data DIR] [--program s2nnds] [--threads 1]

Reads the sweep's axes, settings, configurations, seeds, objective and guarantee; the design is Optuna's. A trial is one
point on every configuration and seed; its value is the objective's geometric mean, its constraint the share of runs
that count. A run that ends with conformal verification gets its beta divided by the number of runs, so that what is said of
the chosen one is wrong with a probability of at most beta. The study lies in FOLDER/optuna.db, every run beside it; the same command goes on. Needs optuna (pip).
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tomllib

GUARANTEES = ["none", "sampled", "conformal", "proved", "invariant"]


def flat_axes(table, prefix=""):
    """(key, axis) of the sweep's axes, whether the keys were written with quotes or as nested tables."""
    for name, axis in table.items():
        if isinstance(axis, dict) and not {"values", "range", "log_range"} & axis.keys():
            yield from flat_axes(axis, f"{prefix}{name}.")
        else:
            yield prefix + name, axis if isinstance(axis, dict) else {"values": axis}


def toml_text(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_text, value)) + "]"
    return json.dumps(value) if isinstance(value, (str, bool)) else repr(value)


def suggest(trial, key, axis):
    """The value of one axis, as TOML."""
    if "values" in axis:
        return trial.suggest_categorical(key, [toml_text(value) for value in axis["values"]])
    logarithmic = "log_range" in axis
    low, high = axis["log_range" if logarithmic else "range"]
    whole = isinstance(low, int) and isinstance(high, int)
    return toml_text((trial.suggest_int if whole else trial.suggest_float)(key, low, high, log=logarithmic))


def train(options, config, seed, settings, run):
    """The run's summary as the program's last line says it; None when it failed."""
    command = [options.program, "train", config, "--seed", str(seed), "--threads", str(options.threads)]
    command += [word for setting in settings for word in ("--set", setting)]
    command += ["--out", run, "--json"] + (["--data", options.data] if options.data else [])
    environment = {**os.environ, "OMP_WAIT_POLICY": "passive"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    if done.returncode not in (0, 3):
        print(f"{run}: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
        return None
    return json.loads(done.stdout.splitlines()[-1])


def mean(values):
    if all(value > 0 for value in values):
        return math.exp(sum(map(math.log, values)) / len(values))
    return sum(values) / len(values)


def counts(sweep, summary):
    """Whether a run has the guarantee and its motion stays as near to the demonstrations as dtw_limit says."""
    limit = sweep.get("dtw_limit", 0.0)
    distance = summary.get("dtw_train")
    near = limit == 0.0 or (distance is not None and distance <= limit)
    return near and GUARANTEES.index(summary["guarantee"]) >= GUARANTEES.index(sweep.get("guarantee", "none"))


def without_quotes(value):
    return value.strip().strip("\"'")


def conformal_settings(options, config, settings):
    """The run's share of beta as a setting; none when the run does not end with conformal verification."""
    with open(config, "rb") as file:
        written = tomllib.load(file)
    words = {key.strip(): value for key, value in (setting.split("=", maxsplit=1) for setting in settings)}

    def value(key, otherwise):
        if key in words:
            return without_quotes(words[key])
        table = written
        for name in key.split("."):
            table = table.get(name, {}) if isinstance(table, dict) else {}
        return otherwise if table == {} else table

    keys = json.loads(subprocess.run([options.program, "keys"], capture_output=True, text=True, check=True).stdout)
    defaults = {key["key"]: without_quotes(key.get(value("profile", "robust"), key["default"])) for key in keys}
    if value("verification.method", defaults["verification.method"]) != "conformal":
        return []
    beta = float(value("verification.conformal.beta", defaults["verification.conformal.beta"]))
    return [f"verification.conformal.beta={beta / options.runs!r}"]


def evaluate(trial, sweep, options):
    """(objective, share of the runs that count); an objective of None: nothing to tell."""
    settings = list(sweep.get("set", []))
    for key, axis in flat_axes(sweep.get("axes", {})):
        value = suggest(trial, key, axis)
        settings += [f"{name}={value}" for name in [key, *axis.get("also", [])]]
    values, reached, count = [], 0, 0
    for config in sweep["configs"]:
        for seed in sweep.get("seeds", [0]):
            run = os.path.join(options.out, f"{trial.number:05d}-{count}.h5")
            count += 1
            path = os.path.join(os.path.dirname(options.sweep), config)
            share_of_beta = conformal_settings(options, path, settings)
            if share_of_beta:
                trial.study.set_user_attr("beta_split_over", options.runs)
            summary = train(options, path, seed, settings + share_of_beta, run)
            if summary is None or summary.get(sweep["objective"]) is None:
                continue
            values.append(summary[sweep["objective"]])
            reached += counts(sweep, summary)
    return (mean(values) if values else None), reached / count


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("sweep")
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--out", required=True)
    parser.add_argument("--data")
    parser.add_argument("--program", default="s2nnds")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    try:
        import optuna
    except ModuleNotFoundError:
        sys.exit("optuna_sweep.py: found no optuna; expected it to be installed (pip install optuna)")
    with open(options.sweep, "rb") as file:
        sweep = tomllib.load(file)
    sweep.setdefault("objective", "mse_train")
    if "test" in sweep["objective"]:
        sys.exit("optuna_sweep.py: objective: expected one that does not look at test demonstrations")
    os.makedirs(options.out, exist_ok=True)

    wanted_share = sweep.get("share", 1.0)
    study = optuna.create_study(
        study_name=sweep.get("name", "sweep"),
        storage=f"sqlite:///{os.path.abspath(options.out)}/optuna.db",
        load_if_exists=True,
        direction=sweep.get("direction", "minimize"),
        sampler=optuna.samplers.TPESampler(
            seed=sweep.get("design_seed", 0), constraints_func=lambda trial: (wanted_share - trial.user_attrs.get("share", 0.0),)
        ),
    )
    options.runs = options.trials * len(sweep["configs"]) * len(sweep.get("seeds", [0]))
    split_over = study.user_attrs.get("beta_split_over", options.runs)
    if options.runs > split_over:
        sys.exit(f"optuna_sweep.py: found {options.runs} runs, but beta was split over {split_over}; expected no more trials")
    options.runs = split_over
    ended = len([trial for trial in study.trials if trial.state.is_finished()])
    for _ in range(max(0, options.trials - ended)):
        trial = study.ask()
        value, share = evaluate(trial, sweep, options)
        trial.set_user_attr("share", share)
        if value is None:
            study.tell(trial, state=optuna.trial.TrialState.FAIL)
        else:
            study.tell(trial, value)
        print(f"trial {trial.number}: {sweep['objective']} {value}, share {share:.2f}, {trial.params}", file=sys.stderr)
    complete = study.get_trials(states=(optuna.trial.TrialState.COMPLETE,))
    feasible = [trial for trial in complete if trial.user_attrs["share"] >= wanted_share]
    if not feasible:
        print("in no trial the wanted share of the runs counts")
        return 3
    best = (min if study.direction.name == "MINIMIZE" else max)(feasible, key=lambda trial: trial.value)
    print(json.dumps({"trial": best.number, sweep["objective"]: best.value, "settings": best.params}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
