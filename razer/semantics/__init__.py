"""Semantics of a finished map: classes, gravity, spatial relations, scene graph."""
