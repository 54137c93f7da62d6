"""Recordings of labelled meshes: scans that a simulated camera is carried through."""
