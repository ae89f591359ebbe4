"""Files: received whole, never over one that is there, and none outside the folder."""

import dataclasses
import errno
import os
import shutil
import tomllib

import pytest

from tests.serve.conftest import COMMANDED, RUNS, TOKEN, answers, opened
from tp_jax.errors import InputError
from tp_jax.serve.answers import answers_of
from tp_jax.serve.folder import ServedFolder
from tp_jax.serve.limits import LIMITS
from tp_jax.serve.names import inside, readable, safe_name

RUN = next(file for file in RUNS if file.name == "run-06.csv")


@pytest.mark.parametrize(
    ("said", "name"),
    [
        ("run.csv", "run.csv"),
        ("../../run.csv", "run.csv"),
        ("/etc/passwd", "passwd"),
        ("C:\\data\\run.csv", "run.csv"),
        ("..\\run.csv", "run.csv"),
        (".hidden.csv", "hidden.csv"),
        ("a\x00b\n.csv", "ab.csv"),
        ('a<b>:"|?*.csv', "a-b------.csv"),
        ("Messung 3 µs.txt", "Messung 3 µs.txt"),
        ("campaign.toml", "campaign.toml"),
        ("run.csv.meta.json", "run.csv.meta.json"),
    ],
)
def test_names_are_made_safe(said, name):
    assert safe_name(said) == name


@pytest.mark.parametrize(
    "said", ["", "..", "a/..", "...", "\x00", "page.html", "a.py", "b" * 201, "測" * 70 + ".csv"]
)
def test_names_of_nothing_are_refused(said):
    with pytest.raises(InputError):
        safe_name(said)


def test_links_are_followed_before_they_are_judged(folder, tmp_path):
    (folder / "out").symlink_to(tmp_path)
    assert inside(folder, folder / "a.csv")
    assert not inside(folder, folder / "out" / "a.csv")
    assert not inside(folder, folder / ".." / "a.csv")
    (folder / "round").symlink_to(folder / "round")
    assert not readable(folder, folder / "round" / "diagnosis.json")


def test_what_the_file_system_refuses_is_told_in_a_sentence(client, folder, monkeypatch):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device", str(folder / "run.csv"))

    monkeypatch.setattr("tp_jax.serve.uploads.created", full)
    answer = client.put("/recordings/run.csv", content="t,phi1\n")
    assert answer.status_code == 507
    assert answer.text == "Cannot write run.csv: no space left on device."


@pytest.mark.parametrize("place", ["../../a.csv", "%2e%2e%2fa.csv", "..%5ca.csv", "%2Ftmp%2Fa.csv"])
def test_a_path_does_not_leave_the_folder(client, folder, place):
    before = set(folder.parent.iterdir())
    client.put(f"/recordings/{place}", content=b"t,phi1\n")
    assert set(folder.parent.iterdir()) == before
    assert {each.name for each in folder.iterdir()} <= {"a.csv"}


def test_a_file_is_shown_and_its_campaign_written(client, folder):
    answer = client.put("/recordings/run-06.csv", content=RUN.read_bytes())
    assert (answer.status_code, answer.text) == (201, "run-06.csv was added.")
    assert (folder / "run-06.csv").read_bytes() == RUN.read_bytes()
    page = client.get("/").text
    for words in ("run-06.csv", "250 Hz", "φ1 above φ2", "“phi2” in rad", "<polyline", "rad/s"):
        assert words in page
    written = tomllib.loads((folder / "campaign.toml").read_text(encoding="utf-8"))
    assert written["recording"][0]["omega"] == pytest.approx(6.0, rel=1e-2)


def test_nothing_is_replaced(client, folder):
    (folder / "a.csv").write_text("mine")
    answer = client.put("/recordings/a.csv", content=b"other")
    assert answer.status_code == 409
    assert "a.csv is there already" in answer.text
    (folder / "b.csv").symlink_to(folder.parent / "nowhere.csv")
    assert client.put("/recordings/b.csv", content=b"other").status_code == 409
    assert (folder / "a.csv").read_text() == "mine"
    assert sorted(each.name for each in folder.iterdir()) == ["a.csv", "b.csv"]


def test_what_is_too_large_leaves_nothing(folder):
    few = dataclasses.replace(LIMITS, upload=1000, files=1)

    def stream():
        for _ in range(11):
            yield b"x" * 100

    with opened(folder, limits=few) as client:
        client.get(f"/?token={TOKEN}")
        for content in (b"x" * 1001, stream()):  # the second does not say how long it is
            answer = client.put("/recordings/a.csv", content=content)
            assert answer.status_code == 413
            assert "a.csv has more than 0.001 MB" in answer.text
            assert list(folder.iterdir()) == []
        assert client.put("/recordings/a.csv", content=b"x" * 1000).status_code == 201
        answer = client.put("/recordings/b.csv", content=b"x")
        assert answer.status_code == 422
        assert "1 files" in answer.text


def test_answers_come_back(filled):
    with opened(filled) as client:
        client.get(f"/?token={TOKEN}")
        assert "Check these recordings" in client.get("/").text
        assert not (filled / "campaign.toml").exists(), "looking writes nothing"
        said = answers("1,2e-3", **COMMANDED)
        said["runs"]["run-22.csv"]["used"] = False
        assert client.post("/answers", json=said).json() == {"fault": ""}
        top = tomllib.loads((filled / "campaign.toml").read_text(encoding="utf-8"))
        assert top["rig"]["B1"] == 1.2e-3
        omegas = {each["file"]: each.get("omega") for each in top["recording"]}
        assert omegas["run-13.csv"] == 13.09
        assert omegas["decay.csv"] is None
        assert "run-22.csv" not in omegas
        page = client.get("/").text
        assert 'value="13.09"' in page
        assert 'value="0.0012"' in page
        assert "5 recordings can be diagnosed" in page
        # a file that comes later is in use, and the others stay as they were
        client.put("/recordings/late.csv", content=RUN.read_bytes())
        top = tomllib.loads((filled / "campaign.toml").read_text(encoding="utf-8"))
        names = [each["file"] for each in top["recording"]]
        assert "late.csv" in names
        assert "run-22.csv" not in names
        assert top["rig"]["B1"] == 1.2e-3


def test_answers_typed_while_a_file_comes_are_kept(filled):
    """And no digit of them is lost, whatever is answered later."""
    served = ServedFolder(filled)
    served.write(answers_of(answers("", **COMMANDED)))
    shutil.copy(RUN, filled / "late.csv")
    typed = {**COMMANDED, "run_13": "13.0899694"}
    served.write(answers_of(answers("1.284614e-3", **typed)))  # while late.csv was on its way
    served.added("late.csv")
    top = tomllib.loads((filled / "campaign.toml").read_text(encoding="utf-8"))
    assert top["rig"]["B1"] == 1.284614e-3
    omegas = {each["file"]: each.get("omega") for each in top["recording"]}
    assert omegas["run-13.csv"] == 13.0899694
    assert "late.csv" in omegas
    with opened(filled) as client:
        client.get(f"/?token={TOKEN}")
        assert 'value="13.0899694"' in client.get("/").text


def test_a_file_that_cannot_be_read_for_a_moment_keeps_its_answer(filled):
    served = ServedFolder(filled)
    served.write(answers_of(answers("", **COMMANDED)))
    run = filled / "run-13.csv"
    content = run.read_bytes()
    run.write_bytes(b"")  # as while something copies it
    shutil.copy(RUN, filled / "late.csv")
    served.added("late.csv")
    toml = filled / "campaign.toml"
    assert "run-13.csv" not in toml.read_text(encoding="utf-8")
    run.write_bytes(content)
    said = served.answers()
    assert said is not None
    assert said.driven["run-13.csv"].omega == 13.09
    assert "run-13.csv" not in said.unused
    shutil.copy(RUN, filled / "later.csv")
    served.added("later.csv")
    omegas = {
        each["file"]: each.get("omega")
        for each in tomllib.loads(toml.read_text("utf-8"))["recording"]
    }
    assert omegas["run-13.csv"] == 13.09
    # an entry that is taken out of the campaign.toml afterwards stays out
    text = toml.read_text("utf-8")
    head, *entries = text.split("[[recording]]")
    kept = [each for each in entries if "run-13.csv" not in each]
    toml.write_text("[[recording]]".join([head, *kept]), encoding="utf-8")
    said = served.answers()
    assert said is not None
    assert "run-13.csv" in said.unused


def test_a_campaign_of_ones_own_takes_the_place_of_the_pages(client, folder):
    client.put("/recordings/run-06.csv", content=RUN.read_bytes())
    own = b"[rig]\nB1 = 1.3e-3\n[[recording]]\nfile = 'run-06.csv'\nomega = 6.0\n"
    assert client.put("/recordings/campaign.toml", content=own).status_code == 201
    assert (folder / "campaign.toml").read_bytes() == own
    again = client.put("/recordings/campaign.toml", content=b"[rig]\n")
    assert again.status_code == 409
    assert "in an editor" in again.text
    assert (folder / "campaign.toml").read_bytes() == own


def test_a_file_of_another_make_puts_no_other_out(client, folder):
    """Though its name comes first."""
    rows = RUN.read_bytes()
    for name in ("m1.csv", "m2.csv"):
        client.put(f"/recordings/{name}", content=rows)
    runs = {"m1.csv": "6.25", "m2.csv": "7.5"}
    said = {n: {"used": True, "kind": "commanded", "omega": w} for n, w in runs.items()}
    assert client.post("/answers", json={"B1": "", "runs": said}).json() == {"fault": ""}
    client.put("/recordings/a.csv", content=rows.replace(b",", b";"))
    top = tomllib.loads((folder / "campaign.toml").read_text(encoding="utf-8"))
    omegas = {each["file"]: each.get("omega") for each in top["recording"]}
    assert omegas == {"m1.csv": 6.25, "m2.csv": 7.5}
    assert "Its columns differ from those of m1.csv" in client.get("/").text


def test_a_recording_below_the_folder_is_checked_again(folder):
    (folder / "raw").mkdir()
    file = folder / "raw" / "x.csv"
    file.write_bytes(RUN.read_bytes())
    entry = "[[recording]]\nfile = 'raw/x.csv'\nomega = 6.0\n"
    (folder / "campaign.toml").write_text(entry)
    served = ServedFolder(folder)
    assert not served.check().wrong
    head, *rest = RUN.read_text().splitlines()
    in_ms = [f"{1e3 * float(t)},{angles}" for t, _, angles in (r.partition(",") for r in rest)]
    file.write_text("\n".join([head, *in_ms]) + "\n")
    assert served.check().wrong


def test_a_drive_that_was_measured(client, folder):
    rows = RUN.read_text(encoding="utf-8").splitlines()
    text = "\n".join([f"{rows[0]},drive", *(f"{row},{i % 7}" for i, row in enumerate(rows[1:]))])
    client.put("/recordings/run.csv", content=text.encode())
    assert '<option value="measured">' in client.get("/").text
    runs = {"run.csv": {"used": True, "kind": "measured", "omega": "6"}}
    assert client.post("/answers", json={"B1": "", "runs": runs}).json() == {"fault": ""}
    top = tomllib.loads((folder / "campaign.toml").read_text(encoding="utf-8"))
    assert top["recording"] == [{"file": "run.csv", "drive": "measured"}]
    assert '<option value="measured" selected>' in client.get("/").text


@pytest.mark.parametrize(
    ("B1", "omega", "words"),
    [
        (
            "minus",
            "6",
            "B1, the inertia of the column, must be a number above zero, but is 'minus'",
        ),
        ("-1", "6", "B1"),
        ("", "", "run-06.csv: the frequency of its drive is missing"),
        ("", "six", "run-06.csv: the frequency of its drive must be a number"),
        ("", "inf", "run-06.csv"),
        ("", "1e155", "must be from 0.0001 to 10000 rad/s, but is 1e+155"),
        ("", "1e-300", "must be from"),
    ],
)
def test_answers_that_cannot_be_are_told_in_a_sentence(filled, B1, omega, words):
    with opened(filled) as client:
        client.get(f"/?token={TOKEN}")
        fault = client.post("/answers", json=answers(B1, run_06=omega)).json()["fault"]
        assert words in fault
        assert fault.endswith(".")
        assert not (filled / "campaign.toml").exists()


def test_checks_are_told(filled):
    with opened(filled) as client:
        client.get(f"/?token={TOKEN}")
        client.post("/answers", json=answers(**{**COMMANDED, "run_06": "37.7"}))  # in Hz times 2 pi
        page = client.get("/").text
        assert '<li class="wrong"><strong>To be mended:</strong> run-06.csv:' in page
        assert 'id="start" class="main" disabled' in page
        refused = client.post("/diagnoses")
        assert refused.status_code == 422
        assert "run-06.csv" in refused.text


def test_a_campaign_by_hand_stays(filled):
    text = (RUN.parent / "campaign.toml").read_text(encoding="utf-8")
    (filled / "campaign.toml").write_text(text, encoding="utf-8")
    with opened(filled) as client:
        client.get(f"/?token={TOKEN}")
        page = client.get("/").text
        assert "written by hand" in page
        assert "<fieldset disabled>" in page
        assert "by hand" in client.post("/answers", json=answers(**COMMANDED)).json()["fault"]
        client.put("/recordings/late.csv", content=RUN.read_bytes())
        assert (filled / "campaign.toml").read_text(encoding="utf-8") == text


def test_files_outside_are_not_read(filled, tmp_path):
    secret = tmp_path / "secret.csv"
    secret.write_bytes(RUN.read_bytes())
    (filled / "link.csv").symlink_to(secret)
    with opened(filled) as client:
        client.get(f"/?token={TOKEN}")
        page = client.get("/").text
        assert "It is a link out of the folder" in page
        (filled / "campaign.toml").write_text(
            '[[recording]]\nfile = "../secret.csv"\nforced = true\nomega = 6.0\n'
        )
        assert "../secret.csv: it lies outside the folder" in client.get("/").text
        os.remove(filled / "campaign.toml")
        (filled / "campaign.toml").symlink_to(tmp_path / "elsewhere.toml")
        assert "written by hand" in client.get("/").text
        assert "by hand" in client.post("/answers", json=answers(**COMMANDED)).json()["fault"]
        assert not (tmp_path / "elsewhere.toml").exists()


def test_a_fault_of_ours_leaves_the_page_whole(client, folder, monkeypatch):
    def odd(file):
        raise ValueError("odd")

    monkeypatch.setattr("tp_jax.serve.folder.survey", odd)
    assert client.put("/recordings/a.csv", content=b"t,phi1\n").status_code == 201
    assert "A fault of ours, ValueError: odd; leave the file out." in client.get("/").text


def test_faults_of_files_are_told_beside_them(client, folder):
    client.put("/recordings/notes.txt", content=b"nothing but words\n")
    page = client.get("/").text
    assert '<p class="fault">There are no rows' in page
    assert str(folder) not in page
    client.put("/recordings/<b>.txt", content=b"<script>alert(1)</script>\n")
    assert "<script>alert" not in client.get("/").text


def test_a_name_that_is_no_text_is_told_beside_it(client, folder):
    shutil.copy(RUN, os.path.join(os.fsencode(folder), b"m\xe4ssung.csv"))
    page = client.get("/")
    assert page.status_code == 200
    assert "its name is no text in UTF-8; rename the file" in page.text.replace("Its", "its")
    shutil.copy(RUN, folder / "run.csv")
    ServedFolder(folder).added("run.csv")
    assert "run.csv" in (folder / "campaign.toml").read_text()
