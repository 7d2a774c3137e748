"""Words of textbooks and of other tools, with what stands for them in the language.

Someone who comes from Modelica, 20-sim, Simscape or a textbook tries these words first. A message
about an unknown name takes its way out from here.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from bgc.grammar.language_words import FORMS

_STORES = {
    "I": "mass inertia inductor inductance flywheel pointmass body",
    "C": "spring capacitor capacitance compliance tank",
    "R": "damper resistor resistance friction dashpot resistive",
    "J0": "zerojunction junction0 zero onejunctionzero parallel node ejunction",
    "J1": "onejunction junction1 one series fjunction",
    "TF": "transformer lever gear idealgear pulley",
    "GY": "gyrator motor emf",
    "Se": "effortsource sourceeffort voltagesource forcesource torquesource pressuresource "
    "constantvoltage battery",
    "Sf": "flowsource sourceflow currentsource velocitysource speedsource pumpsource",
    "MTF": "modulatedtransformer",
    "MGY": "modulatedgyrator",
    "MR": "modulatedresistor",
    "Mux": "multiplexer multiplex",
    "Demux": "demultiplexer demultiplex",
}

_ELEMENT_OF: Mapping[str, str] = {
    word: element for element, words in _STORES.items() for word in words.split()
}

_PARTS: Mapping[str, str] = {
    word: part
    for part, words in {
        "Earth": "ground",
        "IdealTransformer": "transformer",
        "CoupledCoils": "mutualinductor",
        "Emf": "rotationalemf",
        "DcMachine": "dcmotor dcpermanentmagnet",
        "Switch": "idealclosingswitch idealopeningswitch idealswitch",
        "OpAmp": "operationalamplifier idealizedopamp3pin",
        "VoltageSource": "constantvoltage sinevoltage signalvoltage stepvoltage voltagesource",
        "CurrentSource": "constantcurrent sinecurrent signalcurrent currentsource",
        "SlidingMass": "mass",
        "Strut": "spring springdamper",
        "Buffer": "elastogap endstop bumper",
        "Wall": "fixed",
        "ForceSource": "force constantforce",
        "VelocitySource": "speed position",
        "Rotor": "inertia flywheel",
        "TorsionSpring": "rotationalspring torsionalspring",
        "RotaryDamper": "rotationaldamper",
        "Backlash": "elastobacklash",
        "Gear": "idealgear lossygear gearbox",
        "PlanetaryGear": "idealplanetary planetary",
        "RackAndPinion": "idealgearr2t",
        "OneWayClutch": "freewheel",
        "DryFriction": "bearingfriction supportfriction stiction coulombfriction staticfriction",
        "TorqueSource": "torque constanttorque",
        "RateSource": "constantspeed",
        "HeatCapacity": "heatcapacitor thermalmass",
        "Conductor": "thermalconductor thermalresistor",
        "Radiation": "bodyradiation",
        "HeatFlow": "prescribedheatflow fixedheatflow",
        "FixedTemperature": "prescribedtemperature",
        "LowPass": "firstorder lag",
        "HighPass": "derivative washout differentiator",
        "Pid": "pid limpid pidcontroller pi",
        "Saturation": "limiter",
        "DeadBand": "deadzone",
        "RateLimiter": "slewratelimiter",
        "SampleHold": "zeroorderhold sampleandhold",
        "Recorded": "timetable combitimetable datafromfile",
        "HeavyBody": "rigidbody bodyshape",
        "SolidBox": "bodybox",
        "SolidCylinder": "bodycylinder",
        "Shift": "fixedtranslation",
        "Mount": "fixedrotation",
    }.items()
    for word in words.split()
}

_VALUES: Mapping[str, str] = {
    "t": "the time is `time`",
    "Time": "the time is `time`",
    "PI": "the number is `pi`",
    "Pi": "the number is `pi`",
    "e": "the number e is `exp(1)`; the effort of a part is `part.e`",
    "true": "write a condition, such as `1 > 0`",
    "false": "write a condition, such as `1 < 0`",
    "True": "write a condition, such as `1 > 0`",
    "False": "write a condition, such as `1 < 0`",
    "inf": "leave the limit out, or write a large number such as `1e30`",
    "Inf": "leave the limit out, or write a large number such as `1e30`",
    "Modelica": "the library of this language has other names: see `bgc doc library`",
}

_AS_STATE = "an integral is a state: `state s = 0; der(s) = x;`"
_AS_RATE = (
    "name the right-hand side of its `der(x) = ..;`, or filter the value by "
    "`HighPass` of `control.filters`"
)
_HELD = "of a part that computes at instants, see `sample`; `next(x)` is its new value"
_FUNCTIONS: Mapping[str, str] = {
    "pow": "write `x^y`",
    "power": "write `x^y`",
    "sqr": "write `x^2`",
    "square": "write `x^2`",
    "round": "write `floor(x + 0.5)`",
    "ln": "write `log(x)`",
    "mod": "write `fmod(x, y)`",
    "rem": "write `fmod(x, y)`",
    "transposed": "write `transpose(A)`",
    "arcsin": "write `asin(x)`",
    "arccos": "write `acos(x)`",
    "arctan": "write `atan(x)`",
    "arctan2": "write `atan2(y, x)`",
    "int": _AS_STATE,
    "integral": _AS_STATE,
    "integrate": _AS_STATE,
    "ddt": _AS_RATE,
    "diff": _AS_RATE,
    "noevent": "leave it out: write its argument alone",
    "pre": _HELD,
    "edge": "an instant is `when condition { reset x = value; }`",
    "reinit": "write `when condition { reset x = value; }`",
    "delay": "a sampled part holds old values: see `UnitDelay` of `control.sampled`",
    "limit": "write `min(max(x, lowest), highest)`",
    "clip": "write `min(max(x, lowest), highest)`",
    "clamp": "write `min(max(x, lowest), highest)`",
    "step": "write `if time < start then 0 else height`, or use `Step` of `control.signals`",
    "ramp": "write `min(max((time - start)/duration, 0), 1)`, or use `Ramp` of `control.signals`",
    "rand": "write `random(seed, i)`",
    "size": "write `length(v)`",
    "len": "write `length(v)`",
    "linspace": "write the numbers of the vector, or `data(..)` of a file",
    "table": "write `interpolate(xs, ys, x)`",
}

_PATH = r"[A-Za-z_][\w.]*(?:\[[^\]\n]*\])?"
_OWN = "|".join(FORMS)  # the words that begin statements here
_TYPE = rf"(?!(?:{_OWN})\b)([A-Za-z]\w*)"
_QUALIFIED = r"(?:[A-Za-z]\w*\.)*"
_MODEL = "a model is `model Name { .. }`"
_IMPORT = 'an import is `import module.name;` or `import "file.bg";`'
_LOOP = "a loop is `for i in 1..n { .. }`"
_CHOICE = "another branch is `else if condition`"


def _patterns(*written: tuple[str, str]) -> tuple[tuple[re.Pattern[str], str], ...]:
    return tuple((re.compile(pattern), advice) for pattern, advice in written)


_KEYWORDS = _patterns(
    (
        rf"(?:equation\s+)?connect\s*\(\s*({_PATH})\s*,\s*({_PATH})\s*\)",
        r"a bond is an arrow: `\1 -> \2;`",
    ),
    (r"connect\b", "a bond is an arrow: `a -> b;`"),
    (r"end\b", "a block ends with `}`"),
    (r"(?:elif|elseif|elsif)\b", _CHOICE),
    (r"(?:parameter|constant)\s+[\w.]+\s+(\w+)", r"a parameter is `param \1 = value;`"),
    (r"constant\s+(\w+)", r"a constant is `const \1 = value;`"),
    (r"parameters\b", "each parameter is declared by itself: `param name = value;`"),
    (
        r"variables\b",
        "each variable is declared by itself: `state x = 0;`, `let` or `unknown`",
    ),
    (
        r"(?:equations|algorithm|initialequations)\b",
        "equations stand among the other statements: `der(x) = ..;`, `let y = ..;` or "
        "`equation left = right;`",
    ),
    (
        r"(?:Real|real|double|float|var|variable)\s+(\w+)",
        r"a variable is `state \1 = 0;`, `let` or `unknown`",
    ),
    (
        r"(?:Integer|integer|int|Boolean|boolean|bool)\s+(\w+)",
        r"values have no type: `param \1 = value;`, `const` or `let`",
    ),
    (r"String\b", "texts are no values: leave it out"),
    (r"initial\s+equation\b", "a start value stands at its declaration: `state x = ..;`"),
    (r"initial\s+(\w+)", r"a start value stands at its declaration: `state \1 = ..;`"),
    (r"(?:rtol|atol)\b", "tolerances are options of the method: `solver rodas5p(rtol = 1e-6);`"),
    (r"ddt\s*\(\s*(\w+)\s*\)", r"a derivative is `der(\1) = ..;`"),
    (r"extends\s+(\w+)", r"a model that extends another is `model Name is \1 { .. }`"),
    (
        rf"(?:replaceable|inner|outer)\s+{_QUALIFIED}(\w+)\s+(\w+)",
        r"an exchangeable part is a slot: `\2 : Interface = \1;`",
    ),
    (r"(?:protected|public|private|final|inner|outer)\b", "leave the word out"),
    (r"annotation\b", "leave it out; `///` before a declaration describes it"),
    (r"(?:partial|class|component|package|block|record)\b", _MODEL),
    (r"connector\b", "a kind of port is `domain Name { effort e : V; flow f : A; }`"),
    (r"within\b", "leave it out: a file is a module"),
    (r"(?:from|using|include|with)\b", _IMPORT),
    (r"(?:def|func|fun)\b", "a function is `function name(a, b) = expression;`"),
    (r"(?:return|begin)\b", "leave it out"),
    (r"while\b", _LOOP),
    (r"simulate\s+(\w+)", r"a run is a scene: `scene name of \1 { run 10 s; }`"),
)
"""Statements that begin with a word of another tool, each with the way to write it here."""

_SHAPES = _patterns(
    (r"\{|%|#", "a comment begins with `//`"),
    (rf"({_PATH})\s*(?:<-|<--)\s*({_PATH})", r"a bond is an arrow: `\2 -> \1;`"),
    (rf"({_PATH})\s*(?:<->|--|-->|=>)\s*({_PATH})", r"a bond is an arrow: `\1 -> \2;`"),
    (
        r"model\s+(\w+)\s+extends\s+(\w+)",
        r"a model that extends another is `model \1 is \2 { .. }`",
    ),
    (
        r"model\s+(\w+)\s+(?!is\b)[A-Za-z_\"]",
        r"the body of a model stands in braces: `model \1 { .. }`",
    ),
    (r"param\s+[\w.]+\s+(\w+)", r"values have no type: `param \1 = value;`"),
    (r"(?:param|let|const)\s+\w+(?:\[\w+\])?\s*=\s*\{", "a vector is `[1, 2, 3]`"),
    (
        r"param\s+(\w+)\s*=\s*([\d.eE+-]+)\s*\{\s*([\w*/^.-]+)\s*\}",
        r"a unit stands behind its number: `param \1 = \2 \3;`",
    ),
    (r"d(\w+)/dt\b", r"a derivative is `der(\1) = ..;`"),
    (r"(\w+)'\s*=", r"a derivative is `der(\1) = ..;`"),
    (r"der\s*\(\s*der\b", "name the first derivative: `der(x) = v; der(v) = ..;`"),
    (r"([01])-?junction\s+(\w+)", r"a junction is `\2 : J\1;`"),
    (r"(\w+)\s*:\s*([01])(?:-?junction)?\b", r"a junction is `\1 : J\2;`"),
    (
        rf"(\w+)\s*,\s*(\w+)\s*:\s*{_TYPE}",
        r"each part is declared by itself: `\1 : \3; \2 : \3;`",
    ),
    (
        rf"(\w+)\s*:\s*{_TYPE}\([^();]*\)\s*,\s*(\w+)\s*:",
        r"each part is declared by itself: `\1 : \2(..); \3 : ..;`",
    ),
    (r"([a-z_]\w*)\s+([A-Z]\w*)\s*\(", r"a part is `\1 : \2(..);`"),
    (rf"{_QUALIFIED}{_TYPE}\s+(\w+)\s*\(", r"a part is `\2 : \1(..);`"),
    (rf"{_QUALIFIED}{_TYPE}\s+(\w+)\s*;", r"a part is `\2 : \1;`"),
    (r"(\w+)\s*\+=", r"a state changes by `der(\1) = ..;`, in a `sample` by `next(\1) = ..;`"),
    (r"for\s+(\w+)\s*=", r"a loop is `for \1 in 1..n { .. }`"),
)
"""Other statements of peers, by their beginning, each with the way to write it here."""

_IN_SCENES = _patterns(
    (r"(?:dt|h|stepsize|step_size)\s*=\s*([^;\n]+)", r"a step is `step \1;`"),
    (
        r"(?:stopTime|StopTime|stop_time|tend|t_end|tstop|stop|duration)\b\s*=?\s*([^;\n]+)",
        r"the duration is `run \1;`",
    ),
    (r"run\s+(?:for|to|until)\s+([^;\n]+)", r"the duration is `run \1;`"),
    (
        r"(?:tolerance|tol|rtol|reltol)\s*=\s*([^;\n]+)",
        r"a tolerance is an option: `solver auto(rtol = \1);`",
    ),
    (r"(?:every|interval|Interval)\b", "rows are written `run 10 s every 1 ms;`"),
    (
        rf"(?:initial|init)\s+({_PATH})\s*=",
        "a start value is an argument in the model, as `f0` in `I(2 kg, f0 = speed)`; "
        "a scene sets its parameter",
    ),
    (rf"(?!(?:{_OWN})\b)({_PATH})\s*=", r"a parameter is set by `set \1 = value;`"),
)
"""Statements that peers try in a scene."""


def keyword_advice(text: str, block: str = "model") -> str:
    """Advise on a statement that begins with a word of a peer; else an empty text.

    `text` is the statement from its first character on, `block` the kind of block around it.
    """
    return _advice(text, (*_IN_SCENES, *_KEYWORDS) if block == "scene" else _KEYWORDS)


def statement_advice(text: str, block: str = "model") -> str:
    """Advise on a statement of a peer, by its first word or its form; else an empty text."""
    return keyword_advice(text, block) or _advice(text, _SHAPES)


def _advice(text: str, patterns: Iterable[tuple[re.Pattern[str], str]]) -> str:
    for written, advice in patterns:
        if found := written.match(text):
            return found.expand(advice)
    return ""


def element_advice(name: str) -> str:
    """Name the element that a word of a peer stands for; an empty text if there is none.

    Letter case, underscores and hyphens do not count: `OneJunction`, `one_junction`.
    """
    element = _ELEMENT_OF.get(name.casefold().replace("_", "").replace("-", ""))
    return f"the element is called `{element}` here: see `bgc doc {element}`" if element else ""


def part_of(name: str) -> str:
    """The part of the library that a name of another library stands for; empty if there is none."""
    return _PARTS.get(name.casefold().replace("_", "").replace("-", ""), "")


def value_advice(name: str) -> str:
    """Name the value that a word of a peer stands for; an empty text if there is none."""
    return _VALUES.get(name, "")


def function_advice(name: str) -> str:
    """Name what stands for a function of a peer; an empty text if there is none."""
    return _FUNCTIONS.get(name.casefold(), "")
