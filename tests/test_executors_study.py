"""scripts/executors: the same pieces with and without an executor, and with killed workers."""

import argparse
import re

import pytest

from scripts import _executors as study


@pytest.mark.slow
def test_no_piece_is_lost_or_done_otherwise(tmp_path):
    args = argparse.Namespace(pieces=4, runs=1, workers=2, every_s=60.0, kinds=["local"])
    alone, local, killed = study.compared(args, tmp_path)
    assert (alone.pieces, local.pieces, killed.pieces) == (4, 4, 4)
    assert (alone.same, local.same, killed.same) == (4, 4, 4)
    assert local.killed == 0
    assert local.begun == 4
    assert killed.killed == 1
    assert killed.begun in (4, 5)  # the hand may strike just after the result was written
    assert local.efficiency > 0.0
    assert killed.efficiency is None


def test_the_table_goes_where_the_page_has_room():
    line = study.Line("local", 3, 200, 200, 203, 151.4, None)
    assert study.table([line]).endswith("| local | 3 | 200 | 200 | 203 | 151 | – |")
    page = study.PAGE.read_text(encoding="utf-8")
    assert re.search("<!-- executors: begin -->.*<!-- executors: end -->", page, re.DOTALL)
