"""Every command that compiles a scene prints what the compiler warns of."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from bgc.runtime.cli.app import application

ODD = """
model Odd {
  supply : Se(e = 5 V);
  loop : J1;
  coil : I(1 mH);
  param r = -2 ohm;
  loss : R(r);
  supply -> loop;
  loop -> coil, loss;
}
scene s of Odd {
  observe loop.f;
  require loop.f within 1 A;
  run 1 ms;
}
"""
COMMANDS = [
    "activity",
    "bode --input supply.e --output loop.f",
    "build --target c",
    "build --target so",
    "causality",
    "check",
    "cost",
    "equations",
    "equations --latex",
    "equations --linear",
    "graph --out odd.dot",
    "run",
    "show --after elaborate",
    "show --after causality",
    "show --after equations",
    "stress --budget 2",
    "sweep --vary r=1..2:2 --out odd.csv",
    "trade --budget 2",
]


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.slow
def test_a_negative_resistance_is_reported_by_every_command(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("odd.bg").write_text(ODD)
    name, *options = command.split()
    result = CliRunner().invoke(application, [name, "odd.bg", *options])
    assert "BG460" in result.stderr, (result.exception, result.output)
    assert result.stderr.count("BG460") == 1
