"""In place of a diagnosis: writes the saved one of the report's tests, a second later.

stand_in.py OUT done|fail|hang
"""

import json
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

out, end = Path(sys.argv[1]), sys.argv[2]
if end == "hang":
    (out / "fits.json").write_text("{}")  # as a diagnosis keeps what it has done
for i in range(4):
    line = {"stage": f"fitting windows of {i + 1} s", "part": i / 4}
    print(json.dumps(line), file=sys.stderr, flush=True)
    time.sleep(0.25)
print("tp-jax: run-06.csv: a doubt; look at it.", file=sys.stderr, flush=True)
if end == "fail":
    print("tp-jax: run-06.csv: a fault; mend it.", file=sys.stderr)
    raise SystemExit(2)
if end == "hang":
    sys.stdin.buffer.read()  # until the one that started this ends
    (out.parent / "ended.txt").write_text("its starter ended")
    raise SystemExit(130)

from tests.report.conftest import explained  # noqa: E402
from tp_jax.report import write_report  # noqa: E402

diagnosis = {"schema": "tp-jax/diagnosis/1", **explained()}
del diagnosis["fits"]  # which are hollow there
# The report takes seconds on a busy machine. One that is cancelled meanwhile has no result here, so
# that the next has its number whatever the machine does.
write_report(diagnosis, out / "report.part")
(out / "diagnosis.json").write_text(json.dumps(diagnosis), encoding="utf-8")
(out / "report.part").rename(out / "report.html")
