"""Runs examples/radar_track.py with messages that have the fields of radar_msgs, and prints what it publishes. Run by host-tests."""

import dataclasses
import json
import runpy
import sys
import types
from pathlib import Path


def message(name, **fields):
    """A message class that refuses fields it does not have, as rclpy's do."""
    defaults = [(field, object, dataclasses.field(default_factory=default)) for field, default in fields.items()]
    return dataclasses.make_dataclass(name, defaults)


zero, six = float, lambda: [0.0] * 6
Point, Vector3 = message("Point", x=zero, y=zero, z=zero), message("Vector3", x=zero, y=zero, z=zero)
UUID = message("UUID", uuid=lambda: [0] * 16)
Header = message("Header", frame_id=str, stamp=float)
RadarTrack = message(
    "RadarTrack", uuid=UUID, position=Point, velocity=Vector3, acceleration=Vector3, size=Vector3, classification=int,
    position_covariance=six, velocity_covariance=six, acceleration_covariance=six, size_covariance=six,
)
RadarTracks = message("RadarTracks", header=Header, tracks=list)


class Node:
    """What of a node the example uses."""

    def create_publisher(self, kind, topic, depth):
        return types.SimpleNamespace(publish=lambda message: print(json.dumps(dataclasses.asdict(message))))

    def get_clock(self):
        return types.SimpleNamespace(now=lambda: types.SimpleNamespace(to_msg=float))


for module, names in {
    "rclpy": {"init": lambda: None, "create_node": lambda name: Node()},
    "geometry_msgs.msg": {"Point": Point, "Vector3": Vector3},
    "radar_msgs.msg": {"RadarTrack": RadarTrack, "RadarTracks": RadarTracks},
    "unique_identifier_msgs.msg": {"UUID": UUID},
}.items():
    sys.modules[module.split(".")[0]] = types.ModuleType(module.split(".")[0])
    sys.modules[module] = types.ModuleType(module)
    vars(sys.modules[module]).update(names)

runpy.run_path(str(Path(__file__).parent.parent / "examples" / "radar_track.py"), run_name="__main__")
