"""Ways to spoil a JSON document, a few at a time, by a seed."""

import contextlib
import copy
import random
from typing import Any

VALUES: tuple[Any, ...] = (
    None,
    True,
    False,
    "",
    "x",
    "1.0",
    "nan",
    [],
    {},
    [1.0],
    [[]],
    {"x": 1.0},
    ["a", "b"],
    0,
    1,
    -1,
    0.5,
    -0.0,
    1e-300,
    1e30,
    1e31,
    -1e31,
    1e308,
    -1e308,
    10**20,
    10**400,
    -(10**400),
    5e-324,
    "\u0000",
    "ü" * 300,
    float("nan"),
    float("inf"),
    float("-inf"),
)


def places(value: Any, path: tuple = (), most: int = 3) -> list[tuple]:
    """Paths to everything in a document; of long lists only the first few entries."""
    found = [path] if path else []
    if isinstance(value, dict):
        for key, entry in value.items():
            found += places(entry, (*path, key), most)
    elif isinstance(value, list):
        for i, entry in enumerate(value[:most]):
            found += places(entry, (*path, i), most)
    return found


def mutated(document: Any, seed: int, under: tuple = ()) -> Any:
    """The document with one to three entries removed, renamed, or made something else."""
    random_ = random.Random(seed)
    out = copy.deepcopy(document)
    for _ in range(random_.choice((1, 1, 1, 2, 3))):
        there = [p for p in places(out) if p[: len(under)] == under]
        if not there:
            break
        *above, last = random_.choice(there)
        holder = out
        for key in above:
            holder = holder[key]
        kind = random_.random()
        if kind < 0.2:
            del holder[last]
        elif kind < 0.3 and isinstance(holder, dict):
            holder[random_.choice(("x", "", "k", f"{last} "))] = holder.pop(last)
        elif kind < 0.45 and isinstance(holder[last], int | float):
            factor = random_.choice((-1, 1e3, 1e-3, 1e12, 1e-12, 0))
            with contextlib.suppress(OverflowError):  # 10**400 stays as it is
                holder[last] = holder[last] * factor
        elif kind < 0.5 and isinstance(holder, list):
            holder.append(copy.deepcopy(random_.choice(VALUES)))
        else:
            holder[last] = copy.deepcopy(random_.choice(VALUES))
    return out
