"""Sections of a campaign.toml: values of the right type, and the line of what is wrong."""

import math
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from tp_jax._files import bytes_of
from tp_jax.recordings.faults import CampaignError, listed, nearest, reason
from tp_jax.recordings.units import named

_HEADING = re.compile(r"\s*\[")


@dataclass(frozen=True)
class Section:
    """A table of a TOML file.

    Attributes:
        file: the TOML file.
        title: as in the file, "[rig]"; "" for the top.
        values: key -> value.
        lines: of the whole file.
        begin: index in `lines` of its heading.
        end: index in `lines` of the line after its last.
    """

    file: Path
    title: str
    values: dict[str, Any]
    lines: Sequence[str]
    begin: int
    end: int

    def fault(self, wrong: str, mend: str, key: str | None = None) -> NoReturn:
        """Raises a CampaignError at the line of a key, or of the heading."""
        raise CampaignError(self.file, wrong, mend, self.line(key))

    def line(self, key: str | None = None) -> int | None:
        """1-based line of a key; of the heading where the key is not found; None for the top."""
        if key is not None:
            pattern = re.compile(rf"(^|[\s{{,.\[\"']){re.escape(key)}[\"']?\s*[=.\]]")
            own = range(self.begin, self.end)
            # A table of its own, [key], stands below the lines of its parent.
            heads = (i for i in range(len(self.lines)) if _HEADING.match(self.lines[i]))
            for i in (*own, *heads):
                if pattern.search(self.lines[i].split("#")[0]):
                    return i + 1
        return self.begin + 1 if self.title else None

    def only(self, *known: str) -> None:
        """Faults a key that is not among the known ones."""
        for key in self.values:
            if key not in known:
                near = nearest(key, known)
                mend = f'did you mean "{near}"?' if near else f"the keys are {listed(known, 12)}"
                self.fault(f'the key "{key}"{self._in()} is unknown', mend, key)

    def text(self, key: str) -> str | None:
        """A string that is not empty, or None where the key is absent."""
        value = self.values.get(key)
        if value is not None and not (isinstance(value, str) and value):
            self.fault(f"{key}{self._in()} is no text", f'write {key} = "..."', key)
        return value

    def flag(self, key: str) -> bool | None:
        value = self.values.get(key)
        if value is not None and not isinstance(value, bool):
            self.fault(
                f"{key}{self._in()} is neither true nor false", f"write {key} = true or false", key
            )
        return value

    def number(self, key: str) -> float | None:
        """A finite number."""
        value = self.values.get(key)
        return None if value is None else self._number(key, value)

    def positive(self, key: str) -> float | None:
        """A finite number above zero."""
        value = self.number(key)
        if value is not None and value <= 0.0:
            self.fault(
                f"{key}{self._in()} is {value:g}, not positive",
                f"give a number above zero or remove {key}",
                key,
            )
        return value

    def unit(self, key: str, units: Mapping[str, float]) -> float | None:
        """The factor of a unit; None where the key is absent."""
        text = self.text(key)
        if text is None:
            return None
        name = named(text, units)
        if name is None:
            self.fault(f'the unit "{text}"{self._in()} is unknown', one_of(units), key)
        return units[name]

    def whole(self, key: str) -> int | None:
        """A whole number, zero or above."""
        value = self.values.get(key)
        if value is not None and (type(value) is not int or value < 0):
            self.fault(f"{key}{self._in()} is no count", f"write a whole number, {key} = 5", key)
        return value

    def pair(self, key: str) -> tuple[float, float] | None:
        """Two finite numbers."""
        value = self.values.get(key)
        if value is None:
            return None
        if not isinstance(value, list) or len(value) != 2:
            self.fault(
                f"{key}{self._in()} is no pair of numbers", f"write {key} = [0.0, 200.0]", key
            )
        return self._number(key, value[0]), self._number(key, value[1])

    def section(self, key: str) -> "Section | None":
        """The table under a key."""
        value = self.values.get(key)
        if value is None:
            return None
        title = f"[{self.title[1:-1]}.{key}]" if self.title else f"[{key}]"
        if not isinstance(value, dict):
            self.fault(f"{key}{self._in()} is no table", f"write it as {title}", key)
        begin, end = _region(self.lines, re.escape(title))
        if begin is None:  # written in the parent's lines: key = { ... }
            begin, end = self.begin, self.end
        return Section(self.file, title, value, self.lines, begin, end)

    def sections(self, key: str) -> "list[Section]":
        """The tables of an array of tables, [[key]]."""
        value = self.values.get(key, [])
        title = f"[[{key}]]"
        if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
            self.fault(f"{key} is no list of tables", f"begin each of them with {title}", key)
        found = []
        for i, each in enumerate(value):
            begin, end = _region(self.lines, re.escape(title), i)
            if begin is None:
                begin, end = self.begin, self.end
            found.append(Section(self.file, title, each, self.lines, begin, end))
        return found

    def _in(self) -> str:
        return f" in {self.title}" if self.title else ""

    def _number(self, key: str, value: Any) -> float:
        # bool is an int in Python, not in TOML
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.fault(f"{key}{self._in()} is no number", "write a number without quotes", key)
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            self.fault(f"{key}{self._in()} is {number}", "give a finite number", key)
        return number


def one_of(names: Iterable[str]) -> str:
    """Says what to write: one of a few names."""
    return f"write one of {listed(names, 12)}"


def read_toml(file: Path) -> Section:
    """The top of a TOML file.

    Raises:
        CampaignError: the file cannot be read or is no TOML.
    """
    try:
        text = bytes_of(file).decode("utf-8-sig")
    except OSError as error:
        raise CampaignError(
            file, f"the file cannot be read ({reason(error)})", "name a text file that can be read"
        ) from error
    except UnicodeDecodeError as error:
        raise CampaignError(
            file, "the file is no text in UTF-8", "save it in that encoding"
        ) from error
    lines = text.replace("\r\n", "\n").split("\n")
    try:
        values = tomllib.loads(text)
    # TOMLDecodeError is a ValueError; a number of 5000 digits raises another
    except (ValueError, RecursionError) as error:
        what, _, place = str(error).rstrip(")").partition(" (at ")
        at = re.match(r"line (\d+)", place)
        raise CampaignError(
            file,
            f"this is no TOML, {what[:1].lower()}{what[1:]}",
            'write it as key = value, text in quotes, e.g. file = "run-13.csv"',
            int(at[1]) if at else len(lines),
        ) from error
    end = next((i for i, line in enumerate(lines) if _HEADING.match(line)), len(lines))
    return Section(file, "", values, lines, 0, end)


def _region(lines: Sequence[str], title: str, nth: int = 0) -> tuple[int | None, int]:
    """First line of the nth section of a title, and the line after its last."""
    heads = [i for i, line in enumerate(lines) if _HEADING.match(line)]
    own = [i for i in heads if re.fullmatch(rf"\s*{title}\s*(#.*)?", lines[i])]
    if nth >= len(own):
        return None, 0
    begin = own[nth]
    return begin, next((i for i in heads if i > begin), len(lines))
