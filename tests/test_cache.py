"""The folder of kept programs: its size, what is spoiled in it, and who writes at once."""

import os
import subprocess
import sys
import time
import zlib
from pathlib import Path

import pytest

from tp_jax import _cache
from tp_jax._cache import Policy, clean, whole

SMALL = Policy(most_bytes=1000, kept_bytes=600)


def put(folder: Path, name: str, content: bytes, age: float = 0.0) -> Path:
    """A file that was last used so many seconds ago."""
    file = folder / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(content)
    then = time.time() - age
    os.utime(file, (then, then))
    return file


def test_what_was_not_used_for_longest_goes(tmp_path):
    files = [put(tmp_path / f"cpu{i % 2}", f"p{i}", b"x" * 250, 5000.0 - 100 * i) for i in range(5)]
    os.utime(files[0])  # used just now
    clean(tmp_path, SMALL)
    assert [f.is_file() for f in files] == [True, False, False, False, True]


def test_nothing_goes_within_the_limit(tmp_path):
    files = [put(tmp_path, f"p{i}", b"x" * 250, 5000.0) for i in range(4)]
    clean(tmp_path, SMALL)
    assert all(f.is_file() for f in files)


@pytest.mark.parametrize("content", [b"", b"nothing", b"half"])
@pytest.mark.parametrize("kind", ["zlib", "zstandard"])
def test_spoiled_files_go_once_nobody_writes_them(tmp_path, content, kind):
    pack = zlib.compress
    if kind == "zstandard":
        pack = pytest.importorskip("zstandard").ZstdCompressor().compress
    good = pack(os.urandom(4000))
    spoiled = good[: len(good) // 2] if content == b"half" else content
    kept = put(tmp_path, "a-cache", good, 100.0)
    gone = put(tmp_path, "b-cache", spoiled, 100.0)
    written = put(tmp_path, "c-cache", spoiled)
    clean(tmp_path)
    assert kept.is_file()
    assert not gone.exists()
    assert written.is_file()


def test_files_are_looked_into_once(tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr(_cache, "whole", lambda path: seen.append(path.name) or True)
    put(tmp_path, "a-cache", b"", 100.0)
    clean(tmp_path)
    put(tmp_path, "b-cache", b"", 59.0)
    clean(tmp_path, Policy(settled_s=50.0))
    clean(tmp_path)
    assert seen == ["a-cache", "b-cache"]


def test_what_nothing_can_unpack_stays(tmp_path, monkeypatch):
    monkeypatch.setattr(_cache, "_zstd", lambda: None)
    assert whole(put(tmp_path, "a", _cache.ZSTD + b"whatever"))


def test_what_a_writer_left_that_was_killed_goes(tmp_path):
    old, new = put(tmp_path, ".p.1", b"x", 100.0), put(tmp_path, ".p.2", b"x")
    clean(tmp_path)
    assert not old.exists()
    assert new.is_file()


def test_links_and_folders_stay(tmp_path):
    outside = put(tmp_path / "outside", "file", b"x" * 5000, 9000.0)
    root = tmp_path / "root"
    (root / "folder-cache").mkdir(parents=True)
    (root / "link-cache").symlink_to(outside)
    clean(root, SMALL)
    assert outside.is_file()
    assert (root / "link-cache").is_symlink()


def test_cleaned_by_many_at_once(tmp_path):
    for i in range(200):
        put(tmp_path, f"p{i}-cache", b"x" * 100, 1000.0 + i)
    code = (
        "import sys; from pathlib import Path; from tp_jax._cache import Policy, clean; "
        "clean(Path(sys.argv[1]), Policy(most_bytes=1000, kept_bytes=600))"
    )
    words = [sys.executable, "-c", code, str(tmp_path)]
    at_once = [
        subprocess.Popen(words, cwd=Path(__file__).parent.parent, stderr=subprocess.PIPE)
        for _ in range(3)
    ]
    assert [(p.wait(), p.communicate()[1]) for p in at_once] == [(0, b"")] * 3
    assert sum(f.stat().st_size for f in tmp_path.iterdir()) <= 600
