"""Ways to spoil a text or a stream of bytes, as Hypothesis strategies."""

from hypothesis import strategies as st

from scripts._attack.documents import mutated

PIECES = (
    b"",
    b"\0",
    b"\n",
    b"\r\n",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"nan",
    b"inf",
    b"-inf",
    b"1e308",
    b"-1e308",
    b"1e400",
    b"1e-320",
    b"-1",
    b"0",
    b"9" * 5000,
    b"\t",
    b",",
    b";",
    b'"',
    b"'''",
    b"[",
    b"[[",
    b"]",
    b"{",
    b"}",
    b"=",
    b"#",
    b"a.b",
    b"true",
    b"1979-05-27",
    "φ".encode(),
    b"\x80",
    b"../../x",
    b"/dev/zero",
    b"[" * 3000,
    b"a." * 3000,
    b"0x1F",
    b"1_000",
    b"1,5",
    b" ",
    b"\x1b[2J",
)


VALUES = (
    b"0",
    b"-0.0",
    b"-1",
    b"1",
    b"2.5",
    b"1e-320",
    b"1e30",
    b"1e308",
    b"-1e308",
    b"1e400",
    b"nan",
    b"inf",
    b"true",
    b'""',
    b'"x"',
    b"[]",
    b"{}",
    b"9" * 400,
    b"1979-05-27",
    b"0x1F",
    b"1_000",
    b"",
)

WAYS = ("put", "over", "word", "word", "word", "gone", "twice", "line", "line", "end", "byte")


@st.composite
def spoiled(draw: st.DrawFn, text: bytes) -> bytes:
    """The text with one to four places changed: a piece put in, lines gone or doubled, an end."""
    out = text
    for _ in range(draw(st.sampled_from((1, 1, 1, 2, 4)))):
        at = draw(st.integers(0, len(out)))
        how = draw(st.sampled_from(WAYS))
        piece = draw(st.sampled_from(VALUES if how == "word" else PIECES))
        length = draw(st.integers(1, 40))
        out = _changed(out, at, how, piece, length)
    return out


def _changed(text: bytes, at: int, how: str, piece: bytes, length: int) -> bytes:
    begin, rest = text[:at], text[at:]
    if how == "put":
        return begin + piece + rest
    if how == "over":
        return begin + piece + rest[length:]
    if how == "word":  # a whole value, so that what is around it stays good
        stop = next((i for i, c in enumerate(rest) if chr(c) in " ,;\t\r\n]}"), len(rest))
        start = max(begin.rfind(bytes([c])) for c in b" ,;\t\n[=") + 1
        return text[:start] + piece + rest[stop:]
    if how == "gone":
        return begin + rest[length:]
    if how == "twice":
        return begin + rest[:length] + rest
    if how == "line":
        lines = text.split(b"\n")
        i = at % len(lines)
        return b"\n".join([*lines[:i], *lines[i + 1 :], *([lines[i]] if length % 2 else [])])
    if how == "byte":
        return begin + bytes([(rest[0] + length) % 256]) + rest[1:] if rest else begin
    return begin  # "end"


def documents(document: object) -> st.SearchStrategy:
    """A JSON document with one to three entries changed."""
    return st.integers(0, 2**32 - 1).map(lambda seed: mutated(document, seed))
