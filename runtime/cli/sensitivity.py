"""Run 8: show by how much each parameter changes what a scene observes."""

from bgc.runtime.cli.command import command, option
from bgc.runtime.cli.options import PICTURE, TABLE, MethodOptions, SceneOptions
from bgc.runtime.cli.printing import attempt, report

_EPILOG = """\b
Examples (rope.bg: the manual, "Sensitivities of a run"):
  bgc sensitivity rope.bg
  bgc sensitivity rope.bg --observe "max(force)" --of mass --plot tornado.png
"""


@command(epilog=_EPILOG)
def sensitivity(
    scene: SceneOptions,
    *,
    observed: tuple[str, ...] = option(
        'Observable of the run: "max(tension)", "last(x)". May be repeated; by default the '
        "largest magnitude of each observed column.",
        "--observe",
    ),
    parameters: tuple[str, ...] = option(
        "Parameter by which to differentiate. May be repeated; by default all that are not 0.",
        "--of",
        metavar="NAME",
    ),
    out: str | None = option("Write the effects: .csv.", type=TABLE),
    plot: str | None = option("Draw a tornado plot: .png, .svg or .pdf.", type=PICTURE),
    method: MethodOptions,
) -> None:
    """Show the effects of 1 % of each parameter of a scene of FILE on observables.

    They come from the derivatives of the run at the present values of the parameters, and are
    listed by their size.
    """
    model = scene.model()
    found, _ = attempt(
        lambda: model.effects(observed, of=parameters, **method.arguments),
        "interrupted before the effects were found: nothing is written",
    )
    report(found, found.tables(), out, plot)
