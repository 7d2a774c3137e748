"""Options that the commands on linear models share, and the model that these name."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from bgc.diagnostics.catalogue.analysis import several_components
from bgc.runtime.cli.command import OptionGroup, option, require
from bgc.runtime.cli.options import Input, Output, PointOptions, SceneOptions
from bgc.runtime.cli.printing import print_diagnostics
from bgc.runtime.linear.feedback import close_loop, gain_unit, with_gain
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.linearising.operating_point import OpenedModel
from bgc.runtime.running.quantity import read_quantity

Gain = Annotated[
    str | None,
    option(
        'Gain of a controller before the input: 20, or "5 V*s/rad"; by default 1 in SI units.',
        metavar="GAIN",
    ),
]
Closed = Annotated[bool, option("Take the closed loop: input = gain*(reference - output).")]
Low = Annotated[
    float | None, option("Lowest frequency, rad/s; by default from the modes.", "--from")
]
High = Annotated[
    float | None, option("Highest frequency, rad/s; by default from the modes.", "--to")
]


@dataclass(frozen=True)
class LinearOptions(OptionGroup):
    """A scene of FILE, and where to linearise it."""

    scene: SceneOptions
    point: PointOptions

    def linear(self, inputs: Sequence[str] = (), outputs: Sequence[str] = ()) -> Linearisation:
        """Linearise the scene, and print its warnings."""
        opened = OpenedModel(self.scene.file, self.scene.options(), inputs, outputs)
        linear = opened.linearise(opened.operating_point(self.point.point))
        print_diagnostics(linear.warnings)
        return linear


@dataclass(frozen=True)
class ChannelOptions(OptionGroup):
    """A linear model with one input and one output, and the gain of its controller."""

    model: LinearOptions
    input_: Input
    output: Output
    gain: Gain

    def linear(self, closed: bool = False) -> Linearisation:
        """Linearise the scene with the gain before its input; close the loop if asked for."""
        linear = self.model.linear([self.input_], [self.output])
        require_one("input", self.input_, linear.inputs)
        require_one("output", self.output, linear.outputs)
        return in_loop(linear, self.input_, self.output, self.gain, closed)


def in_loop(
    linear: Linearisation, inputs: str, outputs: str, gain: str | None, closed: bool
) -> Linearisation:
    """Put the controller's gain before a model, and close the loop where that is asked for.

    With a gain or a closed loop the model has one input and one output (BG084 where `inputs` or
    `outputs`, as the user wrote them, are vectors).
    """
    if gain is None and not closed:
        return linear
    require_one("input", inputs, linear.inputs)
    require_one("output", outputs, linear.outputs)
    factor = 1.0 if gain is None else read_quantity(gain, "--gain", gain_unit(linear))
    return close_loop(linear, factor) if closed else with_gain(linear, factor)


def require_one(option: str, text: str, names: Sequence[str]) -> None:
    """Refuse a vector where one scalar is needed (BG084)."""
    require(len(names) == 1, several_components(option, text, names))
