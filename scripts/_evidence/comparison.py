"""The answers of both ways for every saved rig, counted: is there anything, and which effect."""

import dataclasses
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from scipy import stats

from scripts import _markdown as markdown
from scripts._evidence import screens
from scripts._evidence.evidence import (
    PRIORS,
    largest_of,
    misfit,
    of_catalogue,
    of_noise_in_sources,
    of_sources,
)
from scripts._evidence.screens import Saved, Variant
from tp_jax.estimation.normal_equations import efficient_inverse
from tp_jax.gap.detectability import TIED
from tp_jax.gap.policy import POLICY

LEVEL = 0.03
"""Level at which false alarms are counted, as many as the sealed trial had."""

DRAWS = 500
"""Draws of scores of noise alone; a p of `LEVEL` has a standard error of .008 then."""

SEED = 0

BANDS = ((1.0, 2.0), (2.0, 3.0), (3.0, np.inf))
"""Times the detectable size, by the rig's own scale; of two effects the larger."""

NULLS = ("noise", "noise, its level drawn", "blocks flipped", "blocks drawn")
"""Ways to draw scores where there is noise alone; see `null_scores`."""

KINDS = {
    "none": "nothing hidden",
    "one": "one effect",
    "two": "two effects",
    "cousin": "of another formula",
    "outside": "outside the catalogue",
}

TODAY = "today"

ALONE = "effects alone"
"""Ends a way of asking that leaves *something else* out."""


@dataclasses.dataclass(frozen=True)
class Answer:
    """Answer for one rig.

    Attributes:
        rigs, kind: as in its facts. multiple: times detectable; None where nothing is hidden.
        p: way of asking -> p that nothing is there.
        first: way of ranking -> whether the right effect is first; None where none is right.
        alone: the same, effects that resemble it counted as wrong. place: the same, its location.
        other: prior -> whether *something else* has more evidence than any effect.
    """

    rigs: str
    kind: str
    multiple: float | None
    p: dict[str, float]
    first: dict[str, bool] | None
    alone: dict[str, bool] | None
    place: dict[str, bool] | None
    other: dict[str, bool]


def answers(folder: Path) -> list[Answer]:
    """Returns the answers for all screens in a folder."""
    found = (screens.read(file) for file in sorted(folder.glob("*.npz")))
    return [answer(saved) for saved in found if saved is not None]


def answer(saved: Saved) -> Answer:
    """Both ways, asked of one screen."""
    facts = saved.facts
    p = {f"{TODAY}, all tests": facts["combined_p"], f"{TODAY}, structure": facts["structure_p"]}
    ranked = {TODAY: _ranked({v.effect: v.drop for v in reversed(_by_drop(saved))})}
    other = {}
    drawn = {name: null_scores(saved, name) for name in NULLS}
    for prior in PRIORS:
        seen = {
            id: float(x[0]) for id, x in of_catalogue(saved, saved.score[:, None], prior).items()
        }
        free = of_sources(saved, prior)
        ranked[prior.name] = _ranked(seen)
        other[prior.name] = max(free.values()) > max(seen.values())
        effects = max(*seen.values(), 0.0)
        largest = max(effects, *free.values())
        first = prior is PRIORS[0]
        for name in NULLS if first else NULLS[1:2]:
            score, level = drawn[name]
            alone = largest_of(of_catalogue(saved, score, prior))
            chance = np.random.default_rng(SEED)
            nothing = np.maximum(alone, of_noise_in_sources(saved, prior, level, chance))
            p[f"{prior.name}; {name}"] = _p(nothing, largest)
            if first and name in NULLS[:2]:
                p[f"{prior.name}; {name}; {ALONE}"] = _p(alone, effects)
    multiples = [each["multiple"] for each in facts["hidden"].values()]
    right = _right(saved)
    places = {each["location"] for each in facts["hidden"].values()}
    location = {v.effect: v.location for v in saved.variants}
    asked = facts["kind"] in ("one", "two", "cousin")
    known = {*facts["hidden"], *facts["cousins"].values()}
    return Answer(
        facts["rigs"],
        facts["kind"],
        max(multiples, default=None),
        p,
        {way: order[0] in right for way, order in ranked.items()} if asked else None,
        {way: order[0] in known for way, order in ranked.items()} if asked else None,
        {way: location[order[0]] in places for way, order in ranked.items()} if multiples else None,
        other,
    )


def _p(nothing: np.ndarray, seen: float) -> float:
    """Computes the p of what was seen, where noise alone gives these (D,)."""
    return float((1 + (nothing >= seen).sum()) / (1 + nothing.size))


def null_scores(saved: Saved, way: str) -> tuple[np.ndarray, np.ndarray]:
    """Scores (E, D) of noise alone, and its variance (D,) over the one evidence is tempered with.

    "noise": as today's test draws them, by the covariance that the noise gives the blocks. "its
    level drawn": the same, with the error of the noise's variance and, where it has a colour, of
    its spectral density. "blocks flipped", "drawn": each block's score with a random sign, or times
    a normal number, so of the scatter that is there.
    """
    rng = np.random.default_rng(SEED)
    if way.startswith("blocks"):
        shape = (len(saved.blocks), DRAWS)
        factor = rng.standard_normal(shape) if "drawn" in way else rng.choice((-1.0, 1.0), shape)
        return saved.blocks.T @ factor, _levels(saved, rng)
    score = saved.noise[:, :DRAWS] * np.sqrt(misfit(saved))
    if way == "noise":
        return score, np.ones(score.shape[1])
    level = _levels(saved, rng)[: score.shape[1]]
    return score * np.sqrt(level), level


def _levels(saved: Saved, rng: np.random.Generator) -> np.ndarray:
    """Variance (DRAWS,) of the noise over the one that evidence is tempered with, as known."""
    colour = POLICY.structure.colour if saved.facts["coloured"] else 0.0
    error = np.hypot(saved.facts["floor_error"], colour)
    return np.exp(error * rng.standard_normal(DRAWS))


def _by_drop(saved: Saved) -> list[Variant]:
    """Each effect where its predicted drop is largest, largest first."""
    best: dict[str, Variant] = {}
    for v in sorted(saved.variants, key=lambda v: -v.drop):
        best.setdefault(v.effect, v)
    return list(best.values())


def _ranked(found: dict[str, float]) -> list[str]:
    """Effects, the one that stands out most first."""
    return sorted(found, key=lambda id: -found[id])


def _right(saved: Saved) -> set[str]:
    """Returns what is hidden, and what these recordings cannot tell from it (`TIED`)."""
    best = {v.effect: v for v in _by_drop(saved)}
    known = {*saved.facts["hidden"], *saved.facts["cousins"].values()}
    like = {
        id
        for id, v in best.items()
        for true in known & set(best)
        if _cosine(saved, v, best[true]) > TIED
    }
    return known | like


def _cosine(saved: Saved, a: Variant, b: Variant) -> float:
    """Largest |cos| between the directions of two effects."""
    roots = []
    for v in (a, b):
        value, vector = np.linalg.eigh(efficient_inverse(saved.information[v.rows, v.rows]))
        roots.append(vector * np.sqrt(np.maximum(value, 0.0)) @ vector.T)
    across = roots[0] @ saved.information[a.rows, b.rows] @ roots[1]
    return float(np.linalg.svd(across, compute_uv=False)[0]) if across.size else 0.0


def tables(found: Sequence[Answer]) -> str:
    """All counts, as Markdown."""
    parts = []
    for rigs in ("clean", "rough"):
        mine = [a for a in found if a.rigs == rigs]
        if mine:
            parts += [_which(rigs, mine), _anything(rigs, mine), _else(rigs, mine)]
    return "\n\n".join(parts)


def share(said: Iterable[bool]) -> str:
    """`0.90 (0.60-0.98), n 10`, with Wilson's interval."""
    from trials import measures
    from trials.table import measure

    return measure(measures.share(list(said)))


def _in(found: Sequence[Answer], band: tuple[float, float]) -> list[Answer]:
    return [a for a in found if a.multiple is not None and band[0] <= a.multiple < band[1]]


def _heads() -> list[str]:
    return [f"{a:g}–{b:g} ×" if np.isfinite(b) else f"from {a:g} ×" for a, b in BANDS]


def _which(rigs: str, found: Sequence[Answer]) -> str:
    """The right effect first, by size."""
    asked = [a for a in found if a.first is not None]
    rows = []
    for way in (TODAY, *(prior.name for prior in PRIORS)):
        by_size = [share(a.first[way] for a in _in(asked, band)) for band in BANDS]
        rows.append(
            (
                f"{way}: predicted drop" if way == TODAY else way,
                share(a.first[way] for a in asked),
                *by_size,
                share(a.alone[way] for a in asked),
                share(a.place[way] for a in asked),
                _against(asked, way),
            )
        )
    heads = (
        "ranked by",
        "right effect first",
        *_heads(),
        "ties wrong",
        "location",
        "better : worse than today",
    )
    return f"Which, {rigs} rigs:\n\n{markdown.table(heads, rows)}"


def _against(asked: Sequence[Answer], way: str) -> str:
    """Counts rigs on which a ranking is right where today's is wrong, and vice versa; sign test."""
    if way == TODAY:
        return "–"
    better = sum(a.first[way] and not a.first[TODAY] for a in asked)
    worse = sum(a.first[TODAY] and not a.first[way] for a in asked)
    p = stats.binomtest(better, better + worse).pvalue if better + worse else 1.0
    return f"{better} : {worse} (p {p:.2g})"


def _anything(rigs: str, found: Sequence[Answer]) -> str:
    """False alarms and detections at the level, and how well both kinds of rigs are told apart."""
    nothing = [a for a in found if a.kind == "none"]
    hidden = [a for a in found if a.kind != "none"]
    rows = []
    for way in found[0].p:
        seen = [share(a.p[way] < LEVEL for a in _in(hidden, band)) for band in BANDS]
        rows.append(
            (way, share(a.p[way] < LEVEL for a in nothing), *seen, _apart(nothing, hidden, way))
        )
    heads = ("asked by", "false alarms", *_heads(), "told apart")
    return f"Is there anything, {rigs} rigs, at {LEVEL:g}:\n\n{markdown.table(heads, rows)}"


def _else(rigs: str, found: Sequence[Answer]) -> str:
    """Counts how often *something else* is ahead of every effect, by what is hidden."""
    kinds = [kind for kind in KINDS if any(a.kind == kind for a in found)]
    rows = [
        (prior.name, *(share(a.other[prior.name] for a in found if a.kind == k) for k in kinds))
        for prior in PRIORS
    ]
    heads = ("something else ahead by", *(KINDS[kind] for kind in kinds))
    return f"Something else before any effect, {rigs} rigs:\n\n{markdown.table(heads, rows)}"


def _apart(nothing: Sequence[Answer], hidden: Sequence[Answer], way: str) -> str:
    """Chance that of two rigs the one that hides something has the smaller p; ties half."""
    if not nothing or not hidden:
        return "–"
    found = stats.mannwhitneyu([a.p[way] for a in nothing], [a.p[way] for a in hidden])
    return f"{found.statistic / (len(nothing) * len(hidden)):.2f}"
