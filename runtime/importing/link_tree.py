"""Links and joints put in the order of their tree; joints that move no mass become fixed."""

from __future__ import annotations

from dataclasses import replace

from bgc.diagnostics.catalogue import listed
from bgc.diagnostics.catalogue.imported import left_out, wrong_structure
from bgc.diagnostics.diagnostic import BgError, Label
from bgc.runtime.importing.inertia import carried_by_joints
from bgc.runtime.importing.notes import Notes
from bgc.runtime.importing.robot import Joint, Kind, Robot


def in_depth_first_order(robot: Robot, notes: Notes) -> Robot:
    """Return the robot with links and joints from the root on, joints by their child.

    Parameters
    ----------
    robot
        Links in any order, joints by their own names; all names exist.
    notes
        Takes the warnings.

    Raises
    ------
    BgError
        BG270 where a link has two parents, and where there is not one root.
    """
    above: dict[str, Joint] = {}
    below: dict[str, list[str]] = {name: [] for name in robot.links}
    for joint in robot.joints.values():
        if joint.child in above:
            first = above[joint.child]
            what = f"`{joint.child}` is the child of two joints, `{first.name}` and `{joint.name}`"
            labels = (Label(first.span, "the first one"),) if first.span else ()
            help = "links form a tree: close the loop in the generated file, with a `Weld`"
            raise BgError([wrong_structure(joint.span, what, help, labels)])
        above[joint.child] = joint
        below[joint.parent].append(joint.child)
    roots = [name for name in robot.links if name not in above]
    if len(roots) > 1:
        what = f"the robot has {len(roots)} roots: {listed(roots)}"
        help = 'join them by `<joint type="fixed">`, or remove the links that nothing uses'
        raise BgError([wrong_structure(robot.links[roots[1]].span, what, help)])
    if not roots:
        joint = next(iter(robot.joints.values()))
        what = "each link is the child of a joint: the links form a loop"
        raise BgError([wrong_structure(joint.span, what, "leave one link without a parent")])
    order, stack = [], [roots[0]]
    while stack:
        name = stack.pop()
        order.append(name)
        stack.extend(reversed(below[name]))
    if len(order) < len(robot.links):
        reached = set(order)
        lost = next(name for name in robot.links if name not in reached)
        what = f"`{lost}` is part of a loop that does not hang on the root `{roots[0]}`"
        help = "correct the parent of one of its joints"
        raise BgError([wrong_structure(above[lost].span, what, help)])
    ordered = replace(
        robot,
        links={name: robot.links[name] for name in order},
        joints={name: above[name] for name in order[1:]},
    )
    return _without_idle_joints(_with_leaders(ordered), notes)


def _with_leaders(robot: Robot) -> Robot:
    """Refuse couplings whose leader has no coordinate, and those that form a circle."""
    named = {joint.name: joint for joint in robot.joints.values()}
    for joint in robot.joints.values():
        if joint.mimic is not None:
            seen, leader = {joint.name}, named[joint.mimic.leader]
            while leader.mimic is not None and leader.name not in seen:
                seen.add(leader.name)
                leader = named[leader.mimic.leader]
            fault = ""
            if leader.name in seen:
                fault = "the joints follow each other in a circle"
            elif not leader.kind.driven:
                fault = f"`{leader.name}` is a {leader.kind.value} joint"
            if fault:
                what = f"`{joint.name}` follows no other joint: {fault}"
                help = "let it follow a revolute or prismatic joint"
                raise BgError([wrong_structure(joint.span, what, help)])
    return robot


def _without_idle_joints(robot: Robot, notes: Notes) -> Robot:
    """Fix the joints that move no mass, for their motion would be undetermined."""
    carried = carried_by_joints(robot)
    moving: set[str] = set()  # links that carry a moving joint, or are carried by one below
    idle: set[str] = set()  # names of joints
    for child, joint in reversed(robot.joints.items()):
        found = carried[child]
        # Radius of gyration below 1e-6 m about the axis, whatever the other joints do.
        on_axis = child not in moving and abs(found.along_axis) <= 1e-12 * found.mass
        nothing = found.mass == 0 and found.along_axis <= 0
        if joint.kind is not Kind.FIXED and (nothing or (on_axis and joint.kind is Kind.TURNS)):
            idle.add(joint.name)
        elif joint.kind is not Kind.FIXED:
            moving.add(joint.parent)
        if child in moving:
            moving.add(joint.parent)
    # Joints that are coupled move what any of them moves.
    pairs = [(joint.name, joint.mimic.leader) for joint in robot.joints.values() if joint.mimic]
    for _ in pairs:
        for pair in pairs:
            if not idle.issuperset(pair):
                idle.difference_update(pair)
    joints = {}
    for child, joint in robot.joints.items():
        if joint.name in idle:
            what = f"`{joint.name}` moves no mass, so that its motion is undetermined: it is fixed"
            help = f"give `{child}` mass and inertia"
            notes.add(left_out(joint.span, what, help))
            joint = replace(joint, kind=Kind.FIXED, mimic=None)
        joints[child] = joint
    return replace(robot, joints=joints)
