"""Doubtful odometry: edges of tracking that the loops of a finished pose graph contradict.

Depth has minima some millimetres beside the right one, and where tracking starts from leads into one in a few of a
hundred times. Alone it cannot tell; where loops say otherwise, the graph is the better start.
"""

from __future__ import annotations

from slam.backend.pose_graph import PoseGraph, mahalanobis
from slam.pose_edge import PoseEdge, unit_weight

# How many times as far off the poses as loops usually are. In 72 simulated walks 8 of 100 edges were: by 2 to 6 mm,
# where the others were wrong by 0.7.
DOUBTFUL = 6.0


def doubtful_odometry(graph: PoseGraph) -> list[PoseEdge]:
    """The odometry edges that the present poses contradict; none where there are no loops."""
    loops = [mahalanobis(edge, graph.poses) for edge in graph.edges if not edge.is_odometry]
    unit = unit_weight(loops, len(graph.edges), len(graph.poses))
    if unit is None:
        return []
    return [edge for edge in graph.edges if edge.is_odometry and mahalanobis(edge, graph.poses) > DOUBTFUL * unit]
