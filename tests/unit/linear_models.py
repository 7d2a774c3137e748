"""Models whose linear form is known, for the tests of linear models and their responses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from model_files import model_text

from bgc.options import Options
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.linearising.operating_point import OpenedModel

MODELS = Path(__file__).parents[1] / "models"

# Two masses between walls: f1 on the first, springs k1 k12 k2, damper d between them.
TWO_MASSES = model_text("linear_models_two_masses")
M1, M2, K1, K12, K2, D = 2.0, 3.0, 50.0, 20.0, 70.0, 0.3

# States in the order of the elements: p1, p2, q1, q2, q12.
EXACT_A = np.array(
    [
        [-D / M1, D / M2, -K1, 0, -K12],
        [D / M1, -D / M2, 0, -K2, K12],
        [1 / M1, 0, 0, 0, 0],
        [0, 1 / M2, 0, 0, 0],
        [1 / M1, -1 / M2, 0, 0, 0],
    ]
)


def opened(tmp_path: Path, text: str, inputs=(), outputs=()) -> OpenedModel:
    path = tmp_path / "model.bg"
    path.write_text(text)
    return OpenedModel(path, Options(), inputs, outputs)


def linear(tmp_path: Path, text: str, inputs=(), outputs=(), at=None) -> Linearisation:
    model = opened(tmp_path, text, inputs, outputs)
    return model.linearise(model.operating_point(at))


def state_space(A, E=None, output=0) -> Linearisation:
    """A model of states x0, x1, .. of which `output` is observed, and u drives x0."""
    n = len(A)
    names, every = tuple(f"x{k}" for k in range(n)), np.eye(n)
    return Linearisation(
        np.array(A, dtype=float), every[:, :1], every[output : output + 1], np.zeros((1, 1)),
        every if E is None else np.array(E, dtype=float), states=names, inputs=("u",),
        outputs=(names[output],), units=dict.fromkeys((*names, "u"), ""),
        point=np.zeros(n), time=0.0,
    )  # fmt: skip
