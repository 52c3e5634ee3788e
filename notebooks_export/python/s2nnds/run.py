# SPDX-License-Identifier: BSD-3-Clause
"""Reads the run files of s2nnds (HDF5, schema 5) with numpy and h5py alone.

    from s2nnds import Run
    run = Run("sine.h5")
    run.name, run.guarantee               # "Sine", "invariant"
    run.f(x), run.V(x), run.B(x)          # x [N, n] or [n], normalised and goal-centred: a NumPy array or torch tensor
    run.V.gradient(x), run.f.jacobian(x)  # [N, n], [N, m, n]
    run.f.torch()                         # the same as a torch.nn.Module
    run.policy()                          # the policy as a torch.nn.Module, in the data's unit
    run.shield(x, wanted)                 # any wanted velocity made safe, where the certificate has a shield
    run.scene_range().velocity(p, by)     # where the obstacle is displaced, without a new proof
    run.velocity(p)                       # in the data's unit and frame
    run.phase_start                       # of states (x, s) with a phase s: where s starts
    run.pose_velocity(p, q)               # of poses: velocity and angular velocity [rad/s], in the data's frame
    run.history["mse"]                    # [rounds]
    run.data.demonstrations               # as read: in the data's unit and frame, time in s
    run.data.normalized                   # the same, normalised: what training saw
    run.data.to_data(x)                   # normalised positions in the data's unit and frame
    run.in_data_unit()                    # the run with all its positions like that, for figures

Networks, sets, rollouts and the grid are in normalised units, with the goal at the origin: (position - goal) /
position_scale, velocity / velocity_scale, (time - first time) * velocity_scale / position_scale.
"""

import copy
import hashlib
import struct
import sys
import tomllib
from dataclasses import dataclass, field, replace

import h5py
import numpy as np

try:
    from ._native import Evaluator
except ImportError:  # not compiled: NumPy evaluates the networks
    Evaluator = None

SCHEMA_VERSION = 5


class RunError(Exception):
    """The file is not a run file that this reader understands; the message is one line."""


def _sigmoid(z):
    return 0.5 * (1.0 + np.tanh(0.5 * z))


# name -> (value, derivative)
ACTIVATIONS = {
    "identity": (lambda z: z, np.ones_like),
    "tanh": (np.tanh, lambda z: 1.0 - np.tanh(z) ** 2),
    "elu": (
        lambda z: np.where(z > 0.0, z, np.expm1(np.minimum(z, 0.0))),
        lambda z: np.where(z > 0.0, 1.0, np.exp(np.minimum(z, 0.0))),
    ),
    "softplus": (lambda z: np.logaddexp(0.0, z), _sigmoid),
    "silu": (lambda z: z * _sigmoid(z), lambda z: _sigmoid(z) * (1.0 + z * (1.0 - _sigmoid(z)))),
    "sine": (np.sin, np.cos),
}


@dataclass
class Network:
    """y(x) made of layers N(x) and a head: plain y = N(x); zero_at_origin y = N(x) - N(0);
    squared_norm y = |N(x) - N(0)|^2 + quadratic |x|^2; diffeomorphism y = |x + N(x) - N(0)|^2.

    Each layer is (weight [out, in], bias [out], name of the activation).
    """

    layers: list
    head: str = "plain"
    quadratic: float = 0.0
    unbiased: frozenset = frozenset()  # the layers, from 0, whose bias the file leaves out: it is 0
    _evaluator: object = field(default=None, init=False, repr=False, compare=False)  # compiled, made when first needed

    @property
    def input_dimension(self):
        return self.layers[0][0].shape[1]

    @property
    def output_dimension(self):
        return 1 if self.head in ("squared_norm", "diffeomorphism") else self.layers[-1][0].shape[0]

    def _stack(self, x, with_jacobian):
        """N(x) [N, out] and, if asked for, its Jacobian [N, out, n]."""
        value, jacobian = x, None
        for weight, bias, activation in self.layers:
            act, slope = ACTIVATIONS[activation]
            z = value @ weight.T + bias
            if with_jacobian:
                jacobian = weight[None] if jacobian is None else weight @ jacobian
                jacobian = slope(z)[:, :, None] * jacobian
            value = act(z)
        return value, jacobian

    def _points(self, x):
        x = np.asarray(x, dtype=float)
        if x.ndim not in (1, 2) or x.shape[-1] != self.input_dimension:
            raise ValueError(
                f"points: found shape {x.shape}, expected [N, {self.input_dimension}] "
                f"or [{self.input_dimension}]"
            )
        return np.atleast_2d(x), x.ndim == 1

    def _at_zero(self):
        return self._stack(np.zeros((1, self.input_dimension)), False)[0]

    def __call__(self, x):
        """[N, m] for points [N, n]; [N] where m = 1. A single point [n] gives [m] or a number.

        A torch tensor gives a tensor. Double precision, C order, on the processor: then x is read where it lies and
        nothing is copied. Derivatives are not followed (see torch()).
        """
        torch = sys.modules.get("torch")
        if torch is not None and isinstance(x, torch.Tensor):
            return torch.as_tensor(self(x.detach().numpy(force=True)))
        points, single = self._points(x)
        y = self._value(points)
        if self.output_dimension == 1:
            y = y[:, 0]
        return y[0] if single else y

    def _value(self, points):
        """[N, m] of points [N, n]."""
        if Evaluator is not None:
            if self._evaluator is None:
                self._evaluator = Evaluator(self.layers, self.head, self.quadratic)
            return self._evaluator.value(np.ascontiguousarray(points))
        y, _ = self._stack(points, False)
        if self.head != "plain":
            y = y - self._at_zero()
        if self.head == "diffeomorphism":
            y = np.sum((y + points) ** 2, axis=1, keepdims=True)
        if self.head == "squared_norm":
            y = np.sum(y * y, axis=1, keepdims=True) + self.quadratic * np.sum(
                points**2, axis=1, keepdims=True
            )
        return y

    def jacobian(self, x):
        """dy/dx: [N, m, n] for points [N, n]; [m, n] for a single point."""
        points, single = self._points(x)
        y, jacobian = self._stack(points, True)
        if self.head == "diffeomorphism":
            phi = y - self._at_zero() + points
            jacobian = 2.0 * (np.einsum("no,noi->ni", phi, jacobian) + phi)[:, None, :]
        if self.head == "squared_norm":
            y = y - self._at_zero()
            jacobian = 2.0 * np.einsum("no,noi->ni", y, jacobian) + 2.0 * self.quadratic * points
            jacobian = jacobian[:, None, :]
        return jacobian[0] if single else jacobian

    def gradient(self, x):
        """Of a network with one output: [N, n] for points [N, n]; [n] for a single point."""
        if self.output_dimension != 1:
            raise ValueError(f"gradient: found {self.output_dimension} outputs, expected 1 (see jacobian)")
        return self.jacobian(x)[..., 0, :]

    def torch(self):
        """The same function as a torch.nn.Module of double tensors: x [N, n] -> [N, m], or [N] where m = 1."""
        import torch  # only who asks for it needs it

        functions = {
            "identity": lambda z: z,
            "tanh": torch.tanh,
            "elu": torch.nn.functional.elu,
            "softplus": torch.nn.functional.softplus,
            "silu": torch.nn.functional.silu,
            "sine": torch.sin,
        }

        class Module(torch.nn.Module):
            def __init__(self, network):
                super().__init__()
                self.network = network
                for k, (weight, bias, _) in enumerate(network.layers):
                    self.register_parameter(f"weight_{k}", torch.nn.Parameter(torch.tensor(weight)))
                    self.register_parameter(f"bias_{k}", torch.nn.Parameter(torch.tensor(bias)))

            def stack(self, x):
                for k, (_, _, activation) in enumerate(self.network.layers):
                    weight, bias = getattr(self, f"weight_{k}"), getattr(self, f"bias_{k}")
                    x = functions[activation](torch.nn.functional.linear(x, weight, bias))
                return x

            def forward(self, x):
                y = self.stack(x)
                if self.network.head != "plain":
                    y = y - self.stack(torch.zeros_like(x[:1]))
                if self.network.head == "diffeomorphism":
                    y = ((y + x) ** 2).sum(1, keepdim=True)
                if self.network.head == "squared_norm":
                    y = (y**2).sum(1, keepdim=True) + self.network.quadratic * (x**2).sum(1, keepdim=True)
                return y[:, 0] if y.shape[1] == 1 else y

        return Module(self)


@dataclass
class ProjectedField:
    """x' = y(x): the velocity nearest to network(x) along which V falls at least as fast as exp(-decay t), the time
    normalised. Called as a Network is."""

    network: Network
    V: Network  # a diffeomorphism
    decay: float

    @property
    def input_dimension(self):
        return self.network.input_dimension

    @property
    def output_dimension(self):
        return self.network.output_dimension

    def __call__(self, x):
        """[N, n] for points [N, n], [n] for one point [n]; of a torch tensor a tensor."""
        torch = sys.modules.get("torch")
        if torch is not None and isinstance(x, torch.Tensor):
            return torch.as_tensor(self(x.detach().numpy(force=True)))
        velocity, gradient = self.network(x), self.V.gradient(x)
        excess = np.sum(gradient * velocity, axis=-1) + self.decay * self.V(x)
        square = np.maximum(np.sum(gradient**2, axis=-1), np.finfo(float).tiny)
        return velocity - np.expand_dims(np.maximum(excess, 0.0) / square, -1) * gradient

    def torch(self):
        """The same function as a torch.nn.Module of double tensors: x [N, n] -> [N, n]. Derivatives are followed in x and
        in all weights."""
        import torch  # only who asks for it needs it

        class Module(torch.nn.Module):
            def __init__(self, field):
                super().__init__()
                self.network, self.V, self.decay = field.network.torch(), field.V.torch(), field.decay

            def forward(self, x):
                with torch.enable_grad():
                    at = x if x.requires_grad else x.detach().requires_grad_(True)
                    value = self.V(at)
                    (gradient,) = torch.autograd.grad(value.sum(), at, create_graph=True)
                    velocity = self.network(at)
                    excess = torch.relu((gradient * velocity).sum(1) + self.decay * value)
                    square = (gradient**2).sum(1).clamp_min(torch.finfo(x.dtype).tiny)
                    y = velocity - (excess / square).unsqueeze(1) * gradient
                return y if torch.is_grad_enabled() else y.detach()

        return Module(self)


@dataclass
class Demonstration:
    time: np.ndarray  # [M]
    position: np.ndarray  # [M, n]
    velocity: np.ndarray  # [M, n]
    orientation: np.ndarray = None  # [M, 4] unit quaternions (w, x, y, z); None without


@dataclass
class Rollout:
    time: np.ndarray  # [M] normalised
    position: np.ndarray  # [M, n] normalised
    stop: str  # reached_goal, entered_unsafe, left_workspace, time_out, step_failed
    start_kind: str  # test, train, grid
    orientation: np.ndarray = None  # [M, 4] unit quaternions (w, x, y, z); None without


@dataclass
class StoredProblem:
    """What a run file says of its sets."""

    workspace_lower: np.ndarray  # [n]
    workspace_upper: np.ndarray  # [n]
    frame: str = "normalised"  # whose unit and frame the descriptions below are in: data, normalised
    unsafe: str = ""  # descriptions of the sets
    initial: str = ""
    containment: float = 0.0  # {B <= 0} lies in containment * workspace; 0: not asked for
    level_band: float = 0.0  # eps_B


@dataclass
class Grid:
    """Samples on axes[0] x axes[1] (x axes[2]), index order [i, j(, k)]; None: not in the file."""

    axes: list  # n arrays [N_k]
    unsafe: np.ndarray = None  # level functions, <= 0 inside
    initial: np.ndarray = None
    V: np.ndarray = None
    B: np.ndarray = None
    velocity: np.ndarray = None  # [N0, N1(, N2), n]


@dataclass
class Data:
    """Demonstrations as read, and how they become normalised."""

    unit: str  # of length: "mm"; "" when unknown
    dimension: int
    normalization: str  # max_abs, max_norm
    position_scale: float  # in `unit`
    velocity_scale: float  # in `unit` per second
    goal: np.ndarray  # [n] in `unit`: where the goal lies in the data's frame
    goals: np.ndarray  # [K, n] in `unit`: what is subtracted from each demonstration; all the goal unless they are moved
    train: list  # indices into demonstrations
    test: list
    frame_name: str = ""  # of the data's frame: "base_link"; "" when not told
    demonstrations: list = field(default_factory=list)
    goal_orientation: np.ndarray = None  # [4] (w, x, y, z) of poses
    quaternion_order: str = ""  # of the user's quaternions: xyzw, wxyz; "" without
    phase_start: float = 0.0  # in `unit`: where the last coordinate, a phase, starts; 0: all are those of a place
    report: list = field(default_factory=list)  # what was recognised and cleaned while reading, a line each

    @property
    def places(self):
        """How many of the coordinates are those of a place: all but a phase."""
        return self.dimension - (self.phase_start > 0.0)

    @property
    def time_scale(self):
        """Seconds per unit of normalised time."""
        return self.position_scale / self.velocity_scale

    @property
    def normalized(self):
        """Bit for bit what training saw."""
        return [
            Demonstration(
                (d.time - d.time[0]) / self.time_scale,
                (d.position - goal) / self.position_scale,
                d.velocity / self.velocity_scale,
                d.orientation,
            )
            for d, goal in zip(self.demonstrations, self.goals)
        ]

    def to_data(self, position):
        """Normalised positions [..., n] in the data's unit and frame."""
        return self.goal + self.position_scale * np.asarray(position, dtype=float)

    def to_normalized(self, position):
        """The way back."""
        return (np.asarray(position, dtype=float) - self.goal) / self.position_scale


@dataclass
class OrientationLaw:
    """How orientations follow positions: with r = log(q_goal^-1 q), dr/dt = dpsi/dt - rate (r - psi)."""

    psi: Network  # normalised position -> rotation vector [rad]
    rate: float  # 1/s
    initial_error: float  # rad: the largest |r - psi| of a start that the certificate speaks of


def _product(a, b):
    """Of quaternions (w, x, y, z), [N, 4] or one of them [4]."""
    a, b = np.broadcast_arrays(a, b)
    real = a[:, :1] * b[:, :1] - np.sum(a[:, 1:] * b[:, 1:], axis=1, keepdims=True)
    return np.hstack([real, a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])])


def rotation_vectors(goal, orientation):
    """log(goal^-1 q), |.| <= pi, of orientations [N, 4] (w, x, y, z): [N, 3] rad."""
    q = _product(np.asarray(goal) * [1.0, -1.0, -1.0, -1.0], np.asarray(orientation, dtype=float))
    q = np.where(q[:, :1] < 0.0, -q, q)
    sine = np.linalg.norm(q[:, 1:], axis=1, keepdims=True)
    small = sine < 1e-8
    share = np.where(small, 2.0 / q[:, :1], 2.0 * np.arctan2(sine, q[:, :1]) / np.where(small, 1.0, sine))
    return share * q[:, 1:]


def rotation_matrices(orientation):
    """[N, 3, 3] of unit quaternions [N, 4] (w, x, y, z)."""
    w, x, y, z = np.asarray(orientation, dtype=float).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def angles_between(a, b):
    """Degrees between orientations [N, 4]."""
    a, b = np.broadcast_arrays(np.asarray(a, dtype=float), np.asarray(b, dtype=float))
    q = _product(a * [1.0, -1.0, -1.0, -1.0], b)
    return np.degrees(2.0 * np.arctan2(np.linalg.norm(q[:, 1:], axis=1), np.abs(q[:, 0])))


def _plain(value):
    """An attribute or data set as a plain Python value or a numpy array."""
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    if isinstance(value, np.ndarray) and value.ndim == 0:
        return _plain(value[()])
    if isinstance(value, np.ndarray) and value.dtype.kind in "OS":
        return [_plain(entry) for entry in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    return value


def _attributes(group):
    return {name: _plain(value) for name, value in group.attrs.items()}


def _fields(group):
    """Attributes and data sets of a group, in one dict."""
    fields = _attributes(group)
    fields.update({name: _plain(item[()]) for name, item in group.items() if isinstance(item, h5py.Dataset)})
    return fields


def _numbered(group):
    """The members 0, 1, ... of a group in numerical order."""
    return [group[key] for key in sorted((key for key in group if key.isdigit()), key=int)]


def _require(condition, message):
    if not condition:
        raise RunError(message)


def _array(group, name, shape):
    """A data set of finite or non-finite doubles; None in `shape` stands for any length."""
    _require(name in group, f"{group.name}/{name}: missing")
    array = np.asarray(group[name][()], dtype=float)
    fits = array.ndim == len(shape) and all(want in (None, have) for want, have in zip(shape, array.shape))
    _require(
        fits,
        f"{group.name}/{name}: found shape {list(array.shape)}, expected "
        f"{['any' if want is None else want for want in shape]}",
    )
    return array


def _network(group):
    layers = []
    width = None
    for k in range(int(group.attrs["layers"])):
        weight = _array(group, f"weight_{k}", (None, width))
        width = weight.shape[0]
        bias = _array(group, f"bias_{k}", (width,)) if f"bias_{k}" in group else np.zeros(width)
        activation = _plain(group.attrs[f"activation_{k}"])
        _require(
            activation in ACTIVATIONS,
            f"{group.name}: activation_{k}: found '{activation}', expected one of " + ", ".join(ACTIVATIONS),
        )
        layers.append((weight, bias, activation))
    _require(layers, f"{group.name}: layers: found 0, expected at least 1")
    head = _plain(group.attrs["head"])
    _require(
        head in ("plain", "zero_at_origin", "squared_norm", "diffeomorphism"),
        f"{group.name}: head: found '{head}', expected plain, zero_at_origin, squared_norm or diffeomorphism",
    )
    unbiased = frozenset(k for k in range(len(layers)) if f"bias_{k}" not in group)
    return Network(layers, head, float(group.attrs.get("quadratic", 0.0)), unbiased)


def weight_hash(f, V, B):
    """SHA-256 of three networks, f perhaps projected, as the program computes it: little-endian 64-bit words, texts after their length."""
    digest = hashlib.sha256()

    def words(*numbers):
        digest.update(struct.pack(f"<{len(numbers)}Q", *numbers))

    def text(value):
        words(len(value))
        digest.update(value.encode())

    for network in (f.network if isinstance(f, ProjectedField) else f, V, B):
        text("anchored" if network.head == "zero_at_origin" else network.head)
        digest.update(struct.pack("<d", network.quadratic))
        words(len(network.layers))
        for k, (weight, bias, activation) in enumerate(network.layers):
            bias = () if k in network.unbiased else bias
            text(activation)
            words(*weight.shape, len(bias))
            digest.update(np.asarray(weight, dtype="<f8").tobytes() + np.asarray(bias, dtype="<f8").tobytes())
    if isinstance(f, ProjectedField):
        text("projected")
        digest.update(struct.pack("<d", f.decay))
    return digest.hexdigest()


def _require_unchanged_bytes(path):
    """The last line of a run file is the SHA-256 of all that stands before it; HDF5 drops it when something is changed."""
    with open(path, "rb") as file:
        data = file.read()
    content, mark, digest = data.rpartition(b"\ns2nnds-sha256 ")
    _require(
        mark and digest == hashlib.sha256(content).hexdigest().encode() + b"\n",
        "found a certified run that something else than the program has written to; `s2nnds verify` makes a new certificate",
    )


class Run:
    """One run file, read whole. Throws RunError when the file is missing, broken or of another schema, and when its
    certificate claims something of other weights or of another problem than the file holds, or of a file that was changed."""

    def __init__(self, path):
        self.path = str(path)
        try:
            with h5py.File(path, "r") as file:
                self._read(file)
            if self._claims():
                _require_unchanged_bytes(path)
        except RunError as error:
            raise RunError(f"{self.path}: {error}") from None
        except (OSError, RuntimeError) as error:
            raise RunError(f"{self.path}: not a readable HDF5 file: {' '.join(str(error).split())}") from None
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            raise RunError(f"{self.path}: not a run file of s2nnds: {' '.join(str(error).split())}") from None

    @property
    def dimension(self):
        return self.data.dimension

    @property
    def phase_start(self):
        """Where the last coordinate of the states (x, s), a phase, starts, in the data's unit; 0 without one.

        A controller begins with s = phase_start and integrates it: s' is the last of velocity(numpy.append(x, s))."""
        return self.data.phase_start

    @property
    def guarantee(self):
        return self.certificate["guarantee"]

    def _claims(self):
        """Whether the certificate claims something."""
        return self.guarantee != "none" or bool(self.certificate["stability"].get("proved", False))

    def policy(self):
        """The policy as a torch.nn.Module (s2nnds.policy.Policy): positions in, velocities out, in the data's unit."""
        from .policy import Policy  # only who asks for it needs torch

        return Policy(self)

    # The policy as it is exported: positions [N, n] or [n] in the data's unit and frame.

    def velocity(self, position):
        """In the data's unit per second: [N, n], or [n] for a single point."""
        return self.data.velocity_scale * self.f(self.data.to_normalized(position))

    def pose_velocity(self, position, orientation):
        """(velocity [N, n], angular velocity [N, 3] in rad/s), both in the data's frame, at positions [N, n] with
        orientations [N, 4] in the order of the recordings (run.data.quaternion_order): q' = 1/2 (0, omega) q."""
        if self.orientation is None:
            raise ValueError("pose_velocity: the run is one of positions alone")
        law, goal = self.orientation, self.data.goal_orientation
        position = np.atleast_2d(np.asarray(position, dtype=float))
        q = np.atleast_2d(np.asarray(orientation, dtype=float))
        if position.shape[1] != self.dimension or q.shape != (len(position), 4):
            raise ValueError(
                f"pose_velocity: found shapes {position.shape} and {q.shape}, expected [N, {self.dimension}] and [N, 4]"
            )
        q = q[:, [3, 0, 1, 2]] if self.data.quaternion_order == "xyzw" else q
        velocity = self.velocity(position)
        z = self.data.to_normalized(position)
        r = rotation_vectors(goal, q / np.linalg.norm(q, axis=1, keepdims=True))
        change = np.einsum("nij,nj->ni", law.psi.jacobian(z), velocity / self.data.position_scale)
        rate = change - law.rate * (r - law.psi(z))
        square = np.sum(r * r, axis=1, keepdims=True)
        angle = np.sqrt(square)
        small = angle < 1e-4
        safe = np.where(small, 1.0, angle)
        first = np.where(small, 0.5 - square / 24, (1 - np.cos(safe)) / safe**2)
        second = np.where(small, 1 / 6 - square / 120, (safe - np.sin(safe)) / safe**3)
        once = np.cross(r, rate)
        turned = rate + first * once + second * np.cross(r, once)
        return velocity, turned @ rotation_matrices(goal[None])[0].T

    def lyapunov(self, position):
        """V: [N], or a number for a single point."""
        return self.V(self.data.to_normalized(position))

    def barrier(self, position):
        """B, <= 0 in the safe set: [N], or a number for a single point."""
        return self.B(self.data.to_normalized(position))

    def safe(self, position):
        """Whether B <= 0, by more than rounding, inside the workspace: [N], or a truth value for a single point."""
        z = self.data.to_normalized(position)
        inside = np.all((z >= self.problem.workspace_lower) & (z <= self.problem.workspace_upper), axis=-1)
        return inside & (self.B(z) <= -self.certificate.get("barrier_float64_error", 0.0))

    def shield(self, position, wanted):
        """(v, change): the wanted velocities [N, n] or [n] made safe (s2nnds.shield.shield), and by how much."""
        from .shield import shield

        return shield(self, position, wanted)

    def scene_range(self, obstacle="all", stretch=0.8, within=None, program=None):
        """The displacements of an obstacle (a number from 0, or "all") that the certificate covers, and the motion for each
        (s2nnds.scene_range.SceneRange). `within`: a radius, or half sizes of a box, in the data's unit. The program finds it
        (`program`, or the one in the package's folder); raises ValueError where there is none."""
        from .scene_range import find_scene_range

        return find_scene_range(self, obstacle, stretch, within, program)

    def in_data_unit(self):
        """A copy with workspace, demonstrations, rollouts, grid and open boxes in the data's unit and frame, times in s.

        Demonstrations that end in different places are moved to end in the common goal, as training sees them. The
        networks stay functions of normalised positions.
        """
        shown, data, n = copy.copy(self), self.data, self.dimension
        at = data.to_data
        shown.data = replace(
            data,
            goals=np.tile(data.goal, (len(data.goals), 1)),
            demonstrations=[
                Demonstration(d.time, d.position + (data.goal - goal), d.velocity, d.orientation)
                for d, goal in zip(data.demonstrations, data.goals)
            ],
        )
        shown.problem = replace(
            self.problem,
            workspace_lower=at(self.problem.workspace_lower),
            workspace_upper=at(self.problem.workspace_upper),
        )
        shown.rollouts = [
            replace(rollout, time=data.time_scale * rollout.time, position=at(rollout.position))
            for rollout in self.rollouts
        ]
        shown.open_boxes = {
            name: np.hstack([at(boxes[:, :n]), at(boxes[:, n:])]) for name, boxes in self.open_boxes.items()
        }
        if self.pushes is not None:
            shown.pushes = np.hstack([at(self.pushes[:, :n]), self.pushes[:, n:]])
        if self.grid is not None:
            velocity = None if self.grid.velocity is None else data.velocity_scale * self.grid.velocity
            axes = [goal + data.position_scale * axis for goal, axis in zip(data.goal, self.grid.axes)]
            shown.grid = replace(self.grid, axes=axes, velocity=velocity)
        return shown

    def _read(self, file):
        self.attributes = _attributes(file)
        version = self.attributes.get("schema_version")
        _require(version == SCHEMA_VERSION, f"schema_version: found {version}, expected {SCHEMA_VERSION}")
        for name in ("data", "problem", "networks"):
            _require(name in file, f"/{name}: missing")
        self.name = self.attributes.get("name", "")
        self.seed = self.attributes.get("seed")
        self._read_config(file)
        self._read_data(file["data"])
        n = self.dimension
        problem = file["problem"]
        self.problem = StoredProblem(
            _array(problem, "workspace_lower", (n,)),
            _array(problem, "workspace_upper", (n,)),
            **{
                key: value
                for key, value in _attributes(problem).items()
                if key in ("frame", "unsafe", "initial", "containment", "level_band")
            },
        )
        self.f, self.V, self.B = (_network(file["networks"][key]) for key in "fVB")
        self.orientation = self._read_orientation(file["networks"])
        for key, outputs in (("f", n), ("V", 1), ("B", 1)):
            network = getattr(self, key)
            found = (network.input_dimension, network.output_dimension)
            _require(
                found == (n, outputs),
                f"/networks/{key}: found {found[0]} inputs and {found[1]} outputs, "
                f"expected {n} and {outputs}",
            )
        decay = float(file["networks"]["f"].attrs.get("decay", 0.0))
        if decay > 0.0:
            self.f = ProjectedField(self.f, self.V, decay)
        self.history = {name: np.atleast_1d(column[()]) for name, column in file.get("history", {}).items()}
        self._read_certificate(file)
        self.evaluation = _fields(file["evaluation"]) if "evaluation" in file else {}
        self.remarks = [str(_plain(line)) for line in file["remarks"][()]] if "remarks" in file else []
        self.timing = _fields(file["timing"]) if "timing" in file else {}
        self.rollouts = [self._read_rollout(group) for group in _numbered(file.get("rollouts", {}))]
        self.grid = self._read_grid(file["grid"]) if "grid" in file else None

    def _read_orientation(self, networks):
        if "psi" not in networks:
            return None
        group = networks["psi"]
        law = OrientationLaw(_network(group), float(group.attrs["rate"]), float(group.attrs["initial_error"]))
        found = (law.psi.input_dimension, law.psi.output_dimension)
        _require(
            found == (self.dimension, 3) and self.data.goal_orientation is not None,
            f"/networks/psi: found {found[0]} inputs and {found[1]} outputs, expected {self.dimension} and 3, "
            "and a goal orientation in /data",
        )
        return law

    def _read_config(self, file):
        group = file.get("config", {})
        self.config_text = _plain(group["text"][()]) if "text" in group else ""
        self.config_resolved = _plain(group["resolved"][()]) if "resolved" in group else ""
        self.config = _attributes(group["values"]) if "values" in group else {}  # dotted key -> value

    def _read_data(self, group):
        values = _attributes(group)
        n = int(values["dimension"])
        indices = {
            key: [int(k) for k in np.atleast_1d(group[key][()])] if key in group else []
            for key in ("train", "test")
        }
        self.data = Data(
            values.get("unit", ""),
            n,
            values.get("normalization", ""),
            float(values["position_scale"]),
            float(values["velocity_scale"]),
            _array(group, "goal", (n,)),
            _array(group, "goals", (None, n)),
            **indices,
            frame_name=values.get("frame_name", ""),
            phase_start=float(values.get("phase_start", 0.0)),
        )
        if "goal_orientation" in group:
            self.data.goal_orientation = _array(group, "goal_orientation", (4,))
            self.data.quaternion_order = values.get("quaternion_order", "")
        if "report" in group:
            self.data.report = [str(_plain(line)) for line in group["report"][()]]
        for item in _numbered(group.get("demonstrations", {})):
            time = _array(item, "time", (None,))
            self.data.demonstrations.append(
                Demonstration(
                    time,
                    _array(item, "position", (len(time), n)),
                    _array(item, "velocity", (len(time), n)),
                    _array(item, "orientation", (len(time), 4)) if "orientation" in item else None,
                )
            )
        count = len(self.data.demonstrations)
        _require(
            len(self.data.goals) == count, f"/data/goals: found {len(self.data.goals)} rows, expected {count}"
        )
        for key in ("train", "test"):
            wrong = [k for k in indices[key] if not 0 <= k < count]
            _require(
                not wrong, f"/data/{key}: found index {wrong[0] if wrong else ''}, expected 0 to {count - 1}"
            )

    def _read_certificate(self, file):
        group = file.get("certificate", {})
        self.certificate = {"guarantee": "none", **(_fields(group) if group else {})}
        self.certificate["execution"] = _fields(group["execution"]) if "execution" in group else {}
        self.certificate["orientation"] = _fields(group["orientation"]) if "orientation" in group else {}
        self.certificate["stability"] = _fields(group["stability"]) if "stability" in group else {}
        self.certificate["conditions"] = [_fields(item) for item in _numbered(group.get("conditions", {}))]
        self.certificate["execution"] = _fields(group["execution"]) if "execution" in group else {}
        if self._claims():
            self._check_scope()
        boxes = group.get("open_boxes", {})  # condition -> [k, 2n]: lower corner, then upper
        self.open_boxes = {name: _array(boxes, name, (None, 2 * self.dimension)) for name in boxes}
        # [k, n + 1]: samples of demonstrations, each with the largest push (N s) there that stays in the safe set.
        self.pushes = _array(group, "pushes", (None, self.dimension + 1)) if "pushes" in group else None

    def _check_scope(self):
        try:
            scope = tomllib.loads(self.certificate.get("scope", ""))
        except tomllib.TOMLDecodeError:
            scope = {}
        frame, problem = scope.get("frame", {}), scope.get("problem", {})
        pairs = [
            (scope.get("weights"), weight_hash(self.f, self.V, self.B)),
            (frame.get("goal"), self.data.goal),
            (frame.get("position_scale"), self.data.position_scale),
            (frame.get("velocity_scale"), self.data.velocity_scale),
            (problem.get("workspace_lower"), self.problem.workspace_lower),
            (problem.get("workspace_upper"), self.problem.workspace_upper),
            (problem.get("level_band"), self.problem.level_band),
        ]
        if self.orientation is not None:
            turning = scope.get("orientation", {})
            pairs += [
                (turning.get("psi"), weight_hash(self.orientation.psi, *(Network([]) for _ in range(2)))),
                (turning.get("goal"), self.data.goal_orientation),
                (turning.get("rate"), self.orientation.rate),
                (turning.get("initial_error"), self.orientation.initial_error),
                (turning.get("quaternion_order"), self.data.quaternion_order),
            ]
        _require(
            all(np.array_equal(certified, found) for certified, found in pairs),
            "found weights, a problem or data other than those that its certificate speaks of; "
            "`s2nnds verify` makes a new one",
        )

    def _read_rollout(self, group):
        time = _array(group, "time", (None,))
        return Rollout(
            time,
            _array(group, "position", (len(time), self.dimension)),
            str(_plain(group.attrs.get("stop", ""))),
            str(_plain(group.attrs.get("start_kind", ""))),
            _array(group, "orientation", (len(time), 4)) if "orientation" in group else None,
        )

    def _read_grid(self, group):
        axes = [_array(group, f"axis_{k}", (None,)) for k in range(self.dimension)]
        shape = tuple(len(axis) for axis in axes)
        fields = {key: _array(group, key, shape) for key in ("unsafe", "initial", "V", "B") if key in group}
        if "velocity" in group:
            fields["velocity"] = _array(group, "velocity", shape + (self.dimension,))
        return Grid(axes, **fields)
