#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""`s2nnds studio` and `s2nnds report`: the server as a foreign program meets it, and the page in a real browser.

The browser is Debian's chromium with its driver and python3-selenium; without them these tests are skipped.
S2NNDS_SCREENSHOTS names a folder for pictures of the page.
"""

import http.client
import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import unittest
import urllib.error
import urllib.parse
import urllib.request

import command_line
from command_line import ProgramTest, start

try:
    from selenium import webdriver
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    NO_BROWSER = "" if shutil.which("chromium") and shutil.which("chromedriver") else "found no chromium with chromedriver"
except ImportError:
    NO_BROWSER = "found no python3-selenium"

PICTURES = os.environ.get("S2NNDS_SCREENSHOTS", "")
REFERENCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../experiments/studio/page")

# A drawing as the page sends it: three strokes along an arc that ends at (0.8, 0.3).
def arc(shift):
    rows = []
    for k in range(121):
        u = k / 120
        s = u**3 * (10 - 15 * u + 6 * u * u)
        rows.append((2.4 * u, 0.15 + 0.65 * s, 0.3 + shift * (1 - s) + 0.22 * math.sin(math.pi * s)))
    t, x, y = map(list, zip(*rows))
    return {"t": t, "x": x, "y": y}


def drawing(**changes):
    return {
        "name": "motion",
        "unit": "m",
        "field": [0, 0, 1, 0.75],
        "seed": 0,
        "strokes": [arc(shift) for shift in (-0.04, 0.0, 0.04)],
        "obstacles": [{"type": "ball", "center": [0.47, 0.2], "radius": 0.09}],
        "initial": None,
        **changes,
    }


class StudioTest(ProgramTest):
    """A studio for each test that asks for one."""

    def studio(self, *words, folder="studio"):
        process = start("studio", *words, "--folder", folder, "--json", cwd=self.folder)
        self.addCleanup(self.end, process)
        line = process.stdout.readline()
        self.assertTrue(line, process.stderr.read() if not line else "")
        self.address = json.loads(line)["address"]
        self.host = urllib.parse.urlsplit(self.address).netloc
        self.token = self.address.split("/")[3]
        return process

    def end(self, process):
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
        process.communicate(timeout=20)

    def ask(self, path, body=None, headers=None, method=None, whole=False):
        """(status, JSON or bytes) of a request below the studio's address, or at a whole path."""
        url = f"http://{self.host}{path}" if whole else self.address + path
        request = urllib.request.Request(url, data=body, headers={"Content-Type": "application/json", **(headers or {})}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                status, got = answer.status, answer.read()
        except urllib.error.HTTPError as error:
            status, got = error.code, error.read()
        try:
            return status, json.loads(got)
        except ValueError:
            return status, got

    def tell(self, path, value=None, code=200):
        status, got = self.ask(path, json.dumps(value).encode(), method="POST")
        self.assertEqual(status, code, got)
        return got

    def wait_for_end(self, seconds=400):
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            job = self.ask("api/state")[1]["job"]
            if job["state"] != "running":
                return job
            time.sleep(0.1)
        self.fail("it went on for too long")


class ServerTest(StudioTest):
    def test_what_is_refused(self):
        self.studio()
        self.assertEqual(self.ask("")[0], 200)
        # Another token, no token.
        for path in ("/", "/api/state", "/" + "0" * 32 + "/", "/" + "0" * 32 + "/api/state", f"/{self.token[:-1]}/"):
            status, got = self.ask(path, whole=True)
            self.assertEqual(status, 403, path)
            self.assertIn("token", got["error"])
        # Pages from elsewhere, and this address under another name.
        for headers in ({"Origin": "http://evil.example"}, {"Origin": "null"}, {"Host": "evil.example"}, {"Host": "127.0.0.1:1"}):
            self.assertEqual(self.ask("api/state", headers=headers)[0], 403, headers)
            self.assertEqual(self.ask("api/learn", b"", headers, "POST")[0], 403, headers)
        self.assertEqual(self.ask("api/state", headers={"Origin": f"http://{self.host}"})[0], 200)
        # No file but the page's.
        for path in ("../lock", "..%2flock", "%2e%2e/%2e%2e/etc/passwd", "studio.json", "//etc/passwd", "report.html", "api/nothing",
                     "studio.css/../../lock", "..\\lock"):
            status, got = self.ask(path)
            self.assertIn(status, (403, 404), path)
            self.assertNotIn(b"root:", json.dumps(got).encode())
        self.assertEqual(self.ask("api/download?kind=../../etc/passwd")[0], 409)

    def test_bad_bodies(self):
        self.studio()
        for body in (b"", b"{", b"[1, 2", b"\xff\xfe", b'{"strokes": ', b"[" * 100000):
            status, got = self.ask("api/drawing", body, method="POST")
            self.assertEqual(status, 400, body[:20])
            self.assertIn("JSON", got["error"])
        for change, word in [({"strokes": 1}, "strokes"), ({"strokes": [{"t": [0, 1], "x": [0], "y": [0, 1]}]}, "stroke"),
                             ({"obstacles": [{"type": "mesh"}]}, "shape"), ({"obstacles": [{"type": "ball", "center": [1e99, 0], "radius": 1}]}, "center"),
                             ({"name": "../x"}, "name"), ({"name": 7}, "name"), ({"field": [1, 1, 0, 0]}, "field"), ({"seed": -1}, "seed"),
                             ({"unit": 'm"\n[x]'}, "unit"), ({"strokes": [arc(0)] * 65}, "strokes")]:
            got = self.tell("api/drawing", drawing(**change), 422)
            self.assertIn(word, got["error"])
        self.assertEqual(self.tell("api/learn", code=409)["error"], "there is no demonstration yet")
        for name, body in [("a.csv", b"a,b\n1,x\n"), ("a.h5", b"no file"), ("a.npy", b"\x93NUMPY"), ("../../a.sh", b"x"), ("a.mat", b"MATLAB 5.0")]:
            status, got = self.ask(f"api/file?name={urllib.parse.quote(name)}", body, method="POST")
            self.assertEqual(status, 422, name)
            self.assertEqual(got["error"].count("\n"), 0)
        self.assertEqual(self.ask("api/state")[0], 200)

    def test_large_bodies(self):
        self.studio()
        status, got = self.ask("api/file?name=a.csv", b"0" * 100_000_000, method="POST")
        self.assertEqual(status, 413)
        self.assertIn("16 MB", got["error"])
        # Of a size that is not told.
        connection = http.client.HTTPConnection(self.host, timeout=20)
        connection.request("POST", f"/{self.token}/api/drawing", body=(b"0" * 1000 for _ in range(10)), encode_chunked=True,
                           headers={"Transfer-Encoding": "chunked"})
        self.assertEqual(connection.getresponse().status, 411)
        connection.close()
        self.assertEqual(self.ask("api/state")[0], 200)

    def test_a_second_studio(self):
        self.studio()
        port = self.host.split(":")[1]
        self.assert_refused(self.call("studio", "--folder", "studio"), "another studio is open in this folder")
        self.assert_refused(self.call("studio", "--folder", "other", "--port", port), "127.0.0.1", port)

    def test_previews_say_what_is_impossible(self):
        self.studio()
        self.tell("api/drawing", drawing())
        found = self.ask("api/preview")[1]
        self.assertEqual((found["refusals"], found["warnings"]), ([], []))
        self.assertEqual(len(found["clearances"]), 3)
        self.assertEqual(found["initial"]["type"], "box")
        self.tell("api/drawing", drawing(obstacles=[{"type": "ball", "center": [0.8, 0.3], "radius": 0.05}]))
        self.assertIn("goal", self.ask("api/preview")[1]["refusals"][0])
        self.tell("api/drawing", drawing(obstacles=[{"type": "box", "lower": [0.4, -1], "upper": [0.5, 2]}]))
        self.assertIn("cuts the goal off", " ".join(self.ask("api/preview")[1]["warnings"]))

    def test_recordings_are_drawings(self):
        self.studio()
        rows = ["demo,t,x,y"] + [f"{k},{t / 50},{200 + 3 * t + k},{100 + math.sin(t / 30)}" for k in range(2) for t in range(100)]
        status, got = self.ask("api/file?name=r.csv", "\n".join(rows).encode(), method="POST")
        self.assertEqual(status, 200, got)
        self.assertEqual(got["opened"], "demonstrations")
        self.assertEqual(len(got["drawing"]["strokes"]), 2)
        low, high = got["drawing"]["field"][0], got["drawing"]["field"][2]
        self.assertTrue(low < 200 and high > 498)
        self.tell("api/drawing", got["drawing"])
        self.assertEqual(self.ask("api/preview")[1]["refusals"], [])

    def child_of(self, process):
        out = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, text=True).stdout.split()
        return int(out[0]) if out else None

    def is_over(self, pid):
        try:
            with open(f"/proc/{pid}/stat") as file:
                return file.read().rpartition(")")[2].split()[0] == "Z"
        except FileNotFoundError:
            return True

    def wait_for_child(self, process):
        for _ in range(200):
            if child := self.child_of(process):
                return child
            time.sleep(0.05)
        self.fail("found no child")

    def test_children_end_one_way_or_another(self):
        process = self.studio()
        self.tell("api/drawing", drawing())
        self.tell("api/learn")
        self.assertIn("being learned", self.tell("api/learn", code=409)["error"])
        os.kill(self.wait_for_child(process), signal.SIGKILL)
        job = self.wait_for_end()
        self.assertEqual(job["state"], "failed")
        self.assertIn("signal 9", job["message"])
        self.tell("api/learn")
        self.wait_for_child(process)
        self.tell("api/cancel")
        self.assertEqual(self.wait_for_end(20)["state"], "cancelled")
        # With the studio, also where that is killed.
        for how in (signal.SIGTERM, signal.SIGKILL):
            self.tell("api/learn")
            child = self.wait_for_child(process)
            process.send_signal(how)
            process.wait(timeout=20)
            for _ in range(100):
                if self.is_over(child):
                    break
                time.sleep(0.05)
            else:
                self.fail("the child outlived its studio")
            process = self.studio()
            self.assertEqual(len(self.ask("api/state")[1]["drawing"]["strokes"]), 3)

    def test_learn_adapt_and_reproduce(self):
        self.studio()
        self.tell("api/drawing", drawing())
        self.tell("api/learn")
        job = self.wait_for_end()
        self.assertEqual(job["state"], "done", job)
        run = self.ask("api/run")[1]
        self.assertEqual(run["certificate"]["guarantee"], "invariant")
        self.tell("api/drawing", drawing(obstacles=[{"type": "ball", "center": [0.5, 0.18], "radius": 0.09}]))
        self.tell("api/adapt")
        job = self.wait_for_end()
        self.assertEqual(job["state"], "done", job)
        adapted = self.ask("api/run")[1]
        self.assertEqual(adapted["certificate"]["guarantee"], "invariant")
        self.assertEqual(adapted["obstacles"][0]["center"], [0.5, 0.18])
        for kind in ("run", "header", "onnx", "torchscript", "report", "configuration", "demonstrations"):
            status, got = self.ask(f"api/download?kind={kind}")
            self.assertEqual(status, 200, (kind, got))
            self.assertGreater(len(got), 100)
            if kind == "report":
                self.assertLess(len(got), 2_000_000)
        # The configuration and the demonstrations make the first run once more.
        os.makedirs(self.path("again"))
        for name in ("motion.toml", "demonstrations.csv"):
            shutil.copy(self.path(f"studio/{name}"), self.path(f"again/{name}"))
        code, out, err = self.call("train", "again/motion.toml", "--data", "again", "--until", "certified", "--out", "again.h5", "--json")
        self.assertEqual(code, 0, err)
        self.assertEqual(json.loads(out.strip().split("\n")[-1])["weight_hash"], run["certificate"]["weight_hash"])


@unittest.skipIf(NO_BROWSER, NO_BROWSER)
class PageTest(StudioTest):
    def browser(self, width=1280, height=860, dark=False):
        options = webdriver.ChromeOptions()
        for word in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars", f"--window-size={width},{height}"):
            options.add_argument(word)
        if dark:
            options.add_argument("--force-dark-mode")
        self.downloads = self.path("downloads")
        os.makedirs(self.downloads, exist_ok=True)
        options.add_experimental_option("prefs", {"download.default_directory": self.downloads})
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        options.binary_location = shutil.which("chromium")
        from selenium.webdriver.chrome.service import Service

        page = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        self.addCleanup(page.quit)
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        if dark:
            page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark"}]})
        return page

    def picture(self, page, name):
        if PICTURES:
            os.makedirs(PICTURES, exist_ok=True)
            whole = page.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": True})
            import base64

            with open(os.path.join(PICTURES, name + ".png"), "wb") as file:
                file.write(base64.b64decode(whole["data"]))

    def wait(self, page, condition, seconds=400):
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            if page.execute_script(f"return {condition}"):
                return
            time.sleep(0.1)
        said = page.execute_script("return [document.getElementById('progress')?.textContent, document.getElementById('message')?.textContent]")
        state = page.execute_script("return JSON.stringify([window.studio?.state?.job, window.studio?.state?.run_version, window.studio?.state?.drawing?.strokes?.length, studio.run && {final: studio.run.final, number: studio.run.number}, studio.sketch?.drawing?.strokes?.length, document.getElementById('guarantee')?.textContent])")
        self.fail(f"waited in vain for {condition}: {said}, {state[:1500]}")

    def tool(self, page, name):
        page.find_element(By.CSS_SELECTOR, f'[data-tool="{name}"]').click()

    def drag(self, page, places, pause=12):
        """A drag through places of the drawing."""
        pixels = page.execute_script(
            "const r = studio.portrait.box.getBoundingClientRect();"
            "return arguments[0].map(([x, y]) => { const [a, b] = studio.portrait.place(x, y); return [a - r.width / 2, b - r.height / 2]; })", places)
        box = page.find_element(By.ID, "portrait")
        chain = ActionChains(page, duration=pause)
        chain.move_to_element_with_offset(box, *map(round, pixels[0])).click_and_hold()
        for pixel in pixels[1:]:
            chain.move_to_element_with_offset(box, *map(round, pixel))
        chain.release().perform()

    def touch(self, page, places):
        """A finger through places of the drawing, by the browser's own touch events."""
        pixels = page.execute_script(
            "const r = studio.portrait.box.getBoundingClientRect();"
            "return arguments[0].map(([x, y]) => { const [a, b] = studio.portrait.place(x, y); return [r.left + a, r.top + b]; })", places)
        page.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
        for k, (x, y) in enumerate(pixels):
            kind = "touchMove" if k else "touchStart"
            page.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y}]})
            time.sleep(0.012)
        page.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})

    def strokes(self, page):
        self.tool(page, "stroke")
        for shift in (-0.04, 0.0, 0.04):
            path = arc(shift)
            self.drag(page, list(zip(path["x"], path["y"]))[::2])

    def no_complaints(self, page):
        found = [entry for entry in page.get_log("browser") if entry["level"] == "SEVERE"]
        self.assertEqual(found, [])

    def test_draw_learn_push_adapt_download_load(self):
        self.studio()
        page = self.browser()
        page.get(self.address)
        self.wait(page, "window.studio?.state", 20)
        self.picture(page, "desktop-empty")
        self.strokes(page)
        self.tool(page, "ball")
        self.drag(page, [(0.47, 0.2), (0.5, 0.2), (0.56, 0.2)])
        self.assertEqual(page.execute_script("return [studio.sketch.drawing.strokes.length, studio.sketch.drawing.obstacles.length]"), [3, 1])
        self.wait(page, "studio.state && document.getElementById('learn').disabled === false", 20)
        time.sleep(0.6)
        self.picture(page, "desktop-drawn")
        began = time.monotonic()
        page.find_element(By.ID, "learn").click()
        self.wait(page, "studio.run && studio.run.rounds >= 1")
        self.picture(page, "desktop-learning")
        page.refresh()  # in mid-training; the state is on the server
        self.wait(page, "window.studio?.state?.job && studio.state.job.state !== 'running' && studio.run?.final === true")
        print(f"certificate after {time.monotonic() - began:.1f} s", file=sys.stderr)
        self.assertEqual(page.execute_script("return studio.run.certificate.guarantee"), "invariant")
        self.assertIn("Proved", page.find_element(By.ID, "guarantee").text)
        self.assertIn("does not say", page.find_element(By.ID, "statement-section").text)
        time.sleep(1.5)
        self.picture(page, "desktop-certified")
        print(f"frames a second: {page.execute_script('return studio.portrait.rate()'):.0f}", file=sys.stderr)
        # A start, a push, the end.
        self.tool(page, "play")
        page.execute_script("studio.player.advance = () => {}")  # it stands still, so that it is hit on a slow machine too
        self.drag(page, [(0.2, 0.5), (0.2, 0.5)])
        place = page.execute_script("return studio.player.x")
        self.drag(page, [place, (place[0] + 0.02, place[1] - 0.05), (0.5, 0.55)])
        self.assertEqual(page.execute_script("return studio.player.state"), "running")
        for found, wanted in zip(page.execute_script("return studio.player.x"), (0.5, 0.55)):
            self.assertAlmostEqual(found, wanted, delta=0.01)
        page.execute_script("delete studio.player.advance")
        time.sleep(0.5)
        self.picture(page, "desktop-pushed")
        self.wait(page, "studio.player.state === 'arrived'", 60)
        # The obstacle moves: what was proved is void until it is proved anew.
        self.tool(page, "select")
        self.drag(page, [(0.47, 0.2), (0.49, 0.19), (0.5, 0.18)])
        self.wait(page, "!document.getElementById('adapt').hidden", 20)
        self.assertIn("void", page.find_element(By.ID, "guarantee").text)
        self.assertFalse(page.find_element(By.ID, "downloads").is_displayed())
        self.picture(page, "desktop-void")
        page.find_element(By.ID, "adapt").click()
        self.wait(page, "studio.state.job.kind === 'adapt' && studio.state.job.state !== 'running' && studio.run?.final === true")
        self.wait(page, "studio.run.number === studio.state.run_version", 20)
        self.assertEqual(page.execute_script("return [studio.state.job.state, studio.run.certificate.guarantee]"), ["done", "invariant"])
        time.sleep(0.5)
        self.picture(page, "desktop-adapted")
        page.find_element(By.LINK_TEXT, "Run file").click()
        stored = os.path.join(self.downloads, "motion.h5")
        for _ in range(100):
            if os.path.exists(stored):
                break
            time.sleep(0.1)
        self.assertEqual(self.call("info", stored)[0], 0)
        hash_of = page.execute_script("return studio.run.certificate.weight_hash")
        page.find_element(By.ID, "clear").click()
        self.wait(page, "document.getElementById('guarantee').textContent.includes('void')", 20)
        page.find_element(By.ID, "file").send_keys(stored)
        self.wait(page, "studio.sketch.drawing.strokes.length === 3 && studio.run?.final && document.getElementById('guarantee').textContent.includes('Proved')", 30)
        self.assertEqual(page.execute_script("return studio.run.certificate.weight_hash"), hash_of)
        self.values_agree(page, stored)
        self.report_opens(page, stored)
        self.no_complaints(page)

    def values_agree(self, page, stored):
        """f, V and B in the page and in the program's Python package, in normalised units."""
        import numpy as np
        import s2nnds

        run = s2nnds.Run(stored)
        z = np.random.default_rng(0).uniform(-1.2, 1.2, (200, 2))
        got = page.execute_script(
            "const m = new studio.portrait.motion.constructor(studio.run);"
            "return arguments[0].map((z) => [...m.f.value(z), m.V.value(z)[0], m.B.value(z)[0], ...m.V.valueAndDerivative(z, [0.3, -0.7])[1]])", z.tolist())
        got = np.array(got)
        want = np.column_stack([run.f(z), run.V(z), run.B(z), run.V.gradient(z) @ np.array([0.3, -0.7])])
        worst = float(np.abs(got - want).max())
        print(f"largest difference of the page's f, V, B: {worst:.1e}", file=sys.stderr)
        self.assertLess(worst, 1e-6)

    def report_opens(self, page, stored):
        out = self.path("report.html")
        code, _, err = self.call("report", stored, "--out", out)
        self.assertEqual(code, 0, err)
        print(f"report: {os.path.getsize(out) / 1e6:.2f} MB", file=sys.stderr)
        self.assertLess(os.path.getsize(out), 2_000_000)
        with open(out, encoding="utf-8") as file:
            self.assertNotRegex(file.read(), r"(src|href)=|https?://(?!www\.w3\.org)")
        page.get("file://" + out)
        time.sleep(1.5)
        self.assertIn("Proved", page.find_element(By.ID, "guarantee").text)
        self.picture(page, "desktop-report")

    def test_phone_and_dark_and_keys(self):
        self.studio()
        page = self.browser(390, 844, dark=True)
        page.get(self.address)
        self.wait(page, "window.studio?.state", 20)
        self.assertLessEqual(page.execute_script("return document.documentElement.scrollWidth"), 390)
        # Keys alone: a demonstration through three places, an obstacle, undo.
        field = page.find_element(By.ID, "portrait")
        page.execute_script("studio.portrait.box.focus()")
        chain = ActionChains(page)
        chain.send_keys(*[Keys.ARROW_LEFT] * 12, " ", *[Keys.ARROW_RIGHT] * 12, *[Keys.ARROW_UP] * 6, " ", *[Keys.ARROW_RIGHT] * 12,
                        *[Keys.ARROW_DOWN] * 6, Keys.ENTER)
        chain.send_keys("c", *[Keys.ARROW_LEFT] * 12, *[Keys.ARROW_DOWN] * 3, Keys.ENTER).perform()
        self.assertEqual(page.execute_script("return [studio.sketch.drawing.strokes.length, studio.sketch.drawing.obstacles.length]"), [1, 1])
        ActionChains(page).key_down(Keys.CONTROL).send_keys("z").key_up(Keys.CONTROL).perform()
        self.assertEqual(page.execute_script("return studio.sketch.drawing.obstacles.length"), 0)
        ActionChains(page).key_down(Keys.CONTROL).key_down(Keys.SHIFT).send_keys("z").key_up(Keys.SHIFT).key_up(Keys.CONTROL).perform()
        self.assertEqual(page.execute_script("return studio.sketch.drawing.obstacles.length"), 1)
        time.sleep(0.8)
        self.picture(page, "phone-dark-drawn")
        # A finger draws another demonstration, and the page does not scroll under it.
        self.tool(page, "stroke")
        page.execute_script("studio.portrait.box.scrollIntoView({block: 'center'})")
        top = page.execute_script("return scrollY")
        path = arc(0.0)
        self.touch(page, list(zip(path["x"], path["y"]))[::3])
        self.assertEqual(page.execute_script("return [studio.sketch.drawing.strokes.length, scrollY]"), [2, top])
        field.send_keys(Keys.TAB)
        self.assertNotEqual(page.execute_script("return document.activeElement.id"), "portrait")
        self.labels_and_contrast(page)
        self.no_complaints(page)

    def labels_and_contrast(self, page):
        """Everything that takes the focus has a name, and words differ from their ground by 4.5 or more (WCAG AA)."""
        nameless = page.execute_script(
            "return [...document.querySelectorAll('button, input, select, a, canvas[tabindex], [role=application]')]"
            ".filter((e) => !(e.textContent.trim() || e.getAttribute('aria-label') || e.labels?.length)).map((e) => e.outerHTML)")
        self.assertEqual(nameless, [])
        poor = page.execute_script("""
          const rgb = (text) => text.match(/[\\d.]+/g).map(Number);
          const light = ([r, g, b]) => [r, g, b].map((v) => v / 255).map((v) => (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
            .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
          const ground = (e) => { for (; e; e = e.parentElement) { const c = rgb(getComputedStyle(e).backgroundColor); if (c.length < 4 || c[3] > 0) return c; } return [255, 255, 255]; };
          return [...document.querySelectorAll('button:not(:disabled), p, li, h1, h2, label, a')].filter((e) => e.offsetParent && e.textContent.trim()).map((e) => {
            const [a, b] = [light(rgb(getComputedStyle(e).color)), light(ground(e))];
            return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), e.textContent.trim().slice(0, 40)];
          }).filter(([ratio]) => ratio < 4.5)""")
        self.assertEqual(poor, [])


if __name__ == "__main__":
    command_line.main()
