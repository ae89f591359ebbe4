"""The command: its address, its folder, its end, and what it says where it cannot begin."""

import builtins
import os
import re
import signal
import socket
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from tp_jax.cli import main
from tp_jax.cli.serve import NEW

ROOT = Path(__file__).parents[2]


@pytest.fixture
def started():
    """Starts the command in a process of its own; the process, and the address that it prints."""
    running = []

    def start(folder: Path, *words: str) -> tuple["subprocess.Popen[str]", str]:
        process = subprocess.Popen(
            [sys.executable, "-m", "tp_jax", "serve", "--no-browser", *words],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
        )
        running.append(process)
        assert process.stdout is not None
        return process, process.stdout.readline().strip()

    yield start
    for process in running:  # whatever a test that failed has left
        if process.poll() is None:
            process.kill()
            process.communicate()


def ended(process: "subprocess.Popen[str]") -> str:
    """What it wrote on standard error, once Ctrl-C has ended it well."""
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 0
    return told


def test_it_serves_until_interrupted(tmp_path, started):
    process, address = started(tmp_path)
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=[\w-]{43}", address)
    new = tmp_path / NEW
    assert new.is_dir()
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    with opener.open(address) as answer:
        assert answer.status == 200
        assert "token" not in answer.url
        assert NEW in answer.read().decode()
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(address.partition("?")[0])
    with refused.value:
        assert refused.value.code == 403
    assert ended(process) == ""
    assert not new.exists(), "nothing came into it"


def test_a_new_folder_is_another_one(tmp_path, started):
    (tmp_path / NEW).mkdir()
    process, _ = started(tmp_path)
    second = tmp_path / f"{NEW}-2"
    assert second.is_dir()
    (second / "run.csv").write_text("t,phi1\n")
    ended(process)
    assert (second / "run.csv").is_file()


def test_each_start_has_a_key_of_its_own(tmp_path):
    from tp_jax.serve.server import bind

    one, other = bind(tmp_path), bind(tmp_path)
    assert one.port != other.port
    assert one.address.partition("=")[2] != other.address.partition("=")[2]
    for bound in (one, other):
        bound._listening.close()


def test_a_port_that_is_taken_is_told(tmp_path, capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["serve", str(tmp_path), "--no-browser", "--port", str(port)]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"tp-jax: Port {port} cannot be used")
    assert told.count("\n") == 1


@pytest.mark.parametrize("port", ["-1", "65536", "http"])
def test_what_is_no_port_is_told(port, capsys):
    assert main(["serve", "--port", port]) == 2
    assert "--port must be" in capsys.readouterr().err


def test_what_is_no_folder_is_told(tmp_path, capsys):
    assert main(["serve", str(tmp_path / "none")]) == 2
    assert "none is no folder" in capsys.readouterr().err


@pytest.mark.parametrize("missing", ["starlette", "uvicorn"])
def test_a_missing_library_is_told_with_its_mend(monkeypatch, capsys, missing, tmp_path):
    real = builtins.__import__

    def without(name, *rest, **more):
        if name.partition(".")[0] == missing:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return real(name, *rest, **more)

    for name in list(sys.modules):
        if name.startswith(("tp_jax.serve.", missing)):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(builtins, "__import__", without)
    monkeypatch.chdir(tmp_path)
    assert main(["serve"]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert missing in told
    assert "pip install 'tp-jax[serve]'" in told
    assert list(tmp_path.iterdir()) == [], "no folder is made"
