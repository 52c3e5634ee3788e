# SPDX-License-Identifier: BSD-3-Clause
"""Figures of a sweep, from its table alone.

    python -m s2nnds.plot_sweep SWEEP-FOLDER/table.h5 --out DIR [--format png|pdf]

effects: what each axis does by itself from end to end of its range, or from a list's first value to another one, with two
standard errors (only where the trials tell the axes apart).
axes: the objective against every axis, a dot a trial, the median a line; with several problems as a factor of each one's
own median, which would hide the axis otherwise. problems: the objective of each problem. pareto: training time against
error, and error against the share of the truly safe area that is kept, with what no other trial beats in both. Prints
the effects and the paths it wrote; exit code 2 and one line on stderr when the table or the folder cannot be used.
"""

import argparse
import os
import re
import sys

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from .sweep import Sweep, SweepError, pareto_front

REACHED, MISSED, FRONT = "#0a7d0a", "#b3261e", "#1f4fd1"
STYLE = {"figure.dpi": 150, "savefig.dpi": 150, "font.size": 10, "axes.titlesize": 11, "axes.axisbelow": True}
LABELS = {
    "mse_train": "training MSE",
    "dtw_train": "training DTW",
    "mse_validation": "validation MSE",
    "seconds": "seconds a trial",
    "seconds_training": "training time, s",
    "safe_area_ratio": "safe area / truly safe area",
}


def label(name):
    return LABELS.get(name, name)


def error_column(sweep):
    """The error to draw against: the objective if it is one, else what was measured. Never the test error."""
    for name in (sweep.objective, "mse_validation", "mse_train"):
        if name in ("mse_validation", "mse_train") and name in sweep and np.isfinite(sweep[name]).any():
            return name
    return None


def spread(values):
    """Positive values over more than a factor of 20, which a logarithmic axis shows better."""
    finite = values[np.isfinite(values)]
    return len(finite) > 0 and finite.min() > 0 and finite.max() > 20 * finite.min()


def short(text):
    text = str(text)
    return text if len(text) <= 14 else text[:6] + "…" + text[-6:]


def in_order(texts):
    """[8] before [16, 16]: by the numbers in the texts, then by the texts."""
    return sorted(set(texts), key=lambda text: ([float(n) for n in re.findall(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?", text)], text))


def scatter(ax, x, y, reached):
    for mask, colour, marker in ((~reached, MISSED, "x"), (reached, REACHED, "o")):
        ax.scatter(x[mask], y[mask], s=22, c=colour, marker=marker, alpha=0.6, linewidths=1.0, zorder=3)


def medians(x, y):
    """A median for each value, or, of many values, for each of up to eight groups: (x, y)."""
    values = np.unique(x)
    if len(values) <= 8:
        return values, np.array([np.median(y[x == value]) for value in values])
    groups = np.array_split(np.argsort(x, kind="stable"), min(8, max(1, len(x) // 5)))
    return np.array([np.median(x[g]) for g in groups]), np.array([np.median(y[g]) for g in groups])


def place(ax, column):
    """The column's places along x; texts one after another, with their names below."""
    if column.dtype.kind != "O":
        if spread(column):
            ax.set_xscale("log")
        else:
            ax.locator_params(axis="x", nbins=5)
        return column
    texts = in_order(column)
    crowded = len(texts) > 3 or max(map(len, texts)) > 14
    ax.set_xticks(range(len(texts)), [short(text) for text in texts], rotation=40 if crowded else 0, fontsize=8)
    ax.set_xlim(-0.5, len(texts) - 0.5)
    return np.array([texts.index(text) for text in column], dtype=float)


def draw_axis(ax, x, y, reached, name):
    x = place(ax, x)
    scatter(ax, x, y, reached)
    ax.plot(*medians(x, y), color="#222222", linewidth=1.4, zorder=4)
    ax.set_xlabel(name, fontsize=9)
    ax.grid(alpha=0.3)


def shown_trials(sweep):
    return sweep.done() & np.isfinite(sweep[sweep.objective]) if sweep.objective in sweep else np.zeros(0, bool)


def as_factors(values, problems):
    """Each value over the median of its own problem."""
    factors = np.empty_like(values)
    for problem in set(problems):
        of_it = problems == problem
        factors[of_it] = values[of_it] / np.median(values[of_it])
    return factors


def draw_axes(sweep):
    """One panel an axis; seeds are an axis too."""
    shown = shown_trials(sweep)
    names = [name for name in [*sweep.axes, "seed"] if len(set(sweep[name])) > 1]
    if not shown.any() or not names:
        return None
    y, text = sweep[sweep.objective][shown], label(sweep.objective)
    factors = len(set(sweep["config"])) > 1 and np.all(y > 0)
    if factors:
        y, text = as_factors(y, sweep["config"][shown]), f"{text} / problem's median"
    columns = min(3 if len(names) <= 9 else 5, len(names))
    rows = -(-len(names) // columns)
    figure, panels = plt.subplots(
        rows, columns, figsize=(3.4 * columns + 0.6, 2.9 * rows + 0.7), squeeze=False, sharey=True, layout="constrained"
    )
    for panel, name in zip(panels.flat, names):
        draw_axis(panel, sweep[name][shown], y, sweep.reached()[shown], name)
    if factors or spread(y):
        panels[0][0].set_yscale("log")
    if factors:
        panels[0][0].yaxis.set_major_formatter("{x:g}")
        panels[0][0].yaxis.set_minor_formatter("{x:g}")
    for row in panels:
        row[0].set_ylabel(text, fontsize=9)
    for panel in panels.flat[len(names) :]:
        panel.set_visible(False)
    figure.suptitle(legend_text(sweep, shown) + "; line: median")
    return figure


def draw_problems(sweep):
    """The objective of each problem, a dot a trial."""
    shown = shown_trials(sweep)
    if not shown.any() or len(set(sweep["config"])) < 2:
        return None
    figure, ax = plt.subplots(figsize=(max(4.6, 0.42 * len(set(sweep["config"])) + 1.6), 4.2), layout="constrained")
    y = sweep[sweep.objective][shown]
    scatter(ax, place(ax, sweep["config"][shown]), y, sweep.reached()[shown])
    if spread(y):
        ax.set_yscale("log")
    ax.set_ylabel(label(sweep.objective))
    ax.grid(alpha=0.3)
    ax.set_title(legend_text(sweep, shown))
    return figure


def legend_text(sweep, shown):
    counted = f"{int((sweep.reached() & shown).sum())} of {int(shown.sum())} trials"
    near = f" with DTW ≤ {sweep.dtw_limit:g}" if sweep.dtw_limit > 0 else ""
    wanted = "ended without an error" if sweep.guarantee == "none" else f"reached `{sweep.guarantee}`{near} (dots, others crosses)"
    return f"{sweep.name}: {counted} {wanted}"


def draw_front(ax, sweep, x_name, y_name, shown, sign_x=1.0):
    x, y, reached = sweep[x_name][shown], sweep[y_name][shown], sweep.reached()[shown]
    scatter(ax, x, y, reached)
    candidates = np.flatnonzero(reached)
    front = candidates[pareto_front(sign_x * x[candidates], y[candidates])] if len(candidates) else candidates
    ax.plot(x[front], y[front], color=FRONT, marker="o", markersize=7, markerfacecolor="none", linewidth=1.4, zorder=4)
    for index in front if len(front) <= 8 else ():
        ax.annotate(
            f"{int(sweep['trial'][shown][index])}",
            (x[index], y[index]),
            textcoords="offset points",
            xytext=(6, 5),
            fontsize=8,
            color=FRONT,
        )
    if spread(x):
        ax.set_xscale("log")
    if spread(y):
        ax.set_yscale("log")
    ax.set_xlabel(label(x_name))
    ax.set_ylabel(label(y_name))
    ax.grid(alpha=0.3)


def draw_pareto(sweep):
    error = error_column(sweep)
    pairs = []
    for name, sign in (("seconds_training", 1.0), ("seconds", 1.0), ("safe_area_ratio", -1.0)):
        if error is None or name not in sweep or (name == "seconds" and pairs):
            continue
        shown = sweep.done() & np.isfinite(sweep[name]) & np.isfinite(sweep[error])
        if name == "safe_area_ratio":
            shown &= sweep[name] <= 1.0  # a barrier that calls unsafe places safe is no trade-off
        if shown.any():
            pairs.append((name, sign, shown))
    if not pairs:
        return None
    figure, panels = plt.subplots(1, len(pairs), figsize=(4.6 * len(pairs), 3.8), squeeze=False, layout="constrained")
    for panel, (name, sign, shown) in zip(panels.flat, pairs):
        draw_front(panel, sweep, name, error, shown, sign)
    wanted = "all trials" if sweep.guarantee == "none" else f"dots: `{sweep.guarantee}`, crosses: less"
    figure.suptitle(f"{sweep.name}: {wanted}; line: Pareto front (numbers: trials)")
    return figure


def draw_effects(sweep):
    """One panel a figure, one row an axis; what lies more than two standard errors from no effect is coloured."""
    if not sweep.effects:
        return None
    texts = [f"{axis}\n{short(start)} → {short(end)}" for axis, start, end in sweep.effect_rows]
    height = np.arange(len(texts))[::-1]
    figure, panels = plt.subplots(
        1,
        len(sweep.effects),
        figsize=(3.0 + 2.6 * len(sweep.effects), 1.2 + 0.36 * len(texts)),
        squeeze=False,
        sharey=True,
        layout="constrained",
    )
    for panel, (name, effect) in zip(panels.flat, sweep.effects.items()):
        none = 1.0 if effect.kind == "factor" else 0.0
        clear = np.abs(effect.change - none) > 2 * effect.error
        for mask, colour in ((clear, FRONT), (~clear, "#888888")):
            panel.errorbar(effect.change[mask], height[mask], xerr=2 * effect.error[mask], fmt="o", color=colour, markersize=5)
        panel.axvline(none, color="#222222", linewidth=1.0, zorder=1)
        panel.set_title(f"{label(name)}\n{effect.kind}, {effect.trials} trials", fontsize=10)
        panel.grid(alpha=0.3)
    panels[0][0].set_yticks(height, texts, fontsize=8)
    panels[0][0].set_ylim(-0.7, len(texts) - 0.3)
    figure.suptitle(f"{sweep.name}: each axis from end to end, the others as they are; bars: two standard errors")
    return figure


def effect_lines(sweep):
    """The effects as a table, one line a step."""
    if not sweep.effects:
        return
    rows = [f"{axis}, {start} -> {end}" for axis, start, end in sweep.effect_rows]
    width = max(map(len, rows))
    yield "effects, each with the other axes as they are, ± standard error"
    yield " " * width + "".join(f"{f'{name} ({effect.trials})':>26}" for name, effect in sweep.effects.items())
    for k, row in enumerate(rows):
        cells = [f"{'x' if e.kind == 'factor' else ''}{e.change[k]:.3f} ±{e.error[k]:.3f}" for e in sweep.effects.values()]
        yield f"{row:<{width}}" + "".join(f"{cell:>26}" for cell in cells)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("table")
    parser.add_argument("--out", required=True)
    parser.add_argument("--format", default="png", choices=("png", "pdf"))
    options = parser.parse_args(arguments)
    try:
        sweep = Sweep(options.table)
        os.makedirs(options.out, exist_ok=True)
        for line in effect_lines(sweep):
            print(line)
        with plt.rc_context(STYLE):
            for name, draw in (("effects", draw_effects), ("axes", draw_axes), ("problems", draw_problems), ("pareto", draw_pareto)):
                figure = draw(sweep)
                if figure is None:
                    continue
                path = os.path.join(options.out, f"{name}.{options.format}")
                figure.savefig(path, metadata={"CreationDate": None} if options.format == "pdf" else None)
                plt.close(figure)
                print(path)
    except (SweepError, OSError) as error:
        print(f"plot_sweep.py: {str(error).splitlines()[0]}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
