"""Pictures of maps: rendered without a window or a GPU, shaded, labelled."""
