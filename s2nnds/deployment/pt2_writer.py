# SPDX-License-Identifier: BSD-3-Clause
"""Writes a policy as a program of torch.export: JSON on stdin (see pt2.cpp), the .pt2 file's bytes on stdout.

What goes wrong is the last line on stderr; exit code 2 if this Python lacks a torch that can write it.
"""

import sys

sys.path = [folder for folder in sys.path if folder]  # not what lies where the user happens to be

import io  # noqa: E402
import json  # noqa: E402
import os  # noqa: E402

EXPECTED = "expected torch 2.6 or newer"


def import_torch():
    python = f"found Python {sys.version.split()[0]}"
    try:
        import torch
    except ImportError as error:
        missing = isinstance(error, ModuleNotFoundError) and error.name == "torch"
        reason = "without torch" if missing else f"whose torch cannot be imported ({error})"
        refuse(f"{python} {reason}, {EXPECTED}")
    version = torch.__version__
    if tuple(int(part) for part in version.split("+")[0].split(".")[:2]) < (2, 6):
        refuse(f"{python} with torch {version}, {EXPECTED}")
    return torch


def refuse(line):
    print(" ".join(line.split()), file=sys.stderr)
    sys.exit(2)


def policy_module(torch, policy):
    """position [N, n] -> velocity, lyapunov, barrier and safe of the policy, computed in float64."""
    linear, functional = torch.nn.functional.linear, torch.nn.functional
    activations = {
        "identity": lambda z: z,
        "tanh": torch.tanh,
        "elu": functional.elu,
        "softplus": lambda z: functional.softplus(z, 1, 40),  # linear only where float64 cannot tell it
        "silu": functional.silu,
        "sine": torch.sin,
    }

    class Module(torch.nn.Module):
        def __init__(self):
            super().__init__()
            info, n = policy["info"], policy["info"]["dimension"]
            # An array, not a number: an operation with it makes float64 of positions in float32.
            self.store("position_scale", [info["position_scale"]] * n)
            self.store("goal", info["goal"])
            self.store("lower", info["workspace"][:n])
            self.store("upper", info["workspace"][n:])
            for name, network in policy["networks"].items():
                for k, layer in enumerate(network["layers"]):
                    self.store(f"{name}_weight_{k}", layer["weight"])
                    self.store(f"{name}_bias_{k}", layer["bias"])
                self.store(f"{name}_origin", network["origin"])

        def store(self, name, values):
            if values is None:  # no buffer then: torch.export miscounts those that are None
                setattr(self, name, None)
            else:
                self.register_buffer(name, torch.tensor(values, dtype=torch.float64))

        def network(self, name, z):
            network, a = policy["networks"][name], z
            for k, layer in enumerate(network["layers"]):
                a = linear(a, getattr(self, f"{name}_weight_{k}"), getattr(self, f"{name}_bias_{k}"))
                a = activations[layer["activation"]](a)
            if network["head"] == "plain":
                return a
            a = a - getattr(self, f"{name}_origin")
            if network["head"] == "zero_at_origin":
                return a
            return ((a * a).sum(1) + network["quadratic"] * (z * z).sum(1)).unsqueeze(1)

        def forward(self, position):
            z = (position - self.goal) / self.position_scale
            barrier = self.network("B", z).squeeze(1)
            inside = ((position >= self.lower) & (position <= self.upper)).all(1)
            return {
                "velocity": self.network("f", z) * policy["info"]["velocity_scale"],
                "lyapunov": self.network("V", z).squeeze(1),
                "barrier": barrier,
                "safe": (barrier <= -policy["info"]["barrier_float64_error"]) & inside,
            }

    return Module().eval()


def main():
    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no part of the file
    policy = json.load(sys.stdin)
    torch = import_torch()
    torch.set_num_threads(1)
    example = torch.zeros(2, policy["info"]["dimension"], dtype=torch.float64)
    rows = torch.export.Dim("N", min=0)
    program = torch.export.export(policy_module(torch, policy), (example,), dynamic_shapes={"position": {0: rows}})
    file = io.BytesIO()
    torch.export.save(program, file, extra_files={"policy.json": json.dumps(policy["info"])})
    answer.write(file.getvalue())
    answer.close()


main()
