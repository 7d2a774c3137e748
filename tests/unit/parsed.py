"""Texts read as trees: one of the whole language, and trees and refusals in short form."""

from __future__ import annotations

from bgc.diagnostics.render import render
from bgc.diagnostics.source import Source
from bgc.grammar import syntax
from bgc.grammar.parse import parse
from bgc.grammar.syntax import Binary, Call, Index, Member, Name, Number, Range, Unary

EVERYTHING = """
import "joints.bg";
import crane.joints;

const g = 9.81 m/s^2;
function skew(v) = [[0, -v[3], v[2]], [v[3], 0, -v[1]], [-v[2], v[1], 0]];
function half(x) =
  if x > 0 and not (x == 1) then x/2 else if x < -1 or x != 3 then -x else 0;

/// A port in space.
domain Frame {
  effort F[3] : N; effort M[3] : N*m;
  flow v[3] : m/s; flow w[3] : rad/s;
  signal r[3] : m; signal A[3, 3];
}
pseudo domain Heat { effort T : K; flow Q : W; }

interface Lock[n] { port p[n]; output d[n]; }

/// Stiff
/// and damped.
model Compliant[n = 6, m] is Lock[n](k = 3) {
  const c = 3;
  param axis[3] = [0, 0, 1];
  param mass : kg = 1 t in 0 t .. 100 t;
  let l = 2*mass;
  signal r[3] : m = [time, 0, .5];
  input q[2];
  output d[n];
  state x : m = 1;
  state A[3, 3];
  unknown z = 0;

  port base in : Frame;
  port tip[6] out : Frame main;
  port p;
  port side out;

  supply : Se(e = 5 V);
  loop   : J1;
  R      : R(R);
  body   : I[6](mass*eye(3), p0 = [0, 0]);
  mass[i + 1] : I(m);
  lock   : Lock[5] = Rigid[5](k = 1e9 N/m);
  slot   : Crane = TwoBeamCrane;
  joint  : Revolute(lock = Rigid[5](stiff = 1), other = Rigid(a = 1));
  drag   : R { e = d1*f + d2*abs(f)*f; }
  spring : C { H = k/2*q^2 + k3/4*q^4; };
  map    : MTF[2, 3] { f2[1..2] = J*f1; }
  nothing : J0 { }

  supply -> loop -> tip;
  a, b.c -> join -> hub[1..3], d[i];
  tip.r = base.r;
  der(x) = -x/2;
  der(x[1]) = 1;
  equation z^2 + der(x) = 0;
  project x = x/norm(x);
  assert x > 3 m, "too far";
  for i in 1..n - 1 { mass[i] -> mass[i + 1]; for j in 1..2 { } }
  if n == 3 { a -> b; } else if n < 2 { b -> a; } else { }
}
model Osv is Vessel(M = [[1, 2], [3, 4]]) { }

scene telescopic of Session(k = 1) {
  use crane = TelescopicCrane;
  use crane.elbow.lock = Rigid[5](k = 1);
  set crane.boom.mass = 7 t;
  device hand = trace(file = "up.csv", gain = 2);
  device omega = forcedimension;
  drive handle.x = hand.position;
  observe energy.stored, tip.z as height, 2*boom.f[1];
  require tip.z within 5 mm;
  plot height, tip.z;
  plot force[3] against height;
  keep x, crane.y;
  deadline 1 ms;
  solver rodas5p(rtol = 1e-8, atol = 1e-10);
  solver auto;
  step 1 ms;
  run 60 every 10 ms;
}
"""


def items(body: str) -> tuple[syntax.Item, ...]:
    """The items of a model."""
    (model,) = read(f"model M {{ {body} }}").declarations
    assert isinstance(model, syntax.Model)
    return model.items


def read(text: str) -> syntax.File:
    """The tree of a text that must be right."""
    file, wrong = parse(Source("test.bg", text))
    assert not wrong, render(wrong, colour=False)
    return file


def show(expr: syntax.Expr | Range) -> str:
    """An expression with all its parentheses."""
    match expr:
        case Number(value, unit):
            return f"{value}" if unit is None else f"{value}_{unit}"
        case Name(name):
            return name
        case Unary(operator, operand):
            return f"({operator}{show(operand)})"
        case Binary(operator, left, right):
            return f"({show(left)}{operator}{show(right)})"
        case Member(base, name):
            return f"{show(base)}.{name}"
        case Index(base, indices):
            return f"{show(base)}[{','.join(show(index) for index in indices)}]"
        case Range(first, last):
            return f"{show(first)}..{show(last)}"
        case Call(function, arguments):
            return f"{function}({','.join(show(argument) for argument in arguments)})"
    raise AssertionError(expr)


def wrong(text: str) -> list[tuple[str, str]]:
    """Code and underlined text of every diagnostic."""
    _, found = parse(Source("test.bg", text))
    assert all(d.help or d.labels for d in found), "a message without a way out"
    return [(d.code, d.span.text if d.span else "") for d in found]
