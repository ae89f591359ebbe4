"""Effects of other packages: a broken one is named and left out."""

import warnings
from importlib import metadata
from types import SimpleNamespace

import pytest

from tests.standing_in import standing_in
from tp_jax import effects
from tp_jax.effects import registry
from tp_jax.effects.base import Amplitude, Effect
from tp_jax.errors import Notice


class Whole(Effect):
    id = "rubber_band"
    location = "column"
    hook = "column"
    amplitudes = (Amplitude("a", "N m/rad"),)

    def increment(self, m, a):
        return -a * m.phi1


class Nameless(Whole):
    id = ""


class Taken(Whole):
    id = "clock_skew"


class NoEffect:
    id = "no_effect"


def entry(name, load):
    dist = SimpleNamespace(name="their-package")
    return standing_in(metadata.EntryPoint, name=name, value=f"theirs:{name}", dist=dist, load=load)


def raising(fault):
    def load():
        raise fault

    return load


@pytest.fixture
def installed(monkeypatch):
    """Puts entry points in the place of those that are there."""
    registry._built_in.cache_clear()

    def put(*entries):
        monkeypatch.setattr(metadata, "entry_points", lambda group: entries)

    yield put
    registry._built_in.cache_clear()


def test_a_whole_one_is_in_the_catalogue(installed):
    installed(entry("whole", lambda: Whole))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert "rubber_band" in effects.catalogue()


@pytest.mark.parametrize(
    ("load", "said"),
    [
        (raising(ImportError("no module named\ntheirs")), "ImportError: no module named theirs"),
        (raising(SystemExit(3)), "SystemExit: 3"),
        (raising(ZeroDivisionError()), "ZeroDivisionError"),
        (lambda: Nameless, "must have an identifier"),
        (lambda: Taken, "there is an effect 'clock_skew' already"),
        (lambda: NoEffect, "makes no tp_jax.effects.Effect"),
        (lambda: 7, "TypeError"),
    ],
)
def test_a_broken_one_is_left_out(load, said, installed):
    installed(entry("broken", load), entry("whole", lambda: Whole))
    with pytest.warns(Notice) as told:
        found = effects.catalogue()
    assert "rubber_band" in found
    assert type(found["clock_skew"]) is not Taken
    (sentence,) = [str(each.message) for each in told]
    assert sentence.startswith("The effect plug-in broken of their-package is left out (")
    assert said in sentence
    assert "\n" not in sentence
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        effects.catalogue()  # told once
