"""The words of the language: where each begins a statement, its form, and its meaning.

One row a word; those of scenes are in `scene_statements.py`. The parser's messages take the forms
from here, `bgc doc` the texts; a test compares the rows with the terminals of `bgc.lark`.
"""

from __future__ import annotations

from collections.abc import Mapping

from bgc.grammar.scene_statements import SCENE_STATEMENTS
from bgc.grammar.word import Reserved, Word

_FILE = (
    Word(
        "import",
        "Makes the declarations of another file, or of a module of the library, visible.",
        ("file",),
        'an import is `import "file.bg";` or `import module.name;`',
        (
            "The path of a file counts from the importing file. What the imported file imports is "
            "visible too; its scenes can be extended, not run. Imports stand before all "
            "declarations.",
        ),
        'import crane.beam;\nimport "my_joint.bg";',
        ("model", "library"),
    ),
    Word(
        "const",
        "A value that is known when the model is compiled.",
        ("file", "model"),
        "a constant is `const name : unit = value;`",
        (
            "Widths, indices, loop bounds and conditions of compile-time `if` must be constant. "
            "An argument or a `set` may replace its value; the model is then compiled again.",
        ),
        "const links = 3;\nconst axis = [0, 0, 1];",
        ("param", "let"),
    ),
    Word(
        "function",
        "A function of the user's own: one expression of its arguments.",
        ("file",),
        "a function is `function name(a, b) = expression;`",
        (
            "Arguments may be scalars, vectors or matrices of any unit. A function may call others "
            "but not itself, and hides a built-in function of the same name.",
        ),
        "function square(x) = x*x;",
        ("functions",),
    ),
    Word(
        "domain",
        "A kind of bond: its efforts and flows with their units, and signals carried along it.",
        ("file",),
        "a domain is `domain Name { effort e : N; flow f : m/s; }`",
        (
            "The efforts, one after the other, are the components of a bond's effort; the flows "
            "pair with them, and each product must be a power. The tail of a bond writes the "
            "signals, the head reads them.",
        ),
        "domain Hydraulic {\n  effort P : Pa;\n  flow Q : m^3/s;\n}",
        ("port", "effort", "flow", "signal", "pseudo"),
    ),
    Word(
        "interface",
        "What all models of a slot have in common: ports, parameters, inputs and outputs.",
        ("file",),
        "an interface is `interface Name[n] { .. }`",
        (
            "A model fits a slot of the interface if it `is` that interface. It repeats the ports "
            "and values of the interface and may add others.",
        ),
        "interface Lock[n] {\n  port p[n] out;\n  output d[n];\n}",
        ("model", "is", "use"),
    ),
    Word(
        "model",
        "A type of part: values, ports, parts, bonds and equations.",
        ("file",),
        "a model is `model Name[n] is Interface { .. }`",
        (
            "`is` names an interface that it fits, or a model whose contents it takes over, with "
            "arguments if need be. Numbers in brackets are dimensions, which are known when the "
            "model is compiled.",
        ),
        "model Spring[n] {\n  port p[n] in;\n  param k : N/m = 1 kN/m;\n"
        "  spring : C[n](stiffness = k);\n  p -> spring;\n}",
        ("interface", "is", "port", "scene"),
    ),
    Word(
        "scene",
        "What is simulated: a model, how it is driven, what is observed and for how long.",
        ("file",),
        "a scene is `scene name of Model { .. }` or `scene name is other { .. }`",
        (
            "A scene is compiled for what it observes; what nothing depends on is left out. The "
            "commands take the first scene of a file unless `--scene` names another.",
            "`is` takes all statements of another scene, of this file or an imported one, and "
            "adds or replaces some.",
        ),
        "scene step of RLC {\n  observe capacitor.e as voltage;\n  run 10 ms;\n}\n"
        "scene slow is step {\n  set R = 10 kohm;\n}",
        ("is", "observe", "run", "use", "set", "solver"),
    ),
)

_VALUES = (
    Word(
        "param",
        "A value that may be changed without compiling again.",
        ("file", "model"),
        "a parameter is `param name : unit = value in lowest .. highest;`",
        (
            "Given by an argument of the part, by `set` in a scene, by `--set` on the command line "
            "or from Python. A value outside its range is refused. A parameter without a default "
            "must be given. A default may depend on other parameters.",
            "At the top level of a file it is one value for all models, such as `gravity` of the "
            "library: functions may hold it, and a scene sets it by its name alone.",
        ),
        "param mass : kg = 2 t in 1 kg .. 100 t;\nparam side : m = 0.5 m;",
        ("const", "set", "in"),
    ),
    Word(
        "let",
        "A name for an expression.",
        ("model",),
        "a derived value is `let name : unit = value;`",
        ("It may depend on parameters, states, bonds and time, and is evaluated where needed.",),
        "let omega = 2*pi/period;",
        ("signal", "const"),
    ),
    Word(
        "signal",
        "A value that varies with time. In a domain: a value carried along a bond.",
        ("model", "domain"),
        "a signal is `signal name[3] : unit = value;`",
        (
            "Without a value it is given by a statement `name = value;`. The tail of a bond gives "
            "the signals of its domain, `tip.r = base.r + base.A*offset;`; the head reads them.",
        ),
        "signal R[3, 3] = rot_z(angle);",
        ("let", "domain"),
    ),
    Word(
        "input",
        "A value that comes from outside the model.",
        ("model",),
        "an input is `input name : unit = default;`",
        (
            "Given by an argument of the part, which may vary, or by `drive` in a scene. Without "
            "either it has its default. A linear model may vary it: `bgc bode --input name`.",
        ),
        "input torque : N*m = 0;",
        ("drive", "output", "param"),
    ),
    Word(
        "output",
        "A value that other parts and scenes read.",
        ("model",),
        "an output is `output name : unit = value;`",
        (
            "Any value of a part can be read; an output is what a model offers on purpose, in the "
            "unit that it declares. Without a value it is given by `name = value;`.",
        ),
        "output height : m = tip.r.z;",
        ("input", "observe"),
    ),
    Word(
        "state",
        "A value that is integrated; its equation is `der(x) = ..;`.",
        ("model",),
        "a state is `state name : unit = start;`",
        (
            "The start is 0 unless given. Storage elements have states of their own, which need no "
            "declaration.",
        ),
        "state x : m = 10 cm;\nder(x) = -x/tau;",
        ("der", "project", "unknown"),
    ),
    Word(
        "unknown",
        "A value that an equation determines implicitly.",
        ("model",),
        "an unknown is `unknown name : unit = first guess;`",
        ("There are as many equations as unknowns and states without `der(x) = ..;`.",),
        "unknown z = 1;\nequation z^3 + z = x;",
        ("equation", "state"),
    ),
)

_STATEMENTS = (
    Word(
        "port",
        "A connection of the model to the outside, where a bond ends.",
        ("model",),
        "a port is `port name[6] in : Domain main;`, with `in` or `out`",
        (
            "`in` and `out` say which way the half arrow points, so the direction of positive "
            "power. What is not written (direction, domain, width) follows from the bonds. A part "
            "in a bond means its only port that fits the arrow, or the one marked `main`.",
        ),
        "port base in : Frame;\nport tip out : Frame main;\nport p;",
        ("in", "out", "main", "domain"),
    ),
    Word(
        "equation",
        "An implicit equation; either side may hold `der(x)`.",
        ("model",),
        "an equation is `equation left = right;`",
        ("Both sides have one shape and one unit.",),
        "equation m*der(v) + d*v = force;",
        ("unknown", "der"),
    ),
    Word(
        "project",
        "Sets a state after each step, or keeps a signal at the value that bonds give it.",
        ("model",),
        "a projection is `project x = value;`",
        (
            "For invariants that integration keeps only within its tolerance.",
            "Of a signal: the states in it are moved as little as possible; the start is closed.",
        ),
        "project h = h/norm(h);",
        ("state",),
    ),
    Word(
        "assert",
        "Ends the run with a message where a condition is false.",
        ("model",),
        'an assertion is `assert condition, "message";`',
        ("It is checked after each step. The last good state and the rows up to it are kept.",),
        'assert abs(theta) < pi/2, "the pitch has reached 90 deg";',
        ("BG705",),
    ),
    Word(
        "shape",
        "Draws a part: a shape in the frame of the part, at another frame, or between two.",
        ("model",),
        'a shape is `shape name(arguments) at place colour "name";`',
        (
            "`at` takes a frame (a port, a 1-junction or a part whose domain carries `r[3]` and "
            "`A[3, 3]`) or an offset in the frame of the part, then a rotation matrix. "
            "`from a to b` stretches a rope, cylinder or capsule between two frames.",
        ),
        'shape box(2 m, 1 m, 0.5 m) at [1 m, 0, 0] colour "orange";\nshape rope from a.tip to b;',
        ("shapes", "at", "colour"),
        Reserved.NOWHERE,
    ),
    Word(
        "sample",
        "A part that computes at instants, as a digital controller does.",
        ("model",),
        "a sampled part is `sample period offset time { .. }`",
        (
            "Its instants are offset + k period, k = 0, 1, ..; without `offset` the first is at "
            "time 0. At each instant all is evaluated with the values before it. Outputs are the "
            "model's and are held in between; until the first instant they are 0.",
        ),
        "sample 10 ms {\n  state i = 0;\n  next(i) = i + error;\n  output u = 2*error + i;\n}",
        ("next", "offset", "when"),
        Reserved.NOWHERE,
    ),
    Word(
        "next",
        "The value of a state of a sampled part from an instant on.",
        (),
        "the next value of a sampled state is `next(x) = value;`",
        ("The value reads all states and outputs as they are before the instant.",),
        "sample 10 ms {\n  state i = 0;\n  next(i) = i + 1;\n}",
        ("sample", "state"),
        Reserved.NOWHERE,
    ),
    Word(
        "offset",
        "Stands before the first instant of a sampled part.",
        example="sample 10 ms offset 2 ms { }",
        related=("sample",),
        reserved=Reserved.NOWHERE,
    ),
    Word(
        "when",
        "Resets states at the instant at which a condition becomes true.",
        ("model",),
        "a jump is `when condition { reset x = value; }`",
        (
            "The instant is located within the step. All resets read the values before it and "
            "apply together. A condition that holds at the start has not become true.",
        ),
        "when ball.q < 0 {\n  reset mass.p = -e*mass.p;\n}",
        ("reset", "events", "BG770"),
        Reserved.NOWHERE,
    ),
    Word(
        "reset",
        "Gives a state, displacement or momentum another value, in a `when`.",
        ("when",),
        "a reset is `reset x = value;`",
        (
            "`x` is a declared state, or the `q` or `p` of a storage element that has a state of "
            "its own, of this model or of a part.",
        ),
        "when x > 1 m { reset x = 0; }",
        ("when",),
        Reserved.NOWHERE,
    ),
    Word(
        "for",
        "Repeats declarations and statements; the loop is unrolled when the model is compiled.",
        ("model",),
        "a loop is `for i in 1..n { .. }`",
        ("Both ends are included and must be constant. Parts in it are indexed: `mass[i]`.",),
        "for i in 1..3 {\n  mass[i] : I(m);\n  link -> mass[i];\n}",
        ("in", "const"),
    ),
    Word(
        "if",
        "A choice: between statements when the model is compiled, between values at run time.",
        ("model",),
        "a choice is `if condition { .. } else { .. }`",
        (
            "The condition of statements must be constant. `if c then a else b` is an expression; "
            "where c depends on states or on time, a change of c ends the step (an event).",
        ),
        "if n > 1 { gap : J0; }\nlet f = if x > 0 then k*x else 0;",
        ("then", "else", "events"),
    ),
    Word(
        "else",
        "The other case of `if`.",
        (),
        "a choice is `if condition { .. } else { .. }`",
        related=("if",),
    ),
    Word(
        "then",
        "Stands before the first value of the expression `if c then a else b`.",
        related=("if",),
    ),
    Word(
        "der",
        "The derivative of a state by time.",
        (),
        "a derivative is `der(x) = value;`",
        ("On the right side of an equation it is allowed in `equation` only.",),
        "der(angle) = shaft.f;",
        ("state", "equation"),
    ),
    Word(
        "time", "The time in s, from 0 at the start of the run.", example="let a = sin(omega*time);"
    ),
    Word(
        "in",
        "The range of a parameter, the direction of a port, or the range of a loop.",
        doc=("A port that is `in` takes power from outside while effort times flow is positive.",),
        example="param R : ohm = 2 ohm in 0 ohm .. 1 kohm;\nport p in;\nfor i in 1..n { }",
        related=("param", "port", "for"),
    ),
    Word("and", "True where both conditions are true.", related=("or", "not")),
    Word("or", "True where one of two conditions is true, or both are.", related=("and", "not")),
    Word("not", "True where the condition is false.", related=("and", "or")),
)

_SOFT = tuple(
    Word(word, summary, begins, form, doc, example, related, Reserved.NOWHERE)
    for word, summary, begins, form, doc, example, related in (
        (
            "is",
            "Names the interface that a model fits, or the model or scene that is extended.",
            (), "", (), "model Osv is Vessel(D = osv_D) { }\nscene heavy is lift { }",
            ("model", "interface", "scene"),
        ),
        ("of", "Names the model of a scene.", (), "", (), "scene step of RLC { .. }", ("scene",)),
        (
            "out",
            "A port whose half arrow points out of the model: positive power leaves.",
            (), "", (), "port tip out : Frame main;", ("port", "in"),
        ),
        (
            "main",
            "Marks the port that a part's bare name means where several fit.",
            (), "", (), "port tip out : Frame main;", ("port",),
        ),
        (
            "sampled",
            "A port that is a virtual coupling to a device, held over samples, exact in energy.",
            (), "", (
                "Its law gives `position`, `stiffness` and `mass`, and more: a spring and a damper "
                "between the device and the bond, with the energy of each sample in its books.",
            ),
            "port tip[3] out sampled 1 ms { position = x; stiffness = 800 N/m; mass = 0.25 kg; }",
            ("port", "sample"),
        ),
        (
            "pseudo",
            "A domain whose effort times flow is not a power, such as temperature and heat flow.",
            ("file",),
            "a pseudo domain is `pseudo domain Name { effort T : K; flow Q : W; }`",
            ("Its bonds do not count in the energy accounts.",),
            "pseudo domain Thermal {\n  effort T : K;\n  flow Q : W;\n}",
            ("domain",),
        ),
        (
            "effort", "An effort of a domain.", ("domain",), "", (), "effort P : Pa;",
            ("domain", "flow"),
        ),
        (
            "flow", "A flow of a domain.", ("domain",), "", (), "flow Q : m^3/s;",
            ("domain", "effort"),
        ),
        (
            "from", "Stands before the first end of a shape.", (), "", (),
            "shape rope from a.tip to b;", ("shape",),
        ),
        (
            "to", "Stands before the second end of a shape.", (), "", (),
            "shape rope from a.tip to b;", ("shape",),
        ),
        (
            "at", "Stands before the place of a shape.", (), "", (),
            "shape sphere(1 m) at [0, 0, 2 m];", ("shape",),
        ),
        (
            "colour", "Stands before the colour of a shape.", (), "", (),
            'shape sphere(1 m) colour "red";', ("shape",),
        ),
    )
)  # fmt: skip

TABLE: Mapping[str, Word] = {
    row.word: row
    for row in (
        *(*_FILE, *_VALUES, *_STATEMENTS, *SCENE_STATEMENTS.values(), *_SOFT),
        *(clause for row in SCENE_STATEMENTS.values() for clause in row.clauses),
    )
}
"""All words of the language."""

RESERVED = frozenset(w.word for w in TABLE.values() if w.reserved is Reserved.EVERYWHERE)
"""Never names."""

SCENE_WORDS = frozenset(w.word for w in TABLE.values() if w.reserved is Reserved.IN_SCENES)
"""Reserved in a scene, names elsewhere."""

WORDS = {
    block: [row.word for row in TABLE.values() if block in row.begins]
    for block in ("file", "model", "scene", "domain", "law", "setting", "filling", "when")
}
"""The words that begin a statement, by kind of block."""

PLACES = {
    "file": "at the top level of a file",
    "model": "in a model",
    "scene": "in a scene",
    "domain": "in a domain",
    "when": "in a `when`",
}
"""The place of a block's statements, as messages name it, by kind of block."""

BLOCK_OF = {
    "MODEL": "model",
    "INTERFACE": "model",
    "FOR": "model",
    "IF": "model",
    "ELSE": "model",
    "WHEN": "when",
    "SAMPLE": "model",
    "SCENE": "scene",
    "DOMAIN": "domain",
    "PSEUDO": "domain",
}
"""The kind of block that follows a statement, by the type of its first token."""

FORMS = {row.word: row.form for row in TABLE.values() if row.form}
"""The form of a statement, as messages show it, by its first word."""

FORMS_IN = {
    "file": "a file holds imports, then models, scenes, interfaces, domains, functions, constants, "
    "parameters",
    "model": "a part is `name : Type(arguments);`, bonds are `a -> b -> c;`",
    "scene": "a scene holds statements such as `observe value as name;` and `run 10 s;`",
    "domain": "a variable is `effort name : unit;`, or `flow` or `signal`",
    "law": "a law is `e = expression;`, or the same for another variable of the element",
    "setting": "a setting is `part.name = value`",
    "filling": "a slot is filled by `part.slot = Type(arguments)`",
    "when": "a `when` holds statements such as `reset x = value;`",
}
"""The statements of a block, as messages show them, by kind of block."""
