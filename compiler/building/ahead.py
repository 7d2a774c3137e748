"""Compile the runtime while a model is still being read: it does not depend on the model."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor, wait

from bgc.building.build import compile_runtime
from bgc.building.cache import open_cache
from bgc.building.toolchain import Compilations, Toolchain, find_toolchain


class RuntimeAhead:
    """The cache and the C compiler of a compilation, and the runtime that it begins with.

    As a context: on leaving it, what has not been compiled by then is given up.
    """

    def __init__(self) -> None:
        self.cache = open_cache()
        self._pool = ThreadPoolExecutor(max_workers=1)
        self._compilations = Compilations()

    def __enter__(self) -> RuntimeAhead:
        self._toolchain = self._pool.submit(find_toolchain)
        self._runtime = self._pool.submit(self._compile)
        return self

    def __exit__(self, *_: object) -> None:
        self._compilations.end()
        self._pool.shutdown(cancel_futures=True)

    @property
    def toolchain(self) -> Toolchain:
        """The C compiler; BgError (BG050, BG051) where there is none."""
        return self._toolchain.result()

    def ready(self) -> None:
        """Wait until the runtime is in the cache, or could not be compiled."""
        wait([self._runtime])

    def _compile(self) -> None:
        compile_runtime(self.toolchain, self.cache, self._compilations)
