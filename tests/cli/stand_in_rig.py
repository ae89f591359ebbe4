"""Diagnoses of rigs that cost nothing: saved ones, by the campaign's name. Workers import this."""

import json
import os
import shutil
import time
from pathlib import Path
from typing import Any

from tests.report.conftest import KINDS
from tp_jax.cli.diagnosed import FITS, REPORT, RESULT, SCREEN
from tp_jax.cli.fleet import Rig
from tp_jax.errors import InputError
from tp_jax.report.fleet.rows import row

CPU_S = 0.1
"""Of a rig [s]."""


def diagnose_rig(rig: Rig) -> dict[str, Any]:
    """The saved diagnosis whose kind the campaign's folder names before its first dash.

    Scores of its screen are those that the campaign's folder holds, if any.
    """
    with (rig.campaign / "begun.txt").open("a") as file:
        file.write(f"{os.getpid()}\n")
    until = time.process_time() + CPU_S
    while time.process_time() < until:
        pass
    kind = rig.campaign.name.partition("-")[0]
    if kind == "faulty":
        raise InputError(f"{rig.campaign}/run.csv has no column t; add one.")
    if kind == "broken":
        raise ZeroDivisionError("division by zero")
    diagnosis = {**KINDS[kind](), "campaign": rig.campaign.name}
    rig.folder.mkdir(parents=True, exist_ok=True)
    (rig.folder / FITS).unlink(missing_ok=True)
    (rig.folder / RESULT).write_text(json.dumps(diagnosis), encoding="utf-8")
    (rig.folder / REPORT).write_text("<!DOCTYPE html><title>report</title>", encoding="utf-8")
    if (rig.campaign / SCREEN).is_file():
        shutil.copy(rig.campaign / SCREEN, rig.folder / SCREEN)
    return row(rig.name, diagnosis, f"{rig.folder.name}/{REPORT}")


def campaign(folder: Path) -> Path:
    """A campaign in name only."""
    folder.mkdir(parents=True)
    (folder / "campaign.toml").write_text('[[recording]]\nfile = "run.csv"\n')
    (folder / "run.csv").write_text("t,phi1\n")
    return folder
