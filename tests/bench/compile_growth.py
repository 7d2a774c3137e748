"""Growth of compile time with the size of a model.

Rules: processor time of the whole command `bgc build --target c`, the least of three, for a small
and a large model of each family. The time of a model of one state, which is that of the imports, is
subtracted. The figure is the exponent of the size that leads from one time to the other.
"""

import math
import resource
import subprocess
import tempfile
from pathlib import Path

from table import Row

RUNS = 3

ALONE = """
model Alone { store : C(1); loss : R(1); node : J0; node -> store, loss; }
scene s of Alone { observe store.q; run 1 s; }
"""

CHAIN = """
model Chain {{
  push : Se(e = 1 N);
  for i in 1..{n} {{
    mass[i] : I(1 kg); at[i] : J1; between[i] : J0; gap[i] : J1; spring[i] : C(stiffness = 1 N/m);
    drag[i] : R(0.1 N*s/m);
    at[i] -> mass[i];
    at[i] -> between[i];
    between[i] -> gap[i] -> spring[i], drag[i];
  }}
  for i in 1..{n} - 1 {{ between[i] -> at[i + 1]; }}
  push -> at[1];
}}
scene s of Chain {{ observe mass[{n}].f; run 1 s; }}
"""

MOTORS = """
model Motor {{
  port shaft out;
  supply : Se(e = 24 V); coil : J1; wire : R(1 ohm); winding : I(2 mH); drive : GY(0.05 N*m/A);
  turning : J1; rotor : I(1e-4 kg*m^2);
  supply -> coil -> wire, winding; coil -> drive -> turning -> rotor; turning -> shaft;
}}
model Motors {{
  common : J0; twist : C(stiffness = 10 N*m/rad); bearing : R(1 N*m*s/rad);
  for i in 1..{n} {{ motor[i] : Motor; motor[i].shaft -> common; }}
  common -> twist;
  common -> bearing;
}}
scene s of Motors {{ observe twist.e; run 1 s; }}
"""


def circuit(n: int) -> str:
    """A ladder of resistors and capacitors with a bridge every third node: resistive loops."""
    lines = ["model Circuit {", "  supply : Se(e = 5 V);"]
    lines += [f"  node{k} : J0;" for k in range(n)]
    bonds = ["  supply -> in0; in0 : J1; inner : R(1 ohm); in0 -> inner; in0 -> node0;"]
    for k in range(n - 1):
        bonds.append(f"  b{k} : J1; r{k} : R({1 + k % 7} ohm);")
        bonds.append(f"  node{k} -> b{k} -> node{k + 1}; b{k} -> r{k};")
        if k % 3 == 0 and k + 2 < n:
            bonds.append(f"  d{k} : J1; s{k} : R({2 + k % 5} ohm);")
            bonds.append(f"  node{k} -> d{k} -> node{k + 2}; d{k} -> s{k};")
    bonds += [f"  c{k} : C({1 + k % 3} uF); node{k} -> c{k};" for k in range(0, n, 2)]
    scene = f"scene s of Circuit {{ observe node{n - 1}.e; run 1 ms; }}"
    return "\n".join([*lines, *bonds, "}", scene])


def field(n: int) -> str:
    """A dense inductance matrix of n coils, all excited."""
    rows = ", ".join(
        "[" + ", ".join(f"{(2.0 if i == j else 1 / (3.0 + abs(i - j)))!r}" for j in range(n)) + "]"
        for i in range(n)
    )
    return (
        f"model Coils {{ param M = [{rows}]; supply : Se[{n}](e = 1); all : J1[{n}];"
        f" coils : I[{n}](M); loss : R[{n}](1); supply -> all -> coils, loss; }}\n"
        f"scene s of Coils {{ observe coils.f; run 1 s; }}"
    )


FAMILIES = {
    "chain of masses": (lambda n: CHAIN.format(n=n), 200, 1000, 1.15),
    "motors": (lambda n: MOTORS.format(n=n), 100, 500, 1.2),
    "circuit": (circuit, 100, 400, 1.2),
    "field": (field, 25, 60, 2.2),
}


def rows() -> list[Row]:
    """The exponent of each family, with the processor times of its two sizes."""
    least = _seconds(ALONE)
    found = []
    for name, (text, small, large, must) in FAMILIES.items():
        times = [_seconds(text(n)) for n in (small, large)]
        exponent = math.log((times[1] - least) / (times[0] - least)) / math.log(large / small)
        note = f"{times[0]:.2f} s and {times[1]:.2f} s, imports {least:.2f} s"
        on = f"compile time, {small} to {large}"
        found.append(Row(name, on, exponent, must=must, below=True, note=note))
    return found


def _seconds(text: str) -> float:
    """The least processor time of `bgc build --target c` of a model."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "model.bg").write_text(text, encoding="utf-8")
        command = ["bgc", "build", "model.bg", "--target", "c"]
        found = []
        for _ in range(RUNS):
            before = _children()
            subprocess.run(command, cwd=folder, check=True, capture_output=True)
            found.append(_children() - before)
    return min(found)


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
