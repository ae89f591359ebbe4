"""The parser on damaged, mutated and random bytes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tp_jax.acquisition import protocol
from tp_jax.acquisition.parser import LONGEST_PIECE, FrameParser, TextParser
from tp_jax.rig.serve import Line

SENT = [protocol.sample(1, i, 1000 * i, (i % 65536, 7 * i % 65536, 0, 65535)) for i in range(60000)]


def fed(parser, data, size):
    batches = [parser.feed(data[i : i + size]) for i in range(0, len(data), size)]
    return np.concatenate([batch.samples for batch in batches])


@given(st.lists(st.integers(1, 60), min_size=1, max_size=30))
def test_pieces_of_any_length_give_the_same(sizes):
    data, parser, got = b"".join(SENT[:20]), FrameParser(), []
    while data and sizes:
        size = sizes.pop()
        got += list(parser.feed(data[:size]).samples["sequence"])
        data = data[size:]
    got += list(parser.feed(data).samples["sequence"])
    assert got == list(range(20))
    assert (parser.good, parser.corrupt) == (20, 0)


@given(st.lists(st.binary(max_size=80), max_size=30))
@settings(max_examples=300)
def test_anything_goes_in_and_the_next_frame_comes_out(pieces):
    frames, text = FrameParser(), TextParser()
    for piece in pieces:
        frames.feed(piece)
        text.feed(piece)
    batch = frames.feed(b"\0" + SENT[5])
    assert list(batch.samples["sequence"]) == [5]
    assert len(text.feed(b"\n1.0 0.1 0.2\n")) == (text.columns == 3)


def mutated(rng):
    """A stream of frames with bytes flipped, lost, doubled and put in."""
    data = np.frombuffer(b"".join(SENT), dtype=np.uint8).copy()
    kind = rng.random(data.size)
    data[kind < 0.01] = rng.integers(0, 256, int((kind < 0.01).sum()))
    repeats = np.ones(data.size, dtype=int)
    repeats[(kind > 0.01) & (kind < 0.02)] = 0
    repeats[(kind > 0.02) & (kind < 0.025)] = 2
    return np.repeat(data, repeats).tobytes()


def test_a_million_random_and_mutated_bytes():
    rng = np.random.default_rng(5)
    streams = [mutated(rng)]
    streams += [rng.integers(0, high, 500_000, dtype=np.uint8).tobytes() for high in (256, 3)]
    streams += [bytes(300_000), b"\xff" * 300_000]
    assert sum(map(len, streams)) > 3_000_000
    for stream in streams:
        parser, text = FrameParser(), TextParser()
        for i in range(0, len(stream), 997):
            batch = parser.feed(stream[i : i + 997])
            assert len(parser._rest) <= LONGEST_PIECE
            text.feed(stream[i : i + 997])
            for sample in batch.samples:  # a wrong one passes with a chance of 2^-32
                assert sample.tobytes()[:-4] == protocol._SAMPLE.pack(
                    1,
                    1,
                    sample["sequence"],
                    1000 * int(sample["sequence"]),
                    int(sample["sequence"]) % 65536,
                    7 * int(sample["sequence"]) % 65536,
                    0,
                    65535,
                )


@pytest.mark.parametrize(("corrupt", "drop"), [(0.01, 0.0), (0.0, 0.01)])
def test_one_bad_byte_in_a_hundred(corrupt, drop):
    parser = FrameParser()
    got = fed(parser, Line(corrupt, drop, 1).carry(b"".join(SENT)), 480)
    share = got.size / len(SENT)
    assert 0.76 < share < 0.82  # 0.99^24 is 0.786
    sent = np.array([list(SENT[i]) for i in got["sequence"]], dtype=np.uint8)
    again = [
        protocol.sample(1, int(s["sequence"]), int(s["time"]), tuple(s["readings"].tolist()))
        for s in got
    ]
    np.testing.assert_array_equal(sent, [list(each) for each in again])
    assert parser.corrupt > 0.15 * len(SENT)


def test_endless_bytes_are_given_up():
    parser = FrameParser()
    for _ in range(1000):
        parser.feed(b"x" * 1000)
    assert len(parser._rest) <= LONGEST_PIECE
    assert parser.feed(b"\0" + SENT[0]).samples.size == 1
    assert parser.corrupt == 1


def test_the_arrival_belongs_to_an_undamaged_first_frame():
    parser = FrameParser()
    assert parser.feed(SENT[0] + SENT[1]).sharp
    assert not parser.feed(b"\x05" + SENT[2] + SENT[3]).sharp
    assert not parser.feed(b"").sharp
    begun = parser.feed(SENT[4][:10])
    assert not begun.sharp
    assert parser.feed(SENT[4][10:]).sharp


def test_a_frame_of_a_kind_to_come_is_let_pass():
    from tp_jax.acquisition.frames import encode

    parser = FrameParser()
    batch = parser.feed(encode(b"\x77later") + SENT[0])
    assert batch.samples.size == 1
    assert (parser.unknown, parser.corrupt) == (1, 0)
