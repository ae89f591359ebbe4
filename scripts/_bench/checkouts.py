"""Diagnoses by this checkout and by another, in turns, with CPU seconds by stage.

The other is unpacked from the repository's history and run with what is installed here. Each keeps
compiled programs to itself; the first diagnosis of a campaign, which makes them, does not count.
"""

import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tp_jax.errors import InputError

ROOT = Path(__file__).parent.parent.parent
EXAMPLE = ROOT / "tp_jax" / "examples" / "case-02"
HERE = "here"

#: What of the package both checkouts have.
PROGRAM = """
import json, sys, time
import tp_jax as tp
from tp_jax._config import enable_compilation_cache
enable_compilation_cache()
campaign = tp.load_campaign(sys.argv[1])
at = [("loading", 0.0), ("preparing", time.process_time())]
found = tp.diagnose(campaign, progress=lambda s, part: at.append((s, time.process_time())))
at.append(("", time.process_time()))
d = found.to_dict()
print(json.dumps({
    "stages": [[s, end - begin] for (s, begin), (_, end) in zip(at, at[1:])],
    "verdict": d["verdict"], "causes": [c["effect"] for c in d["causes"]],
    "shrink": d["gap"]["shrink"],
}))
"""

STAGES = {
    "loading": "loading",
    "preparing": "preparing",
    "fitting windows": "baseline",
    "sharpening": "sharpening",
    "screening": "screening",
    "refitting": "refitting",
    "polishing": "polishing",
    "predicting": "leaving out",
    "trying to do without": "doing without",
    "longer windows": "longer windows",
    "reading": "held-out",
}
"""Beginning of what is shown -> stage."""


class Diagnosed(NamedTuple):
    """CPU seconds by stage, and what came out."""

    stages: dict[str, float]
    answer: tuple[str, tuple[str, ...], float | None]


def campaigns(folder: Path) -> dict[str, Path]:
    """The example; decays alone; a measured drive; a rig whose effect is in no catalogue."""
    import trials.effects  # noqa: F401 -- has bearing_rim
    from tp_jax.rig import make_campaign

    make_campaign(folder / "measured", effects={"spring_hardening": 0.2}, measured=True, seed=35)
    make_campaign(folder / "unknown", effects={"bearing_rim": 0.45}, seed=35)
    return {
        "example": EXAMPLE,
        "decays": _decays(folder / "decays"),
        "measured drive": folder / "measured",
        "stays unknown": folder / "unknown",
    }


def _decays(folder: Path) -> Path:
    """Three swings of a rig with quadratic drag."""
    from tp_jax.recordings import write_csv
    from tp_jax.rig import VirtualRig
    from tp_jax.rig.chain import measure

    rig, rng = VirtualRig(effects={"bearing_drag": 1e-4}), np.random.default_rng(35)
    ts = np.arange(2001) / 250.0
    folder.mkdir(parents=True)
    toml = 'name = "decays"\n'
    for i, release in enumerate((1.2, 0.9, 0.6)):
        phi1, phi2 = measure(rig.run(ts, release=release, duration=8.0), rng).T
        write_csv(folder / f"run-{i}.csv", ts, phi1, phi2, None)
        toml += f'\n[[recording]]\nfile = "run-{i}.csv"\nforced = false\n'
    (folder / "campaign.toml").write_text(toml, encoding="utf-8")
    return folder


def unpacked(ref: str, folder: Path) -> Path:
    """A commit's files in a folder.

    Raises:
        InputError: the repository has no such commit.
    """
    archive = subprocess.run(
        ["git", "-C", str(ROOT), "archive", "--format=tar", ref], capture_output=True, check=False
    )
    if archive.returncode:
        said = archive.stderr.decode(errors="replace").strip()
        raise InputError(f"--against {ref}: git knows no such commit ({said}).")
    with tarfile.open(fileobj=io.BytesIO(archive.stdout)) as tar:
        tar.extractall(folder, filter="data")
    return folder


def compared(
    ref: str, rounds: int, tell: Callable[[str], None]
) -> Iterator[tuple[str, dict[str, list[Diagnosed]]]]:
    """Each campaign with its warm diagnoses by checkout (`HERE`, ref), in turns."""
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        checkouts = {HERE: ROOT, ref: unpacked(ref, folder / "other")}
        for campaign, place in campaigns(folder / "campaigns").items():
            found: dict[str, list[Diagnosed]] = {name: [] for name in checkouts}
            for k in range(1 + rounds):
                for i, (name, root) in enumerate(checkouts.items()):
                    tell(f"diagnosis of {campaign} by {name}, {k} of {rounds}")
                    one = diagnosed(root, place, folder / f"cache-{i}")
                    if k:
                        found[name].append(one)
            yield campaign, found


def diagnosed(root: Path, campaign: Path, cache: Path) -> Diagnosed:
    """One diagnosis in a process of its own by the package of a checkout."""
    environment = {**os.environ, "PYTHONPATH": str(root), "XDG_CACHE_HOME": str(cache)}
    for name in ("TP_JAX_CACHE", "JAX_COMPILATION_CACHE_DIR"):
        environment.pop(name, None)
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(campaign)],
        env=environment,
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"a diagnosis by {root} ended with {done.returncode}:\n{done.stderr}")
    return read(json.loads(done.stdout.splitlines()[-1]))


def read(printed: Mapping[str, Any]) -> Diagnosed:
    """Reads what the program printed, with the times of like stages together."""
    stages: dict[str, float] = {}
    for shown, seconds in printed["stages"]:
        stage = next((s for begin, s in STAGES.items() if shown.startswith(begin)), "other")
        stages[stage] = stages.get(stage, 0.0) + seconds
    answer = (printed["verdict"], tuple(printed["causes"]), printed["shrink"])
    return Diagnosed(stages, answer)


def medians(several: Sequence[Diagnosed]) -> dict[str, float]:
    """CPU seconds by stage, and in all."""
    names = dict.fromkeys(name for one in several for name in one.stages)
    out = {n: float(np.median([one.stages.get(n, 0.0) for one in several])) for n in names}
    return {**out, "in all": float(np.median([sum(one.stages.values()) for one in several]))}
