"""Many recordings, each mapped by a `razer run` of its own, on this machine or on the nodes of a cluster."""
