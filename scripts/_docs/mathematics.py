"""Formulae as MathML, which browsers draw themselves: no script and no font from elsewhere."""

import html
import re

from latex2mathml.converter import convert

# what pymdownx.arithmatex makes of $...$ and $$...$$ with `generic: true`
_INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
_BLOCK = re.compile(r'<div class="arithmatex">\s*\\\[(.*?)\\\]\s*</div>', re.DOTALL)


def with_mathml(page: str) -> str:
    """The page's HTML with its formulae in MathML."""
    page = _INLINE.sub(lambda found: _mathml(found.group(1), "inline"), page)
    # a long formula scrolls by itself, which needs the keyboard's focus
    frame = '<div class="formula" tabindex="0" role="group" aria-label="Formula">{}</div>'
    return _BLOCK.sub(lambda found: frame.format(_mathml(found.group(1), "block")), page)


def _mathml(latex: str, display: str) -> str:
    return convert(html.unescape(latex).strip(), display=display)
