"""Colours on a terminal, the bare text elsewhere."""

import io

import pytest

from tp_jax.report import summary
from tp_jax.report.terminal import coloured, show


class Terminal(io.StringIO):
    """A stream that says it is one."""

    def isatty(self) -> bool:
        return True


def test_elsewhere_it_is_the_plain_summary(diagnosis):
    file = io.StringIO()
    show(diagnosis, file)
    assert file.getvalue() == summary(diagnosis) + "\n"


def test_the_words_stay_the_same(diagnosis):
    assert coloured(diagnosis).plain == summary(diagnosis)


def test_colours_on_a_terminal(made, monkeypatch):
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")
    file = Terminal()
    show(made("explained"), file)
    assert "\x1b[1;32m" in file.getvalue()
    assert "\x1b[36mcontact_stribeck" in file.getvalue()


@pytest.mark.parametrize(("name", "value"), [("NO_COLOR", "1"), ("TERM", "dumb")])
def test_no_colours_where_they_are_not_wanted(made, monkeypatch, name, value):
    monkeypatch.setenv(name, value)
    file = Terminal()
    show(made("explained"), file)
    assert "\x1b[3" not in file.getvalue()
