"""`bgc.reduced_part`: a part with linear laws, as a passive part of fewer states."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from bgc.diagnostics.catalogue.studies import part_not_reduced
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.public import public_function
from bgc.diagnostics.words import listed
from bgc.options import Options
from bgc.record_class import dataclass
from bgc.resolution.modules import Package
from bgc.resolution.resolve import load
from bgc.resolution.scene_digest import scene_digest
from bgc.runtime.reduced_parts.part_source import PartSource, read_part
from bgc.runtime.reduced_parts.part_text import PartText
from bgc.runtime.reduced_parts.port_hamiltonian import PortHamiltonian
from bgc.runtime.reduced_parts.subspace import static_basis, subspaces
from bgc.runtime.reduced_parts.terminated import PartError, Terminals, part_error
from bgc.runtime.results.files import written_whole
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.model_loading import load_model
from bgc.runtime.running.parameters import ParameterValue

_LARGEST = 600  # states of a part whose norms are computed in reasonable time
_INDEX = re.compile(r"\[[^\]]*\]")
_NO_NAME = re.compile(r"\W+")


@dataclass(frozen=True, slots=True, eq=False)
class ReducedPart:
    """A part with fewer states: a model with the same ports, passive by construction.

    Attributes
    ----------
    name
        The name of its model.
    part
        The path of the part that it stands for.
    whole, reduced
        The systems of both, `whole.states` and `reduced.states` their numbers of states; `A`, `B`,
        `C` and `D` are their matrices, in states whose energy is half the sum of their squares.
    error
        The difference between the two.
    tangents
        Elements with nonlinear laws, which are replaced by their tangents at the start.
    text
        The model as text.
    """

    name: str
    part: str
    whole: PortHamiltonian
    reduced: PortHamiltonian
    error: PartError
    tangents: tuple[str, ...]
    text: str
    path: Path

    def to_bg(self, path: str | Path) -> None:
        """Write the model to a file that imports the one of the original."""
        original = os.path.relpath(self.path.absolute(), Path(path).absolute().parent)
        with written_whole(path) as aside:
            text = f'import "{Path(original).as_posix()}";\n\n{self.text}'
            aside.write_text(text, encoding="utf-8")


@public_function
def reduced_part(
    model: str | Path | LoadedModel,
    part: str,
    states: int,
    scene: str | None = None,
    *,
    name: str | None = None,
    parameters: Mapping[str, ParameterValue] | None = None,
    uses: Mapping[str, str] | None = None,
) -> ReducedPart:
    """Reduce a part of a scene whose laws are linear, by projecting its port-Hamiltonian form.

    The result is passive, answers constant inputs as the whole part does, and starts as it starts.
    Nonlinear laws are replaced by their tangents at the start. Its parameters are the numbers of
    the scene.

    Parameters
    ----------
    model, scene
        A `.bg` file and its scene, by default the first; or a model with its source.
    part
        The path of the part, such as `house.wall`.
    states
        The number of states.
    name
        The name of the new model; by default made of the part's.
    parameters, uses
        As for `bgc.compile`.

    Raises
    ------
    BgError
        BG665: the part has no linear passive form, or needs more states.
    """
    if isinstance(model, LoadedModel):
        loaded = model
    else:
        options = Options(scene, uses=tuple((uses or {}).items()))
        loaded = load_model(Path(model), options, parameters or {})
    path, options = loaded.source_for("reduced parts")
    package = load(path)
    source = read_part(path, options, package, part, loaded.parameters.given({}))
    found = reduced_parts(path, options, package, source, [states], name)
    if not found:
        least = static_basis(source.found.system).shape[1]
        whole = source.found.system.states
        reason = f"it has {whole} states, and steady states need {least} of them"
        raise BgError([part_not_reduced(part, reason)])
    return found[0]


def reduced_parts(
    path: Path,
    options: Options,
    package: Package,
    source: PartSource,
    sizes: Sequence[int],
    name: str | None = None,
) -> list[ReducedPart]:
    """Reduce a part to each of some numbers of states that is possible and smaller than its own.

    Raises BgError for a part with too many states.
    """
    whole = source.found.system
    if whole.states > _LARGEST:
        reason = f"it has {whole.states} states, and at most {_LARGEST} are handled"
        raise BgError([part_not_reduced(source.path, reason)])
    terminals = Terminals.of(whole)
    possible = [size for size in sizes if 0 < size < whole.states]
    digest = next(
        scene_digest(package, each)
        for each in package.root.scenes
        if options.scene in (None, each.declaration.name)
    )
    found = []
    for size, basis in subspaces(whole, terminals, possible).items():
        reduced = whole.projected(basis).sparse()
        error = part_error(whole, reduced, terminals)
        own = name or f"{_NO_NAME.sub('_', source.path).strip('_').capitalize()}Of{size}States"
        text = PartText(
            name=own,
            doc=_doc(source, path, digest, reduced, error),
            base=source.base,
            ports=source.ports,
            values=source.values,
            outputs=source.outputs,
            system=reduced,
        )
        found.append(
            ReducedPart(own, source.path, whole, reduced, error, source.tangents, text.text(), path)
        )
    return found


def _doc(
    source: PartSource, path: Path, digest: str, reduced: PortHamiltonian, error: PartError
) -> str:
    """The doc comment: source, error, digest."""
    bent = listed([*dict.fromkeys(_INDEX.sub("[..]", each) for each in source.tangents)])
    bent = f" The nonlinear laws of {bent} are their tangents at the start." if bent else ""
    return (
        f"{reduced.states} of the {source.found.system.states} states of `{source.path}`, a "
        f"`{source.model}` in {path.name} ({digest}), passive and with its static gain.{bent} With "
        f"matched resistors at the ports, a smooth step is answered to {error.step:.1e} of its "
        f"peak; relative norms of the difference are {error.h_infinity:.1e} (H infinity) and "
        f"{error.h2:.1e} (H2)."
    )
