"""The package of ROS 2: programs, launch files and the entry in the ament index; no Python module.

Its distribution has another name than the Python package end-effector-hal. Of two distributions with one name Python
sees the first only: the codecs and commands of the other one would be lost.
"""

from glob import glob

from setuptools import setup

setup(
    name="end-effector-hal-ament",
    version="0.1.0",
    description="Nodes and launch files of a hardware abstraction layer for robot end-effectors",
    license="Apache-2.0",
    packages=[],
    py_modules=[],
    # as data: as scripts they would start with the interpreter of colcon, which does not see a virtual environment
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/end_effector_hal"]),
        ("share/end_effector_hal", ["package.xml"]),
        ("share/end_effector_hal/launch", sorted(glob("launch/*.launch.py"))),
        ("lib/end_effector_hal", sorted({*glob("scripts/*")} - {"scripts/line_arbiter"})),
    ],
    extras_require={"test": ["pytest"]},
)
