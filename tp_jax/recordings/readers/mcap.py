"""MCAP files with messages in JSON, by mcap; in ROS 2's form where mcap-ros2-support is there."""

import json
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.recordings.readers import Unreadable


def read(file: Path, sheet: str | None) -> dict[str, np.ndarray]:
    """The numbers in the messages of one topic, "field" or "field.field"; and t.

    Where a message has no t of its own, it is when it was logged, from the first.

    Args:
        file: the file.
        sheet: the topic; None: the one with the most messages.
    """
    from mcap.reader import make_reader

    topics: dict[str, list[tuple[float, Any]]] = defaultdict(list)
    with file.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            if channel.message_encoding == "json":
                told = (1e-9 * message.log_time, json.loads(message.data))
                topics[channel.topic].append(told)
    if not topics:
        topics = _ros2(file)
    name = max(topics, key=lambda each: len(topics[each])) if sheet is None else sheet
    if name not in topics:
        raise Unreadable(
            f'there is no topic "{name}", but {", ".join(topics)}', "correct sheet under [format]"
        )
    rows = [dict(_numbers("", content)) for _, content in topics[name]]
    fields = dict.fromkeys(key for row in rows for key in row)
    logged = np.array([time for time, _ in topics[name]])
    return {"t": logged - logged[0]} | {
        key: np.array([row.get(key, np.nan) for row in rows]) for key in fields
    }


def _ros2(file: Path) -> dict[str, list[tuple[float, Any]]]:
    try:
        from mcap_ros2.reader import read_ros2_messages  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise Unreadable(
            "its messages are not in JSON",
            "install what decodes ROS 2 messages (pip install mcap-ros2-support), or export CSV",
        ) from error
    topics = defaultdict(list)
    for message in read_ros2_messages(str(file)):
        topics[message.channel.topic].append((1e-9 * message.log_time_ns, message.ros_msg))
    return topics


def _numbers(prefix: str, content: Any) -> Iterator[tuple[str, float]]:
    """Each number of a message with its path, "header.stamp.sec"."""
    if isinstance(content, bool) or content is None or isinstance(content, str | bytes):
        return
    if isinstance(content, int | float):
        yield prefix, float(content)
        return
    if isinstance(content, list | tuple):
        pairs = ((f"[{i}]", each) for i, each in enumerate(content))
        for key, each in pairs:
            yield from _numbers(f"{prefix}{key}", each)
        return
    fields = (
        content
        if isinstance(content, dict)
        else {name: getattr(content, name) for name in getattr(content, "__slots__", ())}
    )
    for key, each in fields.items():
        yield from _numbers(f"{prefix}.{key}" if prefix else str(key), each)
