"""How a study ends."""

import argparse

import pytest

from scripts._carried_out import carried_out
from tp_jax.errors import InputError


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
