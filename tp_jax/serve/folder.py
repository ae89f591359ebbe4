"""The served folder: its data files, its campaign.toml, what is wrong with both."""

import os
import threading
from dataclasses import dataclass, replace
from pathlib import Path

from tp_jax._files import replaced
from tp_jax.checks import Checked, Finding, check
from tp_jax.checks.proposal import Answers, Driven, alike, data_files, guessed, written
from tp_jax.checks.survey import Survey, survey
from tp_jax.errors import InputError
from tp_jax.recordings.entries import Entry, Plan, read_plan
from tp_jax.recordings.faults import CampaignError
from tp_jax.serve.answers import REMARK
from tp_jax.serve.names import CAMPAIGN, inside

Mark = tuple[tuple[str, int, int], ...]


@dataclass(frozen=True)
class File:
    """A data file, as it was found.

    Attributes:
        path: of the file.
        survey: what it holds; None where it cannot be read or does not go with the others.
        fault: why not, in a sentence; empty where there is a survey.
        guess: how it seems to have been driven.
    """

    path: Path
    survey: Survey | None = None
    fault: str = ""
    guess: Driven | None = None


class ServedFolder:
    """A folder of recordings; its methods may be called from any thread.

    Attributes:
        path: of the folder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.RLock()
        self._seen: dict[Path, tuple[Mark, File]] = {}
        self._checked: tuple[Mark, Checked] | None = None
        # of files in use that could not be read when the campaign.toml was written without them
        self._given: dict[str, Driven] = {}

    @property
    def campaign(self) -> Path:
        """Its campaign.toml, which need not be there."""
        return self.path / CAMPAIGN

    def files(self) -> list[File]:
        """Its data files by name; those whose columns differ from the others' have a fault.

        The others are those of the campaign.toml: a file that comes later, whatever its name, does
        not put them out of it.
        """
        with self._lock:
            found = [self._look(path) for path in data_files(self.path)]
        pairs = [(file.path, file.survey) for file in found if file.survey is not None]
        if not pairs:
            return found
        there = {entry.file for entry in self._entries()}
        _, others = alike(pairs, next((pair for pair in pairs if pair[0] in there), None))
        return [
            replace(file, survey=None, fault=self.told(others[file.path]))
            if file.path in others
            else file
            for file in found
        ]

    def answers(self) -> Answers | None:
        """Reads what its campaign.toml says of the rig and its runs, whoever wrote it.

        None where there is none to be read.
        """
        plan = self._plan()
        if plan is None:
            return None
        driven = {each.file.name: _driven(each) for each in plan.entries}
        unused = {each.path.name for each in self.files() if each.survey} - set(driven)
        if not self.by_hand:
            unused -= set(self._given)
        return Answers(plan.B1, {**self._given, **driven}, frozenset(unused), REMARK)

    @property
    def by_hand(self) -> bool:
        """True if there is a campaign.toml that this page must not replace."""
        return os.path.lexists(self.campaign) and not self._own()

    def write(self, answers: Answers) -> None:
        """Writes the campaign.toml.

        Raises:
            InputError: it was written by hand, there is no recording, or it cannot be written.
        """
        with self._lock:
            if self.by_hand:
                raise InputError(
                    f"{CAMPAIGN} was written by hand and stays as it is; change it in an editor."
                )
            found = [(each.path, each.survey) for each in self.files() if each.survey is not None]
            if not any(path.name not in answers.unused for path, _ in found):
                raise InputError("There is no recording to write about; drop one or more files.")
            driven = {**self._given, **answers.driven}
            text = written(self.path, found, replace(answers, driven=driven, remark=REMARK))
            readable = {path.name for path, _ in found}
            waiting = {path.name for path in data_files(self.path)} - readable - answers.unused
            self._given = {name: each for name, each in driven.items() if name in waiting}
            try:
                with replaced(self.campaign) as part:
                    part.write_text(text, encoding="utf-8")
            except OSError as fault:
                raise InputError(f"Cannot write {CAMPAIGN}: {fault.strerror}.") from fault

    def added(self, name: str) -> None:
        """Writes the campaign.toml anew after a file has come, if it is this page's to write.

        The answers so far are kept, those given while the file came among them.

        Args:
            name: of the file, which is used.
        """
        with self._lock:
            if not self.by_hand and any(each.survey for each in self.files()):
                said = self.answers() or Answers()
                self.write(replace(said, unused=said.unused - {name}))

    def check(self) -> Checked | None:
        """All that is wrong or doubtful about the campaign; None without a campaign.toml."""
        with self._lock:
            mark = self._mark()
            if self._checked is not None and self._checked[0] == mark:
                return self._checked[1]
            if not os.path.lexists(self.campaign):
                return None
            outside = self._outside()
            checked = Checked(None, outside, {}) if outside else check(self.path)
            self._checked = (mark, checked)
            return checked

    def told(self, sentence: str) -> str:
        """A sentence without the folder before the names of its files."""
        return sentence.replace(f"{self.path}{os.sep}", "")

    def _plan(self) -> Plan | None:
        """The campaign.toml; None where there is none to be read."""
        if not inside(self.path, self.campaign):
            return None
        try:
            return read_plan(self.campaign)
        except CampaignError:  # which the checks report
            return None

    def _entries(self) -> tuple[Entry, ...]:
        plan = self._plan()
        return () if plan is None else plan.entries

    def _own(self) -> bool:
        if not self.campaign.is_file() or not inside(self.path, self.campaign):
            return False
        try:
            with self.campaign.open(encoding="utf-8") as stream:
                return stream.readline().rstrip("\n") == f"# {REMARK}"
        except (OSError, ValueError):
            return False

    def _look(self, path: Path) -> File:
        about = path.stat()
        mark = ((path.name, about.st_mtime_ns, about.st_size),)
        known = self._seen.get(path)
        if known is not None and known[0] == mark:
            return known[1]
        if not inside(self.path, path):
            file = File(path, fault=f"{path.name}: it is a link out of the folder; copy the file.")
        elif path.name != path.name.encode("utf-8", "replace").decode("utf-8"):
            file = File(path, fault=f"{path.name}: its name is no text in UTF-8; rename the file.")
        else:
            try:
                found = survey(path)
                file = File(path, found, guess=guessed(path, found))
            except CampaignError as fault:
                file = File(path, fault=self.told(str(fault)))
            except Exception as fault:  # the page must go on: nobody could take the file away there
                kind = type(fault).__name__
                file = File(path, fault=f"A fault of ours, {kind}: {fault}; leave the file out.")
        self._seen[path] = (mark, file)
        return file

    def _mark(self) -> Mark:
        """Changes whenever a file of the folder or of its campaign does."""
        files = {Path(each.path) for each in os.scandir(self.path)}
        files |= {entry.file for entry in self._entries() if inside(self.path, entry.file)}
        found = []
        for each in files:
            try:
                if each.is_file():
                    about = each.stat()
                    found.append((str(each), about.st_mtime_ns, about.st_size))
            except OSError:  # a link to itself; what went away just now
                continue
        return tuple(sorted(found))

    def _outside(self) -> tuple[Finding, ...]:
        """A fault for each file of the campaign, itself included, that lies out of the folder."""
        files = {CAMPAIGN: self.campaign} | {each.name: each.file for each in self._entries()}
        return tuple(
            Finding(
                "file", "wrong", (name,), "it lies outside the folder of this page", "copy it in"
            )
            for name, file in files.items()
            if not inside(self.path, file)
        )


def _driven(entry: Entry) -> Driven:
    """Returns how a campaign says that a recording was driven."""
    if entry.measured_drive:
        return Driven("measured")
    return Driven("commanded", entry.omega) if entry.forced else Driven("decay")
