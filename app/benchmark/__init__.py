"""The figures of `razer bench`."""
