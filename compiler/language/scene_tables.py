"""Names in scenes: options of drivers, channels of devices, energy accounts."""

from __future__ import annotations

from collections.abc import Mapping

from bgc.record_class import dataclass
from bgc.values.units import Dimension
from bgc.values.value import Shape

_SECOND: Dimension = (0, 0, 1, 0, 0, 0, 0)
_HERTZ: Dimension = (0, 0, -1, 0, 0, 0, 0)
_METRE: Dimension = (0, 1, 0, 0, 0, 0, 0)
_SPEED: Dimension = (0, 1, -1, 0, 0, 0, 0)
_FORCE: Dimension = (1, 1, -2, 0, 0, 0, 0)
_TORQUE: Dimension = (1, 2, -2, 0, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class Channel:
    """A value that a device gives or takes; `dimension` is None for a plain number."""

    shape: Shape
    dimension: Dimension | None
    doc: str


TRACE_COLUMNS = (
    *("x", "y", "z", "qw", "qx", "qy", "qz", "gripper"),
    *(f"button{k}" for k in range(1, 9)),
    *("vx", "vy", "vz", "wx", "wy", "wz", "hx", "hy", "hz", "age"),
)
"""Columns of a recorded motion beside the time, whose option is `clock`.

An option of their name gives the name that a column has in the file.
"""

DRIVER_OPTIONS: Mapping[str, Mapping[str, bool]] = {
    "forcedimension": {"id": False, "gravity": False, "smooth": False},
    "gamepad": {"smooth": False, "reach": False},
    "haply": {"port": False, "id": False, "wait": False},
    "pointer": {"smooth": False, "reach": False},
    "spring_hand": dict.fromkeys(
        (
            *("mass", "damping", "stiffness", "amplitude", "frequency", "axis"),
            *("push", "start", "resolution"),
        ),
        False,
    ),
    "trace": {
        "file": True,
        "scale": False,
        "loop": False,
        **dict.fromkeys(("clock", *TRACE_COLUMNS), False),
    },
    "udp": {"port": True, "host": False, "wait": False, "lag": False},
}
"""Options of drivers, and whether they are needed; those of other drivers are not compared."""

DRIVER_BY_PATH = "driver"
"""The driver whose first argument is the path of a shared object: `driver("./mine.so")`."""

AUTO = "auto"
"""The solver that stands for the recommendation of `bgc trade`: `solver auto;`."""

OVERRUN_POLICIES: Mapping[str, str] = {
    "hold": "periods that were missed are left out of simulated time",
    "skip": "the model catches up with the last pose, without reading or writing the device",
    "slow": "simulated time runs slower than the clock",
}
"""Overrun policies of a loop in real time, the second part of `deadline`."""

DEVICE_INPUTS: Mapping[str, Channel] = {
    "position": Channel((3,), _METRE, "position of the handle"),
    "orientation": Channel((4,), None, "orientation as a unit quaternion [scalar, vector]"),
    "velocity": Channel((3,), _SPEED, "velocity of the handle"),
    "angular_velocity": Channel((3,), _HERTZ, "angular velocity of the handle, in rad/s"),
    "gripper": Channel((), None, "opening of the gripper"),
    "buttons": Channel((8,), None, "1 for each button that is pressed, else 0"),
    "held_force": Channel((3,), _FORCE, "force that the hand held since the last sample"),
    "age": Channel((), _SECOND, "age of the pose that the held force answers; 0 if not known"),
}
"""Channels that a device gives, sampled at every step of the scene."""

DEVICE_COMMANDS: Mapping[str, Channel] = {
    "force": Channel((3,), _FORCE, "force on the operator's hand"),
    "torque": Channel((3,), _TORQUE, "torque on the operator's hand"),
    "gripper_force": Channel((), _FORCE, "force that opens the gripper"),
}
"""Channels that a device takes, by `drive`."""

ACCOUNTS: Mapping[str, str] = {
    "stored": "energy in all storage elements, less that at the start",
    "supplied": "energy that sources have given since the start",
    "dissipated": "energy that resistors have taken since the start",
    "residual": "stored - supplied + dissipated: 0 but for errors of integration",
}
"""Energy accounts of a scene, in J, observed as `energy.stored` and so on."""

CREATED = "created"
"""The energy that sampled ports have created: an account that only these have."""
