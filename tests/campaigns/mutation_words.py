"""Words, numbers, units and statements that mutations put into a text.

The words and one example of each come from the tables of the language.
"""

from __future__ import annotations

from bgc.grammar.language_words import TABLE
from bgc.language.elements import ELEMENTS as ELEMENT_KINDS
from bgc.values.functions import BUILTINS

KEYWORDS = tuple(TABLE)
ELEMENTS = tuple(ELEMENT_KINDS)
FUNCTIONS = tuple(BUILTINS)
NUMBERS = (
    "0 1 2 3 -1 0.0 -0.0 1e308 1e-308 1e-320 1e400 1e-400 2147483648 99999999999999999999 0.1 1.5"
    " 1e5 1e16 1e-16 1000 7 12 100000 4.9e-324 00 1e+5 1.e3 .5 0x10 1_000 1e 3.14159265358979"
).split()
UNITS = (
    "m kg s N W J V A K rad deg mm m/s N*m kg^99 1/m m^-1 m^0.5 m/m/m furlong N*s/m s^-1 kN.m % "
    "psi bar degC m^2/s^3 Hz h ms 1 ohm mol kg*m^2 m**2 m^ /m * ° µm"
).split()
DIMENSIONS = (
    "[0] [1] [2] [3] [6] [-1] [1..3] [2..1] [1, 2] [2, 2] [3, 3] [2, 2, 2] [1e9] [time] [n] [] "
    "[1.5] [i] [100] [3000] [1..] [x] ['a'] [[1]] [1, 1, 1]"
).split(" [")
PIECES = (
    "{ } ( ) [ ] ; , . : = -> .. + - * / ^ < <= == != > \" ' // /* */ \\ # $ @ ! ? ~ | & ` "
    "\t \n \r \0 \x1b[31m \u202e \u2028 \xe9 \u20ac \U0001f600 \ufeff \ud800 0 1e9"
).split(" ")
STATEMENTS = (
    *(row.example for row in TABLE.values() if row.example),
    "x : R(1);",
    "state x = 1;",
    "der(x) = -x;",
    "unknown y = 0;",
    "equation y = x;",
    "equation y^3 + y = time;",
    "project x = max(x, 0);",
    'assert x > 0, "x";',
    "for i in 1..3 { a[i] : R(i); }",
    "for i in 1..0 { }",
    "if 1 > 2 { b : R(1); } else { b : C(1); }",
    "input u = 0;",
    "output w = x;",
    "signal s[3];",
    "const k = 3;",
    "param p = 1 in 0..2;",
    "port q in;",
    "let v = time;",
    "observe x;",
    "plot x;",
    "plot x against time;",
    "keep x;",
    "run 1 s;",
    "run 1 s every 1 ms;",
    "step 1 ms;",
    "solver rk4;",
    "solver rodas5p(rtol = 1e-3);",
    "deadline 1 ms;",
    "require x within 1;",
    "set p = 2;",
    "use slot = R(1);",
    "device h = omega;",
    'device h = trace(file = "x.csv");',
    "drive u = h.position;",
    "observe energy.residual;",
    "j : J1;",
    "j : J1[3];",
    "s1 : Se(e = 1);",
    "j -> x;",
    "s1 -> j -> x;",
    "sample 10 ms { state i = 0; next(i) = i + x; output u = 2*i; }",
    "sample 1 ms offset 0.3 ms { output u = x; }",
    "when x > 1 { reset x = -x; }",
    "when time > 0.5 { reset x = 0; reset y = 1; }",
    "shape sphere(x) at [x, 0, 0];",
    'shape box(1 m, 1 m, x) colour "red";',
    "shape rope from a to b;",
    "start rest;",
    "start rest hold x vary y;",
    "observe x in deg;",
    'const d = data("road.csv");',
    'let h = interpolate(data("road.csv"), time);',
    "let r = random(7, x);",
    "let J = jacobian([x, y^2], [x, y]);",
    "scene s2 is s { set p = 3; }",
    "param g : m/s^2 = 9.81;",
    "unknown z[2] = [0, 1];",
    "x : IC[2](energy = p*q);",
)
