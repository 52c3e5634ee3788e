# SPDX-License-Identifier: BSD-3-Clause
"""The regressions of experiments/baselines.py, and the figures that it gives them, where the answers are known."""

import os
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../experiments"))

try:
    import numpy as np
    import sklearn  # noqa: F401
    import baselines
except ImportError as error:
    print(f"skipped: {error}; install Debian's python3-sklearn")
    sys.exit(77)


def contraction(x):
    return -x


def decay(start):
    """A motion of xdot = -x."""
    time = np.linspace(0.0, 4.0, 400)
    position = np.exp(-time)[:, None] * np.array(start)
    return {"time": time, "position": position, "velocity": -position}


DECAYS = [decay((np.cos(a), np.sin(a))) for a in np.linspace(0.0, 1.5, 7)]


class Regressions(unittest.TestCase):
    def test_both_find_a_linear_field_along_the_demonstrations(self):
        for name, method in baselines.METHODS.items():
            f = baselines.fit(method, DECAYS[:3] + DECAYS[4:])
            self.assertLess(baselines.squared_error(f, DECAYS[3:4]), 0.01, name)

    def test_a_gaussian_process_of_one_sample(self):
        f = baselines.GaussianProcess(np.zeros((1, 2)), np.array([[2.0, 4.0]]), (0.5, 1.0))
        np.testing.assert_allclose(f(np.array([[0.0, 0.5]])), np.exp(-0.5) * np.array([[1.0, 2.0]]))

    def test_a_mixture_of_one_gaussian_is_the_linear_regression(self):
        random = np.random.default_rng(0)
        x = random.normal(size=(500, 2))
        f = baselines.GaussianMixture(x, x @ np.array([[1.0, 2.0], [3.0, 4.0]]) + 5.0, 1)
        np.testing.assert_allclose(f(np.array([[1.0, 1.0]])), [[9.0, 11.0]], atol=1e-3)


class Figures(unittest.TestCase):
    def test_squared_error(self):
        self.assertAlmostEqual(baselines.squared_error(lambda x: -x + np.array([0.3, 0.4]), DECAYS[:2]), 0.25)

    def test_dtw(self):
        ramp, fine = np.array([[0.0], [2.0]]), np.array([[0.0], [1.0], [2.0]])
        self.assertAlmostEqual(baselines.dtw(ramp, fine), 1.0 / 3.0)
        self.assertAlmostEqual(baselines.dtw(fine, ramp), 1.0 / 3.0)
        self.assertAlmostEqual(baselines.dtw(np.zeros((1, 2)), np.array([[3.0, 4.0]] * 2)), 5.0)

    def test_a_motion_is_followed(self):
        path = baselines.rolled_out(contraction, DECAYS[0])
        np.testing.assert_allclose(path, DECAYS[0]["position"], atol=1e-5)

    def test_shares(self):
        free = {"unsafe": lambda x: np.ones(len(x)), "workspace": 1.0, "reach": 0.99}
        self.assertEqual(baselines.shares(contraction, free), (1.0, 1.0))
        self.assertEqual(baselines.shares(lambda x: x, free), (0.0, 0.0))
        self.assertEqual(baselines.shares(lambda x: 0.0 * x, free), (0.0, 1.0))
        # A ball casts a shadow: the cone behind it and its own front half.
        ball = {"unsafe": baselines.level_of({"type": "ball", "center": [0.5, 0.0], "radius": 0.2}, "")}
        arrive, safe = baselines.shares(contraction, {**free, **ball})
        self.assertEqual(arrive, safe)
        self.assertTrue(0.85 < safe < 0.95, safe)

    def test_levels(self):
        x = np.array([[0.5, 2.0]])
        levels = [
            ({"type": "box", "lower": [0.0, 0.0], "upper": [1.0, np.inf]}, -0.5),
            ({"type": "expression", "level": "max(x, -y) + 2*x^2"}, 1.0),
            ({"type": "polynomial", "level": "1.5e0*x*y - 1", "sign": -1}, -0.5),
        ]
        for region, level in levels:
            self.assertAlmostEqual(baselines.level_of(region, "")(x)[0], level)
        with self.assertRaises(SystemExit):
            baselines.level_of({"type": "expression", "level": "__import__('os')"}, "")


if __name__ == "__main__":
    unittest.main()
