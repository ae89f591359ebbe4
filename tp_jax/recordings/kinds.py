"""Kinds of files, by their first bytes: what is no text is named in a sentence."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Kind:
    """A kind of file that is no text.

    Attributes:
        name: for a sentence, with its article.
        reader: module of `tp_jax.recordings.readers` that reads it, or None.
        extra: the extra that installs what the reader needs; "" where it needs nothing.
        mend: what to do where there is no reader.
    """

    name: str
    reader: str | None = None
    extra: str = ""
    mend: str = "export it as CSV with the columns t, phi1, phi2"


_ARCHIVE = "unpack it and name the data file in it"

KINDS: tuple[tuple[bytes, Kind], ...] = (
    (b"\x89HDF\r\n\x1a\n", Kind("an HDF5 file", "hdf5", "hdf5")),
    (b"MATLAB 5.0 MAT-file", Kind("a MATLAB file", "matlab")),
    (b"PAR1", Kind("a Parquet file", "parquet", "parquet")),
    (b"ARROW1", Kind("an Arrow file", "parquet", "parquet")),
    (b"TDSm", Kind("a TDMS file of LabVIEW", "tdms", "tdms")),
    (b"\x89MCAP0\r\n", Kind("an MCAP file", "mcap", "mcap")),
    (b"\x93NUMPY", Kind("a NumPy array", "numpy_arrays")),
    (b"\xd0\xcf\x11\xe0", Kind("an old Excel workbook (.xls)", mend="save it as .xlsx or CSV")),
    (b"#ROSBAG", Kind("a ROS 1 bag", mend="convert it to MCAP or CSV")),
    (
        b"SQLite format 3\0",
        Kind("an SQLite data base, perhaps a ROS 2 bag", mend="convert it to MCAP or CSV"),
    ),
    (b"MDF     ", Kind("a measurement file of the MDF kind")),
    (b"RIFF", Kind("a sound file")),
    (b"\x1f\x8b", Kind("a gzip archive", mend=_ARCHIVE)),
    (b"7z\xbc\xaf", Kind("a 7z archive", mend=_ARCHIVE)),
    (b"Rar!", Kind("a RAR archive", mend=_ARCHIVE)),
    (b"%PDF", Kind("a PDF")),
    (b"\x89PNG", Kind("a picture")),
    (b"\xff\xd8\xff", Kind("a picture")),
)

EXCEL = Kind("an Excel workbook", "excel", "excel")
ARRAYS = Kind("a NumPy archive", "numpy_arrays")
_ZIP = Kind("a zip archive", mend=_ARCHIVE)
_UNKNOWN = Kind("a binary file of a kind that is not known here")

_LOOKED_AT = 4096
"""Bytes in which a text has no zero byte."""


def kind_of(file: Path, head: bytes) -> Kind | None:
    """The kind of a file by its first bytes; None for a text.

    Args:
        file: its name tells one zip archive from another.
        head: its first bytes, a few thousand.
    """
    for begin, kind in KINDS:
        if head.startswith(begin):
            return kind
    if head.startswith(b"PK\x03\x04"):
        suffix = file.suffix.lower()
        return {".npz": ARRAYS, ".xlsx": EXCEL, ".xlsm": EXCEL}.get(
            suffix, EXCEL if b"[Content_Types].xml" in head else ARRAYS if b".npy" in head else _ZIP
        )
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):  # UTF-16, full of zero bytes
        return None
    return _UNKNOWN if b"\0" in head[:_LOOKED_AT] else None
