"""The words of the language, the blocks that they belong to, and the forms of statements."""

from __future__ import annotations

RESERVED = frozenset(
    "import model interface domain function scene const param let signal input output state "
    "unknown equation project assert port for in if then else use set and or not der time".split()
)
"""Never names."""

SCENE_WORDS = frozenset("observe run solver device drive require deadline step".split())
"""Reserved in a scene, names elsewhere."""

WORDS = {
    "file": "import const function pseudo domain interface model scene".split(),
    "model": "const param let signal input output state unknown port equation project assert "
    "for if".split(),
    "scene": "use set device drive observe plot require keep deadline solver step run".split(),
    "domain": "effort flow signal".split(),
    "law": [],
    "setting": [],
}
"""The words that begin a statement, by kind of block."""

PLACES = {
    "file": "at the top level of a file",
    "model": "in a model",
    "scene": "in a scene",
    "domain": "in a domain",
}
"""The place of a block's statements, as messages name it, by kind of block."""

BLOCK_OF = {
    "MODEL": "model",
    "INTERFACE": "model",
    "FOR": "model",
    "IF": "model",
    "ELSE": "model",
    "SCENE": "scene",
    "DOMAIN": "domain",
    "PSEUDO": "domain",
}
"""The kind of block that follows a statement, by the type of its first token."""

FORMS = {
    "import": 'an import is `import "file.bg";` or `import module.name;`',
    "model": "a model is `model Name[n] is Interface { .. }`",
    "interface": "an interface is `interface Name[n] { .. }`",
    "domain": "a domain is `domain Name { effort e : N; flow f : m/s; }`",
    "pseudo": "a pseudo domain is `pseudo domain Name { effort T : K; flow Q : W; }`",
    "function": "a function is `function name(a, b) = expression;`",
    "scene": "a scene is `scene name of Model { .. }`",
    "const": "a constant is `const name : unit = value;`",
    "param": "a parameter is `param name : unit = value in lowest .. highest;`",
    "let": "a derived value is `let name : unit = value;`",
    "signal": "a signal is `signal name[3] : unit = value;`",
    "input": "an input is `input name : unit = default;`",
    "output": "an output is `output name : unit = value;`",
    "state": "a state is `state name : unit = start;`",
    "unknown": "an unknown is `unknown name : unit = first guess;`",
    "port": "a port is `port name[6] in : Domain main;`, with `in` or `out`",
    "equation": "an equation is `equation left = right;`",
    "project": "a projection is `project x = value;`",
    "assert": 'an assertion is `assert condition, "message";`',
    "for": "a loop is `for i in 1..n { .. }`",
    "if": "a choice is `if condition { .. } else { .. }`",
    "else": "a choice is `if condition { .. } else { .. }`",
    "der": "a derivative is `der(x) = value;`",
    "use": "a slot is filled by `use part.slot = Type(arguments);`",
    "set": "a parameter is set by `set part.name = value;`",
    "device": 'a device is `device name = driver(file = "a.csv");`',
    "drive": "an input is driven by `drive part.input = value;`",
    "plot": "a panel of the plot is `plot name, other;` or `plot name against other;`",
    "observe": "outputs are `observe value as name, other;`",
    "require": "a requirement is `require value within tolerance;`",
    "keep": "a `keep` statement is `keep x, y;`",
    "deadline": "a deadline is `deadline 1 ms;`",
    "solver": "a solver is `solver name(rtol = 1e-8);`",
    "step": "a step is `step 1 ms;`",
    "run": "a run is `run 60 s every 10 ms;`",
}
"""The form of a statement, as messages show it, by its first word."""

FORMS_IN = {
    "file": "a file holds imports, then models, scenes, interfaces, domains, functions, constants",
    "model": "a part is `name : Type(arguments);`, bonds are `a -> b -> c;`",
    "scene": "a scene holds statements such as `observe value as name;` and `run 10 s;`",
    "domain": "a variable is `effort name : unit;`, or `flow` or `signal`",
    "law": "a law is `e = expression;`, or the same for another variable of the element",
    "setting": "a setting is `part.name = value`",
}
"""The statements of a block, as messages show them, by kind of block."""
