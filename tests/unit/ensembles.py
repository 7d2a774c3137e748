"""An oscillator to run many times, and Ctrl-C between its batches."""

from __future__ import annotations

from bgc.runtime.running import batches

# A mass on a spring that hardens; what it is pushed by has no root before it is let go.
OSCILLATOR = """
model Oscillator {
  param mass : kg = 1 kg;
  param k : N/m = 10 N/m;
  param limit : m = 10 m;
  param late : s = -1 s;
  param length : m = 1 m;
  param period : s = 1 s;
  param strength : N = 1 mN;

  joint  : J1;
  body   : I(mass);
  spring : C(q0 = 1 m) { e = k*q*(1 + (q/length)^2); }
  push   : Se(e = strength*sqrt((time - late)/period)*sin(time/period));
  push -> joint -> body, spring;
  assert abs(spring.q) < limit, "the spring is torn";
}

scene swing of Oscillator {
  observe spring.q as q, body.f as v;
  run 3 s every 0.5 s;
}

scene watched of Oscillator {
  observe body.f as v, energy.residual as residual, spring.q as q;
  run 3 s every 0.3 s;
}
"""


def interrupt_after(monkeypatch, after: int) -> None:
    """Stop an ensemble as Ctrl-C does, when so many batches have been run."""
    original = batches.Work.run_batch
    count = iter(range(1, 1000))

    def run_batch(work, start):
        original(work, start)
        if next(count) == after:
            work.stopping = True

    monkeypatch.setattr(batches.Work, "run_batch", run_batch)
