"""The cases of a campaign of mutated files: no traceback, no hang, no gigabyte of memory."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import corpus
import mutations
from judging import Verdict, judged, run_briefly
from lark.exceptions import LarkError

from bgc.grammar.lark_parser import lark_parser
from bgc.resolution import resolve

PORTION = 500
TRIES = (1, 4, 4)  # mutants made of one case until one can be parsed
RUNS = 0.01  # of the cases: those that compile go through the C compiler and a run
VERIFIED = 0.25  # of the cases: with the invariants of every intermediate result
FORMATTED = 0.1  # of the cases: `bgc fmt` is tried, too


@cache
def entries() -> tuple[tuple[corpus.Entry, ...], tuple[float, ...]]:
    found = corpus.corpus()
    return found, tuple(entry.weight for entry in found)


def case(seed: int, number: int) -> tuple[corpus.Entry, bytes]:
    """The mutant of a number, and the file that it comes from."""
    rng = random.Random(f"{seed}:{number}")
    texts, weights = entries()
    chosen, other = rng.choices(texts, weights, k=2)
    made = b""
    for _ in range(rng.choice(TRIES)):
        made = mutations.mutant(rng, chosen.text, other.text)
        if is_syntax(made):
            break
    return chosen, made


def is_syntax(data: bytes) -> bool:
    """Return whether a text can be parsed; other mutants are quick to answer, and alike."""
    try:
        lark_parser().parse(data.decode(), start="start")
    except (UnicodeDecodeError, LarkError):
        return False
    return True


def text_of(seed: int, number: int) -> tuple[str, bytes]:
    """The name of the file that a case comes from, and its text."""
    entry, data = case(seed, number)
    return entry.name, data


def written(seed: int, number: int, folder: Path) -> Path:
    """Write a mutant beside the files that the file that it comes from can import."""
    entry, data = case(seed, number)
    home = folder / str(entry.folder.relative_to(corpus.ROOT)).replace("/", "_")
    if not home.exists():
        home.mkdir()
        for path in sorted(entry.folder.iterdir()):
            if path.is_file():
                (home / path.name).symlink_to(path)
    path = home / "mutant.bg"
    path.write_bytes(data)
    return path


def judge(seed: int, number: int, folder: Path) -> list[Verdict]:
    """The verdicts of a case: of the compiler, and of a run where one is made."""
    path = written(seed, number, folder)
    rng = random.Random(f"{seed}:{number}:how")
    verify, formatted = rng.random() < VERIFIED, rng.random() < FORMATTED
    verdict = judged(path, verify=verify, formatted=formatted)
    found = [verdict]
    if rng.random() < RUNS and verdict.outcome == "accepted":
        found.append(run_briefly(path))
    return found


@contextmanager
def library_parsed_once() -> Iterator[None]:
    """Keep the syntax trees of the library's files, which most mutants import unchanged."""
    kept: dict[tuple[str, str], Any] = {}
    parse = resolve.parse

    def parse_once(source):
        if not source.name.startswith("library/"):
            return parse(source)
        key = (source.name, source.text)
        if key not in kept:
            kept[key] = parse(source)
        return kept[key]

    resolve.parse = parse_once
    try:
        yield
    finally:
        resolve.parse = parse
