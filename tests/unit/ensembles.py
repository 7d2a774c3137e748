"""An oscillator to run many times, and Ctrl-C between its batches."""

from __future__ import annotations

from model_files import model_text

from bgc.runtime.running import batches

# A mass on a spring that hardens; what it is pushed by has no root before it is let go.
OSCILLATOR = model_text("ensembles_oscillator")


def interrupt_after(monkeypatch, after: int) -> None:
    """Stop an ensemble as Ctrl-C does, when so many batches have been run."""
    original = batches.Work.run_batch
    count = iter(range(1, 1000))

    def run_batch(work, start):
        original(work, start)
        if next(count) == after:
            work.stopping = True

    monkeypatch.setattr(batches.Work, "run_batch", run_batch)
