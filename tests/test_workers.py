"""Tasks of a study in processes of their own, and how a study ends."""

import argparse
import os
import time

import pytest

from scripts._carried_out import carried_out
from scripts._workers import fault_of, over_all_cores
from tp_jax.errors import InputError

LATER = 1e9  # s


def worked(number, kind="well"):
    if kind == "badly":
        raise ValueError("on purpose")
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    return number, os.getpid(), processors


def test_all_tasks_end_each_on_one_processor():
    tasks = [(0,), (1,), (2, "badly"), (3,)]
    ended = dict(over_all_cores(worked, tasks, 2, time.monotonic() + LATER, last=1))
    assert set(ended) == set(tasks)
    assert fault_of(ended.pop((2, "badly"))) == "ValueError: on purpose"
    results = [future.result() for future in ended.values()]
    assert sorted(number for number, _, _ in results) == [0, 1, 3]
    assert {processors for _, _, processors in results} == {1}
    # after two tasks, one of each, other processes take over
    assert len({process for _, process, _ in results}) >= 2


def test_none_begins_too_late():
    assert list(over_all_cores(worked, [(0,)], 1, time.monotonic() - 1.0)) == []


@pytest.mark.parametrize(
    ("resumes", "words"), [(True, "the same call goes on from here."), (False, "interrupted.")]
)
def test_an_interrupted_study_says_whether_it_resumes(resumes, words, capsys):
    def interrupted(args):
        raise KeyboardInterrupt

    args = argparse.Namespace(debug=False)
    assert carried_out("study", interrupted, args, resumes=resumes) == 130
    assert words in capsys.readouterr().err


def test_a_fault_is_one_sentence(capsys):
    def faulty(args):
        raise InputError("There is no rig 7; give one of 0 to 3.")

    assert carried_out("study", faulty, argparse.Namespace(debug=False), resumes=True) == 2
    told = capsys.readouterr().err
    assert "There is no rig 7; give one of 0 to 3." in told
    assert "Traceback" not in told
    assert carried_out("study", lambda args: 1, argparse.Namespace(debug=False), resumes=True) == 1
