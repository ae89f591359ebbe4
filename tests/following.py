"""Does what a sentence about a campaign advises, word by word: advice, followed, must help."""

import re
from pathlib import Path


def follow(folder: Path, told: str) -> None:
    """Edits the campaign.toml, or the file named, as the sentence says.

    Raises:
        AssertionError: it says nothing that one could do.
    """
    file = re.search(r"([^/\s]+\.csv)(?:, line (\d+))?: ", told)
    if one := re.search(r"write (\w.*?) for (\w+)(?: and (\w+))? under \[format\.col", told):
        for column in filter(None, (one[2], one[3])):
            _set(folder, "format.columns", f"{column} = {{ {one[1]} }}")
    elif under := re.search(r"write (.+) under \[format\.columns\]", told):
        for setting in re.findall(r"\w+ = \{[^}]*\}", under[1]):
            _set(folder, "format.columns", setting)
    elif "held = true under [format]" in told:
        _set(folder, "format", "held = true")
    elif beside := re.search(r'write (columns = \{.*\}) beside file = "([^"]+)"', told):
        _replace(folder, f'file = "{beside[2]}"', f'file = "{beside[2]}"\n{beside[1]}')
    elif re.search(r"remove (the|these) (line|row)s?\b", told):
        assert file is not None
        numbers = re.search(r"lines ([\d, ]+\d)", told)
        which = [int(n) for n in (numbers[1].split(", ") if numbers else [file[2]])]
        lines = _lines(folder / file[1])
        _write(folder / file[1], [line for i, line in enumerate(lines, 1) if i not in which])
    elif "split the file before this line" in told:
        assert file is not None
        _split(folder, file[1], int(file[2]))
    elif "put the rows in order of time" in told:
        assert file is not None
        head, *rows = _lines(folder / file[1])
        _write(folder / file[1], [head, *sorted(rows, key=lambda row: float(row.split(",")[0]))])
    else:
        raise AssertionError(f"nothing to do is said in: {told}")


def _split(folder: Path, name: str, line: int) -> None:
    lines = _lines(folder / name)
    above, below = lines[: line - 1], lines[line - 1 :]
    if not any(c.isalpha() for c in below[0].replace("e", "")):  # the names are above only
        below = [lines[0], *below]
    _write(folder / name, above)
    _write(folder / f"second-{name}", below)
    toml = (folder / "campaign.toml").read_text(encoding="utf-8")
    entry = toml[toml.index("[[recording]]") :]
    _write(folder / "campaign.toml", [toml, entry.replace(name, f"second-{name}")])


def _lines(file: Path) -> list[str]:
    return file.read_text(encoding="utf-8").rstrip("\n").split("\n")


def _write(file: Path, lines: list[str]) -> None:
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _replace(folder: Path, old: str, new: str) -> None:
    file = folder / "campaign.toml"
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new, 1), encoding="utf-8")


def _set(folder: Path, section: str, setting: str) -> None:
    """Puts a setting into a section of the campaign.toml, in place of the one of its name."""
    lines = _lines(folder / "campaign.toml")
    name = setting.split(" = ")[0]
    if f"[{section}]" not in lines:
        at = lines.index("[[recording]]")
        _write(folder / "campaign.toml", [*lines[:at], f"[{section}]", setting, *lines[at:]])
        return
    begin = lines.index(f"[{section}]")
    end = next((i for i in range(begin + 1, len(lines)) if lines[i].startswith("[")), len(lines))
    own = [line for line in lines[begin + 1 : end] if not line.startswith(f"{name} =")]
    _write(folder / "campaign.toml", [*lines[: begin + 1], setting, *own, *lines[end:]])
