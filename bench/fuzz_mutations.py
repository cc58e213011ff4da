"""Damage: to the bytes of a bag, where its structure is known, to what its messages say, and to the lines of a text."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

NASTY = [
    "9" * 400, "-" + "9" * 5000, "1e999", ".nan", "-.inf", "!!python/object:os.system x", "*a", "&a [*a]", "{a: {a: ",
    "[" * 2000, "? [", "\0", "\u2028", "'", '"', "<<: *x", "---", "...", "null", "~", "[]", "{}", "true", "0x", "1:1:1",
    "2026-11-26", "!!set {a}", "!!binary aGk=", "|", ">", "#", "\t", "-", "\x1b[2J", "\N{PILE OF POO}", "{" * 500,
    '{"a":' * 3000, "Infinity", "NaN",
]  # fmt: skip
NASTY_XML = [
    "<!DOCTYPE r [<!ENTITY a 'aaaaaaaaaa'>]>", "&a;", "&#0;", "&#x1F4A9;", "<joint " * 300, "<a>" * 5000, "</joint>",
    "<![CDATA[", "-->", "<!--", "\0", "\ud800", "lower='1e999'", "upper='nan'", "velocity='-1'", "effort='" + "9" * 400,
    "<?xml version='1.0' encoding='utf-16'?>", "<?xml version='1.0' encoding='nonsense'?>", "\ufeff", "<mimic/>",
]  # fmt: skip
NASTY_NUMBERS = [np.nan, np.inf, -np.inf, 0.0, -0.0, 1e308, -1e308, 5e-324, 1e-300, 1e18, 2.0**63, 1e16]
CONTENT = (
    "numbers", "many numbers", "all numbers", "names", "lengths", "no stamps", "equal stamps", "stamps 1 ns apart",
    "stamps set back", "largest stamps", "received at once", "received backwards", "one message", "none of effort",
)  # fmt: skip


def mcap_records(data: bytes | bytearray) -> list[int]:
    """Where the records of an MCAP file begin, outside of chunks."""
    places, at = [], 8
    while at + 9 <= len(data) - 8:
        places.append(at)
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    return places


def headers(data: bytes) -> list[int]:
    """Bytes that hold the structure of a file of any of the three storages."""
    if data.startswith(b"\x89MCAP0\r\n"):
        outer = mcap_records(data)
        inner = []
        for at in (a for a in outer if data[a] == 6):
            names = int.from_bytes(data[at + 37 : at + 41], "little")
            inside, end = at + 9 + 28 + 4 + names + 8, at + 9 + int.from_bytes(data[at + 1 : at + 9], "little")
            while names == 0 and inside + 9 <= end:
                inner.append(inside)
                inside += 9 + int.from_bytes(data[inside + 1 : inside + 9], "little")
        return [*outer, *inner]
    if data.startswith(b"SQLite"):
        return [*range(0, 100, 4), *(p + i for p in range(0, len(data), 4096) for i in (0, 1, 3, 5, 8, 10, 12))]
    found, at = [], data.find(b"op=")
    while at >= 0:
        found += [max(0, at - 8), max(0, at - 4), at + 3]
        at = data.find(b"op=", at + 3)
    return found or [0]


def mutated(data: bytes, random: np.random.Generator) -> tuple[bytes, str]:
    """The bytes, damaged in one of several ways, and its name."""
    new, size = bytearray(data), len(data)
    at = int(random.integers(size))
    length = int(min(size - at, 2 ** random.uniform(0, 15)))
    ways = ("cut", "flip 1", "flip 30", "zeros", "ones", "removed", "twice", "inserted", "moved", "header", "headers",
            "length")  # fmt: skip
    way = str(random.choice(ways))
    if way == "cut":
        del new[max(1, at) :]
    elif way.startswith("flip"):
        for place in random.integers(0, size, int(way.split()[1])):
            new[place] = int(random.integers(256))
    elif way in ("zeros", "ones"):
        new[at : at + length] = bytes([0 if way == "zeros" else 255]) * length
    elif way == "removed":
        del new[at : at + length]
    elif way == "twice":
        new[at:at] = data[at : at + length]
    elif way == "inserted":
        new[at:at] = random.bytes(length)
    elif way == "moved":
        other = int(random.integers(size - length + 1))
        new[other : other + length] = data[at : at + length]
    else:
        places = headers(data)
        for place in random.choice(places, 8 if way == "headers" else 1):
            if way == "length":
                step = [1, 2, 3, 4, 5, 6, 7, 8][int(random.integers(8))]
                value = [0, 1, 9, 0x7F, 0xFF, 31][int(random.integers(6))]
                new[min(size - 1, int(place) + step)] = value
            else:
                new[min(size - 1, int(place) + int(random.integers(4)) * int(random.random() < 0.5))] = int(
                    random.integers(256)
                )
    return bytes(new), way


def mutated_text(text: str, random: np.random.Generator, nasty: list[str] = NASTY) -> tuple[str, str]:
    """A text, damaged by lines, by characters, or by something nasty in place of a value."""
    lines = text.split("\n")
    way = str(random.choice(["nasty", "nasty", "nasty", "line", "twice", "flip", "indent", "cut"]))
    i = int(random.integers(len(lines)))
    if way == "nasty":
        bad, head = nasty[int(random.integers(len(nasty)))], lines[i].partition(":")[0]
        lines[i] = f"{head}: {bad}" if random.random() < 0.6 else bad if random.random() < 0.5 else bad + lines[i]
        if lines[i].lstrip().startswith('"'):
            lines[i] += ","
    elif way == "line":
        del lines[i]
    elif way == "twice":
        lines.insert(int(random.integers(len(lines))), lines[i])
    elif way == "indent":
        lines[i] = " " * int(random.integers(8)) + lines[i].lstrip()
    new = "\n".join(lines)
    if way == "flip":
        for _ in range(int(random.integers(1, 12))):
            at = int(random.integers(max(1, len(new))))
            new = new[:at] + chr(int(random.integers(1, 256))) + new[at + 1 :]
    elif way == "cut":
        new = new[: int(random.integers(len(new)))]
    return new, way


def mutated_content(messages: list[Any], random: np.random.Generator) -> tuple[list[Any], str]:
    """Messages of joint states that say something no robot would, and what; topics of other types are left."""
    way = str(random.choice(CONTENT))
    at = [i for i, m in enumerate(messages) if m.kind.endswith("JointState")]
    few = random.choice(at, {"numbers": 3, "names": 5, "lengths": 5}.get(way, len(at) // 4), replace=False)
    made = list(messages)
    if way == "one message":
        return made[:1], way
    kept = random.choice(NASTY_NUMBERS)
    first = messages[at[0]].content.header.stamp
    for place, i in enumerate(at):
        content, received = made[i].content, made[i].received_ns
        stamp, header = content.header.stamp, content.header
        if way == "all numbers" or (way.endswith("numbers") and i in few):
            value = kept if way == "all numbers" else random.choice(NASTY_NUMBERS)
            content = replace(content, position=np.full_like(content.position, value))
            if random.random() < 0.5:
                content = replace(content, effort=np.full_like(content.effort, value))
        elif way == "names" and i in few:
            names = [["joint_2", "joint_2"], [], ["joint_2"], ["\x1b[2J", "\u202e"], ["joint_1"] * 40]
            content = replace(content, name=names[int(random.integers(5))])
        elif way == "lengths" and i in few:
            content = replace(
                content, position=np.zeros(int(random.integers(4))), effort=np.zeros(int(random.integers(4)))
            )
        elif way == "none of effort":
            content = replace(content, effort=np.zeros(0))
        elif way in ("no stamps", "largest stamps"):
            high = way == "largest stamps"
            stamp = replace(stamp, sec=2**31 - 1 if high else 0, nanosec=999_999_999 if high else 0)
        elif way in ("equal stamps", "stamps 1 ns apart"):
            stamp = replace(first, nanosec=first.nanosec + (place if way != "equal stamps" else 0))
        elif way == "stamps set back" and place > len(at) // 2:
            stamp = replace(stamp, sec=stamp.sec - 1000)
        elif way.startswith("received"):
            received = messages[at[0]].received_ns + (0 if way.endswith("once") else -1000 * place)
        content = replace(content, header=replace(header, stamp=stamp))
        made[i] = made[i]._replace(content=content, received_ns=received)
    return made, way
