"""Engines: what runs tasks, each in processes of its own, on this machine or on a cluster."""
