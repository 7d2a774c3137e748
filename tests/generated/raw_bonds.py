"""The bonds of a program, each a pair of an effort and a flow."""

from __future__ import annotations

from flat_expressions import Var
from flat_lists import (
    chosen,
)
from program_tree import (
    End,
)
from raw_instances import Instance, Opening, Point


class Joining(Opening):
    """Joins pieces of bonds at ports of models."""

    def _points(self, end: End, inst: Instance, loops: dict[str, int], sign: int) -> list[Point]:
        """The scalar ends of one end of a bond."""
        first, *more = end.path
        index = None if first.index is None else self._index(first.index, inst, loops)
        if not more and index is None and first.name in inst.ports:
            width = inst.ports[first.name].width
            return [(f"{inst.path}:{first.name}", "in", k) for k in chosen(end, width)]
        part = inst.parts[first.name, index]
        if isinstance(part, Instance):
            if more:
                port = part.ports[more[0].name]
            else:
                direction = "in" if sign > 0 else "out"
                (port,) = (p for p in part.ports.values() if p.direction == direction)
            return [(f"{part.path}:{port.name}", "out", k) for k in chosen(end, port.width)]
        widths = part.part.width
        if part.is_junction:
            return [(part.path, "j", k) for k in chosen(end, widths[0])]
        if end.place is not None:
            return [(part.path, "1", end.place - 1)]
        if part.part.type in ("TF", "GY") and len(widths) == 2:
            side = "1" if sign > 0 else "2"
            return [(part.path, side, k) for k in range(widths[0 if sign > 0 else -1])]
        if part.part.type in ("Mux", "Demux"):
            wide = (part.part.type == "Mux") == (sign < 0)
            if wide:
                return [(part.path, "wide", k) for k in range(sum(widths))]
            count = part.taken.get("narrow", 0)
            part.taken["narrow"] = count + 1
            start = sum(widths[:count])
            return [(part.path, "narrow", k) for k in range(start, start + widths[count])]
        return [(part.path, "1", k) for k in range(widths[0])]

    def _join(self) -> None:
        """Join pieces of bonds at ports and muxes, and give each whole bond its variables."""
        by_path = {e.path: e for e in self.elements}
        onward: dict[Point, int] = {}

        def passes(point: Point) -> bool:
            found = by_path.get(point[0])
            return found is None or found.part.type in ("Mux", "Demux")

        for n, (tail, _) in enumerate(self.segments):
            if passes(tail):
                assert tail not in onward, tail
                onward[tail] = n
        inside: dict[Point, Point] = {}
        self._port_bond: dict[Point, int] = {}
        for n, (tail, head) in enumerate(self.segments):
            if passes(tail):
                continue
            gone = [n]
            while passes(head):
                path, side, k = head
                other = {"in": "out", "out": "in", "wide": "narrow", "narrow": "wide"}[side]
                piece = onward.pop((path, other, k))
                gone.append(piece)
                head = self.segments[piece][1]
            bond = len(self.bonds)
            self.bonds.append((tail, head))
            for piece in gone:
                for point in self.segments[piece]:
                    self._port_bond[point] = bond
            for (path, side, k), sign in ((tail, -1), (head, 1)):
                by_path[path].ends.setdefault((side, k), []).append((bond, sign))
        assert not onward and not inside, onward
        for k in range(len(self.bonds)):
            self.effort.append(self.raw.new_z(f"e{k} {self.bonds[k]}"))
            self.flow.append(self.raw.new_z(f"f{k} {self.bonds[k]}"))

    @property
    def bonds(self) -> list[tuple[Point, Point]]:
        return self.__dict__.setdefault("_bonds", [])

    @property
    def effort(self) -> list[Var]:
        return self.__dict__.setdefault("_effort", [])

    @property
    def flow(self) -> list[Var]:
        return self.__dict__.setdefault("_flow", [])
