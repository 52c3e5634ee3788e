#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Ten drawings in the studio: seconds from the last stroke to the certificate, and how smoothly the page draws meanwhile.

    /usr/bin/python3 tests/benchmarks/studio_drawings.py build/release/experiments/s2nnds

The drawings are sent as the page sends them; a real browser (Debian's chromium, without a graphics card) shows the studio at the same
time, so its work is part of the seconds. Frames are those of the page's own clock (requestAnimationFrame), at most 60 a second. Prints a
Markdown table and the page's weight. The exit code is 1 where a drawing ends without a certificate.
"""

import math
import os
import statistics
import sys
import time
import urllib.request

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "program"))

import command_line  # noqa: E402
import studio_test  # noqa: E402


def stroke(path, seconds=2.4):
    """`path` of 0 to 1, passed with a minimum jerk."""
    rows = []
    for k in range(121):
        u = k / 120
        x, y = path(u**3 * (10 - 15 * u + 6 * u * u))
        rows.append((seconds * u, x, y))
    t, x, y = map(list, zip(*rows))
    return {"t": t, "x": x, "y": y}


def strokes(path, spread=0.03):
    """Three strokes that begin beside one another and end at one place."""
    def beside(shift):
        return lambda s: (path(s)[0], path(s)[1] + shift * (1 - s))

    return [stroke(beside(shift)) for shift in (-spread, 0.0, spread)]


def ball(x, y, radius):
    return {"type": "ball", "center": [x, y], "radius": radius}


def box(left, bottom, right, top):
    return {"type": "box", "lower": [left, bottom], "upper": [right, top]}


def spiral(s):
    angle, radius = math.pi * (1.0 - 1.3 * s), 0.3 * (1.0 - 0.75 * s)
    return 0.5 + radius * math.cos(angle), 0.38 + radius * math.sin(angle)


DRAWINGS = {
    "arc over a ball": (lambda s: (0.15 + 0.65 * s, 0.3 + 0.22 * math.sin(math.pi * s)), [ball(0.47, 0.2, 0.09)]),
    "arc under a ball": (lambda s: (0.15 + 0.65 * s, 0.5 - 0.22 * math.sin(math.pi * s)), [ball(0.47, 0.55, 0.09)]),
    "straight, ball beside": (lambda s: (0.15 + 0.7 * s, 0.2 + 0.3 * s), [ball(0.45, 0.52, 0.08)]),
    "S": (lambda s: (0.15 + 0.7 * s, 0.37 + 0.15 * math.sin(2 * math.pi * s)), [ball(0.35, 0.25, 0.06)]),
    "sine of three halves": (lambda s: (0.1 + 0.8 * s, 0.37 + 0.12 * math.sin(3 * math.pi * s)), [ball(0.24, 0.3, 0.05)]),
    "U": (lambda s: (0.5 - 0.3 * math.cos(math.pi * s), 0.6 - 0.4 * math.sin(math.pi * s)), [box(0.45, 0.4, 0.55, 0.55)]),
    "hook": (lambda s: (0.2 + 0.55 * math.sin(0.8 * math.pi * s), 0.15 + 0.45 * s), [ball(0.45, 0.5, 0.07)]),
    "spiral of two thirds": (spiral, [ball(0.5, 0.12, 0.05)]),
    "two balls": (lambda s: (0.12 + 0.75 * s, 0.35 + 0.13 * math.sin(2 * math.pi * s)), [ball(0.3, 0.3, 0.05), ball(0.68, 0.42, 0.05)]),
    "round a box": (lambda s: (0.15 + 0.7 * s, 0.2 + 0.35 * math.sin(math.pi * s)), [box(0.4, 0.15, 0.6, 0.35)]),
}

FRAMES = """
const [seconds, done] = arguments;
let frames = 0;
const from = performance.now();
const next = (now) => { frames += 1; now - from < 1000 * seconds ? requestAnimationFrame(next) : done(1000 * frames / (now - from)); };
requestAnimationFrame(next);
"""


class Drawings(studio_test.PageTest):
    def frames(self, page, seconds):
        return page.execute_async_script(FRAMES, seconds)

    def weight(self):
        """Bytes of the page: what its address and the modules that it names send."""
        with urllib.request.urlopen(self.address) as answer:
            size = len(answer.read())
        names = [name for name in os.listdir(studio_test.REFERENCE) if name.endswith((".js", ".css")) and name != "report.js"]
        for name in names:
            with urllib.request.urlopen(self.address + name) as answer:
                size += len(answer.read())
        return size

    def test_ten_drawings(self):
        self.studio()
        page = self.browser()
        page.set_script_timeout(30)
        page.get(self.address)
        self.wait(page, "window.studio?.state", 20)
        print(f"page: {self.weight() / 1000:.0f} kB\n")
        print("| drawing | guarantee | certificate after [s] | frames/s, learning | frames/s, certified |\n|---|---|---|---|---|")
        seconds, proved = [], 0
        for name, (path, obstacles) in DRAWINGS.items():
            self.tell("api/drawing", studio_test.drawing(strokes=strokes(path), obstacles=obstacles))
            began = time.monotonic()
            self.tell("api/learn")
            learning = self.frames(page, 1.5)
            job = self.wait_for_end()
            seconds.append(time.monotonic() - began)
            guarantee = self.ask("api/run")[1]["certificate"]["guarantee"] if job["state"] == "done" else job["message"]
            proved += guarantee == "invariant"
            self.wait(page, "studio.run?.final === true && studio.run.number === studio.state.run_version", 30)
            self.picture(page, name.replace(" ", "-").replace(",", ""))
            print(f"| {name} | {guarantee} | {seconds[-1]:.1f} | {learning:.0f} | {self.frames(page, 2.0):.0f} |", flush=True)
        print(f"\nmedian {statistics.median(seconds):.1f} s, longest {max(seconds):.1f} s; {proved} of {len(DRAWINGS)} `invariant`")
        self.assertEqual(proved, len(DRAWINGS))


if __name__ == "__main__":
    if studio_test.NO_BROWSER:
        sys.exit(f"studio_drawings: {studio_test.NO_BROWSER}")
    sys.argv.insert(2, "Drawings.test_ten_drawings")
    command_line.main()
