"""The library of `.bg` models: beams, joints, actuators, vessels, kinematics, haptics, scenes."""
