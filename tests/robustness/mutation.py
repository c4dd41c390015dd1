"""Seeded mutation of valid files: bytes and characters changed, lines exchanged, values replaced by hostile ones."""

import os

import numpy as np

HOSTILE = (
    "nan", "inf", "-inf", "1e400", "-1e-400", "0", "-1", "9" * 400, "9" * 5000, "1e308", "true", "[]", "{}", '""',
    "1979-05-27", '"\x1b[31m"', '"\u202e"', '"\\u0000"', '"1e301 mm"', '"2.4e301 mm"', '"1 m^9999"', '"design"',
    '"../../etc/passwd"', '"/dev/zero"', '"=cmd|x"', "[" * 300 + "]" * 300, '{value = "1 mm"}', "'''\n'''",
    '"' + "x" * 10_000 + '"', '"1 +- 1 mm"', '"-0 mm"', '"1e-300 mm"', "0x7fffffffffffffff", "1_0",
)  # fmt: skip
"""Values that have broken a reader of some kind."""

SHARE = float(os.environ.get("STAGECAD_ROBUSTNESS", "1"))
"""Share of the long runs' counts that is run."""


def count(whole: int) -> int:
    """Number of inputs of a long run: `whole`, or the share of it that `STAGECAD_ROBUSTNESS` wants."""
    return max(round(whole * SHARE), 1)


def mutated(text: str, random: np.random.Generator) -> bytes:
    """One to four changes of a text; the result need not be UTF-8."""
    data = text.encode("utf-8")
    for _ in range(int(random.integers(1, 5))):
        data = _CHANGES[int(random.integers(len(_CHANGES)))](data, random)
    return data


def mutated_bytes(data: bytes, random: np.random.Generator) -> bytes:
    changed = bytearray(data)
    for place in random.integers(0, len(changed), int(random.integers(1, 8))):
        changed[place] = int(random.choice([0, 1, 127, 128, 255, int(random.integers(256))]))
    if random.random() < 0.2:
        del changed[int(random.integers(len(changed))) :]
    return bytes(changed)


def _value(data: bytes, random: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    places = [place for place, line in enumerate(lines) if b"=" in line]
    if not places:
        return data
    place = int(random.choice(places))
    lines[place] = lines[place].partition(b"=")[0] + b"= " + str(random.choice(HOSTILE)).encode()
    return b"\n".join(lines)


def _cell(data: bytes, random: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    place = int(random.integers(len(lines)))
    cells = lines[place].split(b",")
    cells[int(random.integers(len(cells)))] = str(random.choice(HOSTILE)).encode()
    lines[place] = b",".join(cells)
    return b"\n".join(lines)


def _bytes(data: bytes, random: np.random.Generator) -> bytes:
    place, length = int(random.integers(len(data) + 1)), int(random.integers(0, 9))
    return data[:place] + random.bytes(int(random.integers(0, 5))) + data[place + length :]


def _exchange(data: bytes, random: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    one, two = random.integers(len(lines), size=2)
    lines[one], lines[two] = lines[two], lines[one]
    return b"\n".join(lines)


def _repeat(data: bytes, random: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    place = int(random.integers(len(lines)))
    return b"\n".join([*lines[: place + 1], *lines[place:]])


def _delete(data: bytes, random: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    del lines[int(random.integers(len(lines)))]
    return b"\n".join(lines)


def _digit(data: bytes, random: np.random.Generator) -> bytes:
    places = [place for place, byte in enumerate(data) if chr(byte).isdigit()]
    if not places:
        return data
    place = int(random.choice(places))
    return data[:place] + str(random.choice(["e", "-", ".", "9", "e9", ",", " ", "\x00"])).encode() + data[place + 1 :]


_CHANGES = (_value, _value, _cell, _bytes, _exchange, _repeat, _delete, _digit)
