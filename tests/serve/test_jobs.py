"""Diagnoses: started, watched, cancelled, listed, compared; none outlives the server."""

import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from tests.serve.conftest import COMMANDED, STAND_IN, TOKEN, answers, opened, standing_in
from tp_jax.errors import InputError
from tp_jax.serve.diagnoses import Diagnoses
from tp_jax.serve.jobs import Jobs, _progress, diagnosing
from tp_jax.serve.limits import LIMITS

PATIENCE = 60.0  # s: the machine may be busy


def until(said, patience: float = PATIENCE):
    """What `said` gives once it is true."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        found = said()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError("waited in vain")


@pytest.fixture
def ready(filled):
    """A folder that can be diagnosed."""
    with opened(filled) as client:
        client.get(f"/?token={TOKEN}")
        assert client.post("/answers", json=answers("1.2e-3", **COMMANDED)).json()["fault"] == ""
    return filled


def state(client) -> str:
    return client.get("/job").json()["state"]


def test_from_start_to_report(ready):
    with opened(ready) as client:
        client.get(f"/?token={TOKEN}")
        assert state(client) == "none"
        begun = client.post("/diagnoses")
        assert (begun.status_code, begun.json()["state"]) == (202, "running")
        again = client.post("/diagnoses")
        assert again.status_code == 422
        assert "running" in again.text
        seen = until(lambda: (j := client.get("/job").json())["part"] and j)
        assert seen["stage"].startswith("fitting windows")
        assert 0.0 < seen["part"] <= 1.0
        done = until(lambda: (j := client.get("/job").json())["state"] != "running" and j)
        assert done["state"] == "done", done
        assert done["messages"] == ["run-06.csv: a doubt; look at it."]
        page = client.get("/").text
        assert 'href="/diagnoses/diagnosis-1/report"' in page
        assert "The gap is explained" in page
        report = client.get("/diagnoses/diagnosis-1/report")
        assert report.headers["content-security-policy"].startswith("default-src 'none'; style-src")
        assert "The gap is explained" in report.text


def test_two_are_compared(ready):
    with opened(ready) as client:
        client.get(f"/?token={TOKEN}")
        client.post("/diagnoses")
        until(lambda: state(client) == "done")
        shutil.copytree(ready / "diagnosis-1", ready / "before repair")
        page = client.get("/").text
        assert "/diagnoses/before%20repair/report" in page
        answer = client.get("/compare", params={"a": "diagnosis-1", "b": "before repair"})
        assert answer.status_code == 200
        for words in ("verdict", "first cause", "gap gone", "contact_stribeck", "before repair"):
            assert words in answer.text
        for name in ("nothing", "../my rig/diagnosis-1", ""):
            refused = client.get("/compare", params={"a": "diagnosis-1", "b": name})
            assert refused.status_code == 422


def test_only_reports_of_the_list_are_read(ready, tmp_path):
    (tmp_path / "report.html").write_text("secret")
    (tmp_path / "diagnosis.json").write_text("{}")
    (ready / "linked").symlink_to(tmp_path)
    (ready / "report.html").write_text("secret")
    (ready / "odd").mkdir()
    (ready / "odd" / "diagnosis.json").write_text('{"schema": "tp-jax/diagnosis/9"}')
    (ready / "round").symlink_to(ready / "round")
    with opened(ready) as client:
        client.get(f"/?token={TOKEN}")
        for name in ("linked", "..", "%2e%2e", "..%2f..", ".", "nothing", "odd"):
            answer = client.get(f"/diagnoses/{name}/report")
            assert answer.status_code in (404, 405)
            assert "secret" not in answer.text
        page = client.get("/").text
        assert "odd/diagnosis.json is of the version tp-jax/diagnosis/9" in page
        assert str(ready) not in page


def test_a_failure_says_why_and_leaves_nothing(ready):
    with opened(ready, "fail") as client:
        client.get(f"/?token={TOKEN}")
        client.post("/diagnoses")
        until(lambda: state(client) == "failed")
        assert "run-06.csv: a fault; mend it." in client.get("/job").json()["messages"]
        assert not (ready / "diagnosis-1").exists()


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("raise SystemExit(3)", "ended with the code 3; it said nothing."),
        ("raise ValueError('odd')", "ended with the code 1; its last words: ValueError: odd."),
    ],
)
def test_a_child_that_says_no_sentence(folder, code, words):
    jobs = Jobs(lambda *_: [sys.executable, "-c", code], LIMITS)
    jobs.start(folder, folder / "diagnosis-1")
    until(lambda: jobs.status().state == "failed")
    assert jobs.status().messages == (f"The diagnosis {words}",)


def test_words_of_libraries_are_no_messages(folder):
    code = "import sys; print('W0000 of a library', file=sys.stderr)"
    jobs = Jobs(lambda *_: [sys.executable, "-c", code], LIMITS)
    jobs.start(folder, folder / "diagnosis-1")
    until(lambda: jobs.status().state == "done")
    assert jobs.status().messages == ()


def test_cancelling_ends_the_child(ready):
    with opened(ready, "hang") as client:
        client.get(f"/?token={TOKEN}")
        client.post("/diagnoses")
        until(lambda: client.get("/job").json()["stage"].startswith("fitting"))
        assert client.delete("/job").json()["state"] == "cancelled"
        assert not (ready / "diagnosis-1").exists()
        assert client.delete("/job").json()["state"] == "cancelled", "once more does nothing"
        assert client.post("/diagnoses").status_code == 202, "another can begin"


def test_closing_ends_the_child(ready):
    with opened(ready, "hang") as client:
        client.get(f"/?token={TOKEN}")
        client.post("/diagnoses")
        until(lambda: client.get("/job").json()["stage"].startswith("fitting"))
    assert not (ready / "diagnosis-1").exists()


def test_a_child_that_will_not_end_is_killed(folder):
    patient = "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); time.sleep(600)"
    jobs = Jobs(lambda *_: [sys.executable, "-c", patient], replace(LIMITS, grace=1.0))
    jobs.start(folder, folder / "diagnosis-1")
    time.sleep(0.5)
    jobs.close()
    assert jobs.status().state == "cancelled"
    with pytest.raises(InputError):
        jobs.start(folder, folder / "diagnosis-2")


def test_a_killed_server_takes_the_child_along(folder):
    """Its standard input closes with the server, however that ends."""
    code = (
        "import sys, time; from pathlib import Path\n"
        "from tp_jax.serve.jobs import Jobs; from tp_jax.serve.limits import LIMITS\n"
        "here = Path(sys.argv[1])\n"
        "jobs = Jobs(lambda c, o: [sys.executable, sys.argv[2], str(o), 'hang'], LIMITS)\n"
        "jobs.start(here, here / 'diagnosis-1')\n"
        "while not jobs.status().messages: time.sleep(0.05)\n"
        "print('begun', flush=True); time.sleep(600)"
    )
    server = subprocess.Popen(
        [sys.executable, "-c", code, str(folder), str(STAND_IN)],
        stdout=subprocess.PIPE,
        cwd=Path(__file__).parents[2],
    )
    assert server.stdout is not None
    assert server.stdout.readline() == b"begun\n"
    os.kill(server.pid, signal.SIGKILL)
    server.wait()
    server.stdout.close()
    until(lambda: (folder / "ended.txt").is_file())


def test_the_real_child_writes_progress_and_ends_with_its_starter(ready):
    """`tp-jax diagnose` as the page runs it; the diagnosis itself is not waited for."""
    jobs = Jobs(diagnosing, LIMITS)
    jobs.start(ready, ready / "diagnosis-1")
    until(lambda: jobs.status().stage not in ("", "starting") or jobs.status().state != "running")
    assert jobs.status().state == "running", jobs.status()
    process = jobs._process
    assert process is not None
    assert process.stdin is not None
    process.stdin.close()  # as it does when the server is killed
    until(lambda: jobs.status().state != "running")
    assert process.returncode not in (0, None)


@pytest.mark.parametrize(
    "line", ["", "tp-jax: a word.", "{", "{}", '{"stage": 1}', '{"stage": "a", "part": "b"}', "[1]"]
)
def test_other_lines_are_no_progress(line):
    assert _progress(line) is None


def test_progress_is_read():
    assert _progress('{"stage": "a", "part": null}') == ("a", None)
    assert _progress('{"stage": "a", "part": 1.5}') == ("a", 1.0)


def test_the_stand_in_is_there():
    assert standing_in()(Path("a"), Path("b"))[1] == str(STAND_IN)


def test_a_job_is_looked_at_before_the_rows(client, monkeypatch):
    """One that ends in between would else be done and have no row, and the page ask no more."""
    looked = []
    status, rows = Jobs.status, Diagnoses.rows
    monkeypatch.setattr(Jobs, "status", lambda self: looked.append("job") or status(self))
    monkeypatch.setattr(Diagnoses, "rows", lambda self: looked.append("rows") or rows(self))
    assert client.get("/").status_code == 200
    assert looked[:2] == ["job", "rows"]
