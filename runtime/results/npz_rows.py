"""NumPy archives that are written while a run goes on.

The arrays of an archive stand one behind the other, and each grows with every row. The number of
rows is known before the run, so each array has a place of its final size, and the directory of the
archive has its own behind them. The file is sparse: places that are not filled yet take no room on
the disk. The headers and the directory are written anew after each block of rows, into bytes that
the disk already holds, so that a full disk cannot prevent it.
"""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from bgc.record_class import dataclass, field
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.row_files import RowArray, RowFile, write_all

_NPY_HEADER = 128
_MORE_ABOUT = 4096  # characters for what is known after the run
_COPIED = 1 << 20  # bytes at once
_LARGE, _MANY = 0xFFFFFFFF, 0xFFFF  # the value is in the 64-bit field
_POLYNOMIAL = 0xEDB88320  # of CRC-32, bits reversed
_UTF8, _DAY = 0x800, 0x21  # flag of names; 1 January 1980


@dataclass(slots=True)
class _Member:
    """An array of the archive: its place in the file, and the checksum of its numbers so far."""

    array: RowArray
    offset: int
    crc: int = 0
    entry: int = field(init=False)  # bytes of a row

    def __post_init__(self) -> None:
        self.entry = 8 * int(np.prod(self.array.shape, dtype=np.int64))

    @property
    def name(self) -> bytes:
        return f"{self.array.name}.npy".encode()

    @property
    def header_size(self) -> int:
        return len(_local_header(self.name, 0, 0)) + _NPY_HEADER

    def npy_header(self, rows: int) -> bytes:
        shape = (rows, *self.array.shape)
        text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape!r}, }}"
        body = text.ljust(_NPY_HEADER - 11) + "\n"
        return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(body)) + body.encode("latin-1")

    def checksum(self, rows: int) -> int:
        return _joined_crc(crc32(self.npy_header(rows)), self.crc, rows * self.entry)

    def size(self, rows: int) -> int:
        return _NPY_HEADER + rows * self.entry


class NpzRows(RowFile):
    """An uncompressed NumPy archive with an array for each column, `time` and `about`."""

    def __init__(
        self, path: Path, arrays: Sequence[RowArray], count: int, about: Mapping[str, Any]
    ) -> None:
        """Lay out an archive for at most `count` rows."""
        self._width = len(json.dumps(about)) + _MORE_ABOUT
        self._about = self._about_bytes(about)
        offset = len(self._about_entry())
        self._members: list[_Member] = []
        for array in (RowArray("time", "s", (), ()), *arrays):
            member = _Member(array, offset)
            self._members.append(member)
            offset += member.header_size + count * member.entry
        self._directory_at = offset
        self._count = count
        self._refused = False
        self._file = path.open("wb+", buffering=0)
        self._put(0, self._about_entry())
        self._note()

    def append(self, times: Array, rows: Array) -> None:
        """Write the numbers of each array to its place, then headers and directory."""
        checksums = []
        try:
            for member in self._members:
                values = times if member.array.name == "time" else member.array.of(rows)
                data = np.ascontiguousarray(values, dtype="<f8").data
                at = member.offset + member.header_size + self.rows * member.entry
                self._put(at, data)
                checksums.append(crc32(data, member.crc))
        except OSError:
            self._refused = True
            raise
        for member, checksum in zip(self._members, checksums, strict=True):
            member.crc = checksum
        self.rows += len(times)
        self._note()

    def end(self, about: Mapping[str, Any]) -> None:
        """Write `about`; close the gaps of a run that ended early."""
        self._about = self._about_bytes(about)
        with self._file:
            self._put(0, self._about_entry())
            self._note()
            if self.rows < self._count and not self._refused:
                self._close_gaps()

    def _note(self) -> None:
        """Write the headers of the arrays, then the directory."""
        for member in self._members:
            local = _local_header(member.name, member.checksum(self.rows), member.size(self.rows))
            self._put(member.offset, local + member.npy_header(self.rows))
        self._put(self._directory_at, self._directory())

    def _close_gaps(self) -> None:
        """Move each array down to the end of the one before, and cut the file behind the last."""
        end = len(self._about_entry())
        for member in self._members:
            size = member.header_size + self.rows * member.entry
            self._move(member.offset, end, size)
            member.offset = end
            self._put(self._directory_at, self._directory())
            end += size
        self._directory_at = end
        directory = self._directory()
        self._put(end, directory)
        self._file.truncate(end + len(directory))

    def _move(self, source: int, goal: int, size: int) -> None:
        for start in range(0, size if source != goal else 0, _COPIED):
            self._file.seek(source + start)
            self._put(goal + start, self._file.read(min(_COPIED, size - start)))

    def _directory(self) -> bytes:
        entries = [(b"about.npy", crc32(self._about), len(self._about), 0)]
        for member in self._members:
            size = member.size(self.rows)
            entries.append((member.name, member.checksum(self.rows), size, member.offset))
        listed = b"".join(_central_header(*entry) for entry in entries)
        end = self._directory_at + len(listed)
        count = len(entries)
        record = struct.pack(
            "<4sQHHIIQQQQ", b"PK\x06\x06", 44, 45, 45, 0, 0, count, count, len(listed),
            self._directory_at,
        )  # fmt: skip
        locator = struct.pack("<4sIQI", b"PK\x06\x07", 0, end, 1)
        last = struct.pack("<4sHHHHIIH", b"PK\x05\x06", 0, 0, _MANY, _MANY, _LARGE, _LARGE, 0)
        return listed + record + locator + last

    def _about_bytes(self, about: Mapping[str, Any]) -> bytes:
        """The text as a NumPy array of a fixed size."""
        text = json.dumps(about)
        if len(text) > self._width:  # a long reason of a failure
            message = str(about["message"])[: _MORE_ABOUT // 12]
            text = json.dumps({**about, "message": message})
        file = io.BytesIO()
        np.lib.format.write_array(file, np.array(text, dtype=f"<U{self._width}"))
        return file.getvalue()

    def _about_entry(self) -> bytes:
        return _local_header(b"about.npy", crc32(self._about), len(self._about)) + self._about

    def _put(self, at: int, data: bytes | memoryview) -> None:
        self._file.seek(at)
        write_all(self._file, data)


def _local_header(name: bytes, crc: int, size: int) -> bytes:
    """The header in front of a member of a ZIP archive, with 64-bit sizes (APPNOTE 4.3.7)."""
    fixed = struct.pack(
        "<4sHHHHHIIIHH", b"PK\x03\x04", 45, _UTF8, 0, 0, _DAY, crc, _LARGE, _LARGE, len(name), 20
    )
    return fixed + name + struct.pack("<HHQQ", 1, 16, size, size)


def _central_header(name: bytes, crc: int, size: int, offset: int) -> bytes:
    """The entry of a member in the directory of a ZIP archive (APPNOTE 4.3.12)."""
    fixed = struct.pack(
        "<4sHHHHHHIIIHHHHHII", b"PK\x01\x02", 45 | 3 << 8, 45, _UTF8, 0, 0, _DAY, crc, _LARGE,
        _LARGE, len(name), 28, 0, 0, 0, 0o644 << 16, _LARGE,
    )  # fmt: skip
    return fixed + name + struct.pack("<HHQQQ", 1, 24, size, size, offset)


def _joined_crc(first: int, second: int, length: int) -> int:
    """The CRC-32 of two texts in a row from theirs; `length` are the bytes of the second one.

    The first is multiplied by x^(8 length) modulo the polynomial of the checksum.
    """
    power, square = 1 << 31, 1 << 23  # 1 and x^8, with reversed bits
    while length:
        if length & 1:
            power = _product(power, square)
        square = _product(square, square)
        length >>= 1
    return _product(first, power) ^ second


def _product(a: int, b: int) -> int:
    """The product of two polynomials over GF(2), modulo that of CRC-32; bits reversed."""
    found = 0
    for bit in range(31, -1, -1):
        if a >> bit & 1:
            found ^= b
        b = b >> 1 ^ (_POLYNOMIAL if b & 1 else 0)
    return found
