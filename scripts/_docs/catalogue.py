"""The catalogue of effects as a table, and a picture of what each of them does."""

import html

import pictures

import tp_jax as tp
from tp_jax.effects import Effect
from tp_jax.report import style, words
from tp_jax.report.formatting import angle, unit


def table() -> str:
    """Markdown: all effects with place, formula, unit and what they look like."""
    rows = ["| effect | place | formula | unit | shows as |", "|---|---|---|---|---|"]
    for effect in tp.effects.catalogue().values():
        units = ", ".join(dict.fromkeys(unit(a.unit) or "1" for a in effect.amplitudes))
        cells = (
            f"[`{effect.id}`](#{effect.id})",
            effect.location,
            _code(effect.formula),
            units,
            effect.looks_like,
        )
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


def gallery() -> str:
    """Markdown: a section for each effect, with its picture."""
    traces = pictures.traces()
    return "\n".join(
        _section(effect, traces[effect.id]) for effect in tp.effects.catalogue().values()
    )


def _code(formula: str) -> str:
    """A formula as code; its bars would end the cell of a table, and escaped ones show."""
    return f"<code>{html.escape(formula).replace('|', '&#124;')}</code>"


def _section(effect: Effect, trace: pictures.Trace) -> str:
    said = words.capital(words.effect(effect.id))
    most = {name: angle(abs(getattr(trace, name)).max()) for name in ("phi1", "phi2")}
    label = (
        f"{said}. Change of the readings of a bench run with {trace.size}: up to {most['phi1']} "
        f"in φ1 and {most['phi2']} in φ2."
    )
    drawn = style.svg(pictures.picture(trace), f"effect-{effect.id}", label)
    lines = [f"### {effect.id} {{ #{effect.id} }}", "", f"{said}. Shows as {effect.looks_like}."]
    lines += ["", _code(effect.formula), ""]
    for shape in effect.shapes:
        grid = ", ".join(f"{x:.2g}" for x in shape.grid)
        lines += [f"Tried at {shape.name} = {grid} {unit(shape.unit)}".rstrip() + ".", ""]
    if effect.source:
        lines += [f"Source: {effect.source}.", ""]
    drawn = " ".join(drawn.split("\n"))  # an empty line would end it
    caption = html.escape(f"Here {trace.size}.")
    lines += [f'<figure class="effect">{drawn}<figcaption>{caption}</figcaption></figure>', ""]
    return "\n".join(lines)
