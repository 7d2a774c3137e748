"""Options that the commands on linear models share, and the model that these name."""

from collections.abc import Sequence
from typing import Annotated

from bgc.diagnostics.catalogue.analysis import several_components
from bgc.record_class import dataclass
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

    def linear(
        self,
        inputs: Sequence[str] = (),
        outputs: Sequence[str] = (),
        gain: str | None = None,
        closed: bool = False,
    ) -> Linearisation:
        """Linearise the scene, print its warnings, and close the loop where that is asked for.

        A controller's gain stands before the input. With it, or in a closed loop, the model has one
        input and one output (BG084 for vectors).
        """
        opened = OpenedModel(self.scene.file, self.scene.options(), inputs, outputs)
        linear = opened.linearise(opened.operating_point(self.point.point))
        print_diagnostics(linear.warnings)
        if gain is None and not closed:
            return linear
        require_one("input", ", ".join(inputs), linear.inputs)
        require_one("output", ", ".join(outputs) or "what the scene observes", linear.outputs)
        factor = 1.0 if gain is None else read_quantity(gain, "--gain", gain_unit(linear))
        return (close_loop if closed else with_gain)(linear, factor)


@dataclass(frozen=True)
class ChannelOptions(OptionGroup):
    """A linear model with one input and one output, and the gain of its controller."""

    model: LinearOptions
    input_: Input
    output: Output
    gain: Gain

    def linear(self, closed: bool = False) -> Linearisation:
        """Linearise the scene with the gain before its input; close the loop if asked for."""
        linear = self.model.linear([self.input_], [self.output], self.gain, closed)
        require_one("input", self.input_, linear.inputs)
        require_one("output", self.output, linear.outputs)
        return linear


def require_one(option: str, text: str, names: Sequence[str]) -> None:
    """Refuse a vector where one scalar is needed (BG084)."""
    require(len(names) == 1, several_components(option, text, names))
