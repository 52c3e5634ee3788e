# SPDX-License-Identifier: BSD-3-Clause
"""The Python package s2nnds as it is installed: PYTHONPATH names its folder, or it comes from a wheel."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import torch

import s2nnds

# A training that is over in a second or two, and far from verified.
SMALL = {
    "name": "small",
    "data": {"source": "handwriting", "motion": "Sine"},
    "networks": {"f.hidden": [16, 16], "V.hidden": [16], "B.hidden": [16]},
    "problem.frame": "normalised",
    "problem.unsafe": {"type": "union", "of": [{"type": "ball", "center": [-0.5, 0.5], "radius": 0.1}]},
    "training": {"rounds": 3, "min_rounds": 3, "steps": 20, "samples": 2000, "rollout_points": 200, "enlarge_rounds": 0,
                 "warm_start": {"steps": 100, "attempts": 1}},
    "verification": {"method": "sampled", "sampled.samples": 2000},
    "evaluation": {"area_cells": 20, "grid_points": 21},
}  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return s2nnds.train(SMALL, out=tmp_path_factory.mktemp("runs") / "small.h5", seed=4)


@pytest.fixture
def points(run):
    return np.random.default_rng(1).uniform(-1.0, 1.0, (500, run.dimension))


def test_training_tells_of_its_rounds_and_returns_the_run(tmp_path):
    rounds, ticks = [], []
    done = threading.Event()

    def tick():
        while not done.wait(0.001):
            ticks.append(time.monotonic())

    other = threading.Thread(target=tick)
    other.start()
    begin = time.monotonic()
    run = s2nnds.train(SMALL, out=tmp_path / "a.h5", settings={"training.rounds": 4}, on_round=rounds.append)
    seconds = time.monotonic() - begin
    done.set()
    other.join()
    assert [row.round for row in rounds] == list(range(len(rounds))) and len(rounds) >= 4
    assert rounds[-1].mse == run.history["mse"][-1]
    assert set(rounds[0].counterexamples) >= {"lyapunov_decrease", "unsafe"}
    assert run.name == "small" and run.seed == 0 and run.config["training.rounds"] == "4"
    assert np.isfinite(run.evaluation["mse_train"])
    # The interpreter was free for the other thread: without that it would have run between the rounds alone.
    assert len(ticks) > 20 * len(rounds) or seconds < 0.2


def test_torch_keeps_its_threads(tmp_path):
    before = torch.get_num_threads()
    torch.set_num_threads(3)
    try:
        s2nnds.train(SMALL, out=tmp_path / "a.h5", settings={"training.rounds": 1, "training.min_rounds": 1})
        assert torch.get_num_threads() == 3
    finally:
        torch.set_num_threads(before)


def test_an_interrupt_keeps_the_checkpoint(tmp_path, run):
    script = (
        "import signal, sys, s2nnds\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a background job of a shell ignores it
        "try:\n"
        f"    s2nnds.train({SMALL!r}, out=sys.argv[1], seed=4, on_round=lambda row: print(row.round, flush=True))\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted')\n"
    )
    path = tmp_path / "broken.h5"
    with subprocess.Popen([sys.executable, "-c", script, path], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout.readline() == "0\n"
        child.send_signal(signal.SIGINT)
        told, _ = child.communicate(timeout=300)
    assert child.returncode == 0 and told.endswith("interrupted\n")
    broken = s2nnds.Run(path)
    assert 1 <= len(broken.history["round"]) < len(run.history["round"])
    whole = s2nnds.resume(broken)
    assert whole.certificate["weight_hash"] == run.certificate["weight_hash"]


def test_an_exception_of_on_round_ends_the_training(tmp_path):
    def stop(row):
        raise LookupError(f"in round {row.round}")

    with pytest.raises(LookupError, match="in round 0"):
        s2nnds.train(SMALL, out=tmp_path / "a.h5", on_round=stop)
    assert len(s2nnds.Run(tmp_path / "a.h5").history["round"]) == 1


def test_networks_answer_arrays_and_tensors_alike(run, points):
    for network in (run.f, run.V, run.B):
        value = network(points)
        assert isinstance(value, np.ndarray) and value.base is not None
        tensor = network(torch.from_numpy(points))
        assert isinstance(tensor, torch.Tensor) and tensor.dtype == torch.float64
        np.testing.assert_array_equal(tensor.numpy(), value)
        np.testing.assert_array_equal(network(points[7]), value[7])
        np.testing.assert_allclose(network.torch()(torch.from_numpy(points)).detach(), value, atol=1e-12)
        np.testing.assert_allclose(network(points[::2]), value[::2], atol=1e-15)  # not contiguous: that is copied
        step = 1e-6 * np.eye(run.dimension)[0]
        slope = (network(points + step) - network(points - step)) / 2e-6
        np.testing.assert_allclose(network.jacobian(points)[:, :, 0].squeeze(), slope, atol=1e-6)


def test_nothing_is_copied(run):
    from s2nnds._native import Evaluator

    network = Evaluator(run.f.layers, run.f.head, run.f.quadratic)
    x = np.zeros((4, run.dimension))
    assert not network.value(x).flags.owndata  # the result is C++'s own
    # What would have to be copied or converted first is refused, so what is taken is not.
    for other in (x[::2], np.asfortranarray(np.zeros((4, run.dimension))), x.astype(np.float32)):
        with pytest.raises(TypeError):
            network.value(other)


def test_the_policy_is_a_module_that_agrees_with_the_exported_one(run, tmp_path, points):
    policy = run.policy()
    assert isinstance(policy, torch.nn.Module)
    exported = torch.jit.load(s2nnds.export(run, tmp_path / "policy.pt", format="torchscript"))
    x = torch.from_numpy(1.2 * points * run.data.position_scale)
    with torch.no_grad():
        scale = policy(x).abs().max()
        assert (policy(x) - exported(x)).abs().max() < 1e-6 * scale
        assert (policy.barrier(x) - exported.barrier(x)).abs().max() < 1e-6
        assert (policy.lyapunov(x) - exported.lyapunov(x)).abs().max() < 1e-6
        assert torch.equal(policy.safe(x), exported.safe(x))
        assert policy(x.float()).dtype == torch.float32
    assert policy.guarantee == run.guarantee and policy.weight_hash == exported.weight_hash


def test_demonstrations_and_problem():
    data = s2nnds.demonstrations(SMALL)
    assert len(data.demonstrations) == 7 and data.test == [6]
    assert np.abs(np.vstack([d.position for d in data.normalized])).max() == pytest.approx(1.0)
    problem = s2nnds.Problem(SMALL)
    assert problem.dimension == 2 and "ball" in problem.unsafe
    np.testing.assert_allclose(problem.unsafe_level([[-0.5, 0.5], [-0.5, 0.8]]), [-0.1, 0.2], atol=1e-12)
    assert (problem.initial_level([d.position[0] for d in data.normalized]) <= 0).all()
    assert (problem.workspace_upper == 1.25).all()


def test_verify_evaluate_and_export(run, tmp_path):
    checked = s2nnds.verify(run, "sampled", samples=1000)
    assert {row["method"] for row in checked.certificate["conditions"]} == {"sampled"}
    assert s2nnds.evaluate(checked).evaluation["mse_test"] == run.evaluation["mse_test"]
    assert s2nnds.export(run) == os.path.splitext(run.path)[0] + ".h"
    for kind in ("header", "onnx"):
        path = s2nnds.export(run.path, tmp_path / kind, format=kind)
        assert os.path.getsize(path) > 1000


def test_what_cannot_be_used_is_told_in_one_line(tmp_path):
    def refusal(call):
        with pytest.raises(s2nnds.Error) as told:
            call()
        assert "\n" not in str(told.value)
        return str(told.value)

    assert "unknown" in refusal(lambda: s2nnds.train({**SMALL, "unknown": 3}, out=tmp_path / "a.h5"))
    assert "covers the goal" in refusal(lambda: s2nnds.Problem(SMALL, settings={"problem.unsafe.of.0.center": [0, 0]}))
    assert "nowhere.h5" in refusal(lambda: s2nnds.export("nowhere.h5"))
    assert "7" in refusal(lambda: s2nnds.export("nowhere.h5", format="7"))
    with pytest.raises(FileNotFoundError):
        s2nnds.train("nowhere.toml")


def test_the_program_lies_in_the_package(run, tmp_path):
    environment = {**os.environ, "S2NNDS_PYTHON": sys.executable}
    command = [sys.executable, "-m", "s2nnds"]
    told = subprocess.run([*command, "info", run.path], env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert told.returncode == 0 and "small (seed 4)" in told.stdout, told.stderr
    drawn = subprocess.run(
        [*command, "plot", run.path, "--out", tmp_path / "figures"], env=environment, cwd=tmp_path, capture_output=True
    )
    assert drawn.returncode == 0, drawn.stderr
    assert (tmp_path / "figures" / "phase_portrait.png").stat().st_size > 5000
