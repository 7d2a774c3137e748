"""Structures and statuses of the C interface, as `bgc.h` declares them, for ctypes.

The only module that knows the layout of C structures.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_char_p, c_double, c_int, c_long, c_uint32, c_void_p
from enum import IntEnum
from typing import Any, ClassVar, TypeAlias

from bgc.language.records import Where, options_of
from bgc.language.solver import Solver

ABI = 20

_Fields: TypeAlias = list[tuple[str, Any]]
_NUMBERS: dict[type, Any] = {float: c_double, int: c_int}


class Status(IntEnum):
    """`bgc_status`."""

    OK = 0
    STEP_TOO_SMALL = 1
    TOO_MANY_STEPS = 2
    NOT_FINITE = 3
    SINGULAR = 4
    ASSERTION = 5
    DEVICE = 6
    BAD_PARAMETER = 7
    BAD_ARGUMENT = 8
    INTERRUPTED = 9
    NO_MEMORY = 10
    NOT_EXPLICIT = 11
    INCONSISTENT = 12
    NOT_CONVERGED = 13
    CHATTERING = 14
    VANISHING = 15
    SINGULAR_CHAIN = 16
    OPEN_CHAIN = 17
    ENDLESS_JUMPS = 18
    BAD_SAMPLE = 19
    GRAZING = 20
    SIMULTANEOUS = 21
    FMU = 22


class ParamInfo(ctypes.Structure):
    """`bgc_param_info`."""

    _fields_: ClassVar[_Fields] = [
        ("name", c_char_p),
        ("unit", c_char_p),
        ("value", c_double),
        ("low", c_double),
        ("high", c_double),
    ]


class VarInfo(ctypes.Structure):
    """`bgc_var_info`."""

    _fields_: ClassVar[_Fields] = [("name", c_char_p), ("unit", c_char_p)]


class ChannelUse(ctypes.Structure):
    """`bgc_channel_use`."""

    _fields_: ClassVar[_Fields] = [("device", c_int), ("channel", c_int), ("component", c_int)]


class DeviceInfo(ctypes.Structure):
    """`bgc_device_info`."""

    _fields_: ClassVar[_Fields] = [("name", c_char_p), ("driver", c_char_p), ("options", c_char_p)]


class SwitchInfo(ctypes.Structure):
    """`bgc_switch_info`."""

    _fields_: ClassVar[_Fields] = [("operation", c_int), ("timed", c_int), ("jumps", c_int)]


_FACTOR_TABLES = (
    "pivot_row",
    "pivot_col",
    "lu_row",
    "lu_pivot",
    "lu_col",
    "lu_jac",
    "lu_mass",
)


_FUNCTIONS = (
    "prepare",
    "positive",
    "defaults",
    "initial",
    "scale",
    "mass",
    "rhs",
    "jacobian",
    "factor",
    "solve",
    "outputs",
    "commands",
    "energy",
    "project",
    "switches",
    "timed_switches",
    "timed_ranges",
    "asserts",
)


class ModelStruct(ctypes.Structure):
    """`bgc_model`; only the runtime calls its functions."""

    _fields_: ClassVar[_Fields] = [
        ("abi", c_uint32),
        ("name", c_char_p),
        ("hash", c_char_p),
        ("n_param", c_int),
        ("n_hoist", c_int),
        ("n_state", c_int),
        ("n_input", c_int),
        ("n_output", c_int),
        ("n_command", c_int),
        ("n_assert", c_int),
        ("n_device", c_int),
        ("n_jac", c_int),
        ("n_mass", c_int),
        ("n_lu", c_int),
        ("n_work", c_int),
        ("param", POINTER(ParamInfo)),
        ("state", POINTER(VarInfo)),
        ("output", POINTER(VarInfo)),
        ("input", POINTER(ChannelUse)),
        ("command", POINTER(ChannelUse)),
        ("device", POINTER(DeviceInfo)),
        ("assertion", POINTER(c_char_p)),
        ("param_check", POINTER(c_char_p)),
        ("n_check", c_int),
        ("n_given_assert", c_int),
        ("jac_row", POINTER(c_int)),
        ("jac_col", POINTER(c_int)),
        ("mass_row", POINTER(c_int)),
        ("mass_col", POINTER(c_int)),
        *((name, POINTER(c_int)) for name in _FACTOR_TABLES),
        ("switch_info", POINTER(SwitchInfo)),
        ("n_switch", c_int),
        ("n_timed", c_int),
        ("step", c_double),
        ("duration", c_double),
        ("every", c_double),
        *((name, c_void_p) for name in _FUNCTIONS),
        ("n_divisor", c_int),
        ("divisor", POINTER(c_char_p)),
        ("divisors", c_void_p),
    ]


C_OPTIONS = options_of(Solver, Where.C)
"""The options of a solver that C has, by field."""


class OptionsStruct(ctypes.Structure):
    """`bgc_options`."""

    _fields_: ClassVar[_Fields] = [
        ("name", c_char_p),
        *((name, _NUMBERS[known.kind]) for name, known in C_OPTIONS.items()),
        ("accounts", c_int),
        ("errors", c_int),
    ]


class CountsStruct(ctypes.Structure):
    """`bgc_counts`."""

    _fields_: ClassVar[_Fields] = [
        *((name, c_long) for name in ("steps", "rejected", "rhs", "jacobians", "factorisations")),
        *((name, c_long) for name in ("solves", "refinements", "fallbacks", "samples", "events")),
        *((name, c_double) for name in ("last_step", "worst_step_seconds", "run_seconds")),
        *((name, c_double) for name in ("worst_sample_seconds", "exchanged")),
        *((name, c_double) for name in ("largest_correction", "correction_time")),
        ("correction_state", c_long),
        ("scale_reached", c_double),
        *((name, c_long) for name in ("subdivided", "over_budget", "most_attempts")),
        *((name, c_double) for name in ("largest_excess", "excess_time", "fastest", "stiffness")),
        ("controlled_steps", c_double),
        *((name, c_long) for name in ("rounding_samples", "rounding")),
        ("largest_rounding", c_double),
        *((name, c_long) for name in ("explicit_steps", "method_changes", "doubtful_errors")),
    ]


class SubtoleranceState(ctypes.Structure):
    """`bgc_subtolerance_state`."""

    _fields_: ClassVar[_Fields] = [
        (name, c_double) for name in ("tolerance", "low", "fell", "grown", "value")
    ]
