"""Records: `bgc.record_class.dataclass` against the standard decorator."""

import copy
import dataclasses
import inspect
import pickle

import pytest

from bgc import record_class as records

CHOICES = {
    "plain": {},
    "frozen": {"frozen": True},
    "slots": {"slots": True},
    "both": {"frozen": True, "slots": True},
    "keywords": {"frozen": True, "kw_only": True},
    "identity": {"frozen": True, "slots": True, "eq": False, "repr": False},
}


def _pair(decorate, options):
    @decorate(**options)
    class Base:
        """Two fields and a rule."""

        name: str
        size: float = 2.0

        def __post_init__(self):
            if self.size < 0:
                raise ValueError(self.size)

    @decorate(**options)
    class Derived(Base):
        parts: list[str] = dataclasses.field(default_factory=list, hash=False)
        hidden: int = dataclasses.field(default=7, repr=False, compare=False)
        fixed: int = dataclasses.field(default=3, init=False)
        fresh: dict = dataclasses.field(default_factory=dict, init=False, hash=False)

        def __repr__(self):
            return f"own {self.name}"

    return Base, Derived


def _outcome(call):
    try:
        return call()
    except Exception as problem:
        return type(problem)


def _facts(cls):
    """All that can be seen of a class and its instances."""
    yield str(inspect.signature(cls))
    yield [(f.name, f.default, f.kw_only) for f in dataclasses.fields(cls)]
    yield cls.__match_args__, cls.__hash__ is None
    made = [
        _outcome(lambda a=a, k=k: cls(*a, **k))
        for a in ((), ("a",), ("a", 3.0))
        for k in ({}, {"name": "b"}, {"size": -1.0}, {"parts": ["c"]}, {"hidden": 8}, {"other": 0})
    ]
    alike = dataclasses.fields(cls) and cls.__eq__ is not object.__eq__
    for one in made:
        if isinstance(one, type):
            yield one
            continue
        yield _outcome(lambda one=one: dataclasses.asdict(one))
        yield alike and [repr(one).split(".")[-1], [one == other for other in made], one == 1]
        yield alike and isinstance(_outcome(lambda one=one: hash(one)), int)
        yield alike and copy.copy(one) == copy.deepcopy(one) == one
        spare = copy.copy(one)
        yield _outcome(lambda spare=spare: setattr(spare, "name", "z"))
        yield _outcome(lambda spare=spare: delattr(spare, "size"))
        yield _outcome(lambda one=one: dataclasses.asdict(dataclasses.replace(one, size=9.0)))


@pytest.mark.parametrize("options", CHOICES.values(), ids=CHOICES)
def test_records_behave_as_standard_dataclasses_do(options):
    ours, standard = (_pair(way, options) for way in (records.dataclass, dataclasses.dataclass))
    for one, other in zip(ours, standard, strict=True):
        assert list(_facts(one)) == list(_facts(other))


@records.dataclass(frozen=True, slots=True)
class Sent:
    first: int
    second: tuple[int, ...] = ()


def test_frozen_records_with_slots_are_pickled():
    assert pickle.loads(pickle.dumps(Sent(1, (2,)))) == Sent(1, (2,))
