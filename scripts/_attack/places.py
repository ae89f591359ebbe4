"""Places of files: a full disk, a home that is none, a cache of another processor or spoiled."""

import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

from scripts._attack import corpus
from scripts._attack.tally import LONGEST, Tally, Wrong
from tp_jax.errors import InputError

SIMULATE = ("simulate", "--preset", "bench", "--duration", "1", "--rate", "100")
PREDICT = ("predict", "diagnosis.json", "--omega", "13", "--duration", "1", "--rate", "100")
RECORD = ("record", "--port", "emulator", "--duration", "1", "--omega", "9", "--speed", "max")

HOMES = (None, "", "nowhere", "/dev/null", "/proc", "/proc/self/nowhere", "a\nb")

SMALL = (0, 100, 5_000)
"""Bytes that a file may have: a disk that is full at once, in a header, in the midst."""


def attack(tally: Tally) -> None:
    """Every place, with a real command each."""
    with tempfile.TemporaryDirectory() as folder:
        root = corpus.Folder(Path(folder)).made().root
        env = {**os.environ, "XDG_CACHE_HOME": str(root / "cache")}
        plain = _run(SIMULATE, root, env)
        for words in (SIMULATE, PREDICT, RECORD, ("calibrate", "volts.csv", "--overwrite")):
            for most in SMALL:
                tally.attempt("place: full disk", lambda w=words, m=most: _full(root, env, w, m))
            tally.attempt("place: /dev/full", lambda w=words: _device(root, env, w), words)
        for home in HOMES:
            tally.attempt("place: home", lambda h=home: _home(root, env, h, plain), repr(home))
        for spoil in (b"", b"\xff" * 999, None):
            tally.attempt("place: spoiled cache", lambda s=spoil: _cache(root, env, s, plain))
        for mode in (0o777, 0o500):
            tally.attempt("place: cache's rights", lambda m=mode: _rights(root, env, m, plain))
        tally.attempt("place: foreign processor", lambda: _foreign(root, env, plain))


def _run(
    words: tuple[str, ...],
    root: Path,
    env: Mapping[str, str],
    begin: Callable | None = None,
    program: tuple[str, ...] = ("-m", "tp_jax"),
) -> str:
    """Standard output; InputError where it was refused as it should be."""
    try:
        done = subprocess.run(
            [sys.executable, *program, *words],
            cwd=root,
            env=dict(env),
            capture_output=True,
            text=True,
            timeout=LONGEST,
            preexec_fn=begin,
        )
    except subprocess.TimeoutExpired as fault:
        raise Wrong(f"hangs: {words}") from fault
    if done.returncode == 0 and not done.stderr:
        return done.stdout
    if done.returncode == 0 and done.stderr.count("\n") == 1:  # a notice
        return done.stdout
    if done.returncode != 2 or done.stderr.count("\n") != 1:
        raise Wrong(f"exit code {done.returncode}: {done.stderr[-300:]}")
    raise InputError(done.stderr.strip())


def _full(root: Path, env: Mapping[str, str], words: tuple[str, ...], most: int) -> None:
    """Checks that what was there stays where nothing more can be written."""
    out = root / ("run.csv" if words is RECORD else "out")
    if words is not RECORD:
        out.write_text("what was there")
    limit = most, resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    try:
        _run(
            (*words, "--out", out.name),
            root,
            {**env, "TP_JAX_CACHE": "off"},
            lambda: resource.setrlimit(resource.RLIMIT_FSIZE, limit),
        )
    except InputError:
        if words is not RECORD and out.read_text() != "what was there":
            raise Wrong("what was there is gone") from None
        raise
    finally:
        for path in (out, Path(f"{out}.meta.json")):
            path.unlink(missing_ok=True)
        left = [p.name for p in root.glob(".*")]
        if left:
            raise Wrong(f"files are left: {left}")


def _device(root: Path, env: Mapping[str, str], words: tuple[str, ...]) -> None:
    _run((*words, "--out", "/dev/full"), root, env)


def _home(root: Path, env: Mapping[str, str], home: str | None, plain: str) -> None:
    """The result is the same without a cache."""
    left = {n: x for n, x in env.items() if n not in ("XDG_CACHE_HOME", "HOME")}
    if home is None:
        # HOME missing: the system knows another; it is not to be written to by an attack
        left["TP_JAX_CACHE"] = "off"
    else:
        left["HOME"] = home
    _same(_run(SIMULATE, root, left), plain)


def _cache(root: Path, env: Mapping[str, str], spoil: bytes | None, plain: str) -> None:
    """Files in the cache that are spoiled, cut in half, or somebody else's."""
    for file in (root / "cache").rglob("*"):
        if file.is_file():
            content = file.read_bytes()
            file.write_bytes(content[: len(content) // 2] if spoil is None else spoil)
    _same(_run(SIMULATE, root, env), plain)
    for file in (root / "cache").rglob("*"):
        os.utime(file, (1.0, 1.0))


def _rights(root: Path, env: Mapping[str, str], mode: int, plain: str) -> None:
    folder = root / "cache" / "tp-jax"
    folder.chmod(mode)
    try:
        _same(_run(SIMULATE, root, env), plain)
    finally:
        folder.chmod(0o700)


def _foreign(root: Path, env: Mapping[str, str], plain: str) -> None:
    """Checks that what was compiled for another processor is not run, though in the same cache."""
    code = (
        "import sys; from tp_jax import _processor; _processor.name = lambda: 'foreign'; "
        "from tp_jax.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    flags = f"{env.get('XLA_FLAGS', '')} --xla_cpu_max_isa=SSE4_2"
    _run(SIMULATE, root, {**env, "XLA_FLAGS": flags}, program=("-c", code))
    if not (root / "cache" / "tp-jax" / "foreign").is_dir():
        raise Wrong("another processor has the same folder")
    _same(_run(SIMULATE, root, env), plain)


def _same(out: str, plain: str) -> None:
    if out != plain:
        raise Wrong("the result differs")
