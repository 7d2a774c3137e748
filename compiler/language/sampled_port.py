"""The model behind a `sampled` port: a virtual coupling with the energy of each sample.

The coupling is a spring and a damper between a device, whose position is read at instants, and a
bond, on which its effort is held in between. The effort h that the device held, times its
displacement since the last instant, is the energy that the coupling received; the effort e on the
bond, times the displacement y of the bond, is the energy that it gave. Both are exact, whatever
happened in between.

    E' = E + h.dx - e.dy            energy in the coupling
    E' > H: lost += E' - H          H(q): energy of the spring; its damper, and every surplus
    E' < H: owed, up to `debt`      energy that sampling has created and that the brake takes back
    e  = g(q) + R dq/T + a v         a = min(owed / (T v.v), brake), 0 where nothing is owed

R = K T (lag + 1) pays for the energy K T (lag + 1/2) v^2 that a held spring creates (Colgate and
Schenkel 1997, for lag 0), so that the brake acts only where the lag was misjudged. What is owed
beyond `debt`, and a leak for the rounding of positions, is entered as `created`.
"""

from __future__ import annotations

import re

NEEDED = ("position", "stiffness", "mass")
"""Quantities that the law of a sampled port must give."""

GIVEN = {
    "position": "position of the device, read at each instant",
    "stiffness": "K, stiffness of the coupling",
    "mass": "mass of the device that the hand feels",
    "held": "what the device really held since the last instant, as `reaction` (default: that)",
    "lag": "periods, at worst, from a position to the effort that answers it (0)",
    "age": "age of the pose that the held effort answers, measured; adapts R up to `lag`",
    "damping": "R, damping of the coupling (K T (lag + 1))",
    "resolution": "resolution of the position (0: ideal)",
    "brake": "largest damping that acts on what is owed",
    "debt": "energy that may be owed (1e-4 J)",
    "leak": "power of the rounding of positions, entered as created (K resolution^2/(4 T))",
    "limit": "largest effort of the device (none)",
    "stretch0": "stretch at the start (0)",
    "one_sided": "1: a wall at position 0, which pushes and does not pull (0)",
}
"""Quantities of the law of a sampled port, with their defaults."""

READ = {
    "reaction": "effort on the device, within its limit: what a scene drives it with",
    "effort": "effort on the bond, held since the last instant",
    "stretch": "displacement of the device less that of the bond",
    "moved": "displacement of the bond since the start",
    "paid_lag": "lag that the damping pays for, where the port has an `age`",
    "energy": "energy in the coupling, less what is owed",
    "owed": "energy that sampling has created and that the brake will take back",
    "supplied": "energy received from the device",
    "delivered": "energy given to the bond",
    "lost": "energy dissipated",
    "created": "energy that sampling has created for good",
}
"""Quantities of a sampled port that can be read, beside `e`, `f` and `power` of its bond."""

MODEL = "SampledPort"

_TEMPLATE = """\
model SampledPort[n] {{
  port bond;
  input position[n] : {q};
  input held[n] : {e} = reaction;
  input stretch0[n] : {q} = zeros(n);
{age}  param period : s in 1e-6 .. 1e6;
  param stiffness : {k} in 0 .. 1e15;
  param mass : {m} in 1e-9 .. 1e12;
  param lag = 0 in 0 .. 1e4;
  param damping : {r} = stiffness*period*(lag + 1) in 0 .. 1e15;
  param resolution : {q} = 0 in 0 .. 1e6;
  param brake : {r} = {brake} in 0 .. 1e15;
  param debt : {w} = 1e-4 in 0 .. 1e15;
  param leak : {p} = stiffness*resolution^2/(4*period) in 0 .. 1e15;
  param limit : {e} = 1e300 in 1e-9 .. 1e300;
  const sense = 1;

  source : MSe[n](e = sense*effort);
  source -> bond;
  state moved[n] : {q};
  der(moved) = source.f;
  let balance = energy - dot(effort, moved - moved_before);

  let force0 = stiffness*stretch0;
  sample period {{
    state begun = 0;
    state position_before[n] : {q} = zeros(n);
    state moved_before[n] : {q} = zeros(n);
    state stretch[n] : {q} = stretch0;
    state effort[n] : {e} = force0;
    state reaction[n] : {e} = -force0*(limit/max(limit, norm(force0)));
    state play[n] : {q} = zeros(n);
    state energy : {w} = 0.5*dot(force0, stretch0);
    state owed : {w} = 0;
    state supplied : {w} = 0;
    state delivered : {w} = 0;
    state lost : {w} = 0;
    state created : {w} = 0;
{worst}
    let dx = if begun > 0 then position - position_before else zeros(n);
    let dy = moved - moved_before;
    let free = if begun > 0 then stretch + dx - dy else {first};
    let pressed = {pressed};
    let dq = if begun > 0 then pressed - {before} else zeros(n);
    let spring = 0.5*stiffness*dot(pressed, pressed);
    let got = if begun > 0 then -dot(held, dx) else spring - energy;
    let gave = dot(effort, dy);
    let left = energy + got - gave;
    let missing = max(spring - left, 0);
    let made = min(missing, leak*period + max(missing - debt, 0));
    let unpaid = missing - made;
    let slack = play + {slack};
    let size = norm(slack);
    let share = if size > resolution then 1 - resolution/size else 0;
    let drift = slack*(share/period);
    let speed = dot(drift, drift);
    let braking = if unpaid > 0 and speed > 0 then min(unpaid/(period*speed), brake) else 0;
{lag}    let force = stiffness*pressed + ({damping}/period)*dq + braking*drift;

    next(begun) = 1;
    next(position_before) = position;
    next(moved_before) = moved;
    next(stretch) = free;
    next(effort) = force;
    next(reaction) = -force*(limit/max(limit, norm(force)));
    next(play) = slack*(1 - share);
    next(energy) = min(left, spring) + made;
    next(owed) = unpaid;
    next(supplied) = supplied + got;
    next(delivered) = delivered + gave;
    next(lost) = lost + max(left - spring, 0);
    next(created) = created + made;
  }}
}}
"""


# The damping with the lag that was measured in the last second, at most the stated one.
_MEASURED = {
    "age": "  input age : s;\n",
    "worst": "    state paid_lag = lag;\n",
    "lag": """\
    let measured = if age > 0 then min(max(age/period - 1, 0), lag) else lag;
    let recent = max(measured, paid_lag - (lag/1 s)*period);
    next(paid_lag) = recent;
""",
    "damping": "damping*((recent + 1)/(lag + 1))",
}
_STATED = {"age": "", "worst": "", "lag": "", "damping": "damping"}


def port_model(width: int, one_sided: bool, measures: bool, effort: str, flow: str) -> str:
    """The text of the model `SampledPort` for a bond of a width, with the units of its domain.

    Where the port `measures`, its damping follows the age of the pose that the held effort answers.
    """
    stroke = flow.removesuffix("/s") if flow.endswith("/s") else f"{flow}*s"
    is_linear = (effort, flow) == ("N", "m/s")
    largest = "mass/(2*period*(lag + 0.5))"

    def pushing(name: str) -> str:
        parts = ", ".join(f"max({name}[{k}], 0)" for k in range(1, width + 1))
        return f"[{parts}]" if one_sided else name

    return _TEMPLATE.format(
        e=effort,
        q=stroke,
        k=f"{effort}{_inverse(stroke)}",
        r=f"{effort}*s{_inverse(stroke)}",
        m="kg" if is_linear else f"{effort}*s^2{_inverse(stroke)}",
        w="J",
        p="W",
        first="position - moved" if one_sided else "stretch0",
        brake=f"min(30, {largest})" if is_linear else largest,
        pressed=pushing("free"),
        before=pushing("stretch"),
        slack="dx" if one_sided else "dq",
        **(_MEASURED if measures else _STATED),
    )


def _inverse(unit: str) -> str:
    """Return the factors by which a product is divided by a unit: `/m*s` for `m/s`."""
    return re.sub(r"[*/]", lambda sign: "/" if sign[0] == "*" else "*", f"*{unit}")
