# SPDX-License-Identifier: BSD-3-Clause
"""ROS 1 bags, ROS 2 bags (SQLite or MCAP, a folder) and lone MCAP files, read without ROS (packages rosbags and mcap)."""

import os

import numpy as np

from .imported_recording import ImportRefused, Recording, package


def _xyz(point):
    return [point.x, point.y, point.z]


def _quaternion(q):
    return [q.x, q.y, q.z, q.w]


def _pose(pose):
    return {"position": _xyz(pose.position), "orientation": _quaternion(pose.orientation)}


def _transform(message):
    motion = message.transform
    return {"position": _xyz(motion.translation), "orientation": _quaternion(motion.rotation)}


def _joints(message):
    """A state may tell some joints alone, in any order."""
    values = {"names": list(message.name), "position": list(message.position)}
    if len(message.velocity) == len(message.position) and len(message.velocity):
        values["velocity"] = list(message.velocity)
    return values


# Message type -> (what a message tells, unit of its positions).
TYPES = {
    "geometry_msgs/Point": (lambda m: {"position": _xyz(m)}, "m"),
    "geometry_msgs/PointStamped": (lambda m: {"position": _xyz(m.point)}, "m"),
    "geometry_msgs/Pose": (_pose, "m"),
    "geometry_msgs/PoseStamped": (lambda m: _pose(m.pose), "m"),
    "geometry_msgs/PoseWithCovarianceStamped": (lambda m: _pose(m.pose.pose), "m"),
    "geometry_msgs/TransformStamped": (_transform, "m"),
    "nav_msgs/Odometry": (lambda m: _pose(m.pose.pose), "m"),
    "sensor_msgs/JointState": (_joints, "rad"),
    "std_msgs/Float64MultiArray": (lambda m: {"position": list(m.data)}, ""),
    "tf2_msgs/TFMessage": (None, "m"),  # several TransformStamped: --child picks one
}


def _plain(type_name):
    return type_name.replace("/msg/", "/")


class _Bag:
    """Topics and messages of a ROS 1 bag or of a folder of a ROS 2 bag."""

    def __init__(self, path):
        from pathlib import Path

        highlevel = package("rosbags.highlevel", "import of ROS bags")
        typesys = package("rosbags.typesys", "import of ROS bags")
        # Old ROS 2 bags do not tell their messages' definitions.
        store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        self._reader = highlevel.AnyReader([Path(path)], default_typestore=None if path.endswith(".bag") else store)

    def __enter__(self):
        self._reader.open()
        return self

    def __exit__(self, *_):
        self._reader.close()

    def topics(self):
        return {c.topic: _plain(c.msgtype) for c in self._reader.connections}

    def messages(self, topic):
        connections = [c for c in self._reader.connections if c.topic == topic]
        for connection, received, data in self._reader.messages(connections=connections):
            yield received, self._reader.deserialize(data, connection.msgtype)


class _Mcap:
    """The same of a lone MCAP file; its messages are decoded by the definitions that it holds."""

    def __init__(self, path):
        self._path = path
        self._reader_of = package("mcap.reader", "import of MCAP files").make_reader
        self._typesys = package("rosbags.typesys", "import of MCAP files with ROS messages")

    def __enter__(self):
        self._file = open(self._path, "rb")
        self._store = self._typesys.get_typestore(self._typesys.Stores.EMPTY)
        summary = self._reader_of(self._file).get_summary()
        if summary is None:
            raise ImportRefused(f"{self._path}: found an MCAP file without its summary, cut off while it was recorded; 'mcap recover' writes one")
        self._topics = {}
        for channel in summary.channels.values():
            schema = summary.schemas.get(channel.schema_id)
            if schema is not None and schema.encoding in ("ros2msg", "ros1msg"):
                self._topics[channel.topic] = schema.name
                self._store.register(self._typesys.get_types_from_msg(schema.data.decode(), schema.name))
        return self

    def __exit__(self, *_):
        self._file.close()

    def topics(self):
        return {topic: _plain(name) for topic, name in self._topics.items()}

    def messages(self, topic):
        for schema, channel, message in self._reader_of(self._file).iter_messages(topics=[topic]):
            name = schema.name if "/msg/" in schema.name else schema.name.replace("/", "/msg/")
            ros1 = channel.message_encoding == "ros1"
            yield message.log_time, (self._store.deserialize_ros1 if ros1 else self._store.deserialize_cdr)(message.data, name)


def _topic_of(source, topics, wanted):
    known = {topic: name for topic, name in topics.items() if name in TYPES}
    told = ", ".join(f"{topic} ({name})" for topic, name in sorted(topics.items())) or "none"
    if wanted:
        if wanted not in topics:
            raise ImportRefused(f"{source}: found no topic {wanted}; expected one of {told}")
        if wanted not in known:
            raise ImportRefused(f"{source}: found {topics[wanted]} on {wanted}; expected one of {', '.join(sorted(TYPES))}")
        return wanted
    if len(known) != 1:
        raise ImportRefused(f"{source}: found {len(known)} topics that hold positions; expected --topic to name one of {told}")
    return next(iter(known))


def _stamp(message):
    """Nanoseconds of a message's header; 0: it has none."""
    header = getattr(message, "header", None)
    return header.stamp.sec * 1_000_000_000 + header.stamp.nanosec if header is not None else 0


def _transforms(messages, child, source, topic):
    """Those of one child frame, from /tf."""
    frames = set()
    for received, message in messages:
        for transform in message.transforms:
            frames.add(transform.child_frame_id)
            if transform.child_frame_id == child:
                yield received, transform
    if child not in frames:
        raise ImportRefused(f"{source}: {topic}: found the frames {', '.join(sorted(frames))}; expected --child to name one of them")


def _times(stamps, received, wish, source):
    """[M] ns, and what they are."""
    stamps, received = np.array(stamps, dtype=np.int64), np.array(received, dtype=np.int64)
    stamped = bool((stamps > 0).all())
    if wish == "header" and not stamped:
        raise ImportRefused(f"{source}: found messages without time stamps in their headers; expected --time received")
    use_stamps = stamped and wish != "received"
    return (stamps, "stamps of the headers") if use_stamps else (received, "times of receipt")


def _same_names(samples):
    """Joint names in every state, in the first one's order; states that lack one of them are left out."""
    counts = {}
    for sample in samples:
        for name in sample["names"]:
            counts[name] = counts.get(name, 0) + 1
    names = [name for name in counts if 2 * counts[name] > max(counts.values())]
    kept = [k for k, sample in enumerate(samples) if set(names) <= set(sample["names"])]
    return names, kept


def _arrays(samples, source, topic):
    """(coordinates, places of the samples that were kept, position, velocity, orientation)."""
    if "names" in samples[0]:
        names, kept = _same_names(samples)
        order = [[samples[k]["names"].index(name) for name in names] for k in kept]
        rows = {
            key: np.array([np.asarray(samples[k][key])[places] for k, places in zip(kept, order)], dtype=float)
            for key in ("position", "velocity")
            if all(key in samples[k] for k in kept)
        }
        return names, kept, rows["position"], rows.get("velocity"), None
    n = len(samples[0]["position"])
    for k, sample in enumerate(samples):
        if len(sample["position"]) != n:
            raise ImportRefused(f"{source}: {topic}: message {k} has {len(sample['position'])} numbers; expected {n} as the first")
    position = np.array([sample["position"] for sample in samples], dtype=float)
    turned = "orientation" in samples[0]
    orientation = np.array([sample["orientation"] for sample in samples], dtype=float) if turned else None
    names = ["x", "y", "z"] if turned or n == 3 else [f"x{k + 1}" for k in range(n)]
    return names, list(range(len(samples))), position, None, orientation


def _recording(bag, source, options):
    topic = _topic_of(source, bag.topics(), options.topic)
    type_name = bag.topics()[topic]
    told, unit = TYPES[type_name]
    messages = bag.messages(topic)
    if type_name == "tf2_msgs/TFMessage":
        messages, told = _transforms(messages, options.child, source, topic), _transform
    received, stamps, samples, frames = [], [], [], set()
    for when, message in messages:
        received.append(when)
        stamps.append(_stamp(message))
        samples.append(told(message))
        if getattr(message, "header", None) is not None:
            frames.add(message.header.frame_id)
    if len(samples) < 2:
        raise ImportRefused(f"{source}: {topic}: found {len(samples)} message(s); expected 2 or more")
    if len(frames) > 1:
        raise ImportRefused(f"{source}: {topic}: found positions in the frames {', '.join(sorted(frames))}; expected one")
    names, kept, position, velocity, orientation = _arrays(samples, source, topic)
    times, what = _times(stamps, received, options.time, source)
    times = times[kept]
    notes = what if len(kept) == len(samples) else f"{what}, {len(samples) - len(kept)} states without all joints left out"
    frame = next(iter(frames), "") if type_name != "sensor_msgs/JointState" else ""
    # Differences of integers: seconds since 1970 in ns do not fit a double.
    seconds = (times - times[0]) * 1e-9
    origin = {"topic": topic, "type": type_name, "start_time": float(times[0]) * 1e-9, "times": what, "notes": notes}
    return Recording(source, seconds, position, names, unit, frame, velocity, orientation, origin)


def read_ros(source, options):
    """The demonstration in one bag."""
    try:
        with _Mcap(source) if source.endswith(".mcap") and os.path.isfile(source) else _Bag(source) as bag:
            return [_recording(bag, source, options)]
    except ImportRefused:
        raise
    # The packages raise errors of many kinds for a damaged file.
    except Exception as error:
        text = " ".join(str(error).split()) or type(error).__name__
        raise ImportRefused(f"{source}: cannot be read as a recording of ROS: {text[:200]}") from None
