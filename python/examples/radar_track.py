"""A ROS 2 node that publishes a board's targets: `cargo picket watch /dev/ttyACM0 --jsonl | python3 radar_track.py`.

The x axis points from the sensor to the target. Across the beam, a target is anywhere in it: half the beam's width is one standard
deviation of y and z. Only answers that may be used are published.
"""

import json
import sys
import uuid

import rclpy
from geometry_msgs.msg import Point, Vector3
from radar_msgs.msg import RadarTrack, RadarTracks
from unique_identifier_msgs.msg import UUID

HALF_BEAM_RAD = 0.1  # of your antenna or lens


def track(answer: dict[str, float], name: uuid.UUID) -> RadarTrack:
    """The track of an answer. Covariances are xx, xy, xz, yy, yz, zz."""
    range_m, across = answer["range_m"], (answer["range_m"] * HALF_BEAM_RAD) ** 2
    closing, sigma = answer["velocity_mps"], answer["sigma_velocity_mps"]
    return RadarTrack(
        uuid=UUID(uuid=list(name.bytes)),
        position=Point(x=range_m),
        velocity=Vector3(x=-closing),
        position_covariance=[answer["sigma_range_m"] ** 2, 0.0, 0.0, across, 0.0, across],
        velocity_covariance=[sigma**2, 0.0, 0.0, 1e4, 0.0, 1e4],  # 100 m/s across: nothing is known
    )


rclpy.init()
node = rclpy.create_node("picket")
publisher = node.create_publisher(RadarTracks, "tracks", 10)
name = uuid.uuid4()
for line in sys.stdin:
    answer = json.loads(line)
    if answer.get("outcome_verdict") in ("good", "moving") and answer["range_m"] is not None:
        tracks = RadarTracks(tracks=[track(answer, name)])
        tracks.header.frame_id = "radar"
        tracks.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(tracks)
