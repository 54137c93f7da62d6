"""The way of a frame to the map: opened, located and perceived in processes ahead of it, and accounted for."""
