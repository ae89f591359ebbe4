"""Files that are no text: each kind is read by its library, others are named."""

import functools
import json
import struct
from pathlib import Path

import numpy as np
import pytest

from tp_jax.cli.diagnose import EXAMPLE
from tp_jax.errors import InputError
from tp_jax.recordings import CampaignError, load_campaign
from tp_jax.recordings.readers import Unreadable, hdf5


@functools.cache
def right(name: str) -> np.ndarray:
    """(3, n) t, phi1, phi2 of a run of the example."""
    return np.loadtxt(EXAMPLE / name, delimiter=",", skiprows=1).T


def _excel(file: Path, t, a, b) -> None:
    book = pytest.importorskip("openpyxl").Workbook()
    sheet = book.active
    sheet.append(["Test rig 2"])
    sheet.append(["time [ms]", "phi1 [deg]", "phi2 [deg]", "note"])
    for row in zip(1e3 * t, np.degrees(a), np.degrees(b), strict=True):
        sheet.append([*map(float, row), "ok"])
    book.save(file)


def _matlab(file: Path, t, a, b) -> None:
    from scipy.io import savemat

    savemat(file, {"run": {"t": 1e3 * t, "angles": np.degrees(np.column_stack([a, b]))}})


def _hdf5(file: Path, t, a, b) -> None:
    with pytest.importorskip("h5py").File(file, "w") as content:
        content["run/t"] = 1e3 * t
        content["run/angles"] = np.degrees(np.column_stack([a, b]))


def _parquet(file: Path, t, a, b) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow.parquet import write_table

    columns = {"t": 1e3 * t, "a": np.degrees(a), "b": np.degrees(b)}
    write_table(pyarrow.table(columns), file)


def _tdms(file: Path, t, a, b) -> None:
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(file) as writer:
        for name, values in (("t", 1e3 * t), ("a", np.degrees(a)), ("b", np.degrees(b))):
            writer.write_segment([nptdms.ChannelObject("run", name, values)])


def _mcap(file: Path, t, a, b) -> None:
    writing = pytest.importorskip("mcap.writer")
    with file.open("wb") as stream:
        writer = writing.Writer(stream)
        writer.start()
        schema = writer.register_schema("rig", "jsonschema", b"{}")
        channel = writer.register_channel("/angles", "json", schema)
        for x, y, z in zip(t, np.degrees(a), np.degrees(b), strict=True):
            data = json.dumps({"t": 1e3 * x, "angle": {"one": y, "two": z}, "note": "ok"}).encode()
            writer.add_message(channel, int(1e9 * x), data, int(1e9 * x))
        writer.finish()


def _numpy(file: Path, t, a, b) -> None:
    np.savez(file, t=1e3 * t, angles=np.degrees(np.column_stack([a, b])))


# kind -> end of the name, how it is written, columns of t, phi1 and phi2 in it
KINDS = {
    "Excel": (".xlsx", _excel, ("time", "phi1", "phi2")),
    "MATLAB": (".mat", _matlab, ("run.t", "run.angles[0]", "run.angles[1]")),
    "HDF5": (".h5", _hdf5, ("run/t", "run/angles[0]", "run/angles[1]")),
    "Parquet": (".parquet", _parquet, ("t", "a", "b")),
    "TDMS": (".tdms", _tdms, ("run/t", "run/a", "run/b")),
    "MCAP": (".mcap", _mcap, ("t", "angle.one", "angle.two")),
    "NumPy": (".npz", _numpy, ("t", "angles[0]", "angles[1]")),
}


@pytest.mark.parametrize("kind", KINDS)
def test_files_of_libraries(kind, tmp_path):
    suffix, write, names = KINDS[kind]
    write(tmp_path / f"run-13{suffix}", *right("run-13.csv"))
    t, a, b = names
    (tmp_path / "campaign.toml").write_text(
        f"[format.columns]\nt = {{ column = '{t}', unit = 'ms' }}\n"
        f"phi1 = {{ column = '{a}', unit = 'deg' }}\nphi2 = {{ column = '{b}', unit = 'deg' }}\n"
        f"[[recording]]\nfile = 'run-13{suffix}'\nomega = 13.09"
    )
    (recording,) = load_campaign(tmp_path).recordings
    for read, truth in zip(
        (recording.t, *recording.channels.values()), right("run-13.csv"), strict=True
    ):
        np.testing.assert_allclose(read, truth, atol=1e-9)


def test_a_column_that_a_table_lacks(tmp_path):
    _numpy(tmp_path / "run.npz", *right("run-13.csv"))
    with pytest.raises(
        CampaignError, match=r'a NumPy archive, and there is no column "phi1" among'
    ):
        load_campaign(tmp_path / "run.npz", omega=13.09)


def test_a_library_that_is_missing_is_named(tmp_path, monkeypatch):
    (tmp_path / "run.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    monkeypatch.setitem(__import__("sys").modules, "h5py", None)
    with pytest.raises(CampaignError, match=r"h5py is not installed; pip install 'tp-jax\[hdf5\]'"):
        load_campaign(tmp_path / "run.h5", omega=13.09)


def test_a_data_set_in_the_place_of_a_group_is_named(tmp_path):
    with pytest.importorskip("h5py").File(tmp_path / "run.h5", "w") as content:
        content["run/t"] = np.arange(9.0)
    with pytest.raises(Unreadable, match='"run/t" is no group'):
        hdf5.read(tmp_path / "run.h5", "run/t")


BINARY = {
    "an HDF5 file that cannot be read": b"\x89HDF\r\n\x1a\n" + bytes(100),
    "an Excel workbook that cannot be read": b"PK\x03\x04[Content_Types].xml" + bytes(100),
    "an old Excel workbook": b"\xd0\xcf\x11\xe0" + bytes(100),
    "a zip archive": b"PK\x03\x04" + bytes(100),
    "a gzip archive": b"\x1f\x8b" + bytes(100),
    "a ROS 1 bag": b"#ROSBAG V2.0\n" + bytes(100),
    "an SQLite data base": b"SQLite format 3\0" + bytes(100),
    "a PDF": b"%PDF-1.7\n",
    "a binary file of a kind that is not known": struct.pack("100d", *np.linspace(0, 1, 100)),
}


@pytest.mark.parametrize("name", BINARY)
def test_binary_files_are_named(name, tmp_path):
    (tmp_path / "run.dat").write_bytes(BINARY[name])
    with pytest.raises(InputError, match=f"this is {name}") as caught:
        load_campaign(tmp_path / "run.dat", omega=13.09)
    assert str(caught.value).isprintable()
